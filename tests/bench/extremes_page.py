"""extremes_page.py LINES FOLDER: from the JSON lines of a whole run of bench_extremes writes FOLDER/extremes.md and its
picture (gnuplot; SVG, and PNG beside it). Every figure on the page comes from the lines."""
import json
import os
import sys

from page import draw, error, label, machine, table, write

OURS = "collided"
AXES = {"scale": ("scale, a power of two", "all lengths times 2^-30 to 2^30: bodies from a nanometre to a million kilometres"),
        "distance": ("distance from the origin, m", "both bodies that far out; positions are doubles, so that at 1e12 m they "
                     "lie on a grid of 0.12 mm: the truth is about the places that they then have"),
        "size ratio": ("size ratio", "B smaller than A by that factor; gaps and depths of the order of B"),
        "aspect ratio": ("aspect ratio", "both bodies flat or needles, thinner than long by that factor"),
        "gap": ("gap, of the mean reach", "separated by that; at 1e-16 rounding of the poses decides whether they are"),
        "depth": ("depth, of the mean reach", "pushed into each other by that"),
        "tilt": ("tilt, rad", "faces, caps or axes parallel but for that angle; 0 = exactly")}


def value_text(axis, value):
    if axis == "scale":
        exponent = round(__import__("math").log2(value))
        return f"2^{exponent}"
    return "0" if value == 0 else error(value)


def who(row):
    return (row["contender"], row["tolerance"])


def cell(rows):
    """All pairs of one contender at one value."""
    if not rows:
        return ""
    asked = sum(r["items"] for r in rows)
    errors = [r["error_max"] for r in rows if r["error_max"] is not None]
    text = error(max(errors)) if errors else "-"
    said = [f"{n} {word}" for word in ("wrong", "failed", "undecided") if (n := sum(r[word] for r in rows))]
    return f"{text}; {', '.join(said)} of {asked}" if said else text


def axis_table(rows, axis):
    mine = [r for r in rows if r["axis"] == axis]
    values = sorted({r["value"] for r in mine})
    contenders = list(dict.fromkeys(who(r) for r in mine))
    lines = []
    for c in contenders:
        cells = [cell([r for r in mine if who(r) == c and r["value"] == v]) for v in values]
        lines.append([f"{c[0]} {label(c[1])}", *cells])
    return table([axis, *[value_text(axis, v) for v in values]], lines)


def summary(rows):
    contenders = list(dict.fromkeys(who(r) for r in rows))
    lines = []
    for c in contenders:
        mine = [r for r in rows if who(r) == c]
        cells = []
        for axis in AXES:
            of = [r for r in mine if r["axis"] == axis]
            asked = sum(r["items"] for r in of)
            bad = sum(r["wrong"] + r["failed"] for r in of)
            cells.append(f"{bad} of {asked}" if asked else "")
        lines.append([f"{c[0]} {label(c[1])}", *cells])
    return table(["wrong or failed", *AXES], lines)


def pair_table(rows):
    """Ours at the finest: the worst error of each pair along each axis."""
    pairs = list(dict.fromkeys(r["pair"] for r in rows))
    lines = []
    for pair in pairs:
        cells = []
        for axis in AXES:
            of = [r["error_max"] for r in rows if r["pair"] == pair and r["axis"] == axis and who(r) == (OURS, "exact")
                  and r["error_max"] is not None]
            cells.append(error(max(of)) if of else "")
        lines.append([pair, *cells])
    return table(["ours, exact", *AXES], lines)


def limits(rows):
    lines = []
    for r in rows:
        value = r["value"] if isinstance(r["value"], str) else f"{r['value']:.17g}"
        lines.append([r["axis"].removeprefix("limit: "), value, r["text"] if r["refused"] else "accepted"])
    return table(["what", "value", "the daemon says"], lines)


def picture(rows, folder):
    """A panel an axis: the share of answers that are wrong or missing, by value."""
    groups = {"collided": ("#1f77b4", 7, (OURS,)),
              "FCL": ("#d62728", 5, ("fcl", "fcl_collide", "fcl_indep", "fcl_indep_collide")),
              "Bullet": ("#2ca02c", 9, ("bullet_pair", "bullet_epa", "bullet_boxbox")), "ODE": ("#9467bd", 13, ("ode",)),
              "libccd": ("#e08a00", 11, ("ccd_gjk", "ccd_mpr"))}
    script = ["set multiplot layout 2,4 title 'wrong verdicts and failures, % of the answers, all settings of a library "
              "together' font ',15' margins 0.045,0.99,0.09,0.88 spacing 0.035,0.14",
              "set logscale x", "unset mxtics", "set tics nomirror", "set grid lc rgb '#dddddd'", "set yrange [-2:65]", "set format x '10^{%L}'"]
    for i, (axis, (title, _)) in enumerate(AXES.items()):
        mine = [r for r in rows if r["axis"] == axis]
        values = sorted({r["value"] for r in mine})
        plots = []
        for k, (name, (colour, point, members)) in enumerate(groups.items()):
            points = []
            for v in values:
                of = [r for r in mine if r["contender"] in members and r["value"] == v]
                if of:
                    share = 100 * sum(r["wrong"] + r["failed"] for r in of) / sum(r["items"] for r in of)
                    points.append(f"{v or 1e-17} {share}")
            script.append(f"$d{i}_{k} << EOD\n" + "\n".join(points) + "\nEOD")
            width = 3 if name == "collided" else 1.5
            plots.append(f"$d{i}_{k} with linespoints lc rgb '{colour}' lw {width} pt {point} ps 0.7 title '{name}'")
        script += [f"set title '{title}' font ',12' offset 0,-0.5", "set key top center font ',9'" if i == 0 else
                   "unset key", "plot " + ", ".join(plots)]
    draw(script, os.path.join(folder, "extremes"), 1500, 680)


def page(rows, ends):
    mine = [r for r in rows if r["contender"] == OURS]
    faults = sum(r["wrong"] + r["failed"] + r["missed_truth"] for r in mine)
    answers = sum(r["items"] for r in mine)
    undecided = sum(r["undecided"] for r in mine)
    nearest = max(r["undecided_max"] for r in mine)
    out = [f"""# Where it gets hard

What collision libraries answer far from everyday sizes, places and shapes. Written by `script/bench extremes`, from
{len(rows)} rows, on {machine()}. Ours: **{faults} wrong verdicts, failures or intervals without the truth in
{answers:,} answers** along {len(AXES)} axes; {undecided} undecided, where the truth is at most {error(nearest)} of the size
from touching.

- **Inputs**: random pairs of bodies (0.3 to 1 m before an axis changes them), separated, in shallow and in deep contact; all
  contenders get the same doubles.
- **Truth**: 113-bit arithmetic, by oracles that share no code with the engine (`tests/bench/narrow_truth.h`).
- **Error**: of the signed distance, greatest of the row, relative to the size of the pair.
- **Wrong**: a verdict (they overlap, they do not) that is not the truth's. **Failed**: no answer, no number, a crash, or no
  answer within 0.2 s of processor time; each question is asked in a process of its own that may die.
- **Undecided**: an interval with 0 in it, wide as arithmetic leaves it, which is no wrong verdict and no right one. Only ours
  says so; the daemon tells such a pair as a touch, with the interval.
- Ours is asked at its default tolerance (1e-6 of the size) and as narrow as arithmetic gives (exact), about world poses; the
  peers as they come, libccd also at 1e-10. Of separated bodies libccd and ODE give the verdict alone. bullet_boxbox is asked
  about boxes only, and ODE not about pairs that it has no collider for.

{summary(rows)}

![wrong verdicts and failures along each axis](extremes.svg)

## The stated range, and beyond it

Positions to 1e12 m, sizes above 0 and to 1e9 m, orientations whose norm is between 0.5 and 2. All axes above stay within
it. What lies beyond is refused, when the message comes, by a text that names field, value and limit:

{limits(ends)}

## Each axis

Greatest error over all pair types, and what was wrong, failed or undecided.
"""]
    for axis, (_, text) in AXES.items():
        out.append(f"### {axis[0].upper()}{axis[1:]}\n\n{text[0].upper()}{text[1:]}.\n\n{axis_table(rows, axis)}\n")
    out.append(f"## Ours by pair type\n\nGreatest error of the exact answers.\n\n{pair_table(rows)}\n")
    return "\n".join(out)


lines = [json.loads(line) for line in open(sys.argv[1], encoding="utf-8")]
measured = [r for r in lines if not r["axis"].startswith("limit")]
os.makedirs(sys.argv[2], exist_ok=True)
picture(measured, sys.argv[2])
write(os.path.join(sys.argv[2], "extremes.md"), page(measured, [r for r in lines if r["axis"].startswith("limit")]))
