"""Runs a benchmark with --json and checks that each line is an object with the keys that it promises. The numbers
themselves are the machine's business, so only their kind is looked at."""
import json
import subprocess
import sys

KEYS = {
    "service": ["bodies", "hz", "core_share", "us_p50", "us_p99", "raw_us_p50", "raw_us_p99", "ticks", "events"],
}

name, command = sys.argv[1], sys.argv[2:]
lines = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
if not lines:
    sys.exit("no line was printed")
for line in lines:
    row = json.loads(line)
    if row.get("bench") != name:
        sys.exit(f'"bench" is not "{name}": {line}')
    wrong = [key for key in KEYS[name] if not isinstance(row.get(key), (int, float)) or row[key] < 0]
    if wrong:
        sys.exit(f"missing or no number: {', '.join(wrong)}: {line}")
    if not row["events"]:
        sys.exit(f"no events came: {line}")
print(f"{len(lines)} lines")
