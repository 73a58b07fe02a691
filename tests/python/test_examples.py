"""README's first client prints the same events in Python as it does in C, over DDS and LCM; the other example proves what it
prints."""

import contextlib
import os
import re
import subprocess
import sys
import tempfile

from world import check, daemon, finish

ROOT, LIBRARY, COMPILER = sys.argv[3:6]
EXAMPLES = os.path.join(ROOT, "client", "python", "examples")


def c_client(folder):
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        code = re.search(r"^```c\n(.*?)^```", file.read(), re.M | re.S).group(1)
    source, program = os.path.join(folder, "client.c"), os.path.join(folder, "client")
    with open(source, "w", encoding="utf-8") as file:
        file.write(code)
    subprocess.run([COMPILER, "-std=c17", source, "-o", program, "-I", os.path.join(ROOT, "client"), LIBRARY,
                    f"-Wl,-rpath,{os.path.dirname(LIBRARY)}", "-lm"], check=True)
    return program


def begin(*command):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def lines(process):
    """What it prints, without repetitions: how often "goes on" is printed depends on how many poses a tick took."""
    out, errors = process.communicate(timeout=120)
    check(process.returncode == 0, f"{process.args}: {errors}")
    told = out.splitlines()
    return [line for i, line in enumerate(told) if i == 0 or line != told[i - 1]]


def same_events(links, first):
    """Each client has a daemon of its own, so that all run at the same time. What differs runs once more: on a busy machine a
    client may join late, and miss the first swing."""
    second = os.path.join(EXAMPLES, "first_client.py")
    clients = [(begin(first, in_c), begin(sys.executable, second, in_python)) for in_c, in_python in links]
    told = [tuple(map(lines, pair)) for pair in clients]
    return [(pair, a, b) for pair, (a, b) in zip(links, told)
            if a != b or len(a) < 4 or a[0] not in ("ball and block: contact begins", "block and ball: contact begins")]


with tempfile.TemporaryDirectory() as work, contextlib.ExitStack() as stack:
    uris = ["dds://0", "dds://1", *(f"lcm://udpm://239.255.76.67:{port}" for port in (7667, 7668))]
    for uri in uris:
        stack.enter_context(daemon(uri))
    program, differ = c_client(work), [(uris[0], uris[1]), (uris[2], uris[3])]
    for _ in range(5):
        what = same_events(differ, program)
        differ = [pair for pair, _, _ in what]
        if not differ:
            break
    check(not differ, f"C and Python differ: {what}")
with daemon("dds://0"):
    said = lines(begin(sys.executable, os.path.join(EXAMPLES, "swarm.py"), "dds://0", "2"))
    print(said[-1])
    check(said[-1].endswith(" m, proven") and len(said) > 3 and "distances; the least" in said[0], f"{said}")
finish()
