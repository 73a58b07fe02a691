/* check_measure: the least distance of one configuration, of links from obstacles and from each other: the links whose
 * balls are nearest are asked exactly first, until no other can be nearer than what was found. */
#include "check_robot.h"

#include <stdlib.h>

typedef struct measure_candidate {
    double below;           /* a lower bound */
    uint32_t link, between; /* one of them is CHECK_NOBODY */
} measure_candidate;

typedef struct measure_work {
    const check_robot *robot;
    const scene *scene;
    const check_request *request;
    check_scratch *scratch;
    check_result *result;
    robot_frames frames[ROBOT_LINKS_MAX]; /* all lanes alike */
    pose poses[ROBOT_LINKS_MAX];
} measure_work;

static int compare_candidates(const void *a, const void *b)
{
    const measure_candidate *x = a, *y = b;
    if (x->below != y->below) return x->below < y->below ? -1 : 1;
    if (x->link != y->link) return x->link < y->link ? -1 : 1;
    return x->between < y->between ? -1 : x->between > y->between;
}

/* The nearest the balls of a link come to the scene, up to `most`. */
static double below_of_link(measure_work *w, const check_link *l, double most)
{
    check_frame f = frame_of_lane(&w->frames[l->link], 0);
    double least = most;
    for (uint32_t ball = l->first_ball; ball < l->first_ball + l->balls; ball += LANES) {
        lanes centre[3], radius = ball_radii(w->robot, ball), clearance = (lanes){0} + least;
        ball_centres(w->robot, &f, ball, centre);
        scene_clearance(w->scene, l->link, centre, &radius, &clearance);
        for (int k = 0; k < LANES; k++) least = fmin(least, clearance[k]);
    }
    return least - l->slack;
}

static double below_of_pair(measure_work *w, const check_between *p)
{
    const check_robot *r = w->robot;
    const check_link *a = &r->links.at[p->a], *b = &r->links.at[p->b];
    check_frame fa = frame_of_lane(&w->frames[a->link], 0), fb = frame_of_lane(&w->frames[b->link], 0);
    double least = INFINITY;
    for (uint32_t i = a->first_ball; i < a->first_ball + a->balls; i++) {
        vec3 c = frame_point(&fa, vec(r->x.at[i], r->y.at[i], r->z.at[i]));
        for (uint32_t k = b->first_ball; k < b->first_ball + b->balls; k++) {
            vec3 d = frame_point(&fb, vec(r->x.at[k], r->y.at[k], r->z.at[k]));
            least = fmin(least, vec_norm(vec_sub(c, d)) - r->radius.at[i] - r->radius.at[k]);
        }
    }
    return least - p->slack;
}

static void measure_shapes(measure_work *w, uint32_t a, uint32_t b, uint32_t obstacle, double slack)
{
    const check_robot *r = w->robot;
    check_result *out = w->result;
    bool of_scene = b == CHECK_NOBODY;
    const scene_obstacle_def *def = of_scene ? &w->scene->defs[obstacle] : NULL;
    const check_shape *sa = &r->shapes.at[a], *sb = of_scene ? NULL : &r->shapes.at[b];
    pose at_a = pose_mul(w->poses[sa->link], sa->pose);
    pose at_b = of_scene ? def->pose : pose_mul(w->poses[sb->link], sb->pose);
    double widen = of_scene ? def->widen_m : 0;
    narrow_result answer;
    out->queries++;
    check_exact_distance(sa->shape, at_a, of_scene ? def->shape : sb->shape, at_b, w->request->tolerance_m,
        out->hi + slack + widen, check_key(a, of_scene ? obstacle : b, of_scene), w->scratch, &answer);
    out->lo = fmin(out->lo, answer.lo - slack - widen);
    if (!(answer.hi + slack + widen < out->hi)) return;
    out->hi = answer.hi + slack + widen;
    if (out->verdict == CHECK_FREE)
        out->shape_a = r->given.at[a], out->shape_b = of_scene ? b : r->given.at[b], out->obstacle = obstacle;
}

static void measure_link(measure_work *w, const check_link *l)
{
    double within = fmax(0, w->result->hi);
    check_frame f = frame_of_lane(&w->frames[l->link], 0);
    check_near near = check_near_begin(w->scratch, w->scene);
    for (uint32_t i = l->first_ball; i < l->first_ball + l->balls; i++) {
        vec3 c = frame_point(&f, vec(w->robot->x.at[i], w->robot->y.at[i], w->robot->z.at[i]));
        check_near_add(&near, l->link, c, w->robot->radius.at[i], within + l->slack);
    }
    for (size_t i = 0; i < near.count; i++)
        for (uint32_t k = 0; k < l->shapes; k++)
            measure_shapes(w, l->first_shape + k, CHECK_NOBODY, near.sources[i], l->slack);
    check_near_end(&near);
}

static void measure_pair(measure_work *w, const check_between *p)
{
    const check_link *a = &w->robot->links.at[p->a], *b = &w->robot->links.at[p->b];
    for (uint32_t i = 0; i < a->shapes; i++)
        for (uint32_t k = 0; k < b->shapes; k++)
            measure_shapes(w, a->first_shape + i, b->first_shape + k, CHECK_NOBODY, p->slack);
}

void check_measure(const check_robot *r, const scene *s, const check_request *request, const double *coordinates,
    check_scratch *scratch, check_result *result)
{
    measure_work *w = base_alloc_aligned(64, 1, sizeof *w);
    w->robot = r, w->scene = s, w->request = request, w->scratch = scratch, w->result = result;
    lanes values[ROBOT_LINKS_MAX];
    for (size_t c = 0; c < robot_tree_coordinates(r->tree); c++) values[c] = (lanes){0} + coordinates[c];
    robot_tree_forward_lanes(r->tree, values, w->frames);
    robot_tree_forward(r->tree, coordinates, w->poses);
    ARRAY(measure_candidate) candidates = {0};
    for (uint32_t i = 0; i < r->links.count; i++) {
        double below = below_of_link(w, &r->links.at[i], INFINITY);
        if (below < INFINITY) array_push(&candidates, ((measure_candidate){below, i, CHECK_NOBODY}));
    }
    for (uint32_t i = 0; i < r->between.count; i++)
        array_push(&candidates, ((measure_candidate){below_of_pair(w, &r->between.at[i]), CHECK_NOBODY, i}));
    if (candidates.count > 0) qsort(candidates.at, candidates.count, sizeof *candidates.at, compare_candidates);
    result->lo = result->hi = INFINITY;
    for (size_t i = 0; i < candidates.count; i++) {
        const measure_candidate *c = &candidates.at[i];
        if (c->below > 0 && c->below >= result->hi)
            break; /* and so are all behind it. How deep balls are says little */
        if (c->link != CHECK_NOBODY)
            measure_link(w, &r->links.at[c->link]);
        else
            measure_pair(w, &r->between.at[c->between]);
    }
    result->lo = fmin(result->lo, result->hi);
    array_free(&candidates);
    free(w);
}
