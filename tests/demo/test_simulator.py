"""test_simulator.py BIN: impact_simulator beside a daemon. Each scene keeps the bounds that it states, two runs over DDS
agree bit for bit, and so does one over LCM. It moves into a network namespace of its own first, as test_demo.py does."""
import json
import os
import subprocess
import sys
import tempfile

from test_demo import URIS, Cell, enter_namespace

SCENES = {  # what is known without running it: bounds that may not be looser, energies (J), impacts at least
    "billiards": {"energy_bound": 1e-9, "momentum_bound": 1e-9, "depth_bound_m": 1e-6, "impacts": 50},
    "break": {"energy_bound": 1e-9, "momentum_bound": 1e-9, "depth_bound_m": 1e-6, "impacts": 30},
    "stack": {"energy_bound": 1e-6, "momentum_bound": 1e-9, "depth_bound_m": 1e-3, "impacts": 10},
}
BREAK_J = 0.5 * 0.17 * (8**2 + 0.1**2)  # of billiards.c
PILE_J = 9.81 * 0.1 * (1 + 3 + 5 + 7 + 9)  # of box_stack.c: five boxes of 1 kg and 0.2 m on each other


def run(binaries, scene, uri, *more):
    command = [os.path.join(binaries, "impact_simulator"), "--connect", uri, "--scene", scene, "--json", *more]
    done = subprocess.run(command, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done
    lines = done.stdout.splitlines()
    assert len(lines) == 1, lines
    print(lines[0])
    return json.loads(lines[0])


def check(scene, s):
    stated = SCENES[scene]
    assert s["holds"] and s["scene"] == scene, s
    for name in ("energy", "momentum"):
        assert s[f"{name}_error"] <= s[f"{name}_bound"] <= stated[f"{name}_bound"], (name, s)
    assert s["deepest_m"] <= s["depth_bound_m"] <= stated["depth_bound_m"], s
    assert s["impacts"] >= stated["impacts"] and s["steps"] >= s["impacts"], s
    assert s["round_trips_per_step"] <= 2, s
    if scene == "stack":  # at rest on each other, a gap of less than 1 mm between
        assert s["at_rest"] and 0 < s["energy_last_j"] - PILE_J < 9.81 * 1e-3 * (1 + 2 + 3 + 4 + 5), s
    else:
        assert abs(s["energy_first_j"] - BREAK_J) < 1e-12, s
    if scene == "billiards":
        assert not s["at_rest"] and abs(s["energy_last_j"] / BREAK_J - 1) < 1e-9, s
    if scene == "break":
        assert s["at_rest"] and s["energy_last_j"] == 0, s


def check_picture(path):
    text = open(path).read()
    assert text.count("<polyline") == 16 and text.count("<circle") == 16 and text.endswith("</svg>\n"), text[:300]
    assert "nan" not in text and "inf" not in text


def check_options(binaries, uri):
    for wrong in (["--scene", "snooker"], ["--simulate", "soon"]):
        command = [os.path.join(binaries, "impact_simulator"), "--connect", uri, *wrong]
        done = subprocess.run(command, capture_output=True, text=True, timeout=250)
        assert done.returncode == os.EX_USAGE and wrong[0] in done.stderr, done


if __name__ == "__main__":
    enter_namespace()
    binaries = sys.argv[1]
    summaries = {}
    for link in ("dds", "lcm"):
        with Cell(binaries, link) as cell, tempfile.TemporaryDirectory() as folder:
            for scene in SCENES:
                for _ in range(2 if link == "dds" else 1):
                    s = run(binaries, scene, URIS[link])
                    check(scene, s)
                    assert s["link"] == link, s
                    first = summaries.setdefault(scene, s)
                    for what in ("hash", "steps", "impacts", "energy_last_j"):
                        assert s[what] == first[what], f"two runs differ in {what}: {first} {s}"
            if link == "dds":
                picture = os.path.join(folder, "break.svg")
                run(binaries, "billiards", URIS[link], "--picture", picture, "--simulate", "0.5")
                check_picture(picture)
                check_options(binaries, URIS[link])
            cell.end()
    assert len({s["hash"] for s in summaries.values()}) == len(SCENES), summaries
