"""README keeps its word: its first client compiles as it stands there, runs over DDS and over LCM, and is told of a
contact; and every file, heading and script that README and the pages behind it name exists."""

import os
import re
import subprocess
import sys
import tempfile

ROOT, BIN, LIBRARY, COMPILER = sys.argv[1:5]
LCM = "lcm://udpm://239.255.76.67:7667"

if "README_IN_NAMESPACE" not in os.environ:
    setup = 'ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"'
    for mode in ("-n", "-Urn"):
        if subprocess.run(["unshare", mode, "true"], check=False, stderr=subprocess.DEVNULL).returncode == 0:
            os.environ["README_IN_NAMESPACE"] = "1"
            os.execvp("unshare", ["unshare", mode, "sh", "-c", setup, "sh", sys.executable, *sys.argv])
    print("skipped: a network namespace is not permitted here")
    sys.exit(77)

with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as f:
    readme = f.read()

PAGES = ["README.md", "daemon/README.md", "daemon/OPERATION.md", "client/README.md", "client/collidectl/README.md",
         "client/examples/README.md", "client/python/README.md", "idl/README.md", "docker/README.md", "tests/README.md", "tests/bench/README.md", "daemon/GLOSSARY.md",
         "CONTRIBUTING.md", "SECURITY.md"]


def text_of(path):
    with open(path, encoding="utf-8") as page:
        return page.read()


def headings(path):
    """As anchors: lower case, blanks as hyphens, without marks."""
    return {re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in re.findall(r"^#+ (.*)$", text_of(path), re.M)}


for page in PAGES:
    for target, anchor in re.findall(r"\]\(([^)#:]*)#?([^):]*)\)", text_of(os.path.join(ROOT, page))):
        path = os.path.join(ROOT, os.path.dirname(page), target) if target else os.path.join(ROOT, page)
        assert os.path.exists(path), f"{page} names {target}, which does not exist"
        assert not anchor or anchor in headings(path), f"{page} names the heading {anchor} of {target}, which has none"
for page in PAGES:
    cells, table = 0, False
    for number, line in enumerate(text_of(os.path.join(ROOT, page)).splitlines(), 1):
        before, table = table, line.startswith("|")
        has = len(re.findall(r"(?<!\\)\|", re.sub(r"`[^`]*`", "", line)))
        assert not (before and table) or has == cells, f"{page}:{number}: a row of another number of cells"
        cells = has
for script in re.findall(r"\b(script/[a-z_]+)\b", readme):
    assert os.path.exists(os.path.join(ROOT, script)), f"README names {script}, which does not exist"

code = re.search(r"^```c\n(.*?)^```", readme, re.M | re.S).group(1)
lines = [line for line in code.splitlines() if line.strip()]
assert len(lines) <= 30, f"README promises 30 lines of C, these are {len(lines)}"

with tempfile.TemporaryDirectory() as work:
    source, client = os.path.join(work, "client.c"), os.path.join(work, "client")
    with open(source, "w", encoding="utf-8") as f:
        f.write(code)
    subprocess.run([COMPILER, "-std=c17", "-Wall", "-Wextra", "-Werror", source, "-o", client,
                    "-I", os.path.join(ROOT, "client"), LIBRARY, f"-Wl,-rpath,{os.path.dirname(LIBRARY)}", "-lm"], check=True)
    daemon = subprocess.Popen([os.path.join(BIN, "collided"), "--links", f"dds://0 {LCM}"])
    try:
        for uri in ("dds://0", LCM):
            for _ in range(8):  # a busy machine may not have the daemon started, or heard, in the client's own time
                done = subprocess.run([client, uri], capture_output=True, text=True, timeout=60, check=False)
                said = done.stdout
                if done.returncode == 0 and "contact begins" in said:
                    break
            assert done.returncode == 0, done
            assert "ball and block: contact begins" in said or "block and ball: contact begins" in said, f"{uri}: {said!r}"
    finally:
        daemon.terminate()
        assert daemon.wait(60) == 0
print("1 passed, 0 failed")
