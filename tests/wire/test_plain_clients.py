"""The clients of idl/examples, which need no library of ours, move a ball through a block and are told what touches, over LCM."""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "startup"))
from rig import DAEMON, check, finish, isolate  # noqa: E402

IDL, LCM_GEN = sys.argv[2:4]
DEFINITIONS, EXAMPLES = os.path.join(IDL, "collided.lcm"), os.path.join(IDL, "examples")


def contacts(out):
    """Of each line: begin or end, and its interval."""
    lines = [line.split() for line in out.splitlines() if line.startswith(("begin", "end"))]
    return [(kind, {a, b}, float(lo), float(hi)) for kind, a, b, lo, hi in lines]


def runs(uri, command, environment):
    """Of each contact one begin, which is an overlap, and one end, which is none."""
    with contextlib.ExitStack() as stack:
        daemon = subprocess.Popen([DAEMON, "--links", uri], stderr=subprocess.DEVNULL)
        stack.callback(daemon.wait, 60)
        stack.callback(daemon.terminate)
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, env=environment)
    check(done.returncode == 0 and not done.stderr, f"{command[0]}: {done.returncode} {done.stderr}")
    told = contacts(done.stdout)
    check(len(told) >= 2, f"{command[0]}: too little is told: {done.stdout}")
    for i, (kind, bodies, lo, hi) in enumerate(told):
        check(kind == ("end" if i % 2 else "begin") and bodies == {"ball", "block"}, f"{command[0]}: {told}")
        check(lo <= hi and (hi <= 0 if kind == "begin" else lo >= 0), f"{command[0]}: {told[i]}")


isolate()
with tempfile.TemporaryDirectory() as made:
    subprocess.run([LCM_GEN, "-p", "--ppath", made, DEFINITIONS], check=True)
    runs("lcm://", [sys.executable, "-B", os.path.join(EXAMPLES, "plain_client.py")], {**os.environ, "PYTHONPATH": made})
node = shutil.which("node") or shutil.which("nodejs")
if node:
    runs("lcm://udpm://239.255.76.67:7668", [node, os.path.join(EXAMPLES, "plain_client.mjs"), DEFINITIONS, "7668"], os.environ)
else:
    print("skipped: plain_client.mjs needs node")
finish()
