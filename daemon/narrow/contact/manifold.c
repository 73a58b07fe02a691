/* Contact manifolds by clipping. Pure; any thread; no history.
 *
 * All work is done in the contact's frame: x and y across the axis, h along it, the origin at the witness on A. Seen
 * along the axis, the contact is where the two features overlap: one is clipped by the other in the plane, and at each
 * corner of the overlap the distance is the difference of the two heights, minus the radii. */
#include "manifold.h"

#include "geom/feature.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

#include <string.h>

/* ---- manifold choice ---- */

/* Which points of a contact are kept. */

void manifold_choice_begin(manifold_choice *c, vec3 axis, double same, bool seamed)
{
    *c = (manifold_choice){.same = same, .seamed = seamed, .u = vec_unit_orthogonal(axis)};
    c->v = vec_cross(axis, c->u);
}

static bool is_chosen(const manifold_choice *c, const manifold_point *p)
{
    for (uint32_t i = 0; i < c->chosen.count; i++) {
        vec3 d = vec_sub(p->point, c->chosen.points[i].point);
        if (max_of(fabs(vec_dot(d, c->u)), fabs(vec_dot(d, c->v))) <= c->same) return true;
    }
    return false;
}

static double square_from(const manifold_choice *c, vec3 from, vec3 to)
{
    vec3 d = vec_sub(to, from);
    double x = vec_dot(d, c->u), y = vec_dot(d, c->v);
    return x * x + y * y;
}

static double left_of_line(const manifold_choice *c, vec3 point)
{
    const manifold_point *at = c->chosen.points;
    vec3 d = vec_sub(point, at[0].point), line = vec_sub(at[1].point, at[0].point);
    return vec_dot(line, c->u) * vec_dot(d, c->v) - vec_dot(line, c->v) * vec_dot(d, c->u);
}

/* How much of what is looked for a point has; it must be positive but for the deepest. */
static double manifold_score_of(const manifold_choice *c, const manifold_point *p)
{
    const manifold_point *at = c->chosen.points;
    switch (c->pass) {
    case PASS_DEEPEST:
        return -p->distance;
    case PASS_FARTHEST:
        return square_from(c, at[0].point, p->point);
    case PASS_CORNER: /* in place of the first, if it is as deep, and farther from the second */
        if (p->distance > at[0].distance + c->same) return 0;
        return square_from(c, at[1].point, p->point) - square_from(c, at[1].point, at[0].point);
    case PASS_LEFT:
        return left_of_line(c, p->point);
    default:
        return -left_of_line(c, p->point);
    }
}

void manifold_choice_offer(manifold_choice *c, const manifold_point *p)
{
    if (is_chosen(c, p)) return;
    double score = manifold_score_of(c, p);
    if (c->pass != PASS_DEEPEST && !(score > 0)) return;
    if (c->found && (score < c->best || (score == c->best && p->feature >= c->point.feature))) return;
    c->found = true;
    c->best = score;
    c->point = *p;
}

bool manifold_choice_next(manifold_choice *c)
{
    bool ends = !c->found && c->pass < PASS_CORNER; /* without a line there are no sides of it */
    if (c->found && c->pass == PASS_CORNER)
        c->chosen.points[0] = c->point;
    else if (c->found)
        c->chosen.points[c->chosen.count++] = c->point;
    c->found = false;
    c->pass += c->pass == PASS_FARTHEST && !c->seamed ? 2 : 1;
    return !ends && c->pass < PASS_COUNT;
}

void manifold_choice_write(const manifold_choice *c, manifold *out)
{
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; i < c->chosen.count; i++) {
        uint32_t place = out->count++;
        for (; place > 0 && out->points[place - 1].feature > c->chosen.points[i].feature; place--)
            out->points[place] = out->points[place - 1];
        out->points[place] = c->chosen.points[i];
    }
}

/* ---- manifold ---- */

enum {
    CORNERS_MAX =
        2 * FEATURE_CORNERS_MAX + 2, /* a convex outline gains one corner at most by each side that clips it */
    NOT_FOUND = -1
};

/* A face counts as lying across the axis up to this sine. The axis of a face contact is the face's normal to rounding;
 * the rest covers almost parallel faces whose least depth is found between two edges. */
static const double FACE_SINE = 0.01;

/* Of the smaller feature's span: corners that lie on a side to within this stay corners, so that flush edges (equal
 * boxes stacked) do not flicker with the last digits of the pose; and the witness is added where a sampled rim misses
 * the deepest point by more. */
static const double FLUSH_RATIO = 1e-6;

/* The same margin for a sliver, as a fraction of the width of the reference face: a wider one would leave out its
 * corners. */
static const double FLUSH_WIDTH = 1e-3;

/* Of that: a side of the reference that is no longer is not clipped by, for its direction is rounding. A longer one is,
 * however short: where it joins two long sides of a sliver, nothing else ends that. */
static const double SHORT_RATIO = 1e-3;

typedef struct contact_frame {
    vec3 origin, x, y, axis;
} contact_frame;

typedef struct spot {
    double x, y, h;
} spot;

typedef struct outline {
    uint32_t count;
    bool unbounded;
    spot at[FEATURE_CORNERS_MAX];
    const uint32_t *corner_id;
    uint32_t face_id;
    double slope_x, slope_y; /* of a polygon's plane: h = at[0].h + slope_x (x - at[0].x) + slope_y (y - at[0].y) */
    double facing;           /* |cosine| between its normal and the axis; 0 for segments */
    double area;             /* twice, signed: positive when it runs counter-clockwise in x, y */
    double low, high;        /* of its corners */
    double span;             /* in x, y; of a segment its length: one that stands upright is no less for that */
} outline;

/* A corner of the overlap, on its way through the clipping. */
typedef struct corner {
    spot at;           /* h: of the incident feature */
    uint32_t ref, inc; /* what it is made of on either feature: manifold.h */
    bool side_is_ref;  /* the side that leaves this corner: along the reference, or along the incident feature? */
    uint32_t side;
} corner;

typedef struct candidate {
    manifold_point point;
    double x, y;
} candidate;

typedef struct candidates {
    uint32_t count;
    double slack; /* m; what is nearer to each other than this is one point */
    candidate at[CORNERS_MAX + 1];
} candidates;

static contact_frame frame_of(vec3 axis, vec3 origin)
{
    vec3 least = fabs(axis.x) <= fabs(axis.y) && fabs(axis.x) <= fabs(axis.z) ? vec(1, 0, 0)
                 : fabs(axis.y) <= fabs(axis.z)                               ? vec(0, 1, 0)
                                                                              : vec(0, 0, 1);
    vec3 x = direction_of(vec_cross(least, axis));
    return (contact_frame){origin, x, vec_cross(axis, x), axis};
}

static spot to_spot(const contact_frame *f, vec3 p)
{
    vec3 d = vec_sub(p, f->origin);
    return (spot){vec_dot(d, f->x), vec_dot(d, f->y), vec_dot(d, f->axis)};
}

static vec3 from_spot(const contact_frame *f, spot s)
{
    return vec_madd(vec_madd(vec_madd(f->origin, s.x, f->x), s.y, f->y), s.h, f->axis);
}

/* Twice the signed area of the triangle a, b, p; positive when p is to the left of the line from a to b. */
static double manifold_turn(spot a, spot b, spot p)
{
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

static double flat_length2(spot a, spot b)
{
    return (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
}

static double flat_length(spot a, spot b)
{
    return sqrt(flat_length2(a, b));
}

static spot manifold_between(spot a, spot b, double t)
{
    return (spot){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.h + t * (b.h - a.h)};
}

/* `to_a`: NULL for A's own. */
static void manifold_outline_of(const feature *f, const transform *to_a, const contact_frame *frame, outline *out)
{
    vec3 normal = to_a ? mat_mul(to_a->r, f->normal) : f->normal;
    double nh = vec_dot(normal, frame->axis);
    out->count = f->count;
    out->unbounded = f->unbounded;
    out->corner_id = f->corner_id;
    out->face_id = f->face_id;
    out->slope_x = out->slope_y = out->area = 0;
    double span2 = 0;
    out->at[0] = out->at[1] = (spot){0, 0, 0};
    out->low = INFINITY, out->high = -INFINITY;
    for (uint32_t i = 0; i < f->count; i++) {
        out->at[i] = to_spot(frame, to_a ? transform_point(to_a, f->corner[i]) : f->corner[i]);
        double rise = f->count == 2 ? out->at[i].h - out->at[0].h : 0;
        span2 = max_of(span2, flat_length2(out->at[0], out->at[i]) + rise * rise);
        if (i > 1) out->area += manifold_turn(out->at[0], out->at[i - 1], out->at[i]);
        out->low = min_of(out->low, out->at[i].h), out->high = max_of(out->high, out->at[i].h);
    }
    out->span = sqrt(span2);
    if (f->unbounded) {
        out->at[0] = to_spot(frame, to_a ? to_a->t : VEC_ZERO);
        out->span = INFINITY;
        out->low = -INFINITY, out->high = INFINITY;
    }
    out->facing = f->count == 2 ? 0 : fabs(nh);
    if (nh == 0) return;
    out->slope_x = -vec_dot(normal, frame->x) / nh;
    out->slope_y = -vec_dot(normal, frame->y) / nh;
}

/* Of a spot that is over it, or flush: it never leaves the heights of the corners. */
static double plane_height(const outline *o, spot p)
{
    double h = o->at[0].h + o->slope_x * (p.x - o->at[0].x) + o->slope_y * (p.y - o->at[0].y);
    return min_of(max_of(h, o->low), o->high);
}

/* Does a face (or plane) lie across the axis? */
static bool lies_across(double facing)
{
    return facing * facing >= 1 - FACE_SINE * FACE_SINE;
}

/* Can the other feature be clipped by it? It lies across the axis, and is no sliver. */
static bool is_reference(const outline *o)
{
    return lies_across(o->facing) && (o->unbounded || fabs(o->area) > FLUSH_RATIO * o->span * o->span);
}

/* Where the working polygon crosses side j of the reference. */
static corner crossing(
    const outline *ref, const outline *inc, uint32_t j, const corner *from, const corner *to, double t)
{
    corner c = {.at = manifold_between(from->at, to->at, t)};
    if (from->side_is_ref) {
        uint32_t i = from->side;
        c.ref = feature_code(FEATURE_VERTEX, ref->corner_id[j == (i + 1) % ref->count ? j : i]);
        c.inc = feature_code(FEATURE_FACE, inc->face_id);
    } else {
        c.ref = feature_code(FEATURE_EDGE, ref->corner_id[j]);
        c.inc = feature_code(FEATURE_EDGE, inc->corner_id[from->side]);
    }
    return c;
}

/* How far each corner is on the inner side of the reference's side j. True if one is outside by more than `slack`. */
static bool measure_side(
    const outline *ref, uint32_t j, double slack, const corner *in, uint32_t count, double height[CORNERS_MAX])
{
    spot a = ref->at[j], b = ref->at[j + 1 == ref->count ? 0 : j + 1];
    double length = flat_length(a, b), sign = ref->area > 0 ? 1 : -1;
    bool cuts = false;
    if (length <= SHORT_RATIO * slack) return false;
    for (uint32_t i = 0; i < count; i++) {
        height[i] = sign * manifold_turn(a, b, in[i].at) / length;
        cuts |= height[i] < -slack;
    }
    return cuts;
}

/* One step of Sutherland and Hodgman: what of `in` lies on the inner side of the reference's side j, by the heights of
 * its corners. Corners within `slack` of the line are on it: kept, and cut nothing. */
static uint32_t clip_by_side(const outline *ref, const outline *inc, uint32_t j, double slack, const corner *in,
    const double *height, uint32_t count, corner *out)
{
    uint32_t made = 0;
    for (uint32_t i = 0; i < count && made + 2 <= CORNERS_MAX; i++) {
        uint32_t next = i + 1 == count ? 0 : i + 1;
        const corner *from = &in[i], *to = &in[next];
        double here = height[i], there = height[next];
        if (here >= -slack) {
            out[made] = *from;
            if (here <= slack && there < -slack) {
                out[made].side_is_ref = true;
                out[made].side = j;
            }
            made++;
        }
        if ((here > slack && there < -slack) || (here < -slack && there > slack)) {
            corner c = crossing(ref, inc, j, from, to, here / (here - there));
            c.side_is_ref = here > slack || from->side_is_ref;
            c.side = here > slack ? j : from->side;
            out[made++] = c;
        }
    }
    return made;
}

/* The incident outline as far as it lies over the reference, in one of the two buffers. A convex outline crosses a line
 * twice at most, so each side adds one corner at most; a side that cuts nothing changes nothing. */
static const corner *clip_polygon(
    const outline *ref, const outline *inc, double slack, corner buffers[2][CORNERS_MAX], uint32_t *count)
{
    corner *in = buffers[0], *out = buffers[1];
    uint32_t sides = ref->unbounded ? 0 : ref->count;
    double height[CORNERS_MAX];
    *count = inc->count;
    for (uint32_t i = 0; i < inc->count; i++)
        in[i] = (corner){inc->at[i], feature_code(FEATURE_FACE, ref->face_id),
            feature_code(FEATURE_VERTEX, inc->corner_id[i]), false, i};
    for (uint32_t j = 0; j<sides && * count> 0; j++) {
        if (!measure_side(ref, j, slack, in, *count, height)) continue;
        *count = clip_by_side(ref, inc, j, slack, in, height, *count, out);
        corner *swap = in;
        in = out;
        out = swap;
    }
    return in;
}

/* The same for a segment: its two ends move inward from side to side (Cyrus and Beck). */
static uint32_t clip_segment(const outline *ref, const outline *inc, double slack, corner *out)
{
    double sign = ref->area > 0 ? 1 : -1, begin = 0, end = 1;
    uint32_t sides = ref->unbounded ? 0 : ref->count;
    for (uint32_t i = 0; i < 2; i++)
        out[i] = (corner){
            .ref = feature_code(FEATURE_FACE, ref->face_id), .inc = feature_code(FEATURE_VERTEX, inc->corner_id[i])};
    for (uint32_t j = 0; j < sides; j++) {
        spot a = ref->at[j], b = ref->at[(j + 1) % ref->count];
        double length = flat_length(a, b);
        if (length <= SHORT_RATIO * slack) continue;
        double first = sign * manifold_turn(a, b, inc->at[0]) / length,
               second = sign * manifold_turn(a, b, inc->at[1]) / length;
        if (first >= -slack && second >= -slack) continue;
        if (first < -slack && second < -slack) return 0;
        double t = min_of(max_of(first / (first - second), 0), 1);
        bool at_begin = first < second;
        if (at_begin ? t <= begin : t >= end) continue;
        *(at_begin ? &begin : &end) = t;
        out[at_begin ? 0 : 1].ref = feature_code(FEATURE_EDGE, ref->corner_id[j]);
        out[at_begin ? 0 : 1].inc = feature_code(FEATURE_FACE, inc->face_id);
    }
    if (begin > end) return 0;
    out[0].at = manifold_between(inc->at[0], inc->at[1], begin);
    out[1].at = manifold_between(inc->at[0], inc->at[1], end);
    return 2;
}

typedef struct contact {
    contact_frame frame;
    double radius_a, radius_b, threshold;
} contact;

/* Of two in one spot the deeper one counts, where that is more than noise: the lower end of a segment upright. */
static void add_candidate(
    const contact *c, spot on_a, double height_b, uint32_t code_a, uint32_t code_b, candidates *out)
{
    double top_a = on_a.h + c->radius_a, bottom_b = height_b - c->radius_b;
    uint32_t place = 0;
    while (
        place < out->count && !(max_of(fabs(out->at[place].x - on_a.x), fabs(out->at[place].y - on_a.y)) <= out->slack))
        place++;
    candidate *to = &out->at[place];
    if (place < out->count && !(bottom_b - top_a < to->point.distance - out->slack)) return;
    to->x = on_a.x;
    to->y = on_a.y;
    to->point.distance = bottom_b - top_a;
    to->point.point = from_spot(&c->frame, (spot){on_a.x, on_a.y, 0.5 * (top_a + bottom_b)});
    to->point.feature = feature_id(code_a, code_b);
    if (place == out->count && to->point.distance <= c->threshold) out->count++;
}

/* Face against face or segment: what of `inc` lies over `ref`. */
static void add_overlap(const contact *c, const outline *ref, const outline *inc, bool ref_is_a, candidates *out)
{
    corner buffers[2][CORNERS_MAX];
    const corner *corners = buffers[0];
    uint32_t count;
    out->slack = FLUSH_RATIO * min_of(ref->span, inc->span);
    if (!ref->unbounded) out->slack = min_of(out->slack, FLUSH_WIDTH * fabs(ref->area) / ref->span);
    if (inc->count == 2)
        count = clip_segment(ref, inc, out->slack, buffers[0]);
    else
        corners = clip_polygon(ref, inc, out->slack, buffers, &count);
    for (uint32_t i = 0; i < count; i++) {
        const corner *k = &corners[i];
        spot on_ref = {k->at.x, k->at.y, plane_height(ref, k->at)};
        if (ref_is_a)
            add_candidate(c, on_ref, k->at.h, k->ref, k->inc, out);
        else
            add_candidate(c, k->at, on_ref.h, k->inc, k->ref, out);
    }
}

/* A stretch of two lines, from `begin` to `end` along A's: how far B's is to the left of A's, and above it. */
typedef struct stretch {
    double begin, end, aside[2], above[2];
} stretch;

static double along_stretch(const double ends[2], double share)
{
    return ends[0] + share * (ends[1] - ends[0]);
}

/* How far aside two edges still touch that are `above` each other where they are nearest: edges that are sharp, by as
 * much; round ones (by the sum of the radii), where the one has fallen off by as much. */
static double touching_width(const contact *c, double above, double slack)
{
    double room = slack + fabs(above - c->radius_a - c->radius_b);
    return room + sqrt(2 * (c->radius_a + c->radius_b) * room);
}

/* Two lines that touch cross, or meet at an end of their common stretch: it ends where they are farther than `most`
 * from each other sideways, or where they are no more than above or below each other. False if they are so all along.
 */
static bool end_aside(const contact *c, double slack, double most, stretch *s)
{
    double turns = s->aside[1] - s->aside[0], length = s->end - s->begin;
    double crossing = turns != 0 ? min_of(max_of(-s->aside[0] / turns, 0), 1) : 0;
    double width = min_of(touching_width(c, along_stretch(s->above, crossing), slack), most);
    if (fabs(along_stretch(s->aside, crossing)) > width) return false;
    double room = turns != 0 ? (width - fabs(along_stretch(s->aside, crossing))) / fabs(turns) : 1;
    if (fabs(s->aside[1]) > width) s->end = s->begin + length * min_of(crossing + room, 1);
    if (fabs(s->aside[0]) > width) s->begin += length * max_of(crossing - room, 0);
    return true;
}

/* From A's edge over to B's, in the ratio of the radii: there two round edges that are beside each other touch. */
static spot manifold_between_edges(const contact *c, spot on_a, spot on_b)
{
    double radius = c->radius_a + c->radius_b, share = radius > 0 ? c->radius_a / radius : 0;
    return (spot){on_a.x + share * (on_b.x - on_a.x), on_a.y + share * (on_b.y - on_a.y), on_a.h};
}

/* Two almost parallel segments: the ends of their common stretch, measured along A's. What ends it names it, though it
 * touches only in the middle. */
static void add_stretch(const contact *c, const outline *a, const outline *b, candidates *out)
{
    double length = flat_length(a->at[0], a->at[1]), length_b = flat_length(b->at[0], b->at[1]);
    double ux = (a->at[1].x - a->at[0].x) / length, uy = (a->at[1].y - a->at[0].y) / length;
    double bx = b->at[1].x - b->at[0].x, by = b->at[1].y - b->at[0].y;
    if (!(fabs(ux * by - uy * bx) <= FACE_SINE * length_b) || !(length > 0)) return;
    double along = ux * bx + uy * by, start = ux * (b->at[0].x - a->at[0].x) + uy * (b->at[0].y - a->at[0].y);
    uint32_t low = along > 0 ? 0 : 1;
    double b_low = min_of(start, start + along), b_high = max_of(start, start + along);
    stretch s = {.begin = max_of(0, b_low), .end = min_of(length, b_high)};
    out->slack = FLUSH_RATIO * min_of(length, length_b);
    if (!(s.end - s.begin > out->slack)) return;
    double aside = ux * (b->at[0].y - a->at[0].y) - uy * (b->at[0].x - a->at[0].x), per = (ux * by - uy * bx) / along;
    for (uint32_t k = 0; k < 2; k++) {
        double at = k ? s.end : s.begin;
        s.aside[k] = aside + (at - start) * per;
        s.above[k] = manifold_between(b->at[0], b->at[1], (at - start) / along).h -
                     manifold_between(a->at[0], a->at[1], at / length).h;
    }
    if (!end_aside(c, out->slack, FACE_SINE * min_of(length, length_b), &s)) return;
    for (uint32_t k = 0; k < 2; k++) {
        double at = k ? s.end : s.begin;
        bool by_a = k ? length <= b_high : b_low <= 0;
        spot on_a = manifold_between(a->at[0], a->at[1], at / length),
             on_b = manifold_between(b->at[0], b->at[1], (at - start) / along);
        uint32_t code_a = by_a ? feature_code(FEATURE_VERTEX, a->corner_id[k]) : feature_code(FEATURE_FACE, a->face_id);
        uint32_t code_b = by_a ? feature_code(FEATURE_FACE, b->face_id)
                               : feature_code(FEATURE_VERTEX, b->corner_id[k ? 1 - low : low]);
        add_candidate(c, manifold_between_edges(c, on_a, on_b), on_b.h, code_a, code_b, out);
    }
}

typedef double score_function(const candidate *chosen, const candidate *c);
static double score_deepest(const candidate *chosen, const candidate *c)
{
    (void)chosen;
    return -c->point.distance;
}
static double score_farthest(const candidate *chosen, const candidate *c)
{
    double dx = c->x - chosen[0].x, dy = c->y - chosen[0].y;
    return dx * dx + dy * dy;
}
static double score_left(const candidate *chosen, const candidate *c)
{
    return (chosen[1].x - chosen[0].x) * (c->y - chosen[0].y) - (chosen[1].y - chosen[0].y) * (c->x - chosen[0].x);
}
static double score_right(const candidate *chosen, const candidate *c)
{
    return -score_left(chosen, c);
}

/* Scores that are apart by no more than this share of the best, or of depths by the slack, are ties. */
#define TIE_RATIO 1e-6

/* Moves the candidate with the best positive score (any score for the first) behind the chosen ones. Of those that are
 * as good but for the tie's width it is the one with the least id: what lies flush has many equally deep points, and
 * noise in the pose must not choose among them. */
static uint32_t manifold_choose(candidates *all, uint32_t chosen, score_function *score)
{
    double least = chosen ? 0 : -INFINITY, most = least;
    for (uint32_t i = chosen; i < all->count; i++) most = max_of(most, score(all->at, &all->at[i]));
    if (!(most > least)) return chosen;
    double enough = most - (chosen ? TIE_RATIO * most : all->slack);
    int best = NOT_FOUND;
    for (uint32_t i = chosen; i < all->count; i++) {
        bool before = best == NOT_FOUND || all->at[i].point.feature < all->at[best].point.feature;
        if (before && score(all->at, &all->at[i]) >= enough) best = (int)i;
    }
    if (best == NOT_FOUND) return chosen;
    candidate swap = all->at[best];
    all->at[best] = all->at[chosen];
    all->at[chosen] = swap;
    return chosen + 1;
}

/* The deepest, the one farthest from it, and the farthest from their line on either side. */
static void manifold_reduce(candidates *all)
{
    if (all->count <= MANIFOLD_POINTS_MAX) return;
    uint32_t chosen = manifold_choose(all, 0, score_deepest);
    chosen = manifold_choose(all, chosen, score_farthest);
    if (chosen == 2) chosen = manifold_choose(all, chosen, score_left);
    if (chosen >= 2) chosen = manifold_choose(all, chosen, score_right);
    all->count = chosen;
}

/* In the order of their ids, so that neighbours in time are neighbours in the arrays. */
static void write_points(const candidates *all, manifold *out)
{
    out->count = all->count;
    for (uint32_t i = 0; i < all->count; i++) {
        uint32_t place = i;
        for (; place > 0 && out->points[place - 1].feature > all->at[i].point.feature; place--)
            out->points[place] = out->points[place - 1];
        out->points[place] = all->at[i].point;
    }
}

/* The witness stands in where the features gave nothing, and joins them where a sampled rim or a tilted face passes
 * above it. Its surfaces include the radii already. */
static void add_witness(const contact *c, vec3 point_a, vec3 point_b, candidates *all)
{
    double distance = vec_dot(vec_sub(point_b, point_a), c->frame.axis), least = INFINITY;
    for (uint32_t i = 0; i < all->count; i++) least = min_of(least, all->at[i].point.distance);
    if (all->count > 0 && least <= distance + all->slack) return;
    candidate *to = &all->at[all->count++];
    vec3 middle = vec_scale(vec_add(point_a, point_b), 0.5);
    spot at = to_spot(&c->frame, middle);
    *to = (candidate){{middle, distance, feature_witness()}, at.x, at.y};
}

/* Clips the one face by the other. False if neither lies across the axis: then nothing of them is looked at. */
static bool find_overlap(
    const feature *feature_a, const feature *feature_b, const transform *b_in_a, const contact *c, candidates *all)
{
    double facing_a = feature_a->count == 2 ? 0 : vec_dot(feature_a->normal, c->frame.axis);
    double facing_b = feature_b->count == 2 ? 0 : vec_dot(mat_mul(b_in_a->r, feature_b->normal), c->frame.axis);
    if (!lies_across(facing_a) && !lies_across(facing_b)) return false;
    outline on_a, on_b;
    manifold_outline_of(feature_a, NULL, &c->frame, &on_a);
    manifold_outline_of(feature_b, b_in_a, &c->frame, &on_b);
    bool a_can = is_reference(&on_a) && feature_b->count > 0, b_can = is_reference(&on_b) && feature_a->count > 0;
    bool by_a = a_can && (!b_can || on_a.facing >= on_b.facing);
    if (by_a)
        add_overlap(c, &on_a, &on_b, true, all);
    else if (b_can)
        add_overlap(c, &on_b, &on_a, false, all);
    return a_can || b_can;
}

static void find_candidates(const shape *a, const shape *b, const transform *b_in_a, const contact *c, candidates *all)
{
    vec3 down_in_b = mat_tmul(b_in_a->r, vec_neg(c->frame.axis));
    feature feature_a, feature_b;
    feature_facing(a, c->frame.axis, &feature_a);
    feature_facing(b, down_in_b, &feature_b);
    if (find_overlap(&feature_a, &feature_b, b_in_a, c, all)) return;
    if (!feature_edge(a, c->frame.axis, FACE_SINE, &feature_a) || !feature_edge(b, down_in_b, FACE_SINE, &feature_b))
        return;
    outline on_a, on_b;
    manifold_outline_of(&feature_a, NULL, &c->frame, &on_a);
    manifold_outline_of(&feature_b, b_in_a, &c->frame, &on_b);
    add_stretch(c, &on_a, &on_b, all);
}

void manifold_build(const shape *a, const shape *b, const transform *b_in_a, vec3 axis, vec3 point_a, vec3 point_b,
    double threshold, manifold *out)
{
    contact c = {frame_of(axis, point_a), a->radius, b->radius, threshold};
    candidates all; /* far larger than what is used of it: not cleared */
    all.count = 0;
    all.slack = 0;
    find_candidates(a, b, b_in_a, &c, &all);
    add_witness(&c, point_a, point_b, &all);
    manifold_reduce(&all);
    memset(out, 0, sizeof *out);
    write_points(&all, out);
}

manifold_point manifold_witness(const narrow_result *answer)
{
    double along = vec_dot(vec_sub(answer->point_b, answer->point_a), answer->axis);
    return (manifold_point){.point = vec_scale(vec_add(answer->point_a, answer->point_b), 0.5),
        .distance = max_of(answer->lo, min_of(along, answer->hi)),
        .feature = feature_witness()};
}
