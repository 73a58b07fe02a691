"""check_shipped.py NM SHIPPED... -- OBJECTS... -- BENCHMARK ARGUMENTS...: does what is timed ship?

SHIPPED are the libraries that the daemon is made of, the caller of the others (world) first. OBJECTS are those of the
benchmarks. Each function of the other libraries that an object calls must be called by world, too: a benchmark that
times an entry of its own is refused. So is a line of the benchmark (run with --json) whose "entry" world does not call.
What is excepted says why."""
import json
import re
import subprocess
import sys

NOT_TIMED = {"broad_proxy_count"}  # asked when the clock has stopped, to hold the pairs against each other
# Of the client's library, which ships by itself.
OF_CLIENTS = {"collided_verify", "collided_verify_prepared"}


def symbols(nm, files, kinds):
    text = subprocess.run([nm, "-P", *files], stdout=subprocess.PIPE, text=True, check=True).stdout
    return {m[1] for m in re.finditer(r"^(\w+) ([A-Za-z])(?: |$)", text, re.M) if m[2] in kinds}


def split(arguments):
    groups = [[]]
    for a in arguments:
        if a == "--" and len(groups) < 3:
            groups.append([])
        else:
            groups[-1].append(a)
    return groups


(nm, caller, *others), objects, benchmark = split(sys.argv[1:])
shipped = symbols(nm, [caller], "U")
offered = symbols(nm, others, "T")
called = symbols(nm, objects, "U") & offered
private = called - shipped - NOT_TIMED
if private:
    sys.exit(f"timed, but the world does not call it: {', '.join(sorted(private))}")
if not called & shipped:
    sys.exit("the objects call nothing of these libraries")
lines = subprocess.run(benchmark, stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
ours = [row for row in map(json.loads, lines) if row.get("contender", "collided").startswith("collided")]
if not ours:
    sys.exit("no line is ours")
for row in ours:
    unknown = {name for name in row["entry"].split(", ")} - shipped - OF_CLIENTS
    if unknown:
        sys.exit(f"{row} times what the world does not call: {', '.join(sorted(unknown))}")
print(f"{len(called)} functions and {len(ours)} lines")
