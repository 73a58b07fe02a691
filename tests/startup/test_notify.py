"""A service manager is told when the daemon is ready, that its ticks go on, and that it ends; nothing while it hangs."""

import os
import signal
import socket
import subprocess
import tempfile
import time

from rig import DAEMON, check, finish, isolate

WATCHDOG_S = 1.0
SLACK_S = 0.15  # of a machine that has other work; where that is more, it is listened to again
PATIENCE_S = 60
TRIES = 8

isolate()
folder = tempfile.mkdtemp()
path = os.path.join(folder, "notify")
manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
manager.bind(path)


def hear(seconds):
    """What was told in that time: (when, text)."""
    heard, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        manager.settimeout(max(end - time.monotonic(), 0.001))
        try:
            text = manager.recv(4096).decode()
            heard.append((time.monotonic(), text))
        except TimeoutError:
            break
    return heard


def hear_until(holds, heard=()):
    """All that is told until it holds of it, or for a long time."""
    heard, end = list(heard), time.monotonic() + PATIENCE_S
    while not holds([text for _, text in heard]) and time.monotonic() < end:
        heard += hear(0.05)
    return heard


def start(watchdog, *options):
    environment = dict(os.environ, NOTIFY_SOCKET=path)
    if watchdog:
        environment["WATCHDOG_USEC"] = str(int(watchdog * 1e6))
    return subprocess.Popen([DAEMON, "--links", "dds://0 lcm://", "--status-period", "60", *options], env=environment,
                            stderr=subprocess.PIPE, text=True)


def first():
    manager.settimeout(PATIENCE_S)
    return manager.recv(4096).decode()


def ready(daemon, words="is ready"):
    said = first()
    check(said.startswith("READY=1\nSTATUS=") and words in said, f"ready: {said!r}")
    lines = []
    while not lines or "is ready" not in lines[-1]:  # the same moment as in the log
        lines.append(daemon.stderr.readline())
        check(lines[-1], f"the log says that it is ready: {lines}")


def end(daemon):
    daemon.send_signal(signal.SIGTERM)
    said = [text for _, text in hear_until(lambda texts: any(t.startswith("STOPPING=1") for t in texts))]
    daemon.communicate()
    check(daemon.returncode == 0, f"it ends in order: {daemon.returncode}")
    check(any(text.startswith("STOPPING=1") for text in said), f"it says that it ends: {said}")


def signs_of_life_come_twice_in_the_time_even_if_idle():
    daemon, others = start(WATCHDOG_S), []
    ready(daemon)
    for _ in range(TRIES):
        said, steady = hear(3), False
        signs = [when for when, text in said if text == "WATCHDOG=1"]
        gaps = [b - a for a, b in zip(signs, signs[1:])]
        steady = len(signs) >= 6 and max(gaps) <= WATCHDOG_S / 2 + SLACK_S and min(gaps) > WATCHDOG_S / 10
        others += [text for _, text in said if text != "WATCHDOG=1"]
        if steady:
            break
    check(steady, f"signs of life, as often as needed and no more: {gaps}")
    others += [text for _, text in hear_until(lambda texts: others or "STATUS=ready" in texts) if text != "WATCHDOG=1"]
    check(others == ["STATUS=ready"], f"its world is whole: {others}")
    daemon.send_signal(signal.SIGSTOP)
    hear(0.1)
    check(not hear(1.5 * WATCHDOG_S), "a daemon that hangs says nothing")
    daemon.send_signal(signal.SIGCONT)
    said = hear_until(lambda texts: "WATCHDOG=1" in texts)
    check(any(text == "WATCHDOG=1" for _, text in said), "it goes on")
    end(daemon)


def without_a_watchdog_there_is_no_sign():
    daemon = start(None)
    ready(daemon)
    said = {text for _, text in hear(1)}
    check(said <= {"STATUS=ready"}, f"nobody has asked: {said}")
    end(daemon)


def it_has_a_worker_for_each_processor_that_it_may_use():
    daemon = start(None, "--cpus", str(min(os.sched_getaffinity(0))))
    ready(daemon, "is ready, 1 worker(s)")
    end(daemon)


def a_daemon_that_does_not_start_is_never_ready():
    environment = dict(os.environ, NOTIFY_SOCKET=path)
    done = subprocess.run([DAEMON, "--links", "dds://0 lcm://", "--gateway", "/bin/false"], env=environment,
                          stderr=subprocess.DEVNULL, check=False)
    check(done.returncode == 69 and not hear(0.1), "nothing was told")


signs_of_life_come_twice_in_the_time_even_if_idle()
without_a_watchdog_there_is_no_sign()
it_has_a_worker_for_each_processor_that_it_may_use()
a_daemon_that_does_not_start_is_never_ready()
finish()
