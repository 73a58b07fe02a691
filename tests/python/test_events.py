"""What the daemon tells arrives in Python as it is in C: events, points, impacts, names, proofs; by for, by async for, and
without memory that grows."""

import asyncio
import os
import time

from world import PATIENCE_S, check, collided, connect, np, raises, read, resident_kb, resting, run

SPHERE, BOX = collided.sphere(0.5), collided.box(1, 1, 1)
Kind = collided.Kind


def a_batch_is_arrays_and_events_that_agree():
    with connect() as c:
        ball = c.body("ball", SPHERE, pose=collided.Pose((0.8, 0, 0)))
        c.body("a box", BOX, fixed=True)
        c.body("söckel", BOX.at((0, 0, -5)), fixed=True)
        stream = c.watch("ball", "*", distance_m=10, manifold=True)
        c.sync(PATIENCE_S)
        first = stream.wait(PATIENCE_S)
        while not len(first):
            first = stream.wait(PATIENCE_S)
        check(first.events.dtype == collided.EVENT and first.events.flags.writeable, "a structured array of its own")
        check(set(first.names) == {"ball", "a box", "söckel"}, f"names: {first.names}")
        for row, event in zip(first.events, first, strict=True):
            check((event.a, event.b) == (first.names[row["a"]], first.names[row["b"]]), f"names of {event}")
            check(event.lo == row["lo"] and event.kind == row["kind"] and event.cause.encode() == row["cause"], f"{event}")
            check(np.array_equal(event.axis, row["axis"]) and abs(np.linalg.norm(event.axis) - 1) < 1e-12, f"axis {event}")
        near = {event.b: event for event in first if event.kind in (Kind.BEGIN, Kind.NEAR)}
        check(near["a box"].lo <= -0.2 <= near["a box"].hi, f"depth: {near['a box']}")
        check(abs(near["söckel"].lo - (np.hypot(0.3, 4.5) - 0.5)) < 1e-4, f"distance: {near['söckel']}")
        touching = [event for event in first if event.b == "a box" and len(event.points)]
        check(touching and abs(touching[0].points["distance"][0] + 0.2) < 1e-3, f"manifold: {touching}")
        ball.move((3, 0, 0))
        ends = read(stream, lambda events: any(e.kind == Kind.END for e in events))
        check(next(e for e in ends if e.kind == Kind.END).cause == "motion", f"cause: {ends}")


def proofs_are_checked_here():
    with connect() as c:
        points = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        cube = c.hull(points)
        poses = collided.Pose((5, 1, 0), xyzw=(0, 0, np.sin(0.2), np.cos(0.2))), collided.Pose((0, 0, 1))
        c.body("cube", cube, pose=poses[0])
        c.body("ball", SPHERE, pose=poses[1])
        c.sync(PATIENCE_S)
        hit = c.distance("cube", "ball", 1e-9, PATIENCE_S)
        check(hit.hi - hit.lo <= 1e-9 and hit.lo > 2, f"{hit}")
        check(collided.verify(cube, poses[0], SPHERE, poses[1], hit), "it is proven")
        for by in ("lo", "hi"):
            wrong = type("Wrong", (), {**vars(hit), by: getattr(hit, by) + (1e-6 if by == "lo" else -1e-6)})
            check(not collided.verify(cube, poses[0], SPHERE, poses[1], wrong), f"a wrong {by} is not")
            setattr(wrong, *(("hi", np.inf) if by == "lo" else ("lo", -np.inf)))
            missing = collided.check(cube, poses[0], SPHERE, poses[1], wrong)
            check(not missing and missing.status.name == f"{by.upper()}_UNPROVEN", f"nor for the kernel: {missing}")
        proven = collided.check(cube, poses[0], SPHERE, poses[1], hit)
        check(proven and proven.lo <= hit.lo + 1e-9 and hit.hi - 1e-9 <= proven.hi and proven.hi - proven.lo < 1e-8, f"{proven}")
        mesh = c.mesh(points, np.array([[0, 1, 2]], dtype=np.int32))
        raises(collided.BadArgument, lambda: collided.verify(mesh, poses[0], SPHERE, poses[1], hit))
        bad = collided.check(mesh, poses[0], SPHERE, poses[1], hit)
        check(not bad and bad.status == collided.CheckStatus.BAD_KIND and bad.status.text and np.isinf(bad.hi), f"a mesh: {bad}")


def the_kernel_takes_all_shapes_and_motions():
    with connect() as c:
        corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        claim = type("Claim", (), dict(lo=-np.inf, hi=9.0, axis=(1, 0, 0), point_a=(0, 0, 0), point_b=(4, 0, 0)))
        there, here = collided.Pose((4, 0, 0)), collided.Pose()
        plane = collided.Pose((4, 0, 0), xyzw=(0, -np.sqrt(0.5), 0, np.sqrt(0.5)))
        for shape in (SPHERE, BOX, collided.capsule(0.5, 1), collided.cylinder(0.5, 1), collided.cone(0.5, 1),
                      collided.ellipsoid(1, 2, 3), c.hull(corners),
                      collided.compound([BOX.at((0, 0, 1)), SPHERE]).rounded(0.1)):
            made = collided.check(shape, here, SPHERE, there, claim)
            check(made and 3.99 < made.hi < 4.51, f"{shape}: {made}")
            claim.lo = -9.0
            beside = collided.check(shape, here, collided.halfspace(), plane, claim)
            check(beside and 0 < beside.lo < 4, f"{shape} beside a plane: {beside}")
            claim.lo = -np.inf
        check(collided.check(SPHERE, collided.Pose(wxyz=(2, 0, 0, 0)), SPHERE, there, claim).status.name == "BAD_POSE", "no pose")
        raises(ValueError, lambda: collided.check(SPHERE, here, SPHERE, there, type("Short", (), {**vars(claim), "axis": (1, 0)})))
        status, speed, bend = collided.check_twist(SPHERE, (1, 0, 0), (0, 0, 0), SPHERE, (-1, 0, 0), (0, 0, 2))
        check(status.name == "PROVEN" and 3 <= speed < 3.001 and 2 <= bend < 2.001, f"{status} {speed} {bend}")
        times = np.array([0.0, 0.5])
        poses_a = np.array([[0, 0, 0, 1, 0, 0, 0], [0.5, 0, 0, 1, 0, 0, 0]], dtype=float)
        poses_b = poses_a * (-1, 1, 1, 1, 1, 1, 1) + (4, 0, 0, 0, 0, 0, 0)
        axes = np.array([[1.0, 0, 0], [1.0, 0, 0]])
        proven = collided.check_motion(SPHERE, SPHERE, times, poses_a, poses_b, axes, speed=2.0)
        check(proven == (collided.CheckStatus.PROVEN, 0.5), f"{proven}")
        early = collided.check_motion(SPHERE, SPHERE, times, poses_a, poses_b, axes, speed=2.0, margin_m=2.1)
        check(early == (collided.CheckStatus.TIME_UNPROVEN, 0.0), f"{early}")
        raises(ValueError, lambda: collided.check_motion(SPHERE, SPHERE, times, poses_a, poses_b, axes[:1], speed=2.0))
        raises(TypeError, lambda: collided.check_motion(SPHERE, SPHERE, times, poses_a.T, poses_b, axes, speed=2.0))


def impacts_and_predictions_carry_their_times():
    with connect() as c:
        bullet = c.body("bullet", collided.sphere(0.01), ccd="full", pose=collided.Pose((-2, 0, 0)))
        c.body("wall", collided.box(0.01, 1, 1), fixed=True)
        stream = c.watch(touch=False, impact=True, predict_s=2.0)
        c.sync(PATIENCE_S)
        bodies, (positions, wxyz) = [bullet], resting(1)
        positions[0] = -1, 0, 0
        now = time.time_ns()
        c.publish(bodies, positions, wxyz=wxyz, linear=np.array([[1.0, 0, 0]]), stamp_ns=now)
        told = read(stream, lambda events: any(e.kind == Kind.PREDICTED for e in events))
        soon = next(e for e in told if e.kind == Kind.PREDICTED).impact
        check(abs(soon["lo_s"] - 0.985) < 1e-3 and not soon["estimated"] and soon["start_ns"] == now, f"predicted: {soon}")
        positions[0] = 1, 0, 0
        c.publish(bodies, positions, wxyz=wxyz, stamp_ns=now + 2_000_000_000)
        told = read(stream, lambda events: any(e.kind == Kind.IMPACT for e in events))
        met = next(e for e in told if e.kind == Kind.IMPACT).impact
        check(abs(met["lo_s"] - 0.985) < 1e-3 and abs(met["position_a"][0] + 0.015) < 1e-3 or
              abs(met["position_b"][0] + 0.015) < 1e-3, f"impact: {met}")


def async_for_shares_one_loop():
    async def first_end(stream):
        async for batch in stream:
            for event in batch:
                if event.kind == Kind.END:
                    return event.a, event.b
        return None

    async def swing(c, ball):
        for i in range(1000):
            ball.move((2 * np.sin(0.3 * i), 0, 0))
            c.flush()
            await asyncio.sleep(0.01)

    async def both(uri):
        with connect(uri) as c:
            ball = c.body("ball", SPHERE)
            c.body("left", BOX, fixed=True)
            streams = c.watch("left", "*"), c.watch("ball", "left")
            swinging = asyncio.create_task(swing(c, ball))
            ends = await asyncio.wait_for(asyncio.gather(*map(first_end, streams)), PATIENCE_S)
            swinging.cancel()
            check(all(set(end) == {"ball", "left"} for end in ends), f"{uri}: {ends}")
            later = asyncio.create_task(first_end(streams[0]))
            await asyncio.sleep(0)
            streams[0].close()
            c.close()
            check(await asyncio.wait_for(later, PATIENCE_S) is None, "closing ends it")

    for uri in ("dds://0", "lcm://"):
        asyncio.run(both(uri))


def who_does_not_read_is_told():
    with connect() as c:
        ball = c.body("ball", SPHERE)
        c.body("block", BOX, fixed=True)
        stream = c.watch(limit=5)
        c.sync(PATIENCE_S)
        for i in range(200):
            ball.move((0.01 * (i % 10), 0, 0))
            c.poll(0.02)
        kept = 0
        try:
            while True:
                kept += 1 + len(stream.wait(PATIENCE_S))
        except collided.Overrun as error:
            check("5" in str(error), str(error))
        check(0 < kept <= 5 and stream.closed, f"{kept} were kept")
        check(len(c.watch().wait(PATIENCE_S)) == 1, "who subscribes anew gets the whole state")


def memory_is_level():
    events = 1_000_000 if os.environ.get("COLLIDED_NIGHTLY") else 200_000
    count = 200
    with connect() as c:
        c.body("floor", collided.box(count + 10, 10, 1).at((count / 2, 0, -2)), fixed=True)
        bodies = collided.ids([c.body(f"ball{i}", SPHERE, pose=collided.Pose((2.0 * i, 0, 0))) for i in range(count)])
        stream = c.watch("floor", "ball*", touch=False, distance_m=5.0)
        c.sync(PATIENCE_S)
        positions, wxyz = resting(count)
        told, before, tick = 0, 0, 0
        while told < events:
            tick += 1
            positions[:, 2] = 0.5 * np.sin(0.1 * tick)
            c.publish(bodies, positions, wxyz=wxyz)
            c.poll(PATIENCE_S)
            for batch in stream.take():
                told += len(batch)
                list(batch)
            if not before and told > events // 4:
                before = resident_kb()
        grown = resident_kb() - before
        print(f"{told} events, {grown} kB more after the first quarter")
        check(grown < 3000, f"memory grows: {grown} kB")


run(a_batch_is_arrays_and_events_that_agree, proofs_are_checked_here, the_kernel_takes_all_shapes_and_motions,
    impacts_and_predictions_carry_their_times, async_for_shares_one_loop, who_does_not_read_is_told, memory_is_level)
