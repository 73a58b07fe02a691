/* check_robot: a robot made ready for checks: covers, pairs of links, and the joints between these. */
#include "check_robot.h"

#include "geom/bounds.h"

#include <stdlib.h>
#include <string.h>

/* What coordinates of balls and distances of simple bodies may be off by, relative to the robot's reach, beside what
 * robot_tree_slack says of the links: scene.h's SCENE_OFF, and as much for centres of balls. */
#define CHECK_OFF (2 * SCENE_OFF)

static void put_ball(check_robot *r, const cover_ball *b)
{
    array_push(&r->x, b->centre.x);
    array_push(&r->y, b->centre.y);
    array_push(&r->z, b->centre.z);
    array_push(&r->radius, b->radius);
}

/* Shapes of one link become its balls. */
static check_fault add_link(check_robot *r, uint32_t link, const check_shape *shapes, size_t count)
{
    check_link l = {.link = link, .first_shape = (uint32_t)r->shapes.count, .first_ball = (uint32_t)r->x.count};
    cover balls = {0};
    pose inner = {VEC_ZERO, robot_tree_inner(r->tree, link)};
    check_fault fault = CHECK_FINE;
    for (size_t i = 0; i < count && fault == CHECK_FINE; i++) {
        if (shapes[i].link != link) continue;
        array_push(&r->shapes, shapes[i]);
        array_push(&r->given, (uint32_t)i);
        l.shapes++;
        if (!cover_shape(shapes[i].shape, pose_mul(inner, shapes[i].pose), &balls)) fault = CHECK_ENDLESS_SHAPE;
    }
    if (balls.count > 0 && fault == CHECK_FINE) {
        l.whole = cover_whole(balls.at, balls.count);
        for (size_t i = 0; i < balls.count; i++) {
            const cover_ball *b = &balls.at[i];
            put_ball(r, b);
            l.reach = fmax(l.reach, vec_norm(b->centre) + b->radius);
            l.extent = fmax(l.extent, vec_norm(vec_sub(b->centre, l.whole.centre)) + b->radius);
            l.fatness = fmax(l.fatness, b->radius);
        }
        l.reach = fmax(l.reach, vec_norm(l.whole.centre)) * (1 + 0x1p-40);
        l.extent *= 1 + 0x1p-40;
        while ((r->x.count - l.first_ball) % LANES != 0) put_ball(r, &balls.at[balls.count - 1]);
        l.balls = (uint32_t)r->x.count - l.first_ball;
        if (!(l.reach <= ROBOT_SIZE_MAX)) fault = CHECK_TOO_LARGE;
        array_push(&r->links, l);
        r->reach = fmax(r->reach, robot_tree_reach(r->tree, link, l.reach));
    }
    array_free(&balls);
    return fault;
}

static uint32_t find_link(const check_robot *r, uint32_t link)
{
    for (uint32_t i = 0; i < r->links.count; i++)
        if (r->links.at[i].link == link) return i;
    return CHECK_NOBODY;
}

static check_fault add_pair(check_robot *r, const check_pair *p)
{
    size_t links = robot_tree_links(r->tree);
    if (p->a >= links || p->b >= links || p->a == p->b) return CHECK_NO_SUCH_LINK;
    uint32_t a = find_link(r, p->a), b = find_link(r, p->b);
    if (a == CHECK_NOBODY || b == CHECK_NOBODY) return CHECK_FINE; /* nothing there to meet */
    if (r->links.at[a].balls < r->links.at[b].balls) {
        uint32_t other = a;
        a = b, b = other;
    }
    check_between between = {.a = a, .b = b, .first_joint = (uint32_t)r->levers.count};
    robot_lever levers[2 * ROBOT_LINKS_MAX];
    between.joints = (uint32_t)robot_tree_levers(
        r->tree, (int32_t)r->links.at[a].link, r->links.at[b].link, r->links.at[b].reach, levers);
    for (uint32_t i = 0; i < between.joints; i++) array_push(&r->levers, levers[i]);
    between.slack = r->links.at[a].slack + r->links.at[b].slack;
    array_push(&r->between, between);
    return CHECK_FINE;
}

check_robot *check_robot_create(const robot_tree *tree, const check_shape *shapes, size_t shape_count,
    const check_pair *pairs, size_t pair_count, check_fault *fault)
{
    size_t links = robot_tree_links(tree);
    *fault = shape_count > CHECK_SHAPES_MAX ? CHECK_TOO_MANY_SHAPES
             : pair_count > CHECK_PAIRS_MAX ? CHECK_TOO_MANY_PAIRS
                                            : CHECK_FINE;
    for (size_t i = 0; i < shape_count && *fault == CHECK_FINE; i++)
        if (shapes[i].link >= links) *fault = CHECK_NO_SUCH_LINK;
    if (*fault != CHECK_FINE) return NULL;
    check_robot *r = base_zalloc(1, sizeof *r);
    r->tree = tree;
    for (uint32_t link = 0; link < links && *fault == CHECK_FINE; link++)
        *fault = add_link(r, link, shapes, shape_count);
    for (size_t i = 0; i < r->links.count; i++) {
        check_link *l = &r->links.at[i];
        l->slack = robot_tree_slack(tree, l->link, l->reach) + CHECK_OFF * r->reach;
        l->first_lever = (uint32_t)r->levers.count;
        robot_lever levers[2 * ROBOT_LINKS_MAX];
        l->levers = (uint32_t)robot_tree_levers(tree, -1, l->link, l->reach, levers);
        for (uint32_t k = 0; k < l->levers; k++) array_push(&r->levers, levers[k]);
    }
    for (size_t i = 0; i < pair_count && *fault == CHECK_FINE; i++) *fault = add_pair(r, &pairs[i]);
    if (*fault == CHECK_FINE) return r;
    check_robot_destroy(r);
    return NULL;
}

void check_robot_destroy(check_robot *r)
{
    if (!r) return;
    array_free(&r->shapes);
    array_free(&r->given);
    array_free(&r->links);
    array_free(&r->x);
    array_free(&r->y);
    array_free(&r->z);
    array_free(&r->radius);
    array_free(&r->between);
    array_free(&r->levers);
    free(r);
}

double check_robot_reach(const check_robot *r)
{
    return r->reach;
}
