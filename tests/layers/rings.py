"""rings.py FOLDER...: no ring of includes between the units of each folder, its sub-folders included.

A unit is a .c file together with the .h file of the same name beside it. A unit stands above those whose headers it
includes; where one stands above itself, by whatever way round, the files of that ring are named, and the test fails."""
import os
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.M)


def units_of(folder):
    """The files below the folder, by unit: its path without the ending."""
    files = [os.path.normpath(os.path.join(at, name)) for at, _, names in os.walk(folder) for name in names]
    return {path: os.path.splitext(path)[0] for path in files if path.endswith((".c", ".h"))}


def find(include, source, files):
    """The file that an include names: beside the one that includes it, or by a path that ends in the same."""
    beside = os.path.normpath(os.path.join(os.path.dirname(source), include))
    if beside in files:
        return beside
    return next((path for path in files if "/" in include and path.endswith("/" + include)), None)


def arrows(folder):
    files = units_of(folder)
    graph = {unit: {} for unit in files.values()}
    for path, unit in files.items():
        with open(path) as f:
            for include in INCLUDE.findall(f.read()):
                other = find(include, path, files)
                if other and files[other] != unit:
                    graph[unit][files[other]] = os.path.basename(path)
    return graph


def below(graph, unit):
    """All units that this one includes, itself among them only where it is in a ring."""
    seen, left = set(), list(graph[unit])
    while left:
        other = left.pop()
        if other not in seen:
            seen.add(other)
            left.extend(graph[other])
    return seen


def rings(graph):
    """The units in rings, each ring as a sorted list."""
    under = {unit: below(graph, unit) for unit in graph}
    found = {tuple(sorted(o for o in under[u] if u in under[o])) for u in graph if u in under[u]}
    return sorted(found, key=len, reverse=True)


def main():
    bad = False
    for folder in sys.argv[1:]:
        graph = arrows(os.path.normpath(folder))
        if not any(graph.values()):
            sys.exit(f"{folder}: no include between its files: is it the right folder?")
        for ring in rings(graph):
            bad = True
            print(f"{folder}: {len(ring)} units include each other in a ring:")
            for unit in ring:
                others = sorted(os.path.relpath(o, folder) for o in graph[unit] if o in ring)
                print(f"  {os.path.relpath(unit, folder)} -> {', '.join(others)}")
        print(f"{folder}: {len(graph)} units, {sum(map(len, graph.values()))} arrows")
    sys.exit(bad)


main()
