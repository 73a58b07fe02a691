/* sweep: the time from which two parts of shapes may meet, found by directions alone, without distances. Pure; any
 * thread.
 *
 * A stretch of the time span is cut into pieces so short that no gap along a direction dips much below its chord
 * (toi.h). A direction is fixed, or turns with one of the two bodies: the frame in which gaps dip the least is chosen.
 * Two bodies that turn as one have no turning at all in that frame. For two parts, the gap along a direction at both
 * ends of a piece shows how long the gap stays open. From that time on other directions are tried, until none proves
 * more; then the piece is cut, and its rest is cut again. Poses at the ends of pieces are computed when they are first
 * needed, and are kept for other parts. */
#ifndef COLLIDED_TOI_SWEEP_H
#define COLLIDED_TOI_SWEEP_H

#include "course.h"
#include "geom/mesh.h"
#include "geom/shape.h"
#include "narrow/narrow.h"
#include "request.h"

/* ==== shapes of parts ==== */

/* A shape as a hierarchy of boxes over convex parts, each a convex shape that moves with the body: the
 * triangles of a mesh, the children of a compound. */

enum { PART_CHILDREN_MAX = MESH_WIDTH };

#define TOI_WHOLE_NODE UINT32_MAX

typedef enum toi_part_form { TOI_PART_SHAPE, TOI_PART_BOX, TOI_PART_TRIANGLE } toi_part_form;

typedef struct toi_part {
    const shape *whole;
    shape shape; /* a box around all below it, or the part itself; with the rounding of the whole */
    pose local;  /* of `shape` in the frame of the whole */
    bool is_leaf;
    uint32_t node, child; /* where its children are; of a mesh: one child of a node, or TOI_WHOLE_NODE */
    double size;          /* m: its reach */
    toi_part_form form;   /* what sweep.c sees, in the frame of the whole */
    vec3 centre, side[3]; /* of a box, which may be turned; of others their extents, but of triangles no sides */
    vec3 normal;          /* of a flat one: of any length */
    double margin;        /* m: of the rounding, and of what hulls were made of */
    hull flat;            /* of a triangle, which shape.hull points to */
    double x[8], y[8], z[8];
} toi_part;

/* Writes the part that is the whole shape. A convex shape is its own only part. */
void toi_part_root(const shape *whole, toi_part *out);

/* Writes the children of a part, which is no leaf, to out[PART_CHILDREN_MAX], and returns their number. */
int toi_part_children(const toi_part *p, toi_part *out);

/* ==== sweeps ==== */

enum {
    SWEEP_PIECES_MAX = 32,
    SWEEP_CUT = 4,      /* a piece is cut into so many */
    SWEEP_LONGEST = 16, /* after two cuts */
    SWEEP_PLACES = 128  /* that are kept; a power of two */
};

/* Prices in units of about 20 ns. They make the end of a search a function of the motion, not of a clock. */
enum { SWEEP_WORK_TRY = 3, SWEEP_WORK_PLACE = 10, SWEEP_WORK_LEAVES = 5, SWEEP_WORK_LEAVES_TRY = 3 };

typedef struct sweep_place { /* the frames of both shapes, in the course's frame */
    transform a, b;
    double floor; /* m: the least gap that counts as apart then, with the rounding in it */
    uint32_t index;
} sweep_place;

typedef struct sweep {
    course course;
    const toi_request *request;
    double size;            /* m */
    double start, end;      /* s: the stretch */
    course_frame frame;     /* the frame in which directions are fixed */
    double bend;            /* m/s^2: the course's, in that frame and stretch */
    double bend_a, bend_b;  /* for fixed directions: the shares of both turnings in the bend */
    uint32_t ends, longest; /* the least pieces, and how many make up a whole one */
    uint32_t whole;         /* a power of SWEEP_CUT of them, up to all */
    double least;           /* s */
    bool begun;             /* the places are of the stretch from `start` */
    double asked;           /* s: the end of that stretch, as it was asked for */
    uint64_t work;          /* that was done, in the units above */
    sweep_place at[SWEEP_PLACES];
} sweep;

/* False: there is no course. */
bool sweep_init(sweep *s, const toi_mover *a, const toi_mover *b, const toi_request *request);

/* From `start` on: a stretch up to `end`, or as much of it as pieces of use make up; s->end says. */
void sweep_begin(sweep *s, double start, double end);

/* Given that they do not meet before `from`, in the stretch: a time before which they do not, either. INFINITY: not
 * before `until`, or the end of the stretch. *hint: a direction to try first, and then the one that went farthest; zero
 * = none. */
double sweep_entry(sweep *s, const toi_part *a, const toi_part *b, double from, double until, vec3 *hint);

/* Is a gap open all along a piece at both of whose ends it is? At a share x of it a gap is above its chord less
 * 4 dip x (1 - x): where it grows or closes quickly, that is least at an end, and else the parabola's own least. */
static inline bool sweep_keeps_open(double first, double last, double dip)
{
    double bow = 4 * dip, slow = bow - fabs(last - first), sag = slow > 0 ? slow * slow / (4 * bow) * (1 + 0x1p-40) : 0;
    return first > sag && last > sag;
}

/* The place at the end of so many least pieces. */
const sweep_place *sweep_place_at(sweep *s, uint32_t index);

/* s: the end of so many least pieces; and how many there are at a time. */
static inline double sweep_time(const sweep *s, double pieces)
{
    return pieces < s->ends ? s->start + pieces * s->least : s->end;
}
static inline double sweep_index(const sweep *s, double time)
{
    double pieces = (time - s->start) / s->least;
    return pieces > 0 ? pieces : 0;
}

/* The share of the dip that a direction has: none along the axis that a body turns about. */
static inline double sweep_share(const sweep *s, vec3 d)
{
    if (s->frame != COURSE_STILL || s->course.straight) return 1;
    double across_a = s->bend_a > 0 ? vec_norm(vec_cross(d, s->course.spin_a.axis)) : 0;
    double across_b = s->bend_b > 0 ? vec_norm(vec_cross(d, s->course.spin_b.axis)) : 0;
    return s->bend_a * across_a + s->bend_b * across_b + 0x1p-45;
}

/* m: how far a gap along any direction dips within so many pieces at most. */
static inline double sweep_dip(const sweep *s, uint32_t pieces)
{
    double time = pieces * s->least * (1 + 8 * 0x1p-53);
    return s->bend * time * time / 8 * (1 + 0x1p-48);
}

/* ==== leaves of two meshes ==== */

/* The triangles of two leaves of meshes, all pairs of them side by side: which may meet, and from when on.
 * One direction, at both ends of a piece of the motion, decides up to 16 pairs at once. */

enum { LEAF_PAIRS = MESH_LEAF_MAX * MESH_LEAF_MAX };

/* Is it a leaf of a mesh, whose children are its triangles? */
bool toi_leaves_apply(const toi_part *p);

/* Given that they do not meet before `from`: entry[MESH_LEAF_MAX * i + k] is a time before which triangle i of A and k
 * of B do not, either. INFINITY: not before `until`, or there is no such triangle. */
void toi_leaves_entries(
    sweep *s, const toi_part *a, const toi_part *b, double from, double until, double entry[LEAF_PAIRS]);

/* ==== shapes of parts ==== */

/* The time of impact of shapes of which one or both are made of parts. */

/* As toi_find, for shapes to which toi_parts_apply; the poses at lo are not filled in. */
void toi_walk(
    const toi_mover *a, const toi_mover *b, const toi_request *request, narrow_scratch *scratch, toi_result *out);

/* toi_find of two convex shapes in canonical order; *out is left as it is where they are free. `from`: they are proven
 * to be free before. `rough`: within the tolerance is as good as contact, and no proof of it is looked for. */
void toi_convex(const toi_mover *a, const toi_mover *b, const toi_request *request, vec3 guess, double from, bool rough,
    narrow_scratch *scratch, toi_result *out);

#endif
