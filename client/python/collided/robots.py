"""Robots: bodies that move by joints, and configurations and motions that are tried out without moving anything."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from ._native import ffi, lib
from .arrays import Vector, vector
from .shapes import Pose


class JointType(IntEnum):
    """How a joint moves its link."""

    FIXED = 0
    REVOLUTE = 1
    CONTINUOUS = 2
    PRISMATIC = 3


@dataclass(frozen=True)
class Joint:
    """A link, and the joint that moves it, as in URDF. `parent`: the place in the list of a joint before this one, -1 = the
    base. `body`: the name of the body that is the link, whose frame is the link's; "" = none. `mimics`: the place of the joint
    whose value times `factor` plus `offset` is this one's."""

    type: JointType
    parent: int = -1
    origin: Pose = Pose()
    axis: Vector = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    body: str = ""
    mimics: int | None = None
    factor: float = 1.0
    offset: float = 0.0


class Robot:
    """A kinematic tree whose links are bodies: `joints`, each behind its parent, and where the base is, world."""

    def __init__(self, joints: Sequence[Joint], base: Pose = Pose()):
        self.joints = tuple(joints)
        self.base = base
        self._names = [ffi.new("char[]", joint.body.encode()) for joint in self.joints]
        self._joints = ffi.new("collided_joint[]", max(1, len(self.joints)))
        self._c = ffi.new("collided_robot *")
        for to, name, joint in zip(self._joints, self._names, self.joints):
            to.parent, to.type, to.body = joint.parent, joint.type, name
            to.origin.position, to.origin.orientation = joint.origin.position, joint.origin.wxyz
            to.axis = vector("axis", joint.axis, 3)
            to.lower, to.upper = joint.lower, joint.upper
            to.mimics, to.mimic = joint.mimics is not None, -1 if joint.mimics is None else joint.mimics
            to.factor, to.offset = joint.factor, joint.offset
        self._c.joints, self._c.joint_count = self._joints, len(self.joints)
        self._c.base.position, self._c.base.orientation = base.position, base.wxyz

    @property
    def native(self) -> Any:
        """A `collided_robot *`, which lives as long as this."""
        return self._c

    @property
    def coordinates(self) -> int:
        """How many numbers a configuration has: those of the joints that move and mimic no other, in their order."""
        return int(lib.collided_robot_coordinates(self._c))


class Verdict(IntEnum):
    """Of a configuration, or of a motion. FREE and MEETS are proven; UNDECIDED is not free; NOT_DONE: the time ran out."""

    FREE = 0
    MEETS = 1
    UNDECIDED = 2
    NOT_DONE = 3


@dataclass(frozen=True)
class Tried:
    """What is told of a configuration, or of a straight line in joint space. `free_until`: of a line, the share of it that is
    free for certain, and `met_at` where it meets something, if it does. [lo, hi] (m): the least distance, if it was measured.
    `a`, `b`: who meets, or is in doubt, or is nearest; "" = nobody."""

    verdict: Verdict
    free_until: float
    met_at: float
    lo: float
    hi: float
    a: str
    b: str


def options(margin_m: float, resolution_m: float, find_first: bool, measure: bool, tolerance_m: float) -> Any:
    """A `collided_check_options *`."""
    made = ffi.new("collided_check_options *")
    made.margin_m, made.resolution_m, made.tolerance_m = margin_m, resolution_m, tolerance_m
    made.find_first, made.measure = find_first, measure
    return made


def _name(text: Any) -> str:
    return "" if text == ffi.NULL else bytes(ffi.string(text)).decode()


def tried(answer: Any) -> list[Tried]:
    """Of a `collided_checked *`, its items."""
    items = (answer.items[i] for i in range(answer.count))
    return [Tried(Verdict(item.verdict), item.first_lo, item.first_hi, item.lo, item.hi, _name(item.name_a), _name(item.name_b))
            for item in items]


def state(positions: Vector, velocities: Vector | None, base: Pose | None, teleport: bool) -> tuple[Any, int, list[Any]]:
    """A `collided_joint_state *`, how many positions it has, and what has to live as long as it."""
    made = ffi.new("collided_joint_state *")
    count = len(positions)
    keep = [ffi.new("double[]", vector("positions", positions, count))]
    made.positions, made.teleport = keep[0], teleport
    if velocities is not None:
        keep.append(ffi.new("double[]", vector("velocities", velocities, count)))
        made.velocities = keep[-1]
    if base is not None:
        keep.append(ffi.new("collided_pose *"))
        keep[-1].position, keep[-1].orientation = base.position, base.wxyz
        made.base = keep[-1]
    return made, count, keep


def rows(name: str, numbers: Any, each: int) -> Any:
    """A float64 array of so many numbers a row, whatever its own shape is behind the first axis."""
    array = np.ascontiguousarray(numbers, dtype=np.float64)
    if array.ndim < 1 or array.size != len(array) * each:
        raise ValueError(f"{name} has the shape {array.shape}: {each} numbers for each of them are needed")
    return array.reshape(len(array), each)
