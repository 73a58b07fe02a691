// fcl_shapes: FCL's geometries, and glibc's hook for whatever asserts in this process.
#include "fcl_shapes.h"

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
#include <vector>

jmp_buf fcl_back;
bool fcl_armed;

namespace
{

using geometry = fcl::CollisionGeometry<double>;

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

} // namespace

std::shared_ptr<geometry> fcl_shape_of(const narrow_body &b)
{
    auto s = shape_of(b);
    s->computeLocalAABB();
    return s;
}

fcl::Transform3<double> fcl_transform_of(const narrow_place &at)
{
    fcl::Transform3<double> t = fcl::Transform3<double>::Identity();
    t.linear() = Eigen::Quaterniond(at.q[0], at.q[1], at.q[2], at.q[3]).toRotationMatrix();
    t.translation() = fcl::Vector3<double>(at.p[0], at.p[1], at.p[2]);
    return t;
}

extern "C" void __assert_fail(const char *what, const char *file, unsigned line, const char *function) noexcept
{
    if (fcl_armed) longjmp(fcl_back, 1);
    std::fprintf(stderr, "%s:%u: %s: Assertion `%s' failed.\n", file, line, function, what);
    std::abort();
}
