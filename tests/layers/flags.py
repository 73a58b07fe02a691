#!/usr/bin/env python3
"""flags.py COMPILE_COMMANDS ROOT: every source of the product is compiled with all warnings as errors."""
import json
import os
import sys

WANTED = ["-Wall", "-Wextra", "-Werror", "-Wconversion"]
FOLDERS = ("daemon/", "client/", "idl/wire/")

commands, root = json.load(open(sys.argv[1])), os.path.realpath(sys.argv[2])
best = {}  # of each source the fewest flags that a compilation of it lacks: tests/abi compiles the client once more
for entry in commands:
    name = os.path.relpath(os.path.realpath(entry["file"]), root)
    if name.startswith(FOLDERS):
        words = entry["command"].split()
        lacks = [flag for flag in WANTED if flag not in words]
        best[name] = min(lacks, best.get(name, WANTED), key=len)
there = [os.path.relpath(os.path.join(folder, name), root) for first in FOLDERS
         for folder, _, names in os.walk(os.path.join(root, first)) for name in names if name.endswith(".c") and not folder.endswith("/proofs")]
faults = [f"{name} is compiled without {' '.join(best[name])}" for name in sorted(best) if best[name]]
faults += [f"{name} is not compiled" for name in sorted(there) if name not in best]
print("\n".join(faults) or f"{len(best)} sources are compiled with {' '.join(WANTED)}")
sys.exit(bool(faults))
