"""What the daemon tells, as numpy structured arrays that own their memory. Their types are read from the C structs that are
copied, once, when a batch comes."""

from collections.abc import Iterator
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._native import ffi, lib
from .errors import text_of


class Kind(IntEnum):
    """What happened to a pair. IMPACT, PREDICTED and AVERTED are COLLIDED_EVENT_... in collided.h."""

    BEGIN = 1
    UPDATE = 2
    END = 3
    NEAR = 4
    FAR = 5
    UNKNOWN = 6
    KNOWN = 7
    IMPACT = 8
    PREDICTED = 9
    AVERTED = 10


class Achieved(IntEnum):
    """What an interval is, beside what was asked."""

    CERTAIN = 0
    WITHIN = 1
    WIDE = 2
    STOPPED = 3


def _format_of(ctype: Any) -> Any:
    if ctype.kind == "enum":
        return np.dtype(np.uint32)
    if ctype.kind == "array":
        if ctype.item.cname == "char":
            return np.dtype(f"S{ctype.length}")
        return np.dtype((_format_of(ctype.item), (ctype.length,)))
    sizes = {"double": "f8", "int64_t": "i8", "int32_t": "i4", "uint8_t": "u1", "_Bool": "?"}
    return np.dtype(sizes[ctype.cname])


def _dtype_of(struct: str) -> np.dtype[np.void]:
    fields = [(name, field) for name, field in ffi.typeof(struct).fields if name != "reserved"]
    return np.dtype({"names": [name for name, _ in fields], "formats": [_format_of(field.type) for _, field in fields],
                     "offsets": [field.offset for _, field in fields], "itemsize": ffi.sizeof(struct)})


EVENT = _dtype_of("native_event")
"""contact, lo, hi, axis, point_a, point_b, age_a_s, age_b_s, closing_m_s, kind, achieved, a and b (of Batch.names), shape_a,
shape_b, first_point and points (of Batch.points), impact (of Batch.impacts, -1 = none), cause."""
POINT = _dtype_of("collided_contact_point")
"""point (world), distance (m, signed), feature."""
IMPACT = _dtype_of("native_impact")
"""lo_s, hi_s, start_ns, position_a, wxyz_a, position_b, wxyz_b, estimated."""
_HEAD_FIELDS = ("epoch", "batch", "tick", "stamp_ns", "latest_pose_ns", "oldest_pose_ns", "step", "simulation_ns", "missing",
                "refused", "undone", "heartbeat", "snapshot", "closing", "lost", "behind", "starved")  # of collided_batch
_HEAD = ffi.sizeof("native_batch")
_KINDS = {int(kind): kind for kind in Kind}
_ACHIEVED = tuple(Achieved)  # what is above, of a later daemon, promises no more than WIDE


class Event(NamedTuple):
    """One event, for people; collided_event in collided.h says what each member means."""

    kind: Kind
    a: str
    b: str
    lo: float
    hi: float
    axis: npt.NDArray[np.float64]
    point_a: npt.NDArray[np.float64]
    point_b: npt.NDArray[np.float64]
    contact: int
    cause: str
    shape_a: int
    shape_b: int
    age_a_s: float
    age_b_s: float
    closing_m_s: float
    achieved: Achieved
    points: npt.NDArray[np.void]
    impact: np.void | None


class Batch:
    """All events of one tick on one stream: `events` (EVENT), `points` (POINT), `impacts` (IMPACT), and the names that events
    give by number. The arrays are the batch's own: they may be kept, and written. Iterating makes an Event of each."""

    __slots__ = (*_HEAD_FIELDS, "refusal", "events", "points", "impacts", "_memory", "_names")
    epoch: int
    batch: int
    tick: int
    stamp_ns: int
    latest_pose_ns: int
    oldest_pose_ns: int
    step: int
    simulation_ns: int
    missing: int
    refused: int
    undone: int
    heartbeat: bool
    snapshot: bool
    closing: bool
    lost: int
    behind: int
    starved: bool

    def __init__(self, native: Any):
        """Takes over what native_take gave."""
        owner = ffi.gc(native, lib.native_free)
        head = native.head
        for name in _HEAD_FIELDS:
            setattr(self, name, getattr(head, name))
        self.refusal = text_of(native.refusal)
        at = _HEAD
        sizes = native.event_count * EVENT.itemsize, native.point_count * POINT.itemsize, native.impact_count * IMPACT.itemsize
        memory = ffi.buffer(owner, at + sum(sizes) + native.names_size)
        self.events = np.frombuffer(memory, EVENT, native.event_count, at)
        self.points = np.frombuffer(memory, POINT, native.point_count, at + sizes[0])
        self.impacts = np.frombuffer(memory, IMPACT, native.impact_count, at + sizes[0] + sizes[1])
        self._memory = memory
        self._names: tuple[str, ...] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the bodies in this batch, by the numbers `a` and `b` of its events."""
        if self._names is None:
            at = _HEAD + self.events.nbytes + self.points.nbytes + self.impacts.nbytes
            self._names = tuple(self._memory[at:].decode("utf-8", "replace").split("\0")[:-1])
        return self._names

    def __len__(self) -> int:
        return len(self.events)

    def __iter__(self) -> Iterator[Event]:
        names = self.names
        for (contact, lo, hi, axis, point_a, point_b, age_a_s, age_b_s, closing_m_s, kind, achieved, a, b, shape_a, shape_b,
             first, points, impact, cause) in self.events.tolist():
            if kind in _KINDS:  # or of a later daemon
                yield Event(_KINDS[kind], names[a], names[b], lo, hi, axis, point_a, point_b, contact, cause.decode(), shape_a,
                            shape_b, age_a_s, age_b_s, closing_m_s, _ACHIEVED[min(achieved, 3)],
                            self.points[first:first + points], self.impacts[impact] if impact >= 0 else None)

    def __repr__(self) -> str:
        return f"<Batch {self.batch} of tick {self.tick}: {len(self)} events{', snapshot' if self.snapshot else ''}>"
