"""bench_python BIN PACKAGE [--json] [--full] [--brief]: what the Python client costs: a call that publishes the poses of many bodies, beside
the same call in C, and an event from the network into an Event that was looked at. Processor time, of the thread that
publishes, and of all threads of the process that is told. Over DDS; the daemon and whoever moves the bodies are processes of
their own."""

import contextlib
import json
import os
import subprocess
import sys
import time

BIN, PACKAGE, *OPTIONS = sys.argv[1:]
sys.path.insert(0, PACKAGE)
import numpy as np  # noqa: E402

import collided  # noqa: E402
from collided._native import ffi, lib  # noqa: E402

URI, PATIENCE_S = "dds://146", 30.0
PAIRS, HZ = 100, 100.0  # together 10,000 events a second


def connect():
    return collided.connect(URI, connect_timeout_s=PATIENCE_S)


def poses(count, apart):
    positions, wxyz = np.zeros((count, 3)), np.zeros((count, 4))
    positions[:, 0], wxyz[:, 0] = apart * np.arange(count), 1.0
    return positions, wxyz


def us_a_publish(count, rounds):
    """Medians, of Python's call and of C's, in turn."""
    with connect() as client:
        bodies = collided.ids([client.body(f"b{i}", collided.sphere(0.1), pose=collided.Pose((i, 0, 0))) for i in range(count)])
        client.sync(PATIENCE_S)
        positions, wxyz = poses(count, 1.0)
        c_arrays = [ffi.from_buffer(kind, array) for kind, array in
                    (("collided_body[]", bodies), ("double[]", positions), ("double[]", wxyz))]

        def in_python():
            client.publish(bodies, positions, wxyz=wxyz)

        def in_c():
            lib.collided_publish(c, count, *c_arrays, ffi.NULL, ffi.NULL, 0, 0)

        took = {in_python: [], in_c: []}
        with client.native() as c:
            pass
        for i in range(2 * rounds):
            positions[:, 1] = 0.001 * i
            call = (in_python, in_c)[i % 2]
            begun = time.thread_time_ns()
            call()
            took[call].append(time.thread_time_ns() - begun)
            client.poll(0.002)
        return [float(np.median(times[rounds // 10:])) / 1e3 for times in took.values()]


def move(seconds):
    """Pairs of spheres whose distances change with each tick, until standard input ends."""
    with connect() as client:
        for i in range(PAIRS):
            client.body(f"post{i}", collided.sphere(0.1), fixed=True, pose=collided.Pose((10.0 * i, 0, 1)))
        bodies = collided.ids([client.body(f"ball{i}", collided.sphere(0.1), pose=collided.Pose((10.0 * i, 0, 0)))
                               for i in range(PAIRS)])
        client.sync(PATIENCE_S)
        positions, wxyz = poses(PAIRS, 10.0)
        print("ready", flush=True)
        begun = time.monotonic()
        for tick in range(int(seconds * HZ)):
            positions[:, 2] = 0.3 * np.sin(0.1 * tick)
            client.publish(bodies, positions, wxyz=wxyz)
            client.poll(max(0.0, begun + tick / HZ - time.monotonic()))


def us_an_event(seconds):
    """And how many were told a second, and which share of a core that took."""
    with connect() as client:
        stream = client.watch("ball*", "post*", touch=False, distance_m=5.0)
        client.sync(PATIENCE_S)
        with subprocess.Popen([sys.executable, __file__, BIN, PACKAGE, "--move", str(seconds + 2)], stdout=subprocess.PIPE) as mover:
            mover.stdout.readline()
            warm = time.monotonic() + 1
            while time.monotonic() < warm:
                stream.wait(PATIENCE_S)
            begun, used, told, lowest = time.monotonic(), time.process_time_ns(), 0, float("inf")
            while time.monotonic() < begun + seconds:
                for event in stream.wait(PATIENCE_S):
                    told += 1
                    lowest = min(lowest, event.lo)
            used = time.process_time_ns() - used
            mover.wait()
        span = time.monotonic() - begun
        assert 0 < lowest < 2, lowest
        return used / 1e3 / told, told, used / 1e9 / span


def main():
    full = "--full" in OPTIONS
    seconds, rounds = (20.0, 2000) if full else (1.0, 20) if "--brief" in OPTIONS else (3.0, 300)
    with contextlib.ExitStack() as stack:
        daemon = stack.enter_context(subprocess.Popen([os.path.join(BIN, "collided"), "--links", URI],
                                                      stderr=subprocess.DEVNULL))
        stack.callback(daemon.terminate)
        rows = []
        for count in (1, 100, 1000):
            in_python, in_c = us_a_publish(count, rounds)
            rows.append({"bodies": count, "us_a_publish": round(in_python, 2), "c_us_a_publish": round(in_c, 2)})
        us, told, share = us_an_event(seconds)
    for row in rows:
        row.update(bench="python", entry="collided_publish", us_an_event=round(us, 2), events=told, core_share=round(share, 4))
    if "--json" in OPTIONS:
        print("\n".join(json.dumps(row) for row in rows))
        return
    for row in rows:
        print(f"publishing {row['bodies']:4d} poses: {row['us_a_publish']:6.1f} us; in C {row['c_us_a_publish']:6.1f} us")
    print(f"an event, from the network until it was looked at: {us:.2f} us; {told} events, {share:.1%} of a core")


if OPTIONS[:1] == ["--move"]:
    move(float(OPTIONS[1]))
else:
    main()
