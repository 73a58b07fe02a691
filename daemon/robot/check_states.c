/* check_states: configurations, four side by side through kinematics and the balls around links; then, one by one, the
 * smaller balls of those links that are in doubt; then exact shapes. */
#include "check_robot.h"

#include <stdlib.h>
#include <string.h>

typedef struct state_work {
    const check_robot *robot;
    const scene *scene;
    const check_request *request;
    check_scratch *scratch;
    const double *coordinates; /* of this configuration */
    const robot_frames *frames;
    int lane;
    check_result *result;
    bool posed; /* `poses` are there */
    pose poses[ROBOT_LINKS_MAX];
} state_work;

check_request check_request_default(void)
{
    return (check_request){.resolution_m = 1e-4, .find_first = true, .tolerance_m = 1e-6};
}

static void need_poses(state_work *w)
{
    if (!w->posed) robot_tree_forward(w->robot->tree, w->coordinates, w->poses);
    w->posed = true;
}

static pose shape_pose(state_work *w, uint32_t shape)
{
    need_poses(w);
    const check_shape *s = &w->robot->shapes.at[shape];
    return pose_mul(w->poses[s->link], s->pose);
}

/* One verdict more. An item that meets stays so; one in doubt may still meet elsewhere. */
static void conclude(
    state_work *w, double lo, double hi, double free_above, double meets_at, uint32_t a, uint32_t b, uint32_t obstacle)
{
    check_result *out = w->result;
    if (lo > free_above || out->verdict == CHECK_MEETS) return;
    bool meets = hi <= meets_at;
    if (!meets && out->verdict == CHECK_UNDECIDED) return;
    out->verdict = meets ? CHECK_MEETS : CHECK_UNDECIDED;
    out->shape_a = a, out->shape_b = b, out->obstacle = obstacle;
}

/* Two shapes, the second one of the robot, too, or an obstacle. Asked twice where the first answer is between the two
 * limits: they are apart by rounding alone. */
static void decide_exactly(state_work *w, uint32_t a, uint32_t b, uint32_t obstacle, double slack)
{
    const check_robot *r = w->robot;
    bool of_scene = b == CHECK_NOBODY;
    const scene_obstacle_def *def = of_scene ? &w->scene->defs[obstacle] : NULL;
    const shape *sa = r->shapes.at[a].shape, *sb = of_scene ? def->shape : r->shapes.at[b].shape;
    pose at_a = shape_pose(w, a), at_b = of_scene ? def->pose : shape_pose(w, b);
    double widen = of_scene ? def->widen_m : 0, margin = w->request->margin_m;
    double free_above = margin + slack + widen, meets_at = margin - slack - widen;
    uint64_t key = check_key(a, of_scene ? obstacle : b, of_scene);
    narrow_result answer;
    w->result->queries++;
    check_exact_verdict(sa, at_a, sb, at_b, free_above, key, w->scratch, &answer);
    if (!(answer.lo > free_above) && !(answer.hi <= meets_at)) {
        w->result->queries++;
        check_exact_verdict(sa, at_a, sb, at_b, meets_at, key, w->scratch, &answer);
    }
    conclude(w, answer.lo, answer.hi, free_above, meets_at, r->given.at[a], of_scene ? b : r->given.at[b], obstacle);
}

/* The smaller balls of a link against the scene; the obstacles that they leave open, exactly. */
static void decide_link(state_work *w, const check_link *l)
{
    const check_robot *r = w->robot;
    check_frame f = frame_of_lane(&w->frames[l->link], w->lane);
    double limit = w->request->margin_m + l->slack;
    check_near near = check_near_begin(w->scratch, w->scene);
    for (uint32_t ball = l->first_ball; ball < l->first_ball + l->balls; ball += LANES) {
        lanes centre[3], radius = ball_radii(r, ball), clearance = (lanes){0} + limit;
        ball_centres(r, &f, ball, centre);
        scene_clearance(w->scene, l->link, centre, &radius, &clearance);
        for (int k = 0; k < LANES; k++)
            if (clearance[k] < limit)
                check_near_add(&near, l->link, vec(centre[0][k], centre[1][k], centre[2][k]), radius[k], limit);
    }
    for (size_t i = 0; i < near.count && w->result->verdict != CHECK_MEETS; i++)
        for (uint32_t k = 0; k < l->shapes && w->result->verdict != CHECK_MEETS; k++)
            decide_exactly(w, l->first_shape + k, CHECK_NOBODY, near.sources[i], l->slack);
    check_near_end(&near);
}

/* Do any balls of two links come nearer to each other than the limit? */
static bool balls_are_near(const state_work *w, const check_link *a, const check_link *b, double limit)
{
    const check_robot *r = w->robot;
    check_frame fa = frame_of_lane(&w->frames[a->link], w->lane), fb = frame_of_lane(&w->frames[b->link], w->lane);
    for (uint32_t i = b->first_ball; i < b->first_ball + b->balls; i++) {
        vec3 c = frame_point(&fb, vec(r->x.at[i], r->y.at[i], r->z.at[i]));
        for (uint32_t ball = a->first_ball; ball < a->first_ball + a->balls; ball += LANES) {
            lanes centre[3], within = ball_radii(r, ball) + (r->radius.at[i] + limit);
            ball_centres(r, &fa, ball, centre);
            lanes x = centre[0] - c.x, y = centre[1] - c.y, z = centre[2] - c.z;
            lane_mask near = x * x + y * y + z * z < within * within;
            if (near[0] | near[1] | near[2] | near[3]) return true;
        }
    }
    return false;
}

static void decide_between(state_work *w, const check_between *p)
{
    const check_link *a = &w->robot->links.at[p->a], *b = &w->robot->links.at[p->b];
    if (!balls_are_near(w, a, b, w->request->margin_m + p->slack)) return;
    for (uint32_t i = 0; i < a->shapes; i++)
        for (uint32_t k = 0; k < b->shapes && w->result->verdict != CHECK_MEETS; k++)
            decide_exactly(w, a->first_shape + i, b->first_shape + k, CHECK_NOBODY, p->slack);
}

/* What the balls around whole links leave open, of four configurations. */
typedef struct coarse_open {
    lane_mask links[ROBOT_LINKS_MAX], between[CHECK_PAIRS_MAX], any;
} coarse_open;

LANES_INLINE void whole_centre(const robot_frames *f, vec3 v, lanes out[3])
{
    for (int k = 0; k < 3; k++) out[k] = f->x[k] * v.x + f->y[k] * v.y + f->z[k] * v.z + f->p[k];
}

LANES_INLINE void coarse_any(
    const check_robot *r, const scene *s, const check_request *request, const robot_frames *frames, coarse_open *open)
{
    lanes centre[ROBOT_LINKS_MAX][3];
    lane_mask all = {0};
    for (size_t i = 0; i < r->links.count; i++) {
        const check_link *l = &r->links.at[i];
        whole_centre(&frames[l->link], l->whole.centre, centre[i]);
        lanes limit = (lanes){0} + (request->margin_m + l->slack), clearance = limit,
              radius = (lanes){0} + l->whole.radius;
        scene_clearance(s, l->link, centre[i], &radius, &clearance);
        all |= open->links[i] = clearance < limit;
    }
    for (size_t i = 0; i < r->between.count; i++) {
        const check_between *p = &r->between.at[i];
        const lanes *a = centre[p->a], *b = centre[p->b];
        double within = r->links.at[p->a].whole.radius + r->links.at[p->b].whole.radius + request->margin_m + p->slack;
        lanes x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
        all |= open->between[i] = x * x + y * y + z * z < (lanes){0} + within * within;
    }
    open->any = all;
}

static void coarse_plain(
    const check_robot *r, const scene *s, const check_request *request, const robot_frames *frames, coarse_open *open)
{
    coarse_any(r, s, request, frames, open);
}
LANES_WHOLE static void coarse_wide(
    const check_robot *r, const scene *s, const check_request *request, const robot_frames *frames, coarse_open *open)
{
    coarse_any(r, s, request, frames, open);
}

/* Up to four configurations. */
static void check_four(const check_robot *r, const scene *s, const check_request *request, const double *coordinates,
    int count, check_scratch *scratch, check_result *results)
{
    size_t n = robot_tree_coordinates(r->tree);
    lanes values[ROBOT_LINKS_MAX];
    for (size_t c = 0; c < n; c++)
        for (int k = 0; k < LANES; k++) values[c][k] = coordinates[(size_t)(k < count ? k : 0) * n + c];
    robot_frames frames[ROBOT_LINKS_MAX];
    robot_tree_forward_lanes(r->tree, values, frames);
    coarse_open open;
    (lanes_wide() ? coarse_wide : coarse_plain)(r, s, request, frames, &open);
    for (int k = 0; k < count; k++) {
        results[k] =
            (check_result){CHECK_FREE, 0, 0, -INFINITY, INFINITY, CHECK_NOBODY, CHECK_NOBODY, CHECK_NOBODY, 1, 0};
        state_work w = {.robot = r,
            .scene = s,
            .request = request,
            .scratch = scratch,
            .frames = frames,
            .lane = k,
            .coordinates = coordinates + (size_t)k * n,
            .result = &results[k]};
        for (size_t i = 0; open.any[k] && i < r->links.count && results[k].verdict != CHECK_MEETS; i++)
            if (open.links[i][k]) decide_link(&w, &r->links.at[i]);
        for (size_t i = 0; open.any[k] && i < r->between.count && results[k].verdict != CHECK_MEETS; i++)
            if (open.between[i][k]) decide_between(&w, &r->between.at[i]);
        if (request->measure) check_measure(r, s, request, w.coordinates, scratch, &results[k]);
    }
}

void check_states(const check_robot *r, const scene *s, const check_request *request, const double *coordinates,
    size_t count, check_scratch *scratch, check_result *results)
{
    size_t n = robot_tree_coordinates(r->tree);
    for (size_t i = 0; i < count; i += LANES)
        check_four(
            r, s, request, coordinates + i * n, count - i < LANES ? (int)(count - i) : LANES, scratch, results + i);
}
