/* Convex decomposition: the hulls hold the solid, the bound of the deviation holds and is not far above what occurs,
 * the same mesh gives the same hulls. Solids are made here: cubes of a grid, a torus. Whether a point is in a solid is
 * known from the formula that made it, and by the sum of solid angles (van Oosterom and Strackee, 1983), which shares
 * nothing with the loaders. */
#include "fixture.h"
#include "loaders/decompose/decompose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 6, SAMPLES = 100000 };

typedef struct model {
    pool pool;
    mesh_triangles mesh;
    double *points;
    int32_t *corners;
    double lo[3], hi[3];
    bool full[SIDE][SIDE][SIDE]; /* cubes of side 0.1, the first at the origin */
    bool torus;
} model;

/* ---- making solids ---- */

static const double EDGE = 0.1;

static bool is_full(const model *m, int x, int y, int z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < SIDE && y < SIDE && z < SIDE && m->full[x][y][z];
}

/* The face of cube c towards `way` along `axis`: two triangles, counter-clockwise from outside. */
static void add_face(model *m, const int c[3], int axis, int way)
{
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    int32_t first = (int32_t)m->mesh.point_count;
    for (int i = 0; i < 4; i++) {
        double *p = m->points + 3 * m->mesh.point_count++;
        p[axis] = EDGE * (c[axis] + (way > 0));
        p[u] = EDGE * (c[u] + (i == 1 || i == 2));
        p[v] = EDGE * (c[v] + (i >= 2));
    }
    const int32_t order[] = {0, 1, 2, 0, 2, 3};
    for (size_t i = 0; i < 6; i++) m->corners[3 * m->mesh.count + i] = first + order[way > 0 ? i : 5 - i];
    m->mesh.count += 2;
}

static void finish_model(model *m)
{
    m->mesh.points = m->points;
    m->mesh.corners = m->corners;
    for (int k = 0; k < 3; k++) m->lo[k] = INFINITY, m->hi[k] = -INFINITY;
    for (size_t i = 0; i < 3 * m->mesh.point_count; i++) {
        m->lo[i % 3] = fmin(m->lo[i % 3], m->points[i]);
        m->hi[i % 3] = fmax(m->hi[i % 3], m->points[i]);
    }
}

static void mesh_of_cubes(model *m)
{
    m->points = pool_alloc(&m->pool, (size_t)SIDE * SIDE * SIDE * 24, 3 * sizeof *m->points);
    m->corners = pool_alloc(&m->pool, (size_t)SIDE * SIDE * SIDE * 12, 3 * sizeof *m->corners);
    for (int x = 0; x < SIDE; x++)
        for (int y = 0; y < SIDE; y++)
            for (int z = 0; z < SIDE; z++)
                for (int side = 0; side < 6; side++) {
                    int c[3] = {x, y, z}, next[3] = {x, y, z}, way = side % 2 ? 1 : -1;
                    next[side / 2] += way;
                    if (!is_full(m, x, y, z) || is_full(m, next[0], next[1], next[2])) continue;
                    add_face(m, c, side / 2, way);
                }
    finish_model(m);
}

static void fill(model *m, int x0, int x1, int y0, int y1, int z0, int z1, bool value)
{
    for (int x = x0; x < x1; x++)
        for (int y = y0; y < y1; y++)
            for (int z = z0; z < z1; z++) m->full[x][y][z] = value;
}

enum { RINGS = 20, TUBES = 10 };
static const double RING = 0.2, TUBE = 0.05;

static void mesh_of_torus(model *m)
{
    m->torus = true;
    m->points = pool_alloc(&m->pool, (size_t)RINGS * TUBES, 3 * sizeof *m->points);
    m->corners = pool_alloc(&m->pool, (size_t)RINGS * TUBES * 2, 3 * sizeof *m->corners);
    for (int i = 0; i < RINGS; i++)
        for (int k = 0; k < TUBES; k++) {
            double a = 2 * M_PI * i / RINGS, b = 2 * M_PI * k / TUBES, r = RING + TUBE * cos(b);
            double *p = m->points + 3 * m->mesh.point_count++;
            p[0] = r * cos(a), p[1] = r * sin(a), p[2] = TUBE * sin(b);
            int32_t i1 = (i + 1) % RINGS, k1 = (k + 1) % TUBES;
            int32_t quad[] = {i * TUBES + k, i1 * TUBES + k, i1 * TUBES + k1, i * TUBES + k1};
            const int order[] = {0, 1, 2, 0, 2, 3};
            for (int j = 0; j < 6; j++) m->corners[3 * m->mesh.count + (size_t)j] = quad[order[j]];
            m->mesh.count += 2;
        }
    finish_model(m);
}

enum { L, U, STAIRS, HOLE, CAVITY, CROSS, TORUS, RANDOM, MODELS = RANDOM + 1 };

static void make_model(model *m, int which)
{
    memset(m, 0, sizeof *m);
    switch (which) {
    case L:
        fill(m, 0, 6, 0, 2, 0, 1, true), fill(m, 0, 1, 0, 2, 0, 6, true);
        break;
    case U:
        fill(m, 0, 6, 0, 3, 0, 6, true), fill(m, 2, 4, 0, 3, 1, 6, false);
        break;
    case STAIRS:
        for (int i = 0; i < 6; i++) fill(m, i, i + 1, 0, 3, 0, i + 1, true);
        break;
    case HOLE:
        fill(m, 0, 6, 0, 2, 0, 6, true), fill(m, 2, 4, 0, 2, 2, 4, false);
        break;
    case CAVITY: /* nothing of it is seen from outside */
        fill(m, 0, 6, 0, 6, 0, 6, true), fill(m, 2, 4, 2, 4, 2, 4, false);
        break;
    case CROSS:
        fill(m, 2, 4, 0, 2, 0, 6, true), fill(m, 0, 6, 0, 2, 2, 4, true);
        break;
    case TORUS:
        mesh_of_torus(m);
        return;
    default:
        srand48(which);
        for (int i = 0; i < SIDE * SIDE * SIDE; i++) (&m->full[0][0][0])[i] = drand48() < 0.6;
    }
    mesh_of_cubes(m);
}

/* ---- oracles ---- */

/* Of the sum over the triangles in units of the whole sphere. */
static double winding(const model *m, const double x[3])
{
    double sum = 0;
    for (size_t i = 0; i < m->mesh.count; i++) {
        double v[3][3], n[3];
        for (int k = 0; k < 3; k++) {
            const double *p = m->points + 3 * m->corners[3 * i + (size_t)k];
            for (int j = 0; j < 3; j++) v[k][j] = p[j] - x[j];
            n[k] = sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
        }
        double det = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) -
                     v[0][1] * (v[1][0] * v[2][2] - v[1][2] * v[2][0]) +
                     v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        double d01 = 0, d12 = 0, d20 = 0;
        for (int j = 0; j < 3; j++) d01 += v[0][j] * v[1][j], d12 += v[1][j] * v[2][j], d20 += v[2][j] * v[0][j];
        sum += 2 * atan2(det, n[0] * n[1] * n[2] + d01 * n[2] + d12 * n[0] + d20 * n[1]);
    }
    return sum / (4 * M_PI);
}

static double point_box(const double x[3], const int c[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double d = fmax(fmax(EDGE * c[k] - x[k], x[k] - EDGE * (c[k] + 1)), 0);
        sum += d * d;
    }
    return sqrt(sum);
}

/* Distance from the solid. The torus is the round one: its mesh is within it, by less than `coarse`. */
static double solid_distance(const model *m, const double x[3])
{
    if (m->torus) return fmax(hypot(hypot(x[0], x[1]) - RING, x[2]) - TUBE, 0);
    double best = INFINITY;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        int c[3] = {i / (SIDE * SIDE), i / SIDE % SIDE, i % SIDE};
        if (m->full[c[0]][c[1]][c[2]]) best = fmin(best, point_box(x, c));
    }
    return best;
}

/* The facets' planes of a hull: those of all triples of points that have no point above. */
typedef struct facets {
    double (*planes)[4];
    size_t count;
} facets;

static bool all_below(const mesh_points *h, const double n[3], double offset)
{
    for (size_t i = 0; i < h->count; i++)
        if (n[0] * h->at[3 * i] + n[1] * h->at[3 * i + 1] + n[2] * h->at[3 * i + 2] > offset + 1e-9) return false;
    return true;
}

static bool is_known(const facets *f, const double n[3], double offset)
{
    for (size_t i = 0; i < f->count; i++) {
        const double *p = f->planes[i];
        if (fabs(p[0] - n[0]) + fabs(p[1] - n[1]) + fabs(p[2] - n[2]) + fabs(p[3] - offset) < 1e-9) return true;
    }
    return false;
}

static void add_plane(facets *f, const mesh_points *h, size_t i, size_t j, size_t k)
{
    const double *a = h->at + 3 * i, *b = h->at + 3 * j, *c = h->at + 3 * k;
    double u[3], v[3];
    for (int q = 0; q < 3; q++) u[q] = b[q] - a[q], v[q] = c[q] - a[q];
    double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 1e-7)) return;
    for (int way = -1; way <= 1; way += 2) {
        double m[3] = {way * n[0] / length, way * n[1] / length, way * n[2] / length};
        double offset = m[0] * a[0] + m[1] * a[1] + m[2] * a[2];
        if (!is_known(f, m, offset) && all_below(h, m, offset))
            memcpy(f->planes[f->count++], (double[]){m[0], m[1], m[2], offset}, 4 * sizeof(double));
    }
}

static facets facets_of(pool *p, const mesh_points *h)
{
    enum { FACETS_MAX = 2000 };
    facets f = {pool_alloc(p, FACETS_MAX, sizeof *f.planes), 0};
    for (size_t i = 0; i < h->count; i++)
        for (size_t j = i + 1; j < h->count; j++)
            for (size_t k = j + 1; k < h->count && f.count + 2 <= FACETS_MAX; k++) add_plane(&f, h, i, j, k);
    assert_true(f.count + 2 <= FACETS_MAX);
    return f;
}

static double outside_of(const facets *f, const double x[3])
{
    double most = -INFINITY;
    for (size_t i = 0; i < f->count; i++) {
        const double *p = f->planes[i];
        most = fmax(most, p[0] * x[0] + p[1] * x[1] + p[2] * x[2] - p[3]);
    }
    return most;
}

/* ---- what is tested ---- */

typedef struct fitted {
    fixture f;
    model m;
    decomposition d;
    facets *facets;
    double diagonal;
} fitted;

static void fit(fitted *t, int which, size_t pieces)
{
    fixture_begin(&t->f);
    make_model(&t->m, which);
    decompose_options o = {.pieces_max = pieces, .name = "model"};
    if (!decompose_mesh(&t->m.pool, &t->m.mesh, &o, &t->d, &t->f.report)) fail_msg("%s", t->f.report.error);
    assert_int_equal(t->f.report.warnings, 0);
    t->facets = pool_alloc(&t->m.pool, t->d.count, sizeof *t->facets);
    for (size_t i = 0; i < t->d.count; i++) t->facets[i] = facets_of(&t->m.pool, &t->d.hulls[i].points);
    t->diagonal = 0;
    for (int k = 0; k < 3; k++) t->diagonal = hypot(t->diagonal, t->m.hi[k] - t->m.lo[k]);
}

static void unfit(fitted *t)
{
    pool_free(&t->m.pool);
    fixture_end(&t->f);
}

/* One sample: in the solid, so in a hull; in a hull, so no farther from the solid than the hull's deviation. */
static void check_point(const fitted *t, const double x[3], double *farthest)
{
    bool held = false;
    double away = solid_distance(&t->m, x);
    for (size_t i = 0; i < t->d.count; i++) {
        double outside = outside_of(&t->facets[i], x);
        held = held || outside <= 2e-9 + t->d.radius;
        if (outside > 0) continue;
        if (away > t->d.hulls[i].deviation_m) fail_msg("%g away, not %g", away, t->d.hulls[i].deviation_m);
        farthest[i] = fmax(farthest[i], away);
    }
    if (!held && winding(&t->m, x) > 0.5) fail_msg("%.9g %.9g %.9g is in the solid and in no hull", x[0], x[1], x[2]);
}

static void check_model(int which, size_t pieces)
{
    fitted t;
    fit(&t, which, pieces);
    double *farthest = pool_alloc(&t.m.pool, t.d.count, sizeof *farthest), most = 0;
    srand48(1);
    for (int i = 0; i < SAMPLES; i++) {
        double x[3];
        for (int k = 0; k < 3; k++) x[k] = t.m.lo[k] + (t.m.hi[k] - t.m.lo[k]) * drand48();
        check_point(&t, x, farthest);
    }
    for (size_t i = 0; i < t.d.count; i++) most = fmax(most, farthest[i]);
    print_message("model %d: at most %zu hulls: %zu, deviation %.2f mm, sampled %.2f mm\n", which, pieces, t.d.count,
        1e3 * t.d.deviation_m, 1e3 * most);
    assert_true(t.d.count <= pieces);
    assert_true(t.d.deviation_m <= fmax(2 * most, 2 * DECOMPOSE_FINE_RATIO * t.diagonal));
    unfit(&t);
}

static void every_hull_holds_its_part_and_no_more_than_it_says(void **state)
{
    (void)state;
    for (int which = 0; which < MODELS; which++)
        for (size_t pieces = 1; pieces <= (getenv("COLLIDED_BRIEF") ? 1 : 10); pieces += 9) check_model(which, pieces);
}

/* Parts along the axes are found as they are, and fit but for the floor of the bound. */
static void solids_of_boxes_become_those_boxes(void **state)
{
    (void)state;
    static const struct {
        int which;
        size_t most;
    } cases[] = {{L, 3}, {U, 4}, {HOLE, 8}, {CAVITY, 8}, {CROSS, 5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        model m;
        fixture f;
        decomposition d;
        make_model(&m, cases[i].which);
        fixture_begin(&f);
        assert_true(decompose_mesh(&m.pool, &m.mesh, &(decompose_options){.name = "boxes"}, &d, &f.report));
        assert_in_range(d.count, 2, cases[i].most);
        assert_true(d.deviation_m < 2e-3);
        assert_true(d.closed && d.united > 0 && d.dropped == 0);
        fixture_end(&f);
        pool_free(&m.pool);
    }
}

static void the_same_mesh_gives_the_same_hulls(void **state)
{
    (void)state;
    decomposition d[2];
    model m;
    load_report r = {0};
    make_model(&m, CROSS);
    for (int i = 0; i < 2; i++)
        assert_true(decompose_mesh(&m.pool, &m.mesh, &(decompose_options){.name = "again"}, &d[i], &r));
    assert_int_equal(d[0].count, d[1].count);
    for (size_t i = 0; i < d[0].count; i++) {
        const decompose_hull *a = &d[0].hulls[i], *b = &d[1].hulls[i];
        assert_int_equal(a->points.count, b->points.count);
        assert_memory_equal(a->points.at, b->points.at, 3 * a->points.count * sizeof *a->points.at);
        assert_memory_equal(&a->deviation_m, &b->deviation_m, sizeof a->deviation_m);
    }
    pool_free(&m.pool);
}

static void a_target_ends_the_cutting(void **state)
{
    (void)state;
    model m;
    decomposition d;
    load_report r = {0};
    make_model(&m, STAIRS);
    decompose_options o = {.deviation_m = 0.055, .name = "stairs"};
    assert_true(decompose_mesh(&m.pool, &m.mesh, &o, &d, &r));
    assert_int_equal(d.count, 1);
    o.deviation_m = 0.045;
    assert_true(decompose_mesh(&m.pool, &m.mesh, &o, &d, &r));
    assert_true(d.count > 1 && d.deviation_m <= 0.045);
    pool_free(&m.pool);
}

/* Without one triangle: one hull, and its deviation is the distance from the others. */
static void an_open_mesh_becomes_one_hull_with_a_warning(void **state)
{
    (void)state;
    model m;
    fixture f;
    decomposition d;
    make_model(&m, U);
    fixture_begin(&f);
    m.mesh.count--;
    assert_true(decompose_mesh(&m.pool, &m.mesh, &(decompose_options){.name = "open.stl"}, &d, &f.report));
    assert_int_equal(d.count, 1);
    assert_false(d.closed);
    assert_non_null(strstr(f.warning, "open.stl: is not closed"));
    assert_true(d.deviation_m > 0.1 && d.deviation_m < 0.2);
    fixture_end(&f);
    pool_free(&m.pool);
}

/* Two triangles that have two corners in one place: of one the segment is a side of the solid, of the other it sticks
 * out, and some hull holds it. */
static void a_segment_that_sticks_out_is_in_a_hull(void **state)
{
    (void)state;
    model m;
    decomposition d;
    load_report r = {0};
    make_model(&m, U);
    double *points = pool_alloc(&m.pool, m.mesh.point_count + 1, 3 * sizeof *points);
    int32_t *corners = pool_alloc(&m.pool, m.mesh.count + 2, 3 * sizeof *corners);
    int32_t tip = (int32_t)m.mesh.point_count, more[6] = {tip, 0, 0, m.corners[0], m.corners[1], m.corners[1]};
    const double at[3] = {2, 0.1, 0.1};
    memcpy(points, m.points, 3 * m.mesh.point_count * sizeof *points);
    memcpy(points + 3 * m.mesh.point_count, at, sizeof at);
    memcpy(corners, m.corners, 3 * m.mesh.count * sizeof *corners);
    memcpy(corners + 3 * m.mesh.count, more, sizeof more);
    const mesh_triangles mesh = {points, m.mesh.point_count + 1, corners, m.mesh.count + 2};
    assert_true(decompose_mesh(&m.pool, &mesh, &(decompose_options){.name = "U"}, &d, &r));
    assert_true(d.closed);
    assert_int_equal(d.dropped, 1);
    double most = -INFINITY;
    for (size_t i = 0; i < d.count; i++)
        for (size_t k = 0; k < d.hulls[i].points.count; k++) most = fmax(most, d.hulls[i].points.at[3 * k]);
    assert_true(most >= 2 - 1e-9);
    pool_free(&m.pool);
}

static void a_flat_mesh_is_refused(void **state)
{
    (void)state;
    static const double points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    static const int32_t corners[] = {0, 1, 2, 1, 3, 2};
    fixture f;
    decomposition d;
    fixture_begin(&f);
    mesh_triangles flat = {points, 4, corners, 2};
    assert_false(decompose_mesh(&f.pool, &flat, &(decompose_options){.name = "flat.stl"}, &d, &f.report));
    assert_string_equal(f.report.error, "flat.stl: is flat: it has no hull");
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_hull_holds_its_part_and_no_more_than_it_says),
        cmocka_unit_test(solids_of_boxes_become_those_boxes),
        cmocka_unit_test(the_same_mesh_gives_the_same_hulls),
        cmocka_unit_test(a_target_ends_the_cutting),
        cmocka_unit_test(an_open_mesh_becomes_one_hull_with_a_warning),
        cmocka_unit_test(a_segment_that_sticks_out_is_in_a_hull),
        cmocka_unit_test(a_flat_mesh_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
