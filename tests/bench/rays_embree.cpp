// rays_embree: Embree 3 as a contender, in its single precision: balls as spheres, capsules as round linear curves,
// boxes as twelve triangles.
#include "rays_peer.h"

#include <cmath>
#include <cstdio>
#include <embree3/rtcore.h>
#include <vector>

namespace
{

struct point {
    float x, y, z, radius;
};

struct world {
    RTCDevice device;
    RTCScene scene;
};

point end_of(const rays_body &b, double along)
{
    double axes[3][3];
    rays_axes(&b, axes);
    return {float(b.at[0] + along * axes[2][0]), float(b.at[1] + along * axes[2][1]),
        float(b.at[2] + along * axes[2][2]), float(b.radius)};
}

template <class T>
void fill(RTCGeometry g, RTCBufferType type, RTCFormat format, size_t stride, const std::vector<T> &from)
{
    auto *to = static_cast<T *>(rtcSetNewGeometryBuffer(g, type, 0, format, stride, from.size() * sizeof(T) / stride));
    for (size_t i = 0; i < from.size(); i++) to[i] = from[i];
}

void attach(world *w, RTCGeometry g)
{
    rtcCommitGeometry(g);
    rtcAttachGeometry(w->scene, g);
    rtcReleaseGeometry(g);
}

void add_balls(world *w, const rays_scene *s)
{
    std::vector<point> points;
    for (size_t i = 0; i < s->body_count; i++)
        if (s->bodies[i].kind == RAYS_BALL) points.push_back(end_of(s->bodies[i], 0));
    RTCGeometry g = rtcNewGeometry(w->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, sizeof(point), points);
    attach(w, g);
}

void add_capsules(world *w, const rays_scene *s)
{
    std::vector<point> points;
    std::vector<uint32_t> firsts;
    for (size_t i = 0; i < s->body_count; i++) {
        const rays_body &b = s->bodies[i];
        if (b.kind != RAYS_CAPSULE) continue;
        firsts.push_back(uint32_t(points.size()));
        points.push_back(end_of(b, -b.half[2]));
        points.push_back(end_of(b, b.half[2]));
    }
    RTCGeometry g = rtcNewGeometry(w->device, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
    fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, sizeof(point), points);
    fill(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, sizeof(uint32_t), firsts);
    attach(w, g);
}

// Corner c has x, y, z on the upper side where bits 0, 1, 2 are set.
void add_boxes(world *w, const rays_scene *s)
{
    static const uint32_t FACES[6][4] = {
        {0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    std::vector<float> corners;
    std::vector<uint32_t> triangles;
    for (size_t i = 0; i < s->body_count; i++) {
        const rays_body &b = s->bodies[i];
        if (b.kind != RAYS_BOX) continue;
        double axes[3][3];
        rays_axes(&b, axes);
        auto first = uint32_t(corners.size() / 3);
        for (int c = 0; c < 8; c++)
            for (int k = 0; k < 3; k++) {
                double at = b.at[k];
                for (int j = 0; j < 3; j++) at += (c >> j & 1 ? b.half[j] : -b.half[j]) * axes[j][k];
                corners.push_back(float(at));
            }
        for (const auto &f : FACES)
            for (uint32_t corner : {f[0], f[1], f[2], f[0], f[2], f[3]}) triangles.push_back(first + corner);
    }
    RTCGeometry g = rtcNewGeometry(w->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), corners);
    fill(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles);
    attach(w, g);
}

void *create(const rays_scene *s)
{
    auto *w = new world{rtcNewDevice("threads=1"), nullptr};
    if (!w->device) {
        std::fprintf(stderr, "embree: skipped, for it has no device here\n");
        delete w;
        return nullptr;
    }
    w->scene = rtcNewScene(w->device);
    rtcSetSceneBuildQuality(w->scene, RTC_BUILD_QUALITY_MEDIUM);
    add_balls(w, s);
    add_capsules(w, s);
    add_boxes(w, s);
    rtcCommitScene(w->scene);
    return w;
}

rays_answer ask(void *context, const rays_ray *r, double length)
{
    auto *w = static_cast<world *>(context);
    RTCIntersectContext how;
    rtcInitIntersectContext(&how);
    RTCRayHit q = {};
    q.ray.org_x = float(r->from[0]), q.ray.org_y = float(r->from[1]), q.ray.org_z = float(r->from[2]);
    q.ray.dir_x = float(r->direction[0]), q.ray.dir_y = float(r->direction[1]), q.ray.dir_z = float(r->direction[2]);
    q.ray.tfar = float(length);
    q.ray.mask = ~0u;
    q.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(w->scene, &how, &q);
    double t = q.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : double(q.ray.tfar);
    return {t, t};
}

void destroy(void *context)
{
    auto *w = static_cast<world *>(context);
    rtcReleaseScene(w->scene);
    rtcReleaseDevice(w->device);
    delete w;
}

} // namespace

const rays_peer rays_embree = {"embree", 1e-3, create, ask, destroy, "rtcIntersect1"};
