"""compare: is a row of the benchmarks slower than it was at another commit, and since which commit? Behind script/bench
--compare. Both builds run in turns on this machine, so that what else it does slows the one as it slows the other; a row
is held by the median of the ratios of its turns. Standard library only."""

import argparse
import json
import os
import statistics
import subprocess
import sys

SLOWER = 1.10
# Program, its arguments, and which numbers of a line are times.
BENCHES = [
    ("bench_world", ["--json", "--bodies", "10000", "--seconds", "1"], ("ms_median", "us_per_tick")),
    ("bench_rays", ["--json", "--seconds", "0.3"], ("ns_median",)),
    ("bench_verdicts", ["--json", "--seconds", "10"], ("ns_median",)),
]
NOT_A_NAME = {"entry", "settings", "samples", "same_events"}


def git(*arguments):
    return subprocess.run(["git", *arguments], check=True, capture_output=True, text=True).stdout.strip()


class Build:
    """A commit's benchmarks, built in a worktree of their own below build/compare."""

    def __init__(self, root, commit):
        self.commit = git("rev-parse", commit)
        self.tree = os.path.join(root, "build", "compare", self.commit[:12])
        self.bin = os.path.join(self.tree, "build", "release", "tests", "bench")
        if not os.path.isdir(self.tree):
            git("worktree", "add", "--detach", self.tree, self.commit)
        run = {"check": True, "stdout": subprocess.DEVNULL, "cwd": self.tree}
        subprocess.run(["cmake", "--preset", "release", "-DBUILD_TESTING=ON"], **run)
        for program, _, _ in BENCHES:
            if os.path.exists(os.path.join(self.tree, "tests", "bench", program + ".c")):
                subprocess.run(["cmake", "--build", "build/release", "--target", program], **run)

    def remove(self):
        git("worktree", "remove", "--force", self.tree)

    def has(self, program):
        return os.path.exists(os.path.join(self.bin, program))

    def measure(self, program, arguments, times):
        """{row: time}; a row is named by what its line says beside its figures."""
        out = subprocess.run([os.path.join(self.bin, program), *arguments], check=True, capture_output=True, text=True)
        rows = {}
        for line in map(json.loads, out.stdout.splitlines()):
            time = next((t for t in times if isinstance(line.get(t), (int, float))), None)
            if time:
                words = [str(v) for k, v in line.items() if isinstance(v, (str, bool)) and k not in NOT_A_NAME]
                words += [f"{k}={line[k]}" for k in ("bodies", "workers", "length_m") if k in line]
                rows[" ".join(words)] = line[time]
        return rows


def compare(before, now, turns, wanted=None):
    """{row: median ratio}, the rows of both builds."""
    ratios = {}
    for program, arguments, times in BENCHES:
        if not (before.has(program) and now.has(program)):
            print(f"{program}: not in both, left out", file=sys.stderr)
            continue
        for turn in range(turns):
            order = [before, now] if turn % 2 == 0 else [now, before]
            found = {build: build.measure(program, arguments, times) for build in order}
            for row, time in found[now].items():
                if row in found[before] and time > 0 and found[before][row] > 0:
                    ratios.setdefault(row, []).append(time / found[before][row])
    return {row: statistics.median(r) for row, r in ratios.items() if wanted is None or row in wanted}


def first_slower(root, before, row, turns):
    """The first commit after `before` at which the row is slower, by halving."""
    commits = git("rev-list", "--reverse", "--first-parent", f"{before.commit}..HEAD").split()
    low, high = 0, len(commits) - 1
    while low < high:
        middle = (low + high) // 2
        build = Build(root, commits[middle])
        slow = compare(before, build, turns, {row}).get(row, 1) >= SLOWER
        build.remove()
        low, high = (low, middle) if slow else (middle + 1, high)
    return git("log", "-1", "--format=%h %s", commits[low])


def baseline(root):
    """The commit that this kind of processor is held against: no times are kept, since both are measured here."""
    with open(os.path.join(root, "tests", "bench", "baseline.json"), encoding="utf-8") as f:
        commits = json.load(f)
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        models = [line.split(":", 1)[1].strip() for line in f if line.startswith("model name")]
    return commits.get(models[0] if models else "", commits["any"])


def main():
    parser = argparse.ArgumentParser(prog="script/bench --compare", description=__doc__)
    parser.add_argument("commit", nargs="?", help="what HEAD is held against; by default what baseline.json has")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--name", action="store_true", help="of each slower row, find the commit that made it so")
    o = parser.parse_args()
    root = git("rev-parse", "--show-toplevel")
    before, now = Build(root, o.commit or baseline(root)), Build(root, "HEAD")
    ratios = compare(before, now, o.turns)
    slower = [row for row, ratio in ratios.items() if ratio >= SLOWER]
    for row, ratio in sorted(ratios.items(), key=lambda r: -r[1]):
        since = first_slower(root, before, row, o.turns) if o.name and ratio >= SLOWER else None
        if o.json:
            print(json.dumps({"bench": "compare", "row": row, "ratio": round(ratio, 3), "since": since}))
        else:
            print(f"{ratio:7.3f}  {row}{f'   since {since}' if since else ''}")
    if not o.json:
        print(f"{len(slower)} of {len(ratios)} rows take {SLOWER:.2f} of {before.commit[:12]}'s time, or more")
    if not ratios:
        sys.exit("no row is in both builds")
    for build in {before.commit: before, now.commit: now}.values():
        build.remove()
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
