"""world: a daemon in a network of the test's own, and what the tests of the Python package share."""

import contextlib
import os
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "startup"))
sys.path.insert(0, sys.argv[2])
from rig import DAEMON, check, finish, isolate, skip  # noqa: E402,F401  # pylint: disable=unused-import

os.environ["PYTHONPATH"] = sys.argv[2]
isolate()
import numpy as np  # noqa: E402

import collided  # noqa: E402

PATIENCE_S = 30.0


@contextlib.contextmanager
def daemon(links="dds://0 lcm://", options=()):
    """One on these links, ended in order."""
    process = subprocess.Popen([DAEMON, "--links", links, *options], stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        check(process.wait(timeout=60) in (0, -9), "the daemon ends in order")


def connect(uri="dds://0", **options):
    return collided.connect(uri, connect_timeout_s=PATIENCE_S, **options)


def raises(kind, call, *words):
    """It raises that, and says these words."""
    try:
        call()
    except kind as error:
        for word in words:
            check(word in str(error), f"{word!r} is not in {error!s}")
        return
    check(False, f"nothing raised {kind.__name__}")


def read(stream, enough):
    """Events of batches until there are enough of them by that function; all of them."""
    events, end = [], time.monotonic() + PATIENCE_S
    while not enough(events) and time.monotonic() < end:
        with contextlib.suppress(collided.Timeout):
            events += stream.wait(1.0)
    check(enough(events), f"what was waited for did not come: {events}")
    return events


def resting(count):
    """Poses of so many bodies: a row, 1 m apart."""
    positions, wxyz = np.zeros((count, 3)), np.zeros((count, 4))
    positions[:, 0], wxyz[:, 0] = np.arange(count), 1.0
    return positions, wxyz


def resident_kb():
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))


def run(*tests):
    """Each against a daemon of its own."""
    for test in tests:
        with daemon():
            test()
        print(f"{test.__name__}", flush=True)
    finish()
