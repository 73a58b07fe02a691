"""reach.py ALLOWED ROOT OBJECTS... -- LAYER OBJECTS...: is every function of the layers reached by what ships?

The root objects are the programs' and the client's: all in them ships. A function is reached if one that is names it: by
a call or an address in the machine code (objdump), or in data that the code names. Each that is not reached, but for
those of one file alone, which the compiler watches, must stand in ALLOWED, by name and reason; and what stands there must
be unreached, so that the list does not outlive its reasons."""
import collections
import re
import subprocess
import sys

SYMBOL = re.compile(r"^([0-9a-f]+) (.{7}) (\S+)\t([0-9a-f]+) (?:\.hidden )?(\S+)$", re.M)
HEADER = re.compile(r"^[0-9a-f]+ <(\S+)>:$")
NAMED = re.compile(r"<([^+>]+)(?:\+0x([0-9a-f]+))?>\s*$")
RELOCATION = re.compile(r"R_\w+\s+([^\s+-]+)(?:([+-])0x([0-9a-f]+))?\s*$")
DATA = re.compile(r"^([0-9a-f]+) (R_\w+)\s+([^\s+-]+)(?:([+-])0x([0-9a-f]+))?\s*$")
COMPLAINT = "not called by anything that ships: use it, delete it, or say in {} why it stays"


def run(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout


class Object:
    """One file: its functions, and what each names: functions of this file, symbols of others, sections of data."""

    def __init__(self, path):
        self.path, self.globals, self.functions = path, set(), {}
        self.places = collections.defaultdict(list)  # by section: offset, size, name
        for offset, flags, section, size, name in SYMBOL.findall(run("objdump", "-t", path)):
            if "F" not in flags or section == "*UND*":
                continue
            self.places[section].append((int(offset, 16), int(size, 16), name))
            self.functions[name] = set()
            if flags[0] in "gu!" or flags[1] == "w":
                self.globals.add(name)
        self.data = {}  # section: what its words name
        self.read_code()
        self.read_data()

    def at(self, section, offset):
        for first, size, name in self.places.get(section, ()):
            if first <= offset < first + max(size, 1):
                return name
        return None

    def target(self, symbol, addend, relative):
        """What a relocation names: of a section's code the function there; else the symbol, or the section itself."""
        if symbol.startswith(".text"):
            return self.at(symbol, addend + relative) or self.at(symbol, addend)
        return symbol

    def read_code(self):
        inside = None
        for line in run("objdump", "-dr", "--no-show-raw-insn", self.path).splitlines():
            header = HEADER.match(line)
            if header:
                inside = self.functions.get(header[1])
                continue
            if inside is None:
                continue
            relocation = RELOCATION.search(line)
            if relocation:
                symbol, sign, addend = relocation.groups()
                addend = int(addend or "0", 16) * (-1 if sign == "-" else 1)
                name = self.target(symbol, addend, 4)
                if name:
                    inside.add(name)
                continue
            named = NAMED.search(line)
            if named and named[1] in self.functions:
                inside.add(named[1])

    def read_data(self):
        section = None
        for line in run("objdump", "-r", self.path).splitlines():
            if line.startswith("RELOCATION RECORDS FOR ["):
                section = line[len("RELOCATION RECORDS FOR ["):-2]
                continue
            found = DATA.match(line)
            if not found or not section or section.startswith((".text", ".eh_frame", ".debug")):
                continue
            _, _, symbol, sign, addend = found.groups()
            name = self.target(symbol, int(addend or "0", 16) * (-1 if sign == "-" else 1), 0)
            if name:
                self.data.setdefault(section, set()).add(name)
        # a symbol of data is as good as all of its section
        for offset, flags, home, size, name in SYMBOL.findall(run("objdump", "-t", self.path)):
            if "O" in flags and home in self.data:
                self.data[name] = self.data[home]


def walk(objects, roots):
    where = {name: o for o in objects for name in o.globals}
    data = {name: o for o in objects for name in o.data if not name.startswith(".")}
    reached, left = set(), [(o, name) for o in roots for name in [*o.functions, *o.data]]
    while left:
        o, name = left.pop()
        if (o.path, name) in reached:
            continue
        reached.add((o.path, name))
        for other in o.functions.get(name, set()) | o.data.get(name, set()):
            home = o if other in o.functions or other in o.data else where.get(other) or data.get(other)
            if home:
                left.append((home, other))
    return reached


def main():
    allowed_path, *rest = sys.argv[1:]
    split = rest.index("--")
    roots, layers = [Object(p) for p in rest[:split]], [Object(p) for p in rest[split + 1:]]
    reached = walk(roots + layers, roots)
    names = {(o.path, n) for o in layers for n in o.functions}
    if len(reached & names) < len(names) / 2:
        sys.exit(f"only {len(reached & names)} of {len(names)} functions are reached: this walk has lost its way")
    with open(allowed_path) as f:
        allowed = dict(line.split(None, 1) for line in f if line.strip() and not line.startswith("#"))
    unreached = {n: o.path for o in layers for n in o.globals if (o.path, n) not in reached}
    new = sorted(unreached.keys() - allowed.keys())
    for name in new:
        print(f"{name} ({unreached[name].split('CMakeFiles/')[-1]})")
    stale = sorted(allowed.keys() - unreached.keys())
    if new:
        print(COMPLAINT.format(allowed_path))
    for name in stale:
        print(f"{name} stands in {allowed_path}, but is called, or is not there")
    if new or stale:
        sys.exit(1)
    print(f"{len(names)} functions, all reached but {len(unreached)}, which are allowed")


main()
