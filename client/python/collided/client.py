"""A client of the daemon: bodies and poses in, events and answers out. collided.h is the manual of what each function does;
here is what is different in Python.

Threads: one at a time; a second one gets an error, and nothing breaks. No Python code runs inside of the library. Ctrl-C
interrupts whatever waits for events within a tenth of a second; connecting and queries end first, which their timeouts limit.
A child that was forked cannot use the client: Forked is raised there."""

from __future__ import annotations

import asyncio
import logging
import os
import threading
import time
import warnings
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from . import errors
from ._native import ffi, lib
from .arrays import Floats, Vector, doubles, one_order, quaternion, vector
from .errors import text_of
from .events import Achieved, Batch
from .robots import Robot, Tried, options, rows, state, tried
from .shapes import IDENTITY, Pose, Shape, c_shapes, fill_pose
from .subscription import Subscription

_SLICE_S = 0.1  # a signal's handler runs between two of these
_log = logging.getLogger("collided")

Ids: TypeAlias = npt.NDArray[np.int32]
"""Bodies by their numbers, as `ids` makes them."""


class Rule(NamedTuple):
    """Ordered; the first whose pattern ('*', '?', or "group:NAME") matches the other body decides. allow: touching is
    allowed, the pair is not looked at. padding_m: they touch from there on; margin_m: they are near from so much farther."""

    pattern: str
    allow: bool = True
    reason: str = ""
    padding_m: float = 0.0
    margin_m: float = 0.0


class Rejection(NamedTuple):
    """What the daemon refused ("Body", ...), the number of the body or subscription or -1, and why."""

    message: str
    object: int
    reason: str
    text: str


@dataclass(frozen=True)
class Hit:
    """One body, or one pair, of an answer; lo and hi are certified, in m (of `sweep`: s)."""

    a: str
    b: str
    lo: float
    hi: float
    axis: tuple[float, ...]
    point_a: tuple[float, ...]
    point_b: tuple[float, ...]
    age_s: float
    stale: bool
    achieved: Achieved


@dataclass(frozen=True)
class Found:
    """A body as the daemon has it: `age_s` is -1 if its pose is not stamped; stale: where it is is unknown."""

    name: str
    pose: Pose
    age_s: float
    stale: bool


@dataclass(frozen=True)
class Status:
    """How the daemon is; counters are the daemon's and this client's own."""

    epoch: int
    tick: int
    stamp_ns: int
    started_ns: int
    health: str
    daemon: str
    release: str
    links: str
    limits: str
    counters: dict[str, int]


class Body:
    """A body of a client, made by Client.body. `data` is yours: the daemon does not see it."""

    __slots__ = ("client", "id", "name", "data")

    def __init__(self, client: Client, number: int, name: str):
        self.client = client
        self.id = number
        self.name = name
        self.data: Any = None

    def move(self, position: Vector, *, wxyz: Vector | None = None, xyzw: Vector | None = None) -> None:
        """Publishes its pose, true now; not turned if no orientation is given. Sent by whatever waits, or flush."""
        pose = ffi.new("collided_pose *", (vector("position", position, 3), quaternion(wxyz, xyzw)))
        with self.client.native() as c:
            self.client.check(lib.collided_move(c, (self.id,), pose[0]))

    def remove(self) -> None:
        """Its contacts end with the cause "removed"."""
        with self.client.native() as c:
            self.client.check(lib.collided_remove_body(c, (self.id,)))
        if self.client.bodies.get(self.name) is self:
            del self.client.bodies[self.name]

    def __repr__(self) -> str:
        return f"<Body {self.id} {self.name!r}>"


_Answer = TypeVar("_Answer")


class Answers(list[_Answer]):
    """What a query found; `truncated`: there is more, for which the answer had no room. It is of that tick."""

    def __init__(self, found: Iterable[_Answer], truncated: bool, tick: int):
        super().__init__(found)
        self.truncated = truncated
        self.tick = tick


def ids(bodies: Sequence[Body]) -> Ids:
    """The numbers of bodies: whoever publishes the same ones often makes these once."""
    return np.fromiter((body.id for body in bodies), np.int32, len(bodies))


_clients: weakref.WeakSet[Client] = weakref.WeakSet()
_dds_is_of_parent = False


def _in_child() -> None:
    """After fork(): the threads of the library did not come along."""
    global _dds_is_of_parent
    for client in [client for client in _clients if not client.closed]:
        _dds_is_of_parent = _dds_is_of_parent or client.uri.startswith("dds:")
        client.disown()


os.register_at_fork(after_in_child=_in_child)


class _Use:
    """See Client.native."""

    __slots__ = ("_client",)

    def __init__(self, client: Client):
        self._client = weakref.proxy(client)

    def __enter__(self) -> Any:
        return self._client.begin_use()

    def __exit__(self, *_: object) -> None:
        self._client.end_use()


def _close(pointer: Any, inbox: Any, process: int) -> None:
    if os.getpid() == process:
        lib.collided_close(pointer)
        lib.native_close(inbox)


class Client:
    """A connection, made by `connect`; a context manager, which closes it. `bodies` has its bodies by their names."""

    def __init__(self, uri: str, pointer: Any):
        self.uri = uri
        self.bodies: dict[str, Body] = {}
        self.rejections: deque[Rejection] = deque(maxlen=256)
        self._c = pointer
        self._inbox = lib.native_open(pointer)
        self._rejection = ffi.new("native_rejection *")
        self._received = 0  # batches and refusals
        self._forked = False
        # One that its owner may take again: a KeyboardInterrupt may come between taking it and the code that gives it back.
        self._busy = threading.RLock()
        self._use = _Use(self)
        self._subscriptions: dict[int, Subscription] = {}
        self._arrivals: set[asyncio.Future[None]] = set()
        self._turned: Floats = np.empty((0, 4))
        self._finalizer = weakref.finalize(self, _close, pointer, self._inbox, os.getpid())
        _clients.add(self)

    # ---- life ----

    def native(self) -> _Use:
        """The library's client, for one call: it is open, it is ours, and no other thread has it."""
        return self._use

    def begin_use(self) -> Any:
        """What entering `native` does."""
        if self._forked:
            raise errors.Forked("this client belongs to the process that this one was forked from: connect in the child, "
                                "or use the start method 'spawn'")
        if not self._busy.acquire(False):
            raise RuntimeError("another thread uses this client at the moment: one at a time")
        if self._c is None:
            self._busy.release()
            raise errors.BadArgument("this client is closed")
        return self._c

    def end_use(self) -> None:
        """What leaving `native` does."""
        self._busy.release()

    def check(self, status: int) -> None:
        """Raises the exception that belongs to a status."""
        if status:
            raise errors.error_of(status, text_of(lib.collided_error(self._c)))

    def disown(self) -> None:
        """In a forked child: the parent's client is not to be touched."""
        self._forked = True
        self._busy = threading.RLock()
        self._arrivals.clear()

    @property
    def closed(self) -> bool:
        """It cannot be used any more."""
        return self._c is None or self._forked

    def close(self) -> None:
        """Leaves in order: the bodies are removed at once, unless on_loss says "keep". Takes up to a second."""
        if self.closed:
            return
        with self.native() as c:
            for future in self._arrivals:
                future.get_loop().remove_reader(lib.collided_fd(c))
            self._c = None
            for subscription in self._subscriptions.values():
                subscription.closed = True
            self._subscriptions.clear()
            self._wake(None)
            self._finalizer()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self, _warn: Any = warnings.warn) -> None:
        if getattr(self, "_c", None) is not None and not self._forked:
            _warn(f"a client of {self.uri} was not closed", ResourceWarning, source=self)

    @property
    def id(self) -> int:
        """The number under which the daemon knows this client."""
        with self.native() as c:
            return int(lib.collided_client_id(c))

    # ---- receiving ----

    def _receive(self) -> bool:
        """Hands what has come to the subscriptions. True if something has."""
        before = self._received
        try:
            self._take_all()
        except BaseException:  # KeyboardInterrupt, MemoryError: a batch may have been taken, and not kept
            for subscription in self._subscriptions.values():
                subscription.lose("receiving was interrupted")
            raise
        return self._received > before

    def _take_all(self) -> None:
        while (native := lib.native_take(self._inbox)) != ffi.NULL:
            self._received += 1
            subscription = self._subscriptions.get(native.head.subscription.id)
            batch = Batch(native)
            if subscription:
                subscription.keep(batch)
        while lib.native_take_rejection(self._inbox, self._rejection):
            self._received += 1
            r = self._rejection
            rejection = Rejection(text_of(r.message), r.object, text_of(r.reason), text_of(r.text))
            self.rejections.append(rejection)
            _log.warning("the daemon refused %s %d: %s: %s", *rejection)
        if dropped := lib.native_dropped(self._inbox):
            _log.warning("%d further refusals were not kept", dropped)
        if lib.native_lost(self._inbox):
            raise MemoryError("there was no memory for a batch of events")

    def _sliced(self, call: Callable[[Any, float], int], timeout_s: float, done: Callable[[], bool]) -> int:
        """Calls with a short timeout, until it is done, or has failed, or the time is over."""
        end = time.monotonic() + timeout_s
        while True:
            left = end - time.monotonic()
            with self.native() as c:
                status = int(call(c, max(0.0, min(left, _SLICE_S))))
                self._receive()
            waits = status == lib.COLLIDED_TIMEOUT or (status == lib.COLLIDED_OK and not done())
            if not waits or left <= 0:
                return status

    def wait_for(self, done: Callable[[], bool], timeout_s: float) -> None:
        """Receives until that is true, or the time is over; raises NoDaemon if none is heard, and it is not true."""
        status = self._sliced(lib.collided_poll, timeout_s, done)
        if not done():
            self.check(status)

    def poll(self, timeout_s: float = 0.0) -> None:
        """Sends what is buffered, and receives what has come, or waits for the first of it. Raises NoDaemon."""
        before = self._received
        self.check(self._sliced(lib.collided_poll, timeout_s, lambda: self._received > before))

    def flush(self) -> None:
        """Sends what is buffered now. Whatever waits does so, too."""
        with self.native() as c:
            lib.collided_flush(c)

    def sync(self, timeout_s: float = 5.0) -> None:
        """Waits until the daemon has applied all changes, and every subscription has begun. Raises Rejected, Timeout."""
        self.check(self._sliced(lib.collided_sync, timeout_s, lambda: True))

    def fileno(self) -> int:
        """A descriptor for event loops: when it is readable, call `poll`. (asyncio: `async for` does it.)"""
        with self.native() as c:
            descriptor = int(lib.collided_fd(c))
            if descriptor < 0:
                self.check(lib.COLLIDED_TRANSPORT)
            return descriptor

    async def arrival(self) -> None:
        """Waits, in an event loop, until something has come for a subscription. Raises NoDaemon."""
        self.flush()
        loop, descriptor = asyncio.get_running_loop(), self.fileno()
        future = loop.create_future()
        self._arrivals.add(future)
        loop.add_reader(descriptor, self._readable)
        try:
            await future
        finally:
            self._arrivals.discard(future)
            if not self._arrivals and not self.closed:
                loop.remove_reader(descriptor)

    def _readable(self) -> None:
        try:
            with self.native() as c:
                status = lib.collided_poll(c, 0.0)
                came = self._receive()
                self.check(status)
        except Exception as error:  # pylint: disable=broad-except # is raised where it is awaited
            self._wake(error)
            return
        if came:
            self._wake(None)

    def _wake(self, error: Exception | None) -> None:
        for future in list(self._arrivals):
            if future.done():
                continue
            if error:
                future.set_exception(error)
            else:
                future.set_result(None)

    # ---- bodies ----

    def _geometry(self, kind: int, made: Any, points: Floats | None) -> Shape:
        if not made.hash:
            self.check(lib.COLLIDED_BAD_ARGUMENT)
        return Shape(kind, geometry=made.hash, points=points)

    def hull(self, points: Floats) -> Shape:
        """The convex hull of points (n, 3), in metres."""
        with self.native() as c:
            made = lib.collided_create_hull(c, doubles("points", points, len(points), 3), len(points))
            return self._geometry(lib.COLLIDED_HULL, made, points.copy())

    def mesh(self, points: Floats, triangles: npt.NDArray[np.int32]) -> Shape:
        """A mesh of points (n, 3) and triangles (m, 3), counter-clockwise seen from outside."""
        if triangles.dtype != np.int32 or not triangles.flags.c_contiguous or triangles.shape[1:] != (3,):
            raise TypeError("triangles: a C-contiguous int32 array (m, 3) is needed")
        with self.native() as c:
            made = lib.collided_create_mesh(c, doubles("points", points, len(points), 3), len(points),
                                            ffi.from_buffer("int32_t[]", triangles), len(triangles))
            return self._geometry(lib.COLLIDED_MESH, made, None)

    def height_field(self, heights: Floats, spacing_x: float, spacing_y: float, base: float) -> Shape:
        """Ground of heights (rows, columns) over a grid that is centred; row 0 has the least y. Solid down to `base` below
        the lowest height."""
        rows, columns = heights.shape
        with self.native() as c:
            made = lib.collided_create_height_field(c, doubles("heights", heights, rows, columns), rows, columns, spacing_x,
                                                    spacing_y, base)
            return self._geometry(lib.COLLIDED_HEIGHT_FIELD, made, None)

    def body(self, name: str, shapes: Shape | Sequence[Shape], *, change: Body | None = None, id: int = -1,
             fixed: bool = False, pose: Pose = IDENTITY, stamp_ns: int = 0, group: str = "", category: int = 1,
             mask: int = 2**64 - 1, one_way: bool = False, ccd: Literal["off", "linear", "full"] = "off",
             acceleration_m_s2: float = 0.0, angular_acceleration_rad_s2: float = 0.0, deadline_s: float = 0.0,
             rules: Sequence[Rule] = ()) -> Body:
        """Announces a body, or with `change` one anew that exists. Does not wait: `sync` tells whether the daemon took it.
        What the keywords mean stands at collided_body_def in collided.h."""
        keep: list[Any] = []

        def string(text: str) -> Any:
            keep.append(ffi.new("char[]", text.encode()))
            return keep[-1]

        shapes = [shapes] if isinstance(shapes, Shape) else list(shapes)
        d = ffi.new("collided_body_def *", lib.collided_body_def_default())
        d.id, d.name, d.group, d.stamp_ns = id, string(name), string(group), stamp_ns
        d.motion = lib.COLLIDED_FIXED if fixed else lib.COLLIDED_MOVING
        d.category, d.mask, d.one_way, d.deadline_s = category, mask, one_way, deadline_s
        d.ccd = {"off": lib.COLLIDED_CCD_OFF, "linear": lib.COLLIDED_CCD_LINEAR, "full": lib.COLLIDED_CCD_FULL}[ccd]
        d.acceleration_m_s2, d.angular_acceleration_rad_s2 = acceleration_m_s2, angular_acceleration_rad_s2
        fill_pose(d.pose, pose)
        d.shapes, d.shape_count = c_shapes(shapes, keep), len(shapes)
        c_rules = ffi.new("collided_rule[]", [(string(r.pattern), r.allow, string(r.reason), r.padding_m, r.margin_m)
                                              for r in rules])
        d.rules, d.rule_count = c_rules, len(rules)
        with self.native() as c:
            if change is not None:
                self.check(lib.collided_change_body(c, (change.id,), d))
                self.bodies.pop(change.name, None)
                body, body.name = change, name
            else:
                body = Body(self, lib.collided_create_body(c, d).id, name)
                if body.id == lib.COLLIDED_NONE:
                    self.check(lib.COLLIDED_BAD_ARGUMENT)
        self.bodies[name] = body
        return body

    def adopt(self, id: int, name: str) -> Body:
        """Takes over a body that an earlier process made under the same client id."""
        with self.native() as c:
            body = Body(self, lib.collided_adopt_body(c, id).id, name)
            if body.id == lib.COLLIDED_NONE:
                self.check(lib.COLLIDED_BAD_ARGUMENT)
        self.bodies[name] = body
        return body

    # ---- poses ----

    def publish(self, bodies: Sequence[Body] | Ids, positions: Floats, *, wxyz: Floats | None = None,
                xyzw: Floats | None = None, linear: Floats | None = None, angular: Floats | None = None, stamp_ns: int = 0,
                step: int = 0) -> None:
        """Publishes the poses of many bodies: positions (n, 3), orientations (n, 4) in the order that the keyword says, and
        velocities (n, 3) in m/s and rad/s, world axes, for what is predicted. C-contiguous float64 arrays, which are read
        where they are (xyzw is what it says: it is turned round, into memory of the client's, on the way). stamp_ns: when
        that was true, 0 = now. Sent by whatever waits, or flush. `ids` makes numbers of bodies, for who does this often."""
        self._publish(lib.collided_publish, bodies, positions, wxyz, xyzw, linear, angular, stamp_ns, step)

    def teleport(self, bodies: Sequence[Body] | Ids, positions: Floats, *, wxyz: Floats | None = None,
                 xyzw: Floats | None = None, linear: Floats | None = None, angular: Floats | None = None, stamp_ns: int = 0,
                 step: int = 0) -> None:
        """As publish, for bodies that did not move there: nothing is swept, contacts end with the cause "teleport"."""
        self._publish(lib.collided_teleport, bodies, positions, wxyz, xyzw, linear, angular, stamp_ns, step)

    def _publish(self, call: Any, bodies: Sequence[Body] | Ids, positions: Floats, wxyz: Floats | None, xyzw: Floats | None,
                 linear: Floats | None, angular: Floats | None, stamp_ns: int, step: int) -> None:
        count = len(bodies)
        if not isinstance(bodies, np.ndarray):
            bodies = ids(bodies)
        elif bodies.dtype != np.int32 or not bodies.flags.c_contiguous or bodies.ndim != 1:
            raise TypeError("bodies: a C-contiguous int32 array, as ids() makes it, or a sequence of Body is needed")
        one_order(wxyz, xyzw)
        if xyzw is not None:
            if len(self._turned) < count:
                self._turned = np.empty((count, 4))
            orientations = ffi.from_buffer("double[]", self._turned)
            lib.native_wxyz(orientations, doubles("xyzw", xyzw, count, 4), count)
        else:
            assert wxyz is not None
            orientations = doubles("wxyz", wxyz, count, 4)
        c_linear = ffi.NULL if linear is None else doubles("linear", linear, count, 3)
        c_angular = ffi.NULL if angular is None else doubles("angular", angular, count, 3)
        c_positions = doubles("positions", positions, count, 3)
        with self.native() as c:
            self.check(call(c, count, ffi.from_buffer("collided_body[]", bodies), c_positions, orientations, c_linear,
                            c_angular, stamp_ns, step))

    # ---- robots ----

    def set_robot(self, carrier: Body, robot: Robot) -> None:
        """Makes bodies of this client move with the joints of a robot, which is known by one of them from now on, as a rule its
        first link. Where each is follows from what publish_joints says."""
        with self.native() as c:
            self.check(lib.collided_set_robot(c, [carrier.id], robot.native))

    def publish_joints(self, carrier: Body, positions: Vector, *, velocities: Vector | None = None, base: Pose | None = None,
                       teleport: bool = False, stamp_ns: int = 0, step: int = 0) -> None:
        """Publishes the values of a robot's joints, rad or m, of those that move and mimic no other; the daemon puts the links
        where they are then. velocities: a second; base: of a robot that moves about, world."""
        joints, count, keep = state(positions, velocities, base, teleport)
        with self.native() as c:
            self.check(lib.collided_publish_joints(c, [carrier.id], joints, count, stamp_ns, step))
        del keep

    def attach(self, carrier: Body, part: Body, link: Body, in_link: Pose = IDENTITY) -> None:
        """Makes a body ride with a link of a robot, at a pose in the link's frame: a gripped part."""
        pose = ffi.new("collided_pose *")
        pose.position, pose.orientation = in_link.position, in_link.wxyz
        with self.native() as c:
            self.check(lib.collided_attach(c, [carrier.id], [part.id], [link.id], pose))

    def detach(self, carrier: Body, part: Body) -> None:
        """Lets go of a part: it stays where it was last."""
        with self.native() as c:
            self.check(lib.collided_detach(c, [carrier.id], [part.id]))

    def check_states(self, robot: Robot, configurations: Any, *, margin_m: float = 0.0, measure: bool = False,
                     tolerance_m: float = 1e-6, timeout_s: float = 10.0) -> list[Tried]:
        """Tells which configurations are free of all that the robot's links are to keep away from, and of each other: (n,
        robot.coordinates) numbers. Nothing is moved. The links' bodies may be anybody's. Raises Timeout, Unsupported."""
        asked = rows("configurations", configurations, robot.coordinates)
        return self._try(lib.collided_check_states, robot, asked, options(margin_m, 1e-4, True, measure, tolerance_m), timeout_s)

    def check_edges(self, robot: Robot, edges: Any, *, margin_m: float = 0.0, resolution_m: float = 1e-4,
                    find_first: bool = True, timeout_s: float = 10.0) -> list[Tried]:
        """Tells which straight lines in joint space are free, all of each, not samples: (n, 2, robot.coordinates) numbers, from
        and to. Otherwise as check_states."""
        asked = rows("edges", edges, 2 * robot.coordinates)
        return self._try(lib.collided_check_edges, robot, asked, options(margin_m, resolution_m, find_first, False, 1e-6), timeout_s)

    def _try(self, call: Any, robot: Robot, asked: Floats, how: Any, timeout_s: float) -> list[Tried]:
        found: list[Tried] = []
        until = time.monotonic() + timeout_s
        answer = ffi.new("collided_checked *")
        for first in range(0, len(asked), 1024):  # between two calls Ctrl-C is heard
            some = asked[first:first + 1024]
            with self.native() as c:
                try:
                    left = max(0.0, until - time.monotonic())
                    self.check(call(c, robot.native, how, ffi.from_buffer("double[]", some), len(some), left, answer))
                    found += tried(answer)
                finally:
                    lib.collided_checked_free(answer)
        return found

    def end_step(self, step: int) -> bool:
        """Ends a step of lock-step without waiting. True if it is done already: `step` waits for the same one."""
        with self.native() as c:
            status = lib.collided_step(c, step, 0.0)
            self._receive()
            if status != lib.COLLIDED_TIMEOUT:
                self.check(status)
            return bool(status == lib.COLLIDED_OK)

    def step(self, step: int, timeout_s: float = 5.0) -> None:
        """Ends a step of lock-step, unless end_step has, and waits until it is done. Raises Timeout, Rejected."""
        self.check(self._sliced(lambda c, left: int(lib.collided_step(c, step, left)), timeout_s, lambda: True))

    def set_simulation_time(self, simulation_ns: int) -> None:
        """What is published from now on carries this time, in ns; 0 = none."""
        with self.native() as c:
            self.check(lib.collided_set_simulation_time(c, simulation_ns))

    # ---- subscriptions ----

    def watch(self, a: str = "*", b: str = "*", *, touch: bool = True, distance_m: float | None = None,
              manifold: bool = False, impact: bool = False, predict_s: float | None = None, threshold_m: float = 0.0,
              accuracy: Literal["tolerance", "boxes", "verdict"] = "tolerance", tolerance_m: float = 0.0,
              relative_tolerance: float = 1e-6, hysteresis_m: float = 0.0, rate_hz: float = 0.0, stream: str | None = None,
              heartbeats: bool = False, limit: int = 1_000_000) -> Subscription:
        """Asks to be told of pairs of a body whose name matches `a` and another that matches `b`: of touches; of distances
        within distance_m; of contact points (manifold); of impacts between two poses, of bodies with ccd; of what will meet
        within predict_s seconds. The rest stands at collided_subscription_def in collided.h. heartbeats: also give the
        batches that say that nothing has changed. limit: so many events and batches are kept for who does not read."""
        d = ffi.new("collided_subscription_def *", lib.collided_subscription_def_default())
        facts = ((touch, lib.COLLIDED_TOUCH), (distance_m is not None, lib.COLLIDED_DISTANCE),
                 (manifold, lib.COLLIDED_MANIFOLD), (impact, lib.COLLIDED_IMPACT),
                 (predict_s is not None, lib.COLLIDED_PREDICT))
        d.facts = sum(fact for wanted, fact in facts if wanted)
        keep = [ffi.new("char[]", text.encode()) for text in (a, b, stream or "")]
        d.select_a, d.select_b = keep[0], keep[1]
        if stream is not None:
            d.stream = keep[2]
        d.threshold_m, d.range_m, d.horizon_s = threshold_m, distance_m or 0.0, predict_s or 0.0
        d.accuracy = {"tolerance": lib.COLLIDED_BY_TOLERANCE, "boxes": lib.COLLIDED_BY_BOXES,
                      "verdict": lib.COLLIDED_BY_VERDICT}[accuracy]
        d.tolerance_m, d.relative_tolerance, d.hysteresis_m, d.rate_hz = tolerance_m, relative_tolerance, hysteresis_m, rate_hz
        with self.native() as c:
            number = lib.native_subscribe(self._inbox, c, d).id
            if number == lib.COLLIDED_NONE:
                self.check(lib.COLLIDED_BAD_ARGUMENT)
        subscription = Subscription(self, number, limit, heartbeats)
        self._subscriptions[number] = subscription
        return subscription

    def unsubscribe(self, subscription: Subscription) -> None:
        """What Subscription.close does."""
        if self.closed or not self._subscriptions.pop(subscription.id, None):
            return
        with self.native() as c:
            self.check(lib.collided_unsubscribe(c, (subscription.id,)))

    # ---- queries ----

    def _ask(self, read: Callable[[Any], _Answer], call: Any, *arguments: Any) -> tuple[Answers[_Answer], str]:
        out = ffi.new("collided_result *")
        try:
            with self.native() as c:
                status = call(c, *arguments, out)
                self._receive()
                self.check(status)
            found = (read(out.hits[i]) for i in range(out.count))
            return Answers(found, out.truncated, out.tick), text_of(out.text)
        finally:
            lib.collided_result_free(out)

    def ray(self, origin: Vector, direction: Vector, length_m: float, timeout_s: float = 5.0) -> Hit | None:
        """The first body along a ray; None: there is none."""
        hits, _ = self._ask(_hit, lib.collided_query_ray, vector("origin", origin, 3), vector("direction", direction, 3),
                               length_m, timeout_s)
        return hits[0] if hits else None

    def distance(self, a: str, b: str, tolerance_m: float = 0.0, timeout_s: float = 5.0) -> Hit:
        """The certified distance of two bodies now, as an interval at most tolerance_m wide."""
        return self._ask(_hit, lib.collided_query_distance, a.encode(), b.encode(), tolerance_m, timeout_s)[0][0]

    def overlapping(self, pose: Pose, half: Vector, timeout_s: float = 5.0) -> Answers[Hit]:
        """The bodies that overlap a box, given by its pose and its half sides."""
        return self._ask(_hit, lib.collided_query_box, _c_pose(pose), vector("half", half, 3), timeout_s)[0]

    def cast(self, pose: Pose, half: Vector, direction: Vector, length_m: float, timeout_s: float = 5.0) -> Hit | None:
        """The first body that a box meets on its way; lo and hi bracket the free length."""
        hits, _ = self._ask(_hit, lib.collided_query_cast, _c_pose(pose), vector("half", half, 3),
                               vector("direction", direction, 3), length_m, timeout_s)
        return hits[0] if hits else None

    def sweep(self, name: str, linear: Vector, angular: Vector, span_s: float, tolerance_m: float = 1e-3,
              timeout_s: float = 5.0) -> Hit | None:
        """What a body would meet first if it moved on at these velocities (m/s, rad/s): lo and hi bracket the time, s. None
        is proven: nothing."""
        hits, _ = self._ask(_hit, lib.collided_query_sweep, name.encode(), vector("linear", linear, 3),
                               vector("angular", angular, 3), span_s, tolerance_m, timeout_s)
        return hits[0] if hits else None

    def nearest(self, of: str | Pose, within_m: float = float("inf"), most: int = 1, half: Vector = (0.0, 0.0, 0.0),
                timeout_s: float = 5.0) -> Answers[Hit]:
        """The nearest bodies (`most`, 0 = all) of a body, by its name, or of a box at a pose, by its half sides."""
        name, pose = (of.encode(), ffi.NULL) if isinstance(of, str) else (ffi.NULL, _c_pose(of))
        return self._ask(_hit, lib.collided_query_nearest, name, pose, vector("half", half, 3), within_m, most, timeout_s)[0]

    def explain(self, a: str, b: str, timeout_s: float = 5.0) -> str:
        """Why two bodies are checked against each other, or not."""
        return self._ask(_hit, lib.collided_query_explain, a.encode(), b.encode(), timeout_s)[1]

    def find(self, pattern: str = "*", timeout_s: float = 5.0) -> Answers[Found]:
        """The bodies whose names match, with their poses: everybody's."""
        return self._ask(_found, lib.collided_query_bodies, pattern.encode(), timeout_s)[0]

    # ---- the daemon ----

    def record(self, name: str, timeout_s: float = 5.0) -> str:
        """Starts a recording on the daemon, and tells what the daemon says of it: its path. `collided --replay` plays it."""
        return self._ask(_hit, lib.collided_record, name.encode(), timeout_s)[1]

    def end_recording(self, timeout_s: float = 5.0) -> str:
        """Ends the recording that this client has begun."""
        return self._ask(_hit, lib.collided_record, ffi.NULL, timeout_s)[1]

    def status(self, timeout_s: float = 5.0) -> Status:
        """The last status of the daemon, which tells it once a second. Raises NoDaemon."""
        s = ffi.new("collided_daemon_status *")
        with self.native() as c:
            self.check(lib.collided_get_status(c, timeout_s, s))
            counters = {text_of(s.counters[i].name): s.counters[i].value for i in range(s.counter_count)}
            return Status(s.epoch, s.tick, s.stamp_ns, s.started_ns, text_of(s.health), text_of(s.daemon), text_of(s.release),
                          text_of(s.links), text_of(s.limits), counters)


def _hit(h: Any) -> Hit:
    return Hit(text_of(h.name_a), text_of(h.name_b), h.lo, h.hi, tuple(h.axis), tuple(h.point_a), tuple(h.point_b), h.age_s,
               h.stale, Achieved(min(h.achieved, Achieved.STOPPED)))


def _found(h: Any) -> Found:
    return Found(text_of(h.name_a), Pose(tuple(h.point_a), wxyz=tuple(h.orientation)), h.age_s, h.stale)


def _c_pose(pose: Pose) -> Any:
    return ffi.new("collided_pose *", (pose.position, pose.wxyz))


def connect(uri: str = "dds://0", *, name: str | None = None, id: int = 0, lease_s: float = 2.0,
            on_loss: Literal["remove", "hold", "keep"] = "remove", connect_timeout_s: float = 5.0, lock_step: int = 0,
            interface: str | None = None, security: str | None = None) -> Client:
    """Connects to the daemon at "dds://DOMAIN" or "lcm://", and waits for it for connect_timeout_s (0 = does not wait). What
    the keywords mean stands at collided_def in collided.h. Raises ConnectError."""
    if _dds_is_of_parent and uri.startswith("dds:"):
        raise errors.Forked("this process was forked from one with a client over DDS, whose threads did not come along: use "
                            "the start method 'spawn', or close that client before")
    d = ffi.new("collided_def *", lib.collided_def_default())
    keep = [None if text is None else ffi.new("char[]", text.encode()) for text in (name, interface, security)]
    d.name, d.interface, d.security = (ffi.NULL if text is None else text for text in keep)
    d.id, d.lease_s, d.connect_timeout_s, d.lock_step = id, lease_s, connect_timeout_s, lock_step
    d.on_loss = {"remove": lib.COLLIDED_REMOVE, "hold": lib.COLLIDED_HOLD, "keep": lib.COLLIDED_KEEP}[on_loss]
    pointer = lib.collided_connect(uri.encode(), d)
    if pointer == ffi.NULL:
        raise errors.ConnectError(text_of(lib.collided_connect_error()))
    return Client(uri, pointer)


def version() -> str:
    """The release of the library."""
    return text_of(lib.collided_version())
