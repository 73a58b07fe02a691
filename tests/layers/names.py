"""names.py ROOT LIBRARY... -- ALLOWED...: does each name of a function stand for one function in its library?

A library is a folder of ROOT; its name ends in "/" where the folders below it are part of it. Static functions count too:
a profile or a backtrace shows no more of them than the name. Formatting is the house's (script/lint), so a definition
begins at the beginning of a line, and a `{` on a line of its own follows its head. ALLOWED are folders whose files are
passed over; one that has no such names any more must leave that list."""
import collections
import pathlib
import re
import sys

DEFINITION = re.compile(r"^(?![#/} ]|typedef\b|else\b)[^\n;={}]*?\b(\w+)\((?:[^;{}]|\n)*?\)\n\{$", re.M)
PASSED_OVER = re.compile(r"/\*.*?\*/|__attribute__\(\((?:[^()]|\([^()]*\))*\)\)\s*", re.S)


def read_functions(root, folder):
    """By name: the files that define a function of it."""
    found = collections.defaultdict(set)
    for path in sorted((root / folder).glob("**/*.[ch]" if folder.endswith("/") else "*.[ch]")):
        for name in DEFINITION.findall(PASSED_OVER.sub("", path.read_text(encoding="utf-8"))):
            found[name].add(path.relative_to(root))
    return found


def main():
    root, rest = pathlib.Path(sys.argv[1]), sys.argv[2:]
    split = rest.index("--")
    allowed, count, faults = dict.fromkeys(rest[split + 1:], 0), 0, 0
    for library in rest[:split]:
        functions = read_functions(root, library)
        if len(functions) < 10:
            sys.exit(f"{library}: only {len(functions)} functions are found in it: this guards nothing")
        count += len(functions)
        for name, files in sorted(functions.items()):
            if len(files) < 2:
                continue
            home = next((f for f in allowed if all(str(file).startswith(f) for file in files)), None)
            if home:
                allowed[home] += 1
                continue
            faults += 1
            print(f"{name}: {' '.join(map(str, sorted(files)))}")
    if faults:
        print(f"{faults} names of functions stand for several in one library", file=sys.stderr)
    for folder, hits in allowed.items():
        if not hits:
            faults += 1
            print(f"{folder} has no such names any more: take it off the list", file=sys.stderr)
    if faults:
        sys.exit(1)
    print(f"{count} names of functions; {sum(allowed.values())} of several in {' '.join(allowed) or 'no folder'}")


main()
