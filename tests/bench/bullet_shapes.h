// bullet_shapes: the bodies of the races as Bullet has them, in double precision (the -float64 libraries), with margin
// 0: with its margins a box is rounded or grown, and its distances are those of another body. The ellipsoid, which
// Bullet has not, is given as its user would: by its support function. No meshes.
#ifndef COLLIDED_TESTS_BENCH_BULLET_SHAPES_H
#define COLLIDED_TESTS_BENCH_BULLET_SHAPES_H

#include "narrow_peer.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <memory>

std::unique_ptr<btConvexShape> bullet_shape_of(const narrow_body &b);
btTransform bullet_transform_of(const narrow_place &at);

#endif
