"""What a Python client says arrives at the daemon as it was meant: poses by arrays that are not copied, bodies, queries,
steps, recordings; and what is wrong raises the exception that tells it."""

import tracemalloc

from world import PATIENCE_S, check, collided, connect, daemon, finish, np, raises, resting, run

SPHERE, BOX = collided.sphere(0.5), collided.box(1, 1, 1)


def poses_of(c, pattern):
    c.sync(PATIENCE_S)
    return {found.name: found.pose for found in c.find(pattern, PATIENCE_S)}


def wait_for_pose(c, name, position):
    for _ in range(300):
        pose = poses_of(c, name)[name]
        if np.allclose(pose.position, position, atol=1e-12):
            return pose
        c.poll(0.02)
    check(False, f"{name} is at {pose}, not at {position}")
    return pose


def poses_are_read_where_they_are():
    with connect() as c:
        count = 500
        bodies = [c.body(f"b{i}", SPHERE) for i in range(count)]
        c.sync(PATIENCE_S)
        positions, wxyz = resting(count)
        numbers = collided.ids(bodies)
        half = np.sqrt(0.5)
        xyzw = np.tile([0.0, half, 0.0, half], (count, 1))
        c.publish(numbers, positions, wxyz=wxyz)
        wait_for_pose(c, "b499", (499, 0, 0))
        positions[:, 1] = 3
        c.publish(bodies, positions, xyzw=xyzw)
        pose = wait_for_pose(c, "b7", (7, 3, 0))
        check(np.allclose(pose.wxyz, (half, 0, half, 0)) and np.allclose(pose.xyzw, xyzw[0]), f"turned: {pose}")
        bodies[3].move((1, 2, 3), xyzw=(1, 0, 0, 0))
        check(wait_for_pose(c, "b3", (1, 2, 3)).wxyz == (0, 1, 0, 0), "one body's")
        tracemalloc.start()
        for _ in range(10):
            tracemalloc.reset_peak()
            before, _ = tracemalloc.get_traced_memory()
            c.publish(numbers, positions, wxyz=wxyz)
            _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        check(peak - before < positions.nbytes / 2, f"publishing takes {peak - before} bytes: something is copied")


def arrays_that_would_be_copied_are_refused():
    with connect() as c:
        bodies = [c.body("a", SPHERE), c.body("b", SPHERE, pose=collided.Pose((9, 0, 0)))]
        positions, wxyz = resting(2)
        wide = np.zeros((2, 6))
        for wrong, words in ((positions.astype(np.float32), "float32 array"), (positions.tolist(), "is a list"),
                             (wide[:, ::2], "not C-contiguous"), (np.asfortranarray(positions), "not C-contiguous")):
            raises(TypeError, lambda wrong=wrong: c.publish(bodies, wrong, wxyz=wxyz), "positions", words,
                   "np.ascontiguousarray(positions, dtype=np.float64)")
        raises(ValueError, lambda: c.publish(bodies, positions[:1], wxyz=wxyz), "(1, 3)", "(2, 3)")
        raises(ValueError, lambda: c.publish(bodies, positions, wxyz=positions), "(2, 4)")
        raises(TypeError, lambda: c.publish(bodies, positions), "wxyz= or xyzw=")
        raises(TypeError, lambda: c.publish(bodies, positions, wxyz=wxyz, xyzw=wxyz), "wxyz= or xyzw=")
        raises(TypeError, lambda: c.publish(np.array([0, 1]), positions, wxyz=wxyz), "int32")
        raises(TypeError, lambda: c.publish(bodies, positions, wxyz=wxyz, linear=[[0, 0, 0]] * 2), "linear")
        raises(collided.BadArgument, lambda: c.publish(bodies, positions * np.nan, wxyz=wxyz), "not a number")
        raises(collided.UnknownId, lambda: c.publish(np.array([5], np.int32), positions[:1], wxyz=wxyz[:1]), "no body 5")


def exceptions_tell_the_status():
    raises(collided.ConnectError, lambda: collided.connect("tcp://0"), "dds://", "lcm://")
    raises(ConnectionError, lambda: collided.connect("dds://77", connect_timeout_s=0.3), "is collided running")
    with connect() as c, connect() as other:
        c.body("arm", SPHERE)
        c.sync(PATIENCE_S)
        other.body("arm", SPHERE)
        raises(collided.Rejected, lambda: other.sync(PATIENCE_S), "arm")
        check(other.rejections and other.rejections[0].reason == "name_taken", f"refusals: {other.rejections}")
        raises(collided.BadArgument, lambda: c.body("", SPHERE))
        raises(collided.BadArgument, lambda: c.watch(tolerance_m=-1))
        raises(collided.CollidedError, lambda: c.distance("arm", "nobody", timeout_s=PATIENCE_S))
        raises(collided.BadArgument, lambda: c.step(1))
        raises(TimeoutError, lambda: c.watch("x", "y").wait(0.0))
    raises(collided.BadArgument, c.flush, "closed")
    c.close()  # twice is no error


def queries_answer():
    with connect() as c:
        ground = c.height_field(np.zeros((3, 3)), 10, 10, 1)
        tetra = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
        c.body("ground", ground, fixed=True)
        c.body("tetra", c.mesh(tetra, faces), fixed=True, pose=collided.Pose((0, 0, 5)))
        ball = c.body("ball", collided.compound([SPHERE, SPHERE.at((0, 0, 1))]), pose=collided.Pose((5, 0, 3)),
                      rules=[collided.Rule("tetra", reason="bolted together")])
        ball.data = "mine"
        c.sync(PATIENCE_S)
        hit = c.ray((5, 0, 10), (0, 0, -1), 20, PATIENCE_S)
        check(hit and hit.lo <= 5.5 <= hit.hi and "ball" in (hit.a, hit.b), f"ray: {hit}")
        check(c.bodies["ball"].data == "mine", "bodies by their names")
        check(c.ray((50, 0, 10), (0, 0, 1), 20, PATIENCE_S) is None, "a ray that meets nothing")
        hit = c.distance("ball", "ground", 1e-6, PATIENCE_S)
        check(hit.lo <= 2.5 <= hit.hi and hit.hi - hit.lo < 1e-5, f"distance: {hit}")
        hit = c.sweep("ball", (0, 0, -1), (0, 0, 0), 5, 1e-3, PATIENCE_S)
        check(hit and abs(hit.lo - 2.5) < 1e-2, f"sweep: {hit}")
        hit = c.cast(collided.Pose((5, 0, 20)), (0.1, 0.1, 0.1), (0, 0, -1), 50, PATIENCE_S)
        check(hit and hit.lo <= 15.4 <= hit.hi + 1e-6, f"cast: {hit}")
        names = {h.a or h.b for h in c.overlapping(collided.Pose((5, 0, 3)), (1, 1, 1), PATIENCE_S)}
        check(names == {"ball"}, f"overlapping: {names}")
        near = c.nearest(collided.Pose((5, 0, 10)), most=2, timeout_s=PATIENCE_S)
        check(len(near) == 2 and near.tick > 0 and not near.truncated and near[0].lo <= near[1].lo, f"nearest: {near}")
        check("bolted together" in c.explain("ball", "tetra", PATIENCE_S), "explain names the reason")
        c.body("ball", SPHERE, change=ball, pose=collided.Pose((5, 0, 3)))
        c.sync(PATIENCE_S)
        check("bolted together" not in c.explain("ball", "tetra", PATIENCE_S), "a body is changed")
        ball.remove()
        check(set(poses_of(c, "*")) == {"ground", "tetra"} and "ball" not in c.bodies, "a body is removed")
        for _ in range(300):
            status = c.status(PATIENCE_S)
            if status.health == "ready" and status.counters["clients"] == 1:
                break
            c.poll(0.1)
        check(status.health == "ready" and status.counters["clients"] == 1 and "dds" in status.links.lower(), f"{status}")


def steps_end_now_and_are_waited_for_later():
    with connect(lock_step=1) as c:
        bodies = [c.body("ball", SPHERE), c.body("block", BOX, fixed=True, pose=collided.Pose((9, 0, 0)))]
        stream = c.watch()
        c.sync(PATIENCE_S)
        positions, wxyz = resting(1)
        for step in range(1, 21):
            positions[0, 0] = step
            c.set_simulation_time(step * 1000)
            c.publish(bodies[:1], positions, wxyz=wxyz, step=step)
            if step % 2:
                c.end_step(step)
            c.step(step, PATIENCE_S)
        batches = [batch for batch in stream.take() if batch.step]
        check([batch.step for batch in batches] == list(range(1, 21)), f"steps: {batches}")
        check(all(batch.simulation_ns == 1000 * batch.step for batch in batches), "the time of the simulation")
        kinds = [(batch.step, event.kind.name) for batch in batches for event in batch if event.kind != collided.Kind.UPDATE]
        check(kinds == [(8, "BEGIN"), (11, "END")], f"events: {kinds}")


def recordings_begin_and_end():
    import tempfile  # pylint: disable=import-outside-toplevel
    with tempfile.TemporaryDirectory() as folder, daemon(options=("--record-dir", folder)), connect() as c:
        check(f"{folder}/session" in c.record("session", PATIENCE_S), "the path is told")
        c.body("ball", SPHERE)
        c.sync(PATIENCE_S)
        c.end_recording(PATIENCE_S)
        raises(collided.CollidedError, lambda: c.record("../escape", PATIENCE_S))


recordings_begin_and_end()
run(poses_are_read_where_they_are, arrays_that_would_be_copied_are_refused, exceptions_tell_the_status, queries_answer,
    steps_end_now_and_are_waited_for_later)
finish()
