"""test_planner BIN EXAMPLES: motion_planner beside a daemon, in a network namespace of its own: what has a way is solved,
by a path within the joints' limits, the same one each time;
who is in the way at an end is told; and wrong problems are refused with the line."""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

BIN, EXAMPLES = sys.argv[1:3]
ARM = [f"{EXAMPLES}/arm.urdf", f"{EXAMPLES}/arm.srdf"]
CLOSED = """problem closed
box 0.02 3 3 0.25 0 0 1 0 0 0
box 3 0.02 3 0 0.25 0 1 0 0 0
start up
goal at_b
"""


def own_network():
    if "IN_NAMESPACE" in os.environ:
        subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
        return
    mode = ["-n"] if os.geteuid() == 0 else ["-Urn"]
    if not shutil.which("unshare") or subprocess.run(["unshare", *mode, "true"], stderr=subprocess.DEVNULL).returncode:
        print("skipped: a network namespace is not permitted here")
        sys.exit(77)
    os.environ["IN_NAMESPACE"] = "1"
    os.execvp("unshare", ["unshare", *mode, sys.executable, *sys.argv])


def plan(problems, *options):
    return subprocess.run([f"{BIN}/motion_planner", "--connect", "dds://0", *options, *ARM], input=problems, text=True,
                          capture_output=True, timeout=240)


def check(good, what):
    if not good:
        sys.exit(f"FAILED: {what}")


def check_path(line):
    path = line["path"]
    check(line["solved"] and len(path) >= 2, f"{line['problem']}: not solved")
    check(all(len(q) == 6 and all(abs(x) <= 2 * math.pi + 1e-9 for x in q) for q in path), "beyond the joints' limits")
    length = sum(math.dist(a, b) for a, b in zip(path, path[1:]))
    check(abs(length - line["length"]) < 1e-3, "another length than is told")


def main():
    own_network()
    with open(f"{EXAMPLES}/arm_shelf.problems", encoding="utf-8") as file:
        problems = file.read()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_STATE_HOME"] = folder
        daemon = subprocess.Popen([f"{BIN}/collided", "--links", "dds://0"], stderr=subprocess.DEVNULL)
        try:
            subprocess.run([f"{BIN}/collidectl", "status", "--wait", "60", "--timeout", "60"], check=True,
                           stdout=subprocess.DEVNULL)
            first, again = plan(problems, "--json"), plan(problems, "--json")
            check(first.returncode == 0, f"status {first.returncode}: {first.stdout}{first.stderr}")
            *lines, whole = [json.loads(line) for line in first.stdout.splitlines()]
            check(whole["problems"] == whole["solved"] == len(lines) == 3 and whole["median_ms"] > 0, f"{whole}")
            for line in lines:
                check_path(line)
            check(lines[0]["edges"] > 300, "the wall is no obstacle: the trees were not needed")
            paths = [json.loads(line).get("path") for line in again.stdout.splitlines()]
            check(paths == [line["path"] for line in lines] + [None], "the same problems give other paths")
            closed = plan(CLOSED)
            check(closed.returncode == 70 and "the goal is not free: forearm_link, obstacle_1" in closed.stderr, f"closed: {closed.stderr}")
            for text, words in (("problem x\nstart up\n", "it needs a start and a goal"),
                                ("problem x\nstart up\ngoal nowhere\n", "has no state 'nowhere'"),
                                ("problem x\nstart up\ngoal elbow 1 tail 2\n", "no joint 'tail'"),
                                ("problem x\ncone 1 2\n", "not understood"),
                                ("problem x\nbox 1 1 1 0 0 0\n", "a body needs its sizes"),
                                ("problem x\nstart elbow one\n", "not a number")):
                wrong = plan(text)
                check(wrong.returncode == 70 and words in wrong.stderr, f"{text!r}: {wrong.stderr}")
            print(f"planner: {len(lines)} problems, {sum(line['edges'] for line in lines)} edges asked")
        finally:
            daemon.terminate()
            daemon.wait()


main()
