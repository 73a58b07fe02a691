// fcl_shapes: the bodies of the races as FCL has them, and its assertions caught: FCL's package fails by assertions,
// too, which would end a whole race. One that fails while `fcl_armed` leads back to `fcl_back` (what FCL held is lost).
#ifndef COLLIDED_TESTS_BENCH_FCL_SHAPES_H
#define COLLIDED_TESTS_BENCH_FCL_SHAPES_H

#include "narrow_peer.h"

#include <csetjmp>
#include <fcl/geometry/collision_geometry.h>
#include <memory>

std::shared_ptr<fcl::CollisionGeometry<double>> fcl_shape_of(const narrow_body &b); // with its box computed
fcl::Transform3<double> fcl_transform_of(const narrow_place &at);

extern jmp_buf fcl_back;
extern bool fcl_armed;

#endif
