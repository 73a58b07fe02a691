/* rim_parts: the features of a box, a capsule, a cylinder or a cone, by their sides: what they are, which directions
 * leave the body there, and which one a point is on. Pure; any thread. */
#include "rim_parts.h"

enum { BETWEEN, HIGH, LOW, SIDES }; /* along an axis of a box, or along that of a body of revolution */
enum { ROUND, FLAT };               /* a body of revolution: its rim or apex, or its flat end */

static const double SIGN[SIDES] = {0, 1, -1};
static const double LEAN = 0x1p-13; /* sine of the angle by which n points out of other faces, ends and sides */

/* ---- what it is ---- */

typedef struct sides { /* of a box: of what lies between, at is 0 */
    double half[3], side[3];
    int free;
} sides;

static inline void put(vec3 v, double out[3])
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

static inline vec3 unit_along(int i, double sign)
{
    return vec(i == 0 ? sign : 0, i == 1 ? sign : 0, i == 2 ? sign : 0);
}

static vec3 half_of(const shape *s)
{
    return s->type == SHAPE_CAPSULE ? vec(0, 0, s->half.z) : s->half;
}

static bool sides_of(const shape *s, const uint16_t side[3], sides *x)
{
    bool right = true;
    put(half_of(s), x->half);
    x->free = 0;
    for (int i = 0; i < 3; i++) {
        right &= side[i] < SIDES && (side[i] == HIGH || x->half[i] > 0);
        x->side[i] = SIGN[right ? side[i] : 0];
        x->free += x->side[i] == 0;
    }
    return right;
}

/* A corner, an edge or a face of A. */
static bool part_of_box(const shape *s, const uint16_t side[3], rim_part *out)
{
    sides x;
    if (!sides_of(s, side, &x) || x.free > 2) return false;
    vec3 middle = vec(x.side[0] * x.half[0], x.side[1] * x.half[1], x.side[2] * x.half[2]);
    *out = (rim_part){.discs = 1, .centre = {middle}};
    if (x.free == 1) {
        int i = x.side[0] == 0 ? 0 : x.side[1] == 0 ? 1 : 2;
        out->discs = 2;
        out->centre[0] = vec_add(middle, unit_along(i, -x.half[i]));
        out->centre[1] = vec_add(middle, unit_along(i, x.half[i]));
    }
    if (x.free == 2) {
        out->is_face = true;
        out->axis = vec(x.side[0], x.side[1], x.side[2]);
    }
    return true;
}

static bool part_of_revolved(const shape *s, const uint16_t side[3], rim_part *out)
{
    bool cone = s->type == SHAPE_CONE, high = side[0] == HIGH;
    if (side[0] >= SIDES || side[1] > FLAT || side[2]) return false;
    if (side[1] == FLAT && (side[0] == BETWEEN || (cone && high))) return false;
    vec3 top = vec(0, 0, s->half.z), bottom = vec(0, 0, -s->half.z);
    double r = s->half.x, r_top = cone ? 0 : r;
    *out = (rim_part){.discs = 1,
        .x = vec(1, 0, 0),
        .y = vec(0, 1, 0),
        .axis = vec(0, 0, 1),
        .has_rim = !(cone && high),
        .is_face = side[1] == FLAT};
    out->centre[0] = high ? top : bottom;
    out->radius[0] = high ? r_top : r;
    if (side[0] == BETWEEN) {
        out->discs = 2;
        out->centre[1] = top;
        out->radius[1] = r_top;
    }
    if (out->is_face && !high) out->axis = vec(0, 0, -1);
    return true;
}

bool rim_part_of(const shape *s, const uint16_t side[3], uint8_t count, rim_part *out)
{
    if (count != 3) return false;
    return rim_is_revolved(s) ? part_of_revolved(s, side, out) : part_of_box(s, side, out);
}

/* ---- does a direction point out of a body as its feature wants? ---- */

static bool box_holds(const shape *s, const uint16_t side[3], vec3 out)
{
    double half[3], d[3];
    bool right = true;
    put(half_of(s), half);
    put(out, d);
    for (int i = 0; i < 3; i++) right &= side[i] == BETWEEN || SIGN[side[i]] * d[i] > LEAN || half[i] == 0;
    return right;
}

/* By how much the upper end's support point is above the lower end's, as the sine of an angle. */
static double upward(const shape *s, vec3 out)
{
    if (s->type == SHAPE_CYLINDER) return out.z;
    double r = s->half.x, h = 2 * s->half.z, slant = sqrt(r * r + h * h);
    return slant > 0 ? (h * out.z - r * sqrt(out.x * out.x + out.y * out.y)) / slant : 0;
}

static bool revolved_holds(const shape *s, const uint16_t side[3], vec3 out)
{
    double up = upward(s, out);
    bool apex = s->type == SHAPE_CONE && side[0] == HIGH;
    bool leaves = side[1] == FLAT || apex || out.x * out.x + out.y * out.y > RIM_SINE * RIM_SINE;
    return leaves && (side[0] == BETWEEN || (side[0] == HIGH ? up > LEAN : up < -LEAN));
}

bool rim_part_holds(const shape *s, const uint16_t side[3], vec3 out)
{
    return rim_is_revolved(s) ? revolved_holds(s, side, out) : box_holds(s, side, out);
}

static bool box_may_be(const shape *s, const uint16_t side[3], vec3 out, double off)
{
    double half[3], d[3];
    bool may = true;
    put(half_of(s), half);
    put(out, d);
    for (int i = 0; i < 3; i++) {
        bool between = half[i] > 0 && fabs(d[i]) <= off;
        may &= half[i] == 0 ? side[i] == HIGH : side[i] == BETWEEN ? between : SIGN[side[i]] * d[i] > LEAN - off;
    }
    return may;
}

static bool revolved_may_be(const shape *s, const uint16_t side[3], vec3 out, double off)
{
    double up = upward(s, out), sine = sqrt(out.x * out.x + out.y * out.y);
    bool apex = s->type == SHAPE_CONE && side[0] == HIGH;
    if (side[1] == FLAT ? apex || side[0] == BETWEEN || sine > off : !apex && sine < RIM_SINE - off) return false;
    return side[0] == BETWEEN ? fabs(up) <= off : (side[0] == HIGH ? up : -up) > LEAN - off;
}

bool rim_part_may_be(const shape *s, const uint16_t side[3], vec3 out, double off)
{
    return rim_is_revolved(s) ? revolved_may_be(s, side, out, off) : box_may_be(s, side, out, off);
}

/* ---- which one is at a point? ---- */

bool rim_part_contains(const shape *s, const uint16_t side[3], vec3 at, double margin)
{
    double half[3], x[3];
    if (rim_is_revolved(s)) {
        double r = s->half.x - margin;
        return r > 0 && at.x * at.x + at.y * at.y < r * r;
    }
    bool inside = true;
    put(half_of(s), half);
    put(at, x);
    for (int i = 0; i < 3; i++) inside &= side[i] != BETWEEN || fabs(x[i]) < half[i] - margin;
    return inside;
}

void rim_part_at(const shape *s, vec3 at, vec3 out, double near, uint16_t side[3])
{
    double half[3], x[3];
    put(half_of(s), half);
    put(at, x);
    if (rim_is_revolved(s)) {
        bool cone = s->type == SHAPE_CONE, end = s->half.z - fabs(at.z) <= near;
        double r = s->half.x - near, across2 = at.x * at.x + at.y * at.y;
        side[0] = !end ? BETWEEN : at.z > 0 ? HIGH : LOW;
        bool flat = !cone || side[0] == LOW;
        side[1] = end && flat && fabs(out.z) > 0.7 && across2 < r * r ? FLAT : ROUND;
        side[2] = 0;
        return;
    }
    for (int i = 0; i < 3; i++)
        side[i] = half[i] == 0 || half[i] - x[i] <= near ? HIGH : half[i] + x[i] <= near ? LOW : BETWEEN;
}

bool rim_part_make_round(const shape *s, uint16_t side[3])
{
    bool flat = rim_is_revolved(s) && side[1] == FLAT;
    if (flat) side[1] = ROUND;
    return flat;
}

/* ---- all of them ---- */

/* 27 of a box; of a body of revolution three, and its two flat ends. */
uint32_t rim_part_count(const shape *s)
{
    return rim_is_revolved(s) ? 6 : 27;
}

void rim_part_numbered(const shape *s, uint32_t i, uint16_t side[3])
{
    uint32_t base = rim_is_revolved(s) ? 2 : 3;
    side[0] = (uint16_t)(rim_is_revolved(s) ? i / base : i % base);
    side[1] = (uint16_t)(rim_is_revolved(s) ? i % base : i / 3 % 3);
    side[2] = (uint16_t)(rim_is_revolved(s) ? 0 : i / 9);
}
