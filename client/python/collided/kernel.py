"""The small checker that a machine has proven, collided_check.h: what an accepted certificate proves, and what it does not, says
CERTIFICATE.md, which libcollided-dev installs. Slower than `verify`, and with a status that says what is missing."""

from dataclasses import dataclass
from enum import IntEnum
from math import inf
from typing import Any

import numpy as np

from ._native import ffi, lib
from .arrays import Floats, Vector, doubles, vector
from .shapes import Claim, Pose, Shape


class CheckStatus(IntEnum):
    """Of a check: PROVEN, what is missing for that, or which input is none."""

    PROVEN = 0
    LO_UNPROVEN = 1
    HI_UNPROVEN = 2
    DEPTH_UNPROVEN = 3
    TIME_UNPROVEN = 4
    BAD_KIND = 5
    BAD_SIZE = 6
    BAD_POSE = 7
    BAD_POINTS = 8
    BAD_CHILDREN = 9
    BAD_AXIS = 10
    BAD_CLAIM = 11
    BAD_TIMES = 12
    NO_POINTER = 13

    @property
    def text(self) -> str:
        """In words."""
        return str(ffi.string(lib.collided_check_status_text(self.value)).decode())


@dataclass(frozen=True)
class Checked:
    """What came of a check of a distance: true if all of the claim is proven. [lo, hi] (m) is what its axis and its points
    prove of the signed distance: infinite where nothing was claimed, or nothing is proven."""

    status: CheckStatus
    lo: float
    hi: float

    def __bool__(self) -> bool:
        return self.status is CheckStatus.PROVEN


def _machine() -> None:
    if not lib.collided_check_machine():
        raise ArithmeticError("this machine, or this thread's rounding, does not compute as the proofs of the checker assume")


def _fill(c: Any, shape: Shape, keep: list[Any]) -> None:
    c.kind, c.half, c.radius, c.deviation = shape.type, shape.half, shape.radius, shape.deviation
    c.pose = (*shape.pose.position, *shape.pose.wxyz)
    if shape.points is not None:
        points = np.ascontiguousarray(shape.points, dtype=np.float64)
        keep.append(ffi.from_buffer("double[]", points))
        c.points, c.point_count = keep[-1], len(points)
    if shape.children:
        children = ffi.new("collided_check_shape[]", len(shape.children))
        keep.append(children)
        for child, of in zip(children, shape.children):
            _fill(child, of, keep)
        c.children, c.child_count = children, len(shape.children)


def _shape(shape: Shape, keep: list[Any]) -> Any:
    c = ffi.new("collided_check_shape *")
    _fill(c, shape, keep)
    return c


def _pose(pose: Pose) -> Any:
    return ffi.new("double[7]", (*pose.position, *pose.wxyz))


def check(a: Shape, pose_a: Pose, b: Shape, pose_b: Pose, claim: Claim, *, allowed_m: float = 1e-9) -> Checked:
    """Is the claim, an Event or a Hit, proven by its axis and its points, for the two shapes at these poses of their bodies?
    `allowed_m`: its lo may be above what is proven, and its hi below, by less than this, since the daemon rounds the points
    that it sends; 0: the claim has to hold as it stands. Bad input is told by the status, and raises nothing. Raises
    ArithmeticError where the machine does not compute as the proofs assume."""
    _machine()
    keep: list[Any] = []
    c = ffi.new("collided_check_claim *")
    c.lo, c.hi = float(claim.lo), float(claim.hi)
    c.axis, c.point_a, c.point_b = (vector(name, getattr(claim, name), 3) for name in ("axis", "point_a", "point_b"))
    proven = ffi.new("collided_check_proven *")
    status = lib.collided_check_distance(_shape(a, keep), _pose(pose_a), _shape(b, keep), _pose(pose_b), c, float(allowed_m), proven)
    return Checked(CheckStatus(status), proven.lo, proven.hi)


def check_motion(a: Shape, b: Shape, times: Floats, poses_a: Floats, poses_b: Floats, axes: Floats, *, speed: float = inf,
                 bend: float = inf, margin_m: float = 0.0) -> tuple[CheckStatus, float]:
    """Is it proven that two shapes that move are farther apart than the margin, from the first to the last of the times? They
    are looked at at each of `times`, (n,): poses_a and poses_b, (n, 7), are positions and wxyz of their bodies then, and `axes`,
    (n, 3), what parts them. No point of A moves relative to one of B by more than `speed` x the time that it takes, and no such
    velocity changes by more than `bend` x the time: these bounds are believed. The second number is the time until which it is
    proven: the first of them if nothing is, NaN for bad input. C-contiguous float64 arrays."""
    _machine()
    keep: list[Any] = []
    count = len(times)
    m = ffi.new("collided_check_motion *")
    m.count, m.speed, m.bend, m.margin = count, float(speed), float(bend), float(margin_m)
    arrays = [doubles("times", times[:, None] if isinstance(times, np.ndarray) else times, count, 1),
              doubles("poses_a", poses_a, count, 7), doubles("poses_b", poses_b, count, 7), doubles("axes", axes, count, 3)]
    m.times, m.poses_a, m.poses_b, m.axes = arrays
    until = ffi.new("double *")
    status = lib.collided_check_motion_free(_shape(a, keep), _shape(b, keep), m, until)
    return CheckStatus(status), float(until[0])


def check_twist(a: Shape, linear_a: Vector, angular_a: Vector, b: Shape, linear_b: Vector,
                angular_b: Vector) -> tuple[CheckStatus, float, float]:
    """Speed and bend for check_motion, of two bodies that each move at a constant velocity, m/s and rad/s in world axes."""
    _machine()
    keep: list[Any] = []
    velocities = [ffi.new("double[3]", vector(name, v, 3)) for name, v in
                  (("linear_a", linear_a), ("angular_a", angular_a), ("linear_b", linear_b), ("angular_b", angular_b))]
    out = ffi.new("double[2]")
    status = lib.collided_check_twist(_shape(a, keep), *velocities[:2], _shape(b, keep), *velocities[2:], out, out + 1)
    return CheckStatus(status), float(out[0]), float(out[1])
