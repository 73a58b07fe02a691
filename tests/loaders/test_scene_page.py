"""The page of YAML scenes names each key that the schema has, in the table of its mapping, and no other."""

import re
import sys

PAGE, SCHEMA = (open(path, encoding="utf-8").read() for path in sys.argv[1:3])
FIELDS = {"A scene": ["scene_fields"], "A body": ["body_fields", "MOTION_FIELDS"], "A pose": ["pose_fields"],
          "A shape": ["SHAPE_FIELDS", "shape_fields"], "A rule": ["rule_fields"], "A robot": ["robot_fields", "MOTION_FIELDS"]}


def keys_of(name):
    """The strings that begin the fields of a table, or of a macro that stands in tables."""
    begin = re.search(rf"{name}(\[\] = \{{|\(type\)| \\\\?\n)", SCHEMA).end()
    text = SCHEMA[begin:]
    ends = r"CYAML_FIELD_END" if name.endswith("fields") else r"\n(?:static|/\*|\n)"
    return set(re.findall(r'\(\s*"(\w+)"', text[: re.search(ends, text).start()]))


def keys_told(title):
    """What stands in the first column of the table under a title."""
    section = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S).group(1)
    return {key for row in re.findall(r"^\| (`[^|]*`) \|", section, re.M) for key in re.findall(r"`(\w+)`", row)}


failed = False
for title, names in FIELDS.items():
    wanted, told = set().union(*map(keys_of, names)), keys_told(title)
    assert len(wanted) >= 2, f"{title}: the schema is not understood: {wanted}"
    if wanted != told:
        failed = True
        print(f"FAILED: {title}: not on the page {wanted - told}, not in the schema {told - wanted}")
sys.exit(failed)
