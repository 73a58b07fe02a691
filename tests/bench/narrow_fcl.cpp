// narrow_fcl: FCL through its public functions (distance, collide) with libccd's solver, and its own solver ("indep"),
// whose guess can be kept from frame to frame.
//
// FCL fails by exceptions, and its package by assertions, too, which would end the whole race. So an assertion that
// fails during a query leads back to it (what FCL held is lost); it counts as failed and is not asked again.
#include "narrow_peer.h"

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <map>
#include <memory>
#include <vector>

namespace
{

using geometry = fcl::CollisionGeometry<double>;
using transform = fcl::Transform3<double>;

std::shared_ptr<geometry> hull_of(const narrow_polytope &p)
{
    auto vertices = std::make_shared<std::vector<fcl::Vector3<double>>>();
    auto faces = std::make_shared<std::vector<int>>();
    for (size_t i = 0; i < p.vertex_count; i++)
        vertices->emplace_back(p.vertices[3 * i], p.vertices[3 * i + 1], p.vertices[3 * i + 2]);
    for (size_t f = 0; f < p.face_count; f++) {
        faces->push_back(int(p.face_first[f + 1] - p.face_first[f]));
        for (uint32_t i = p.face_first[f]; i < p.face_first[f + 1]; i++) faces->push_back(int(p.face_vertices[i]));
    }
    return std::make_shared<fcl::Convex<double>>(vertices, int(p.face_count), faces);
}

std::shared_ptr<geometry> mesh_of(const narrow_polytope &p)
{
    std::vector<fcl::Vector3<double>> vertices;
    std::vector<fcl::Triangle> triangles;
    for (size_t i = 0; i < p.vertex_count; i++)
        vertices.emplace_back(p.vertices[3 * i], p.vertices[3 * i + 1], p.vertices[3 * i + 2]);
    for (size_t f = 0; f < p.face_count; f++) {
        const uint32_t *v = &p.face_vertices[p.face_first[f]];
        triangles.emplace_back(v[0], v[1], v[2]);
    }
    auto m = std::make_shared<fcl::BVHModel<fcl::OBBRSS<double>>>();
    m->beginModel();
    m->addSubModel(vertices, triangles);
    m->endModel();
    return m;
}

std::shared_ptr<geometry> shape_of(const narrow_body &b)
{
    const double *h = b.half;
    switch (b.kind) {
    case KIND_SPHERE:
        return std::make_shared<fcl::Sphere<double>>(b.radius);
    case KIND_CAPSULE:
        return std::make_shared<fcl::Capsule<double>>(b.radius, 2 * h[2]);
    case KIND_BOX:
        return std::make_shared<fcl::Box<double>>(2 * h[0], 2 * h[1], 2 * h[2]);
    case KIND_CYLINDER:
        return std::make_shared<fcl::Cylinder<double>>(h[0], 2 * h[2]);
    case KIND_CONE:
        return std::make_shared<fcl::Cone<double>>(h[0], 2 * h[2]);
    case KIND_ELLIPSOID:
        return std::make_shared<fcl::Ellipsoid<double>>(h[0], h[1], h[2]);
    case KIND_MESH:
        return mesh_of(*b.polytope);
    default:
        return hull_of(*b.polytope);
    }
}

transform transform_of(const narrow_place &at)
{
    transform t = transform::Identity();
    t.linear() = Eigen::Quaterniond(at.q[0], at.q[1], at.q[2], at.q[3]).toRotationMatrix();
    t.translation() = fcl::Vector3<double>(at.p[0], at.p[1], at.p[2]);
    return t;
}

struct item {
    const geometry *a, *b;
    transform at_a, at_b;
    bool begins;
};

struct self {
    std::map<const narrow_body *, std::shared_ptr<geometry>> shapes;
    std::vector<item> items;
    std::vector<bool> dies; // by item: it ended in an assertion
    bool coherent;
    fcl::DistanceRequest<double> distance;
    fcl::CollisionRequest<double> collision;
};

self *create_asking(
    const narrow_item *items, size_t count, const narrow_row *row, fcl::GJKSolverType solver, double tolerance)
{
    auto *s = new self;
    bool apart = row->regime == REGIME_SEPARATED;
    s->coherent = row->coherent;
    s->distance = fcl::DistanceRequest<double>(false, !apart, 0, 0, tolerance, solver);
    s->collision = fcl::CollisionRequest<double>(8, true, 1, false, true, solver, tolerance);
    s->dies.resize(count);
    for (size_t i = 0; i < count; i++) {
        for (const narrow_body *b : {items[i].a, items[i].b})
            if (!s->shapes.count(b)) {
                s->shapes[b] = shape_of(*b);
                s->shapes[b]->computeLocalAABB();
            }
        s->items.push_back({s->shapes[items[i].a].get(), s->shapes[items[i].b].get(), transform_of(items[i].at_a),
            transform_of(items[i].at_b), items[i].begins});
    }
    return s;
}

void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row, fcl::GST_LIBCCD, 1e-6);
}

void *create_fine(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row, fcl::GST_LIBCCD, 1e-12);
}

void *create_indep(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row, fcl::GST_INDEP, 1e-6);
}

void destroy(void *context)
{
    auto *s = static_cast<self *>(context);
    auto dead = std::count(s->dies.begin(), s->dies.end(), true);
    if (dead) std::fprintf(stderr, "  fcl: %td queries ended in a failed assertion\n", dead);
    delete s;
}

jmp_buf back;
bool armed; // an assertion leads back, instead of ending the process

narrow_answer failure()
{
    narrow_answer out = {};
    out.failed = true;
    return out;
}

typedef narrow_answer one(self &s, const item &it);

void query(self &s, size_t first, size_t count, narrow_answer *out, one *ask)
{
    volatile size_t i = 0; // as it was when an assertion failed
    armed = true;
    if (setjmp(back) != 0) {
        s.dies[first + i] = true;
        out[i] = failure();
        i = i + 1;
    }
    for (; i < count; i = i + 1) {
        try {
            out[i] = s.dies[first + i] ? failure() : ask(s, s.items[first + i]);
        } catch (const std::exception &) {
            out[i] = failure();
        }
    }
    armed = false;
}

narrow_answer measure(self &s, const item &it)
{
    fcl::DistanceResult<double> result;
    double d = fcl::distance(it.a, it.at_a, it.b, it.at_b, s.distance, result);
    narrow_answer out = {};
    out.measured = true;
    out.overlap = d <= 0;
    out.distance = d;
    return out;
}

void query_distance(void *context, size_t first, size_t count, narrow_answer *out)
{
    query(*static_cast<self *>(context), first, count, out, measure);
}

narrow_answer collide(self &s, const item &it)
{
    fcl::CollisionResult<double> result;
    s.collision.enable_cached_gjk_guess = s.coherent && !it.begins;
    fcl::collide(it.a, it.at_a, it.b, it.at_b, s.collision, result);
    s.collision.cached_gjk_guess = result.cached_gjk_guess;
    narrow_answer out = {};
    out.overlap = out.measured = result.isCollision();
    double deepest = 0;
    for (size_t k = 0; k < result.numContacts(); k++)
        deepest = std::max(deepest, result.getContact(k).penetration_depth);
    out.distance = -deepest;
    return out;
}

void query_collide(void *context, size_t first, size_t count, narrow_answer *out)
{
    query(*static_cast<self *>(context), first, count, out, collide);
}

bool takes_all(const narrow_row *row)
{
    return row->b != KIND_COMPOUND;
}

bool takes_contact(const narrow_row *row)
{
    return row->regime != REGIME_SEPARATED;
}

bool takes_gaps(const narrow_row *row)
{
    return row->regime == REGIME_SEPARATED && row->b != KIND_COMPOUND;
}

} // namespace

// glibc's, for whatever asserts in this process.
extern "C" void __assert_fail(const char *what, const char *file, unsigned line, const char *function) noexcept
{
    if (armed) longjmp(back, 1);
    std::fprintf(stderr, "%s:%u: %s: Assertion `%s' failed.\n", file, line, function, what);
    std::abort();
}

const narrow_peer narrow_fcl = {"fcl", "distance(), libccd's solver, tolerance 1e-6 (default), signed in contact",
    false, takes_all, create, query_distance, destroy};
const narrow_peer narrow_fcl_fine = {"fcl_fine", "distance(), libccd's solver, tolerance 1e-12, signed in contact",
    false, takes_all, create_fine, query_distance, destroy};
const narrow_peer narrow_fcl_collide = {"fcl_collide", "collide(), libccd's solver, tolerance 1e-6, 8 contacts", false,
    takes_contact, create, query_collide, destroy};
const narrow_peer narrow_fcl_indep = {
    "fcl_indep", "distance(), FCL's solver", false, takes_gaps, create_indep, query_distance, destroy};
const narrow_peer narrow_fcl_indep_collide = {"fcl_indep_collide",
    "collide(), FCL's solver, 8 contacts; coherent: cached guess", false, takes_contact, create_indep, query_collide,
    destroy};
