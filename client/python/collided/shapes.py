"""Poses and shapes, in metres, and the check of what the daemon claims about them. Sizes are full ones, as people measure,
but for radii and semi-axes; each shape is centred at the origin of its pose, which is in the body's frame."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from . import errors
from ._native import ffi, lib
from .arrays import Floats, Vector, quaternion, vector


class Pose:
    """Where a frame is in another: metres, and a unit quaternion whose keyword says its order."""

    __slots__ = ("position", "wxyz")

    def __init__(self, position: Vector = (0.0, 0.0, 0.0), *, wxyz: Vector | None = None, xyzw: Vector | None = None):
        self.position = tuple(vector("position", position, 3))
        self.wxyz = tuple(quaternion(wxyz, xyzw))

    @property
    def xyzw(self) -> tuple[float, ...]:
        """The quaternion with its real part last."""
        return (*self.wxyz[1:], self.wxyz[0])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pose) and (self.position, self.wxyz) == (other.position, other.wxyz)

    def __hash__(self) -> int:
        return hash((self.position, self.wxyz))

    def __repr__(self) -> str:
        return f"Pose({self.position}, wxyz={self.wxyz})"


IDENTITY = Pose()


@dataclass(frozen=True)
class Shape:
    """A shape, made by one of the functions below, or by those of a Client. `radius` rounds it: all points within it of the
    rest are the shape's. What the shape stands for may be finer, by `deviation` (m) at most, and is inside of it."""

    type: int
    half: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float = 0.0
    pose: Pose = IDENTITY
    deviation: float = 0.0
    children: tuple["Shape", ...] = ()
    geometry: int = 0
    points: Floats | None = field(default=None, compare=False, repr=False)
    """Of a hull: for `verify`."""

    def at(self, position: Vector, *, wxyz: Vector | None = None, xyzw: Vector | None = None) -> "Shape":
        """The same shape elsewhere in the body."""
        return replace(self, pose=Pose(position, wxyz=wxyz, xyzw=xyzw))

    def rounded(self, radius: float) -> "Shape":
        """The same shape with that rounding."""
        return replace(self, radius=radius)


def _of(c: Any) -> Shape:
    return Shape(int(c.type), (c.half[0], c.half[1], c.half[2]), c.radius)


def sphere(radius: float) -> Shape:
    """A sphere."""
    return _of(lib.collided_sphere(radius))


def capsule(radius: float, length: float) -> Shape:
    """A capsule along z; `length` is between its two centres."""
    return _of(lib.collided_capsule(radius, length))


def box(x: float, y: float, z: float) -> Shape:
    """A box, by its full side lengths."""
    return _of(lib.collided_box(x, y, z))


def cylinder(radius: float, height: float) -> Shape:
    """A cylinder along z."""
    return _of(lib.collided_cylinder(radius, height))


def cone(radius: float, height: float) -> Shape:
    """A cone: base at z = -height/2, apex at +height/2."""
    return _of(lib.collided_cone(radius, height))


def ellipsoid(x: float, y: float, z: float) -> Shape:
    """An ellipsoid, by its semi-axes."""
    return _of(lib.collided_ellipsoid(x, y, z))


def halfspace() -> Shape:
    """All points with z <= 0."""
    return _of(lib.collided_halfspace())


def compound(children: Sequence[Shape]) -> Shape:
    """One shape that is the union of 1 to 255 others, which are no half-spaces, meshes, height fields or compounds."""
    return Shape(lib.COLLIDED_COMPOUND, children=tuple(children))


def fill_pose(c: Any, pose: Pose) -> None:
    """Writes a collided_pose."""
    c.position = pose.position
    c.orientation = pose.wxyz


def c_shapes(shapes: Sequence[Shape], keep: list[Any]) -> Any:
    """An array of collided_shape; `keep` holds what it points to."""
    array = ffi.new("collided_shape[]", len(shapes))
    keep.append(array)
    for c, shape in zip(array, shapes):
        c.type, c.half, c.radius, c.deviation = shape.type, shape.half, shape.radius, shape.deviation
        c.geometry.hash = shape.geometry
        fill_pose(c.pose, shape.pose)
        if shape.children:
            c.children, c.child_count = c_shapes(shape.children, keep), len(shape.children)
    return array


class Claim(Protocol):
    """A distance and what proves it: an Event or a Hit."""

    @property
    def lo(self) -> float: ...
    @property
    def hi(self) -> float: ...
    @property
    def axis(self) -> Vector: ...
    @property
    def point_a(self) -> Vector: ...
    @property
    def point_b(self) -> Vector: ...


def _c_hull(shape: Shape, keep: list[Any]) -> tuple[Any, int]:
    if shape.points is None:
        return ffi.NULL, 0
    points = np.ascontiguousarray(shape.points, dtype=np.float64)
    keep.append(ffi.from_buffer("double[]", points))
    return keep[-1], len(points)


def verify(a: Shape, pose_a: Pose, b: Shape, pose_b: Pose, claim: Claim) -> bool:
    """Does the claim follow from the two shapes, at these poses of their bodies? By code that shares nothing with the
    daemon's: the axis proves lo, the two points prove hi (collided_verify in collided.h says how). False: it does not
    follow. Raises BadArgument for meshes and height fields, whose distance no axis proves, and Unsupported for what
    of a compound is neither proven nor contradicted."""
    keep: list[Any] = []
    (shape_a,), (shape_b,) = c_shapes([a], keep), c_shapes([b], keep)
    poses = ffi.new("collided_pose[2]")
    fill_pose(poses[0], pose_a)
    fill_pose(poses[1], pose_b)
    c = ffi.new("collided_certificate *")
    c.lo, c.hi = float(claim.lo), float(claim.hi)
    c.axis, c.point_a, c.point_b = (vector(name, getattr(claim, name), 3) for name in ("axis", "point_a", "point_b"))
    status = lib.collided_verify(ffi.addressof(shape_a), poses, *_c_hull(a, keep), ffi.addressof(shape_b), poses + 1,
                                 *_c_hull(b, keep), c)
    if status in (lib.COLLIDED_OK, lib.COLLIDED_REJECTED):
        return bool(status == lib.COLLIDED_OK)
    raise errors.error_of(status, "")
