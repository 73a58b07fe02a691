"""A recording goes through lcm-logplayer without loss: as a file of LCM's own, and over the network to lcm-logger. The copy
replays like the original, and what a changed byte in it changes is told."""

import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "startup"))
from rig import BIN, DAEMON, check, finish, isolate, skip, until  # noqa: E402

EXAMPLES = sys.argv[2]
CTL = [os.path.join(BIN, "collidectl"), "--connect", "dds://0"]
HEAD = struct.Struct(">IqqII")


def records(path):
    """Of LCM's log format: channel, data, and where the data begins."""
    found, at = [], 0
    with open(path, "rb") as file:
        log = file.read()
    while at < len(log):
        sync, number, _, channel, data = HEAD.unpack_from(log, at)
        check(sync == 0xEDA1DA01 and number == len(found), f"the record at {at}")
        at += HEAD.size
        found.append((log[at:at + channel].decode(), log[at + channel:at + channel + data], at + channel))
        at += channel + data
    return found


def ctl(*arguments):
    done = subprocess.run(CTL + list(arguments) + ["--timeout", "30"], capture_output=True, text=True, timeout=90, check=False)
    check(done.returncode == 0, f"collidectl {arguments}: {done.stderr}")


def record(path):
    daemon = subprocess.Popen([DAEMON, "--links", "dds://0", "--record", path], stderr=subprocess.DEVNULL)
    watch = subprocess.Popen(CTL + ["watch", "--facts", "touch,distance,manifold"], stdout=subprocess.PIPE, text=True,
                             env=dict(os.environ, XDG_STATE_HOME=folder))
    watch.stdout.readline()  # the snapshot: somebody listens
    ctl("load", "--srdf", os.path.join(EXAMPLES, "arm.srdf"), os.path.join(EXAMPLES, "arm.urdf"))
    for i in range(5):
        ctl("joints", "arm", f"elbow={0.5 * i}")
    for process in (watch, daemon):
        process.send_signal(signal.SIGINT)
        check(process.wait(timeout=60) == 0, "it ends in order")
    watch.stdout.close()


def replay(path, *options):
    return subprocess.run([DAEMON, "--replay", path, *options], capture_output=True, text=True, timeout=90, check=False)


def a_copy_by_lcm_logplayer_is_the_same(path, copy):
    done = subprocess.run(["lcm-logplayer", "--speed=1000", f"--lcm-url=file://{copy}?mode=w", path],
                          capture_output=True, text=True, timeout=90, check=False)
    check(done.returncode == 0, f"lcm-logplayer: {done.stdout}{done.stderr}")
    ours, theirs = records(path), records(copy)
    check([r[:2] for r in ours] == [r[:2] for r in theirs], f"{len(ours)} records became {len(theirs)}")
    channels = {channel for channel, _, _ in ours}
    check({"collided.in.Body", "collided.in.PoseBatch", "collided.tick"} <= channels, f"channels: {channels}")
    check(any(channel.startswith("collided.out.EventBatch.") for channel in channels), f"no events: {channels}")
    for file in (path, copy):
        done = replay(file)
        check(done.returncode == 0 and "equal to the recording" in done.stdout, f"replay: {done.stdout}{done.stderr}")


def what_is_played_reaches_the_network(path):
    """By UDP: a machine that is busy may lose some of it, but not each time."""
    for turn in range(5):
        told = play_to_logger(path, os.path.join(folder, f"heard{turn}"))
        if not told:
            return
    check(False, told)


def logger_listens():
    with open("/proc/net/udp", encoding="ascii") as f:
        return any(line.split()[1].endswith(":%04X" % 7667) for line in f.readlines()[1:])


def play_to_logger(path, heard):
    """What is wrong with it, or nothing."""
    logger = subprocess.Popen(["lcm-logger", "--channel=collided.out.*", "--flush-interval=10", heard],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    expected = [r[:2] for r in records(path) if r[0].startswith("collided.out.")]
    check(until(30, logger_listens), "lcm-logger listens")
    time.sleep(0.2)  # it says nowhere when it has subscribed
    done = subprocess.run(["lcm-logplayer", "--speed=20", "--regexp=collided.out.*", path], capture_output=True, text=True,
                          timeout=120, check=False)
    check(done.returncode == 0, f"lcm-logplayer: {done.stdout}{done.stderr}")
    arrived = until(5, lambda: os.path.exists(heard) and os.path.getsize(heard) >= sum(len(c) + len(d) + HEAD.size
                                                                                      for c, d in expected))
    logger.send_signal(signal.SIGINT)
    logger.wait(timeout=60)
    return "" if arrived and [r[:2] for r in records(heard)] == expected else f"not all of {len(expected)} arrived"


def a_changed_byte_is_told(path, copy):
    """Of an event's lower bound, a double: the last byte but one of the first is changed."""
    shutil.copy(path, copy)
    channel, data, at = next(r for r in records(path) if r[0].startswith("collided.out.EventBatch."))
    lower = struct.unpack_from(">d", data, offset_of_lower(data))[0]
    with open(copy, "r+b") as file:
        file.seek(at + offset_of_lower(data) + 6)
        byte = file.read(1)
        file.seek(-1, os.SEEK_CUR)
        file.write(bytes([byte[0] ^ 1]))
    done = replay(copy)
    check(done.returncode == 70, f"the status is {done.returncode}")
    words = [f"stream \"{channel.removeprefix('collided.out.EventBatch.')}\", its event 0", "lo: recorded ",
             f"replayed {lower:.17g}"]
    for word in words:
        check(word in done.stdout, f"{word} is not in {done.stdout}")
    print(done.stdout, end="")


def offset_of_lower(data):
    """Behind the fields that come before it in idl/collided.lcm."""
    at = 8 + struct.calcsize(">iqiqqqqqqqiiBqBqBBiii")
    for size in ("string", 1, 1, 8, "strings", "strings", 4, 4):  # stream, kinds, causes, contacts, names, shapes
        count = struct.unpack_from(">i", data, at)[0]
        at += 4
        if size == "strings":
            for _ in range(count):
                at += 4 + struct.unpack_from(">i", data, at)[0]
        else:
            at += count * (1 if size == "string" else size)
    return at + 4


if not shutil.which("lcm-logplayer"):
    skip("lcm-logplayer (package liblcm-bin) is not installed")
isolate()
folder = tempfile.mkdtemp()
os.environ["XDG_STATE_HOME"] = folder
session, other = os.path.join(folder, "session"), os.path.join(folder, "copy")
try:
    record(session)
    a_copy_by_lcm_logplayer_is_the_same(session, other)
    what_is_played_reaches_the_network(session)
    a_changed_byte_is_told(session, other)
finally:
    shutil.rmtree(folder)
finish()
