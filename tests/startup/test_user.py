#!/usr/bin/env python3
"""Started as root, the daemon becomes another user for good, and so does what it starts."""

import atexit
import os
import pwd
import shutil
import signal
import subprocess
import tempfile

import rig
from rig import DAEMON, check, refused, until

USER = "nobody"


def status_of(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as f:
        return dict(line.rstrip("\n").split(":\t", 1) for line in f if ":\t" in line)


def check_is_user(pid, what):
    status, who = status_of(pid), pwd.getpwnam(USER)
    check(status["Uid"].split() == [str(who.pw_uid)] * 4, f"{what}: uid {status['Uid']}")
    check(status["Gid"].split() == [str(who.pw_gid)] * 4, f"{what}: gid {status['Gid']}")
    check(status["Groups"].split() in ([], [str(who.pw_gid)]), f"{what}: groups {status['Groups']}")
    check(all(int(status[c], 16) == 0 for c in ("CapEff", "CapPrm", "CapAmb")), f"{what}: capabilities are left")
    check(status["NoNewPrivs"] == "1", f"{what}: may get new privileges")


def threads(pid):
    return os.listdir(f"/proc/{pid}/task")


def children(pid):
    found = []
    for thread in threads(pid):
        with open(f"/proc/{pid}/task/{thread}/children", encoding="ascii") as f:
            found += f.read().split()
    return found


def start(*arguments):
    daemon = subprocess.Popen([DAEMON, *arguments], stderr=subprocess.PIPE, text=True)
    atexit.register(daemon.kill)  # whatever a failed test leaves behind
    return daemon


def test_becomes_the_user():
    folder = tempfile.mkdtemp()
    os.chmod(folder, 0o755)
    shutil.chown(folder, USER)
    record = os.path.join(folder, "session.lcmlog")
    daemon = start("--user", USER, "--links", "dds://0 lcm://", "--record", record, "--workers", "2", "--metrics-port", "80")
    lines = iter(daemon.stderr.readline, "")
    check(any("is ready" in line for line in lines), "it does not start")
    for thread in threads(daemon.pid):
        check_is_user(f"{daemon.pid}/task/{thread}", "a thread of the daemon")
    gateway = children(daemon.pid)
    check(len(gateway) == 1, f"one gateway, not {gateway}")
    check_is_user(gateway[0], "the gateway")
    check(os.stat(record).st_uid == pwd.getpwnam(USER).pw_uid, "the recording is another's")
    os.kill(int(gateway[0]), signal.SIGKILL)  # started again: not as root, either

    def is_there_again():
        return [c for c in children(daemon.pid) if c not in gateway]

    if until(30, is_there_again):
        check_is_user(is_there_again()[0], "the gateway that was started again")
    else:
        check(False, "the gateway was not started again")
    daemon.terminate()
    check(daemon.wait(60) == 0, "it does not end in order")
    daemon.stderr.close()
    shutil.rmtree(folder)


def test_root_is_told():
    daemon = start("--links", "dds://0")
    said = ""
    for line in iter(daemon.stderr.readline, ""):
        said += line
        if "is ready" in line:
            break
    check("this is root" in said, f"nobody says that it is root: {said}")
    daemon.terminate()
    daemon.wait(60)


rig.isolate()
if os.getuid() != 0 or open("/proc/self/uid_map", encoding="ascii").read().split() != ["0", "0", "4294967295"]:
    rig.skip("it takes root, outside of a user namespace")
refused("unknown user", ["--links", "dds://0", "--user", "no-such-user"], 78, "user =", "no such user")
refused("not root", ["--links", "dds://0", "--user", "root"], 77, "only root can become another user",
        before=["setpriv", "--reuid", USER, "--regid", "nogroup", "--clear-groups"])
test_becomes_the_user()
test_root_is_told()
rig.finish()
