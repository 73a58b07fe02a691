"""Runs a benchmark with --json and checks that each line is an object with the keys that it promises. The numbers
themselves are the machine's business, so only their kind is looked at; but nobody may be silent, or miss a pair."""
import json
import subprocess
import sys

KEYS = {
    "service": ["bodies", "hz", "core_share", "us_p50", "us_p99", "raw_us_p50", "raw_us_p99", "ticks", "events"],
    "latency": ["world", "poses", "us_p50", "us_p99", "ratio_p50", "ratio_p99", "missed", "on_arrival"],
    "throughput": ["world", "poses_s", "poses_core_s", "raw_poses_s", "raw_poses_core_s", "ratio", "core_ratio",
                   "sent", "lost"],
    "crowd": ["clients", "us_p50", "us_p99", "ratio_p99", "rounds", "missed"],
    "hostile": ["neighbour_ms_p99", "longest_tick_ms", "rss_mb", "restarts", "wrong", "unanswered"],
    "subscriptions": ["clients", "bodies", "subscriptions", "matching_us_each", "tick_us_p50", "tick_us_p99",
        "bytes_each", "pairs"],
    "clients": ["clients", "joined", "seconds", "client_mb", "client_core_s", "daemon_core_s", "daemon_mb"],
    "python": ["bodies", "us_a_publish", "c_us_a_publish", "us_an_event", "events", "core_share"],
    "soak": ["events", "resident_kib"],
    "world": ["us_per_tick", "us_p99"],
    "verdicts": ["ns_median", "to_fine", "overlaps", "items"],
    "rays": ["bodies", "length", "ns_median", "rays", "hits", "wrong", "width_max"],
    "dial": ["us_per_tick", "us_p99"],
    "fit": ["us_per_tick", "us_mean", "us_p99", "times_cheaper", "excess_m", "events"],
    "check": ["items", "us_an_item", "free", "meets", "undecided", "missed"],
    "broad": ["n", "moving", "us_per_step", "us_mean", "us_p99", "ns_per_moved", "ticks", "bytes_per_body", "pairs",
              "extra", "missed"],
    "narrow": ["coherent", "ns_median", "ns_p99", "wrong", "failed", "missed_truth", "items", "samples"],
    "elementary": ["queries", "contacts", "ns_median", "ns_p99", "misses", "false_hits", "late", "late_max"],
    "pareto": ["ns_mean", "ns_p99", "missed", "false", "failed", "measured", "items"],
    "depth": ["pairs", "width_median", "width_p90", "certain", "us_median", "us_max"],
    "extremes": ["wrong", "failed"],
    "soft": ["triangles", "ms_median", "ms_p99", "contacts", "missed", "extra", "within", "frames",
             "bytes_per_triangle"],
    "worst": ["ms_max", "elements", "tried", "wide", "undecided"],
    "ccd": ["us_median", "us_p99", "misses", "false_hits", "late", "toi_error_max", "pairs", "hits", "failed"],
}
# Of the world's scenes of impacts, all numbers a tick: searches for a time of impact ("sweeps"), the distances and
# verdicts in them ("sweep_queries": refinements), and those of the searches that one axis settled without any
# ("sweeps_by_axis"); "core_share": processor time, in cores, at "hz" ticks a second; "undecided": searches, of all
# ticks, that ended in doubt.
# Of the world's scenes in which all bodies move, milliseconds a tick; and how many pairs touch in the end, where it is
# asked: those of the subscribers agree, whatever the number of workers.
MOVING = ["bodies", "moving", "workers", "ms_median", "ms_p99"]
IMPACTS = ["bodies", "hz", "core_share", "sweeps", "sweep_queries", "sweeps_by_axis", "undecided"]


def broken(name, row):
    """What a line says that cannot be; None = it is well."""
    if row.get("bench") != name:
        return f'"bench" is not "{name}"'
    if not row.get("entry"):
        return "does not say which functions are timed"
    wanted = MOVING if row.get("scene") == "all move" else KEYS[name]
    wrong = [key for key in wanted if not isinstance(row.get(key), (int, float)) or row[key] < 0]
    if wrong:
        return f"missing or no number: {', '.join(wrong)}"
    if name == "service" and not row["events"]:
        return "no events came"
    if name == "latency" and not (row.get("link") and row.get("contender") and row["us_p50"]):
        return "no link, contender or time"
    if name == "latency" and row["poses"] == 1 and row["link"] != "pair" and not row["on_arrival"]:
        return "each tick was handed over"
    if name == "crowd" and not (row.get("link") and row.get("contender") and row["us_p99"] and row["rounds"]):
        return "no link, contender or time"
    if name == "clients" and not (row.get("link") and row["joined"] == row["clients"] and row["client_mb"]):
        return "not all came in, or no memory"
    if name == "python" and not (row["us_a_publish"] and row["events"]):
        return "no time, or no events"
    if name == "throughput" and not (row.get("link") and row["poses_s"] and row["sent"]):
        return "no link, or no poses"
    if name == "world" and (not row.get("scene") or row.get("same_events") is False):
        return "no scene, or other events without the caches"
    if name == "world" and row["scene"] == "all move" and row["facts"] == "touch" and not row["contacts"]:
        return "nothing touched"
    if name == "world" and "sweeps" in row:
        wrong = [key for key in IMPACTS if not isinstance(row.get(key), (int, float)) or row[key] < 0]
        if wrong or row["undecided"]:
            return f"impacts: missing, no number, or in doubt: {', '.join(wrong)}"
        if bool(row["sweeps"]) == ("not predicted" in row["scene"]):
            return "sweeps that nobody asked for, or none"
    if name == "dial" and not row.get("scene"):
        return "no scene"
    if name == "dial" and "accuracy" in row and (row["manifolds"] or (row["accuracy"] == "boxes" and row["queries"])):
        return "work that nobody asked for"
    if name == "dial" and "budget_us" in row and (row["missed"] or not row["width_mean"] > 0):
        return "a contact was missed, or no interval told"
    if name == "fit" and not all(row.get(key) for key in ("robot", "facts", "motion", "contender")):
        return "no robot, facts, motion or contender"
    if name == "broad" and (not row.get("contender") or "ratio_to_best_peer" not in row):
        return "no contender, or no ratio"
    if name == "broad" and (row["missed"] or not row["pairs"]):
        return "pairs were missed, or none found"
    if name == "narrow" and ("error_max" not in row or not all(row.get(key) for key in ("pair", "regime", "contender"))):
        return "no pair, regime, contender or error"
    if name == "narrow" and row["contender"].startswith("collided") and (
            row["wrong"] or row["failed"] or row["missed_truth"]):
        return "ours is wrong"
    if name == "elementary" and not (row.get("scene") and row.get("contender") and row["queries"]):
        return "no scene, contender or queries"
    if name == "elementary" and row["contender"] == "collided" and (row["misses"] or row["late"]):
        return "ours missed a contact, or was late"
    if name == "depth" and not (row.get("scene") and row.get("asked") and row["pairs"]):
        return "no scene, no pairs, or not what was asked"
    if name == "depth" and row["scene"] == "all" and row["asked"] == "measured" and row["width_median"] > 0.1:
        return "half of the depths are told no better than to a tenth"
    if name == "pareto" and not ("error_max" in row and all(row.get(key) for key in ("pair", "contender", "tolerance"))):
        return "no pair, contender, tolerance or error"
    if name == "pareto" and row["contender"] == "collided" and (row["missed"] or row["failed"]):
        return "ours missed an overlap, or failed"
    if name == "pareto" and row["contender"] == "collided" and row["tolerance"] not in ("boxes", "bounds") and row["false"]:
        return "ours saw an overlap that is none"
    if name == "extremes" and not ("error_max" in row and "value" in row and all(
            row.get(key) for key in ("axis", "pair", "contender"))):
        return "no axis, value, pair, contender or error"
    if name == "extremes" and row["contender"] == "collided" and (
            row["wrong"] or row["failed"] or row.get("missed_truth")):
        return "ours is wrong"
    if name == "rays" and not (row.get("contender") and row["ns_median"] and row["hits"] < row["rays"]):
        return "no contender or time, or each ray hits"
    if name == "rays" and row["contender"] == "collided" and (row["wrong"] or row["width_max"] > 1e-6):
        return "ours is wrong, or told no better than to a micrometre"
    if name == "worst" and not all(row.get(key) for key in ("case", "entry", "asked", "ms_max", "elements", "tried")):
        return "no case, entry, time or size"
    if name == "soft" and not (row.get("scene") and row.get("asked") and row.get("contender") and row["triangles"]):
        return "no scene, contender or triangles, or not what was asked"
    if name == "soft" and (row["missed"] or row["extra"] > row["within"]):
        return "a contact was missed, or one is extra that is not within rounding"
    if name == "ccd" and not (row.get("scene") and row.get("contender") and row["pairs"]):
        return "no scene, contender or pairs"
    if name == "ccd" and row["contender"] == "collided" and (
            row["misses"] or row["false_hits"] or row["late"] or row["failed"] or row["toi_error_max"] > 1e-3):
        return "ours missed a contact, saw one that is none, or was late or early"
    return None


name, command = sys.argv[1], sys.argv[2:]
lines = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
if not lines:
    sys.exit("no line was printed")
for line in lines:
    fault = broken(name, json.loads(line))
    if fault:
        sys.exit(f"{fault}: {line}")
print(f"{len(lines)} lines")
