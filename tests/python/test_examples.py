"""README's first client prints the same events in Python as it does in C, over DDS and LCM; the other example proves what it
prints."""

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


def lines(*command):
    """What it prints, without repetitions: how often "goes on" is printed depends on how many poses a tick took."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    check(done.returncode == 0, f"{command}: {done.stderr}")
    said = done.stdout.splitlines()
    return [line for i, line in enumerate(said) if i == 0 or line != said[i - 1]]


with tempfile.TemporaryDirectory() as work, daemon():
    first = c_client(work)
    for uri in ("dds://0", "lcm://"):
        for turn in range(5):  # a busy machine may join late, and miss the first swing
            in_c, in_python = lines(first, uri), lines(sys.executable, os.path.join(EXAMPLES, "first_client.py"), uri)
            if in_c == in_python and len(in_c) >= 4:
                break
        check(in_c == in_python and len(in_c) >= 4, f"{uri}: {in_c} {in_python}")
        check(in_python[0] in ("ball and block: contact begins", "block and ball: contact begins"), f"{uri}: {in_python[:1]}")
    said = lines(sys.executable, os.path.join(EXAMPLES, "swarm.py"), "dds://0", "2")
    print(said[-1])
    check(said[-1].endswith(" m, proven") and len(said) > 3 and "distances; the least" in said[0], f"{said}")
finish()
