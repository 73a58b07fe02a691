"""rings.py ROOT FOLDER... -- ALLOWED...: does no unit below these folders of ROOT include itself by way of others?

A unit is a .c with its .h. A ring is printed as one shortest way round, with all units that are caught in it. An include
is looked for beside the file first, then by the end of its path. Rings within one of the ALLOWED folders are passed over;
a folder that has none any more must leave that list, so that it gets no new one."""
import collections
import pathlib
import re
import sys

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.M)


def read_units(root, folders):
    """By unit, which is a path without its ending: the units that it includes, and the line that says so."""
    files = [p.relative_to(root) for f in folders for p in sorted((root / f).rglob("*.[ch]"))]
    ends = collections.defaultdict(list)
    for file in files:
        for first in range(len(file.parts)):
            ends["/".join(file.parts[first:])].append(file)
    units = collections.defaultdict(dict)
    for file in files:
        own = file.with_suffix("")
        units[own]
        for include in INCLUDE.findall((root / file).read_text(encoding="utf-8")):
            beside = file.parent / include
            found = [beside] if beside in ends[str(beside)] else ends[include]
            for other in {f.with_suffix("") for f in found[:1]} - {own}:
                units[own].setdefault(other, f"{file} includes {include}")
    return units


def shortest_way_round(units, start):
    """The units from `start` back to it, or none."""
    before, queue = {}, collections.deque([start])
    while queue:
        unit = queue.popleft()
        for other in units[unit]:
            if other == start:
                way = [unit]
                while way[-1] != start:
                    way.append(before[way[-1]])
                return way[::-1]
            if other not in before:
                before[other] = unit
                queue.append(other)
    return []


def reachable(units, start):
    seen, left = set(), [start]
    while left:
        for other in units[left.pop()]:
            if other not in seen:
                seen.add(other)
                left.append(other)
    return seen


def tell_ring(units, ring):
    print(f"a ring of {len(ring)} units: {' '.join(map(str, sorted(ring)))}")
    way = min((shortest_way_round(units, unit) for unit in sorted(ring)), key=len)
    for here, there in zip(way, way[1:] + way[:1]):
        print(f"    {units[here][there]}")


def main():
    root, rest = pathlib.Path(sys.argv[1]), sys.argv[2:]
    split = rest.index("--")
    units, allowed = read_units(root, rest[:split]), {folder: False for folder in rest[split + 1:]}
    if not any(units.values()):
        sys.exit(f"no unit below {root} includes another: this guards nothing")
    below = {unit: reachable(units, unit) for unit in units}
    left, faults = {unit for unit in units if unit in below[unit]}, 0
    while left:
        unit = min(left)
        ring = {other for other in below[unit] if unit in below[other]}
        left -= ring
        home = next((f for f in allowed if all(other.is_relative_to(f) for other in ring)), None)
        if home:
            allowed[home] = True
            continue
        faults += 1
        tell_ring(units, ring)
    if faults:
        print("split what is two things, or move what both sides need below them", file=sys.stderr)
    for folder, used in allowed.items():
        if not used:
            faults += 1
            print(f"{folder} has no ring any more: take it off the list", file=sys.stderr)
    if faults:
        sys.exit(1)
    print(f"{len(units)} units, no ring but in: {' '.join(allowed) or 'none'}")


main()
