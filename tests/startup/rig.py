"""rig: a network, a mount table and a folder of the test's own, and what every test here does with them.

Every process that a daemon leaves behind becomes a child of the test, which looks for them. One thread."""

import ctypes
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time

BIN = sys.argv[1]  # where collided, collidectl and collided-lcm are
DAEMON = os.path.join(BIN, "collided")
PR_SET_CHILD_SUBREAPER = 36
SKIPPED = 77
failures = []


def skip(why):
    print(f"skipped: {why}", flush=True)
    sys.exit(SKIPPED)


def isolate():
    """Starts this program again in namespaces of its own, once."""
    if os.environ.get("STARTUP_ISOLATED") != "yes":
        unshare = ["unshare", "-nm"] if os.getuid() == 0 else ["unshare", "-Urnm"]
        if subprocess.run(unshare + ["true"], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            skip("this system does not permit a network and a mount namespace")
        environment = dict(os.environ, STARTUP_ISOLATED="yes", PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")
        os.execvpe("unshare", unshare + [sys.executable] + sys.argv, environment)
    for line in ("link set lo up", "link set lo multicast on", "route add 224.0.0.0/4 dev lo"):
        subprocess.run(["ip"] + line.split(), check=True)
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    for name in ("CYCLONEDDS_URI", "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"):
        os.environ.pop(name, None)


def children():
    with open("/proc/self/task/%d/children" % os.getpid(), encoding="ascii") as f:
        return f.read().split()


def check(holds, what):
    if not holds:
        failures.append(what)
        print(f"FAILED: {what}", flush=True)


def count_sockets():
    with open("/proc/net/udp", encoding="ascii") as f:
        return len(f.readlines()) - 1


def refused(name, arguments, status, *words, program=DAEMON, before=(), preexec=None):
    """The program ends with the status and one line that has the words, and leaves nothing."""
    folder = tempfile.mkdtemp()
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ear.bind(("127.0.0.1", 7410))  # where the first participant of domain 0 would be looked for
    try:
        done = subprocess.run([*before, program, *arguments], cwd=folder, capture_output=True, text=True, timeout=60,
                              preexec_fn=preexec, check=False)
        ear.setblocking(False)
        try:
            heard = len(ear.recv(65536))
        except BlockingIOError:
            heard = 0
    finally:
        ear.close()
    line = done.stderr
    check(done.returncode == status, f"{name}: status {done.returncode}, not {status}: {line}")
    check(line.count("\n") == 1 and line.startswith(os.path.basename(program) + ": "), f"{name}: not one line: {line!r}")
    for word in words:
        check(word in line, f"{name}: {word!r} is not in {line!r}")
    check(not done.stdout, f"{name}: standard output: {done.stdout!r}")
    check(not os.listdir(folder), f"{name}: files are left: {os.listdir(folder)}")
    check(until(20, lambda: not children()), f"{name}: processes are left: {children()}")
    check(not heard, f"{name}: a participant was announced")
    check(until(20, lambda: count_sockets() == expected_sockets), f"{name}: sockets are left")
    shutil.rmtree(folder)
    print(f"{name}: {line.strip()}", flush=True)


expected_sockets = 0  # of the test itself


def set_expected_sockets(count):
    global expected_sockets
    expected_sockets = count


def until(seconds, holds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.01)
    return False


def finish():
    print(f"{len(failures)} failure(s)")
    sys.exit(1 if failures else 0)
