"""Python's processes, threads and signals: a forked child gets an error and not the parent's connection, Ctrl-C ends what
waits, a second thread is refused, a daemon that is gone is told."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
import traceback
import warnings

from world import PATIENCE_S, check, collided, connect, daemon, finish, raises

SPHERE = collided.sphere(0.5)


def in_child(work):
    """Whether it is true in a forked child, which ends as Python's do, with all its destructors."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            status = 0 if work() else 2
        except BaseException:  # pylint: disable=broad-except
            traceback.print_exc()
        gc.collect()
        os._exit(status)
    for _ in range(int(PATIENCE_S / 0.01)):
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return status == 0
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def forked(call):
    try:
        call()
    except collided.Forked as error:
        return "spawn" in str(error)
    return False


def a_forked_child_is_refused():
    with connect() as c:
        ball = c.body("ball", SPHERE)
        stream = c.watch()
        c.sync(PATIENCE_S)
        check(in_child(lambda: forked(lambda: ball.move((1, 0, 0)))), "moving in a child")
        stream.take()
        check(in_child(lambda: forked(lambda: stream.wait(1))), "reading in a child")
        check(in_child(lambda: forked(lambda: collided.connect("dds://0"))), "connecting in a child of a client over DDS")
        check(in_child(lambda: (c.close(), c.closed)[1]), "closing in a child does nothing")
        c.sync(PATIENCE_S)
        check([f.name for f in c.find("*", PATIENCE_S)] == ["ball"], "the parent goes on")
    check(in_child(lambda: connect().close() is None), "who forks before connecting, or after closing, may")


def a_second_thread_is_refused():
    told = []
    with connect() as c:
        stream = c.watch()
        c.sync(PATIENCE_S)

        def use(call):
            end = time.monotonic() + PATIENCE_S
            while not told and time.monotonic() < end:
                try:
                    call()
                except collided.Timeout:
                    pass
                except RuntimeError as error:
                    told.append(str(error))

        thread = threading.Thread(target=use, args=(c.flush,))
        thread.start()
        use(lambda: stream.wait(0.05))
        thread.join()
        c.sync(PATIENCE_S)  # nothing is broken
    check(told and "one at a time" in told[0], f"{told}")


WAITS = """
import sys, collided
with collided.connect("dds://0", connect_timeout_s=30) as c:
    stream = c.watch()
    print("ready", flush=True)
    {}
"""
FOREVER = {"for": "list(stream)", "poll": "while True: c.poll(1000)",
           "async for": "import asyncio\n    async def read():\n        async for _ in stream: pass\n    asyncio.run(read())"}


def ctrl_c_ends_what_waits():
    for name, waits in FOREVER.items():
        process = subprocess.Popen([sys.executable, "-c", WAITS.format(waits)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        process.stdout.readline()
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        try:
            _, said = process.communicate(timeout=PATIENCE_S)
            check(said.count("KeyboardInterrupt") >= 1 and process.returncode in (-signal.SIGINT, 1, 130),
                  f"{name}: {process.returncode} {said}")
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            check(False, f"{name}: Ctrl-C ends nothing")


def an_interrupted_receiver_is_told():
    """A KeyboardInterrupt where it hurts most: a batch has been taken, and nobody has it yet."""
    with connect() as c:
        stream = c.watch()
        keep, stream.keep = stream.keep, lambda batch: signal.raise_signal(signal.SIGINT)
        raises(KeyboardInterrupt, lambda: stream.wait(PATIENCE_S))
        stream.keep = keep
        raises(collided.Overrun, lambda: stream.wait(PATIENCE_S), "interrupted", "subscribe anew")
        check(c.watch().wait(PATIENCE_S).snapshot, "who subscribes anew is told the whole state")


def a_client_that_is_left_open_is_told():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        client = connect()
        del client
        gc.collect()
    check(any(issubclass(w.category, ResourceWarning) and "not closed" in str(w.message) for w in told), f"{told}")


def a_daemon_that_is_gone_is_told():
    with daemon() as process, connect() as c:
        stream = c.watch()
        c.sync(PATIENCE_S)
        process.kill()
        process.wait()
        begun = time.monotonic()
        raises(collided.NoDaemon, lambda: list(stream), "no daemon")
        check(time.monotonic() - begun < PATIENCE_S, "soon")
        with daemon():
            c.body("ball", SPHERE)
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end:
                try:
                    c.sync(PATIENCE_S)
                    break
                except collided.NoDaemon:
                    continue
            check([f.name for f in c.find("*", PATIENCE_S)] == ["ball"], "the next one is told everything")


def main():
    with daemon():
        for test in (a_forked_child_is_refused, a_second_thread_is_refused, ctrl_c_ends_what_waits,
                     an_interrupted_receiver_is_told, a_client_that_is_left_open_is_told):
            test()
            print(test.__name__, flush=True)
    a_daemon_that_is_gone_is_told()
    finish()


main()
