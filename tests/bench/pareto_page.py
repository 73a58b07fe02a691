"""pareto_page.py LINES FOLDER: from the JSON lines of a whole run of bench_pareto writes FOLDER/pareto.md and its pictures
(gnuplot; SVG, and PNG beside it). Every figure on the page comes from the lines."""
import collections
import json
import os
import sys

from page import draw, error, fixed, label, machine, table, write

REGIMES = ["separated", "shallow", "deep"]
OURS = "collided"
PERHAPS = ("boxes", "bounds")  # these may leave the verdict open
LABELS = ["boxes", "bounds", "cascade", "verdict", 1, 0.1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-12, "exact"]
FLOOR = 4e-15  # as ERROR_FLOOR in bench_pareto.c
NAMES = {"fcl": "FCL distance, libccd's solver", "fcl_collide": "FCL collide, libccd's solver",
         "fcl_indep": "FCL distance, its own solver", "fcl_indep_collide": "FCL collide, its own solver",
         "bullet_pair": "Bullet, pair detector (GJK, EPA)", "bullet_epa": "Bullet, GJK/EPA solver 2",
         "bullet_boxbox": "Bullet, box-box", "ode": "ODE", "ccd_gjk": "libccd, GJK and EPA", "ccd_mpr": "libccd, MPR"}


def sound(row):
    return row["missed"] + row["false"] + row["failed"] == 0


def faults(row):
    """What a cell says beside its time: nothing if all verdicts are right."""
    said = [f"{row[key]} {key}" for key in ("missed", "false", "failed") if row[key]]
    return ", ".join(said)


def cell(row):
    if row is None:
        return ""
    wrong = faults(row)
    text = f"{fixed(row['ns_mean'])} / {fixed(row['ns_p99'])} / {error(row['error_max'])}"
    return f"~~{text}~~ {wrong} of {row['items']}" if wrong else text


class Run:
    def __init__(self, path):
        self.rows = [json.loads(line) for line in open(path, encoding="utf-8")]
        self.at = {(r["pair"], r["contender"], r["tolerance"], r["regime"], r["coherent"]): r for r in self.rows}
        self.pairs = list(dict.fromkeys(r["pair"] for r in self.rows))
        self.settings = {(r["contender"], r["tolerance"]): (r["entry"], r["settings"]) for r in self.rows}

    def regimes(self, pair):
        return [g for g in REGIMES if any(r["pair"] == pair and r["regime"] == g for r in self.rows)]

    def peers(self, pair):
        return [r for r in self.rows if r["pair"] == pair and r["contender"] != OURS]


def mean(values):
    return sum(values) / len(values)


def dial(run):
    """Ours: mean time by tolerance, all classes mixed; and the worst error."""
    lines = []
    for pair in run.pairs:
        cells = []
        for tolerance in LABELS:
            rows = [run.at[pair, OURS, tolerance, g, False] for g in run.regimes(pair)]
            cells.append(fixed(mean([r["ns_mean"] for r in rows])))
        lines.append([pair, *cells])
    return table(["ns", *[label(t) for t in LABELS]], lines)


def quickest(run, pair, regime, most, ours, coherent=False):
    """The quickest of ours, or of the peers, that answers the whole row rightly at an error of at most `most`; or None."""
    fit = [r for r in run.rows if r["pair"] == pair and r["regime"] == regime and r["coherent"] == coherent and sound(r)
           and (r["contender"] == OURS) == ours and r["tolerance"] not in PERHAPS and r["measured"] == r["items"]
           and r["error_max"] <= most]
    return min(fit, key=lambda r: r["ns_mean"], default=None)


def duel(run, most):
    """At an error of at most `most`: our quickest, and the quickest of the peers."""
    lines = []
    for pair in run.pairs:
        cells = []
        for regime in REGIMES:
            ours, peer = quickest(run, pair, regime, most, True), quickest(run, pair, regime, most, False)
            if regime not in run.regimes(pair):
                cells.append("")
            elif ours is None:
                cells.append("ours: none")
            elif peer is None:
                cells.append(f"{fixed(ours['ns_mean'])} : no peer")
            else:
                cells.append(f"{fixed(ours['ns_mean'])} : {fixed(peer['ns_mean'])} {peer['contender']}")
        lines.append([pair, *cells])
    return table(["ns, ours : quickest peer", *REGIMES], lines)


def verdict_duel(run):
    """Our verdict alone, and the quickest peer whose verdicts are all right, whatever else it says."""
    lines = []
    for pair in run.pairs:
        cells = []
        for regime in REGIMES:
            for coherent in (False, True):
                rows = [r for r in run.rows if (r["pair"], r["regime"], r["coherent"]) == (pair, regime, coherent) and sound(r)]
                ours = run.at.get((pair, OURS, "cascade" if coherent else "verdict", regime, coherent))
                peer = min((r for r in rows if r["contender"] != OURS), key=lambda r: r["ns_mean"], default=None)
                cells.append("" if ours is None else f"{fixed(ours['ns_mean'])} : "
                             + (f"{fixed(peer['ns_mean'])} {peer['contender']}" if peer else "no peer"))
        lines.append([pair, *cells])
    heads = [f"{regime}, {state}" for regime in REGIMES for state in ("cold", "coherent")]
    return table(["ns, ours : quickest peer", *heads], lines)


def beaten_at(run, most):
    """The pair types in which a peer is quicker somewhere at that accuracy, with who and where."""
    named = collections.OrderedDict()
    for pair in run.pairs:
        for regime in run.regimes(pair):
            for coherent in (False, True):
                ours, peer = (quickest(run, pair, regime, most, who, coherent) for who in (True, False))
                if peer and (ours is None or ours["ns_mean"] > peer["ns_mean"]):
                    named.setdefault(pair, {})[peer["contender"]] = True
    return named


def classes(rows):
    """{class: its rows}, a class being a pair type, a regime, and cold or coherent."""
    out = collections.OrderedDict()
    for r in rows:
        out.setdefault((r["pair"], r["regime"], r["coherent"]), []).append(r)
    return out


def share(part, whole):
    return f"{part} of {whole} ({100 * part / max(whole, 1):.0f} %)"


def dominance(run):
    lines, whole = [], 0
    raced = [p for p in run.pairs if run.peers(p)]
    for pair in raced:
        good = [r for r in run.peers(pair) if sound(r)]
        left = [r for r in good if not r["dominated"]]
        whole += not left
        where = collections.OrderedDict()
        for r in left:
            where.setdefault(r["contender"], {})[r["regime"] + (" coherent" if r["coherent"] else "")] = True
        named = "; ".join(f"{who} ({', '.join(places)})" for who, places in where.items())
        lines.append([pair, share(len(good) - len(left), len(good)), named or "nobody"])
    good = [r for r in run.rows if r["contender"] != OURS and sound(r)]
    cells = classes(good)
    won = sum(all(r["dominated"] for r in rows) for rows in cells.values())
    quicker = {most: beaten_at(run, most) for most in (1e-3, 1e-6, 1e-9)}
    text = [f"- Ours dominates {share(sum(r['dominated'] for r in good), len(good))} points,",
            f"- all points of a class in {share(won, len(cells))} classes,",
            f"- all points of all classes in {share(whole, len(raced))} pair types: the rest are named "
            "below."]
    for most, beaten in quicker.items():
        named = "; ".join(f"{pair} ({', '.join(who)})" for pair, who in beaten.items()) or "none"
        text.append(f"- Of those that measure all of a class to {error(most)} of the size or better, ours is the quickest in "
                    f"every class of {share(len(raced) - len(beaten), len(raced))} pair types. The others: {named}.")
    return "\n".join(text) + "\n\n" + table(["pair type", "sound points dominated", "not dominated"], lines)


def verdicts(run):
    """Each contender over all pair types: what it got wrong, and its worst error at its finest tolerance."""
    lines = []
    for who in [OURS, *NAMES]:
        of = collections.OrderedDict()
        for r in run.rows:
            if r["contender"] == who and r["tolerance"] not in PERHAPS:
                of.setdefault(r["tolerance"], []).append(r)
        for tolerance, rows in of.items():
            items = sum(r["items"] for r in rows)
            errors = [r["error_max"] for r in rows if r["error_max"] is not None]
            cells = [sum(r[key] for r in rows) for key in ("missed", "false", "failed")]
            lines.append([who, label(tolerance), items, *cells, error(max(errors)) if errors else "-"])
    return table(["contender", "tolerance", "queries", "missed", "false", "failed", "worst error"], lines)


def numbers(run, pair, coherent):
    regimes = run.regimes(pair)
    keys = list(dict.fromkeys((r["contender"], r["tolerance"]) for r in run.rows if r["pair"] == pair))
    lines = [[who, label(t), *[cell(run.at.get((pair, who, t, g, coherent))) for g in regimes]] for who, t in keys]
    return table(["contender", "tolerance", *regimes], lines)


def points(rows):
    return "\n".join(f"{r['ns_mean']} {max(r['error_max'], 1e-17)}" for r in rows)


def front(rows):
    """The points that no other of them beats in both, by rising time."""
    kept = []
    for r in sorted(rows, key=lambda r: (r["ns_mean"], r["error_max"])):
        if not kept or r["error_max"] < kept[-1]["error_max"]:
            kept.append(r)
    return kept


LIBRARIES = {"FCL": ("#d62728", 4, ("fcl", "fcl_collide", "fcl_indep", "fcl_indep_collide")),
             "Bullet": ("#2ca02c", 8, ("bullet_pair", "bullet_epa", "bullet_boxbox")),
             "ODE": ("#9467bd", 12, ("ode",)), "libccd": ("#e08a00", 10, ("ccd_gjk", "ccd_mpr"))}
STYLES = {"ours": "with points lc rgb '#1f77b4' pt 7 ps 0.8", "front": "with lines lc rgb '#1f77b4' lw 2",
          "errs": "with points lc rgb '#aaaaaa' pt 2 ps 0.7",
          **{name: f"with points lc rgb '{c}' pt {pt} ps 0.9" for name, (c, pt, _) in LIBRARIES.items()}}


def panel(run, pair, regime, number):
    """gnuplot's words for one pair type; what errs is grey and crossed out."""
    whole = [r for r in run.rows if r["pair"] == pair and r["regime"] == regime and not r["coherent"]
             and r["error_max"] is not None and (r["measured"] == r["items"] or not sound(r))]
    ours = [r for r in whole if r["contender"] == OURS and sound(r)]
    sets = {"front": front(ours), "ours": ours, "errs": [r for r in whole if not sound(r) and r["contender"] != OURS]}
    for name, (_, _, members) in LIBRARIES.items():
        sets[name] = [r for r in whole if r["contender"] in members and sound(r)]
    words, plots = [], []
    for k, (name, rows) in enumerate(sets.items()):
        if rows:
            words.append(f"$p{number}_{k} << EOD\n{points(rows)}\nEOD")
            plots.append(f"$p{number}_{k} {STYLES[name]} notitle")
    times = [r["ns_mean"] for r in whole]
    least, most = min(times) / 1.6, max(times) * 1.6
    step = (1, 2, 5) if most / least < 30 else (1, 3) if most / least < 300 else (1,)
    tics = [f * 10 ** k for k in range(8) for f in step if least <= f * 10 ** k <= most]
    ticks = ", ".join(f"'{t:,}' {t}" if t < 1000 else f"'{t // 1000}k' {t}" if t < 10 ** 6 else f"'{t // 10 ** 6}M' {t}"
                      for t in tics)
    return [*words, f"set title '{pair}' font ',12' offset 0,-0.7", f"set xrange [{least}:{most}]",
            f"set xtics ({ticks}) font ',9' offset 0,0.4", "plot " + ", ".join(plots)]


def picture(run, regime, folder):
    """A panel a pair type: mean time against greatest error, both logarithmic; the key in one more."""
    pairs = [p for p in run.pairs if regime in run.regimes(p)]
    columns = 5
    lines = -(-(len(pairs) + 1) // columns)
    script = [f"set multiplot layout {lines},{columns} title "
              f"'{regime}, cold: greatest error (of the size) against mean time (ns); lower left is better' "
              "font ',15' margins 0.045,0.99,0.09,0.93 spacing 0.035,0.075", "set logscale xy", "unset mxtics",
              "unset mytics", "set tics nomirror", "set format y '10^{%L}'",
              "set grid lc rgb '#dddddd'", "set yrange [1e-17:10]", "set ytics 1e4 font ',9'"]
    for number, pair in enumerate(pairs):
        script += panel(run, pair, regime, number)
    named = {"ours": "collided, by tolerance", "front": "its front", **{name: name for name in LIBRARIES},
             "errs": "with wrong verdicts or failures"}
    keys = ", ".join(f"NaN {STYLES[name]} title '{text}'" for name, text in named.items())
    script += ["unset logscale", "set xrange [0:1]", "set yrange [0:1]", "unset tics", "unset border", "unset grid",
               "set title ' '", "set key center center font ',12' samplen 2 spacing 1.2", f"plot {keys}"]
    draw(script, os.path.join(folder, f"pareto_{regime}"), 1500, 290 * lines + 80)


def page(run):
    out = [f"""# Speed against accuracy

What a user buys with a looser tolerance, and what the collision libraries of Debian 12 offer for the same time. Written
by `script/bench pareto`, from {len(run.rows)} measured points, on {machine()}.

- **Inputs**: random pairs of bodies of 0.3 to 1 m, {run.rows[0]['items']} a row: separated by 5 to 50 % of the mean
  reach, in shallow contact (0.1 to 2 %), in deep contact (pulled to 10 to 60 % of the way); meshes of 5,000 triangles and
  compounds of 10 boxes are raced separated only. *Cold*: independent configurations in random order. *Coherent*: followed
  along a smooth motion, with whatever a contender keeps from frame to frame.
- **Truth**: 113-bit arithmetic, by oracles that share no code with the engine (`tests/bench/narrow_truth.h`).
- **Error**: of the signed distance (gap, or least depth), greatest of the row, relative to the size of the pair. Of ours it
  is the middle of the certified interval, which held the truth each time.
- **Time**: one process, one thread, contenders interleaved in random order; ns a query. Mean: over the inputs, of each the
  median of its rounds. p99: of all samples. A sample is 16 queries.
- **Missed**: overlaps not seen. **False**: overlaps that are none. **Failed**: no answer, an assertion, or no number.
  A contender that errs at some tolerance is struck out there: it is no choice, however quick.

- **What is timed of ours** is what the daemon calls: for each query the relative pose of the two bodies and
  `narrow_query`, with the cache that a tick keeps for the pair (empty where the pair is new); `narrow_query_world`, as shape
  casts ask, for *exact*; for *cascade* the cheap proofs that a tick tries first. The last table names the functions of each
  contender, and a test (`tests/bench/check_shipped.py`) holds that the world calls those of ours.

## The dial: ours, by tolerance

Mean ns, cold, the classes mixed alike. *boxes*: the two bounding boxes alone (they never miss; of separated bodies they may
say "perhaps"). *bounds*: an interval by one axis or two, as the world answers who asks for no more. *cascade*: the verdict as the world finds it (motion bound, last axis, a guess, then the narrow phase).
*verdict*: the narrow phase asked for the verdict alone. Numbers: the width of the interval, relative to the size, verdict
exact. *exact*: as narrow as arithmetic gives, to the last bits of the given poses.

{dial(run)}

## Beside the peers

The quickest of ours and the quickest peer that answers all of the row without a wrong verdict, at an error of at most 1e-6
of the size (cold, mean ns):

{duel(run, 1e-6)}

and of at most 1e-3:

{duel(run, 1e-3)}

The verdict alone: ours (cold: *verdict*, coherent: *cascade*), which is proven, beside the quickest peer whose verdicts are all
right, and which proves nothing. A controller that is content with an unproven yes or no finds it quicker where the second
number is the smaller one:

{verdict_duel(run)}

![separated](pareto_separated.svg)

![shallow contact](pareto_shallow.svg)

![deep contact](pareto_deep.svg)

## Who is dominated

A point is one peer at one of its tolerances in one class (separated, shallow, deep; cold, coherent). It is dominated if
ours at some tolerance is at least as fast at no larger error, with all verdicts right and proven (boxes and bounds, which may
leave one open, count only where all pairs are apart); where a peer gives no distance, the verdict alone is compared; where it
gives one, ours must give one that is no worse, so that a quick but wrong depth counts as a point if its verdict is right. A
pair type is dominated if all points in all of its classes are. The clock runs from the world poses of the two bodies; the
peers are given the matrix of each body's orientation before. Errors up to {FLOOR:.0e} are
the rounding of poses in doubles, and count as equal. Points with a wrong verdict or a failure are not counted; the
compounds have no Debian peer.

{dominance(run)}

## Right and wrong

Each contender over all pair types and classes, cold and coherent. Tolerances of the peers are their own, in metres: those of
FCL's requests, of libccd's `epa_tolerance` and `mpr_tolerance`, of Bullet's simplex and EPA; *none*: it has none that can be
set, or it is of no effect there. libccd and ODE do not measure gaps.

{verdicts(run)}

## All numbers

ns mean / ns p99 / greatest error.
"""]
    for pair in run.pairs:
        out.append(f"<details><summary>{pair}, cold</summary>\n\n{numbers(run, pair, False)}\n</details>\n")
        out.append(f"<details><summary>{pair}, coherent</summary>\n\n{numbers(run, pair, True)}\n</details>\n")
    out.append("## Contenders\n")
    names = [[who, NAMES.get(who, "ours"), *said] for (who, _), said in run.settings.items()]
    out.append(table(["contender", "what", "functions that are timed", "settings"], [n for i, n in enumerate(names) if n not in names[:i]]))
    return "\n".join(out)


run = Run(sys.argv[1])
folder = sys.argv[2]
os.makedirs(folder, exist_ok=True)
for regime in REGIMES:
    picture(run, regime, folder)
write(os.path.join(folder, "pareto.md"), page(run))
