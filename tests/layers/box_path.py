"""box_path.py ROOT COMPILER LAYERS LIBRARIES FILES/FUNCTIONS FILES/FUNCTIONS: how many files and functions of
daemon/narrow does a tick enter for the distance of two boxes that it has asked about before?

Compiles daemon/narrow without optimisation and with gcov's counters, runs box_path.c, prints the functions that were
entered, and fails where there are more than the two arguments say. The first counts functions that are called; the
second, with COLLIDED_NIGHTLY=1 alone, also those that the compiler is told to inline. A function that one query of
thousands enters counts like all others; how often each was entered is printed. LAYERS are the include paths, LIBRARIES
what narrow stands on; both are separated by commas."""
import collections
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile


WAYS = {"calls": [], "all functions": ["-Dalways_inline=unused", "-Dflatten=unused"]}


def compile_all(root, compiler, layers, libraries, folder, extra):
    narrow = root / "daemon/narrow"
    flags = ["-std=c17", "-D_GNU_SOURCE", "-DNDEBUG", "-O0", "-ffp-contract=off", "-fno-math-errno", "-w", "-Wno-psabi", "--coverage",
             ] + extra + [f"-I{path}" for path in layers]
    jobs = [(source, str(source.relative_to(narrow)).replace("/", "__")) for source in sorted(narrow.glob("**/*.c"))]
    if len(jobs) < 20:
        sys.exit("daemon/narrow has hardly any sources: this guards nothing")
    jobs.append((root / "tests/layers/box_path.c", "box_path.c"))

    def build(job):
        target = folder / (job[1][:-2] + ".o")
        subprocess.run([compiler, *flags, "-c", job[0], "-o", target], check=True, cwd=folder)
        return target

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(build, jobs))
    subprocess.run([compiler, "--coverage", "-o", folder / "box_path", *objects, *libraries, "-lm"], check=True)
    return objects


def entered(narrow, folder, objects, what):
    """By file of daemon/narrow: how often each of its functions was entered."""
    for data in folder.glob("*.gcda"):
        data.unlink()
    subprocess.run([folder / "box_path", what], check=True, cwd=folder)
    found = collections.defaultdict(collections.Counter)
    notes = [str(path.with_suffix(".gcda")) for path in objects if path.with_suffix(".gcda").exists()]
    out = subprocess.run(["gcov", "--json-format", "--stdout", *notes], check=True, cwd=folder, stdout=subprocess.PIPE)
    for line in out.stdout.decode().splitlines():
        for file in json.loads(line)["files"]:
            path = os.path.realpath(file["file"])
            if not path.startswith(narrow):
                continue
            for function in file["functions"]:
                if function["execution_count"]:
                    found[path[len(narrow):]][function["name"]] += function["execution_count"]
    return found


def main():
    root, compiler = pathlib.Path(sys.argv[1]), sys.argv[2]
    layers, libraries = sys.argv[3].split(","), sys.argv[4].split(",")
    limits = dict(zip(WAYS, (tuple(map(int, limit.split("/"))) for limit in sys.argv[5:])))
    narrow = os.path.realpath(root / "daemon/narrow") + "/"
    faults = 0
    for way, extra in WAYS.items():
        if extra and os.environ.get("COLLIDED_NIGHTLY") != "1":
            print(f"{way}: skipped: it takes as long again; COLLIDED_NIGHTLY=1 counts them")
            continue
        with tempfile.TemporaryDirectory() as path:
            folder = pathlib.Path(path)
            objects = compile_all(root, compiler, layers, libraries, folder, extra)
            paths = [entered(narrow, folder, objects, what) for what in ("1", "2")]
        for files, title in zip(paths, ("distance of two boxes", "verdict of balls, capsules and boxes")):
            print(f"{way}, {title}: {len(files)} files, {sum(map(len, files.values()))} functions")
            for name, functions in sorted(files.items()):
                print(f"  {name}: " + ", ".join(f"{f} {n}" for f, n in functions.most_common()))
        count = len(paths[0]), sum(map(len, paths[0].values()))
        if not 5 <= count[0] <= limits[way][0] or not 20 <= count[1] <= limits[way][1]:
            faults += 1
            print(f"{way}: {count[0]} files and {count[1]} functions; at most {limits[way][0]} and {limits[way][1]} are "
                  "allowed (and less than 5 or 20 would mean that nothing was counted)", file=sys.stderr)
    sys.exit(faults)


main()
