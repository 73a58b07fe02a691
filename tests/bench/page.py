"""page: what the pages of the benchmarks share."""
import datetime
import os
import subprocess
import sys
import tempfile


def fixed(value):
    """A time in ns with three figures: 9.1, 27, 1,280."""
    if value < 9.95:
        return f"{value:.1f}"
    digits = max(0, len(str(int(value))) - 3)
    return f"{round(value, -digits):,.0f}"


def error(value):
    """Of the size, one figure: 4e-16."""
    if value is None:
        return "-"
    digits, exponent = f"{value:.0e}".split("e")
    return digits if int(exponent) == 0 else "0" if value == 0 else f"{digits}e{int(exponent)}"


def label(tolerance):
    return tolerance if isinstance(tolerance, str) else f"{tolerance:g}" if tolerance >= 0.1 else error(tolerance)


def draw(script, base, width, height):
    """base.svg and base.png, by gnuplot."""
    for terminal, ending in (("svg size {},{} font 'sans,11' background '#ffffff'", "svg"),
                             ("pngcairo size {},{} font 'sans,11'", "png")):
        words = [f"set terminal {terminal.format(width, height)}", f"set output '{base}.{ending}'", *script,
                 "unset multiplot"]
        with tempfile.NamedTemporaryFile("w", suffix=".gp") as f:
            f.write("\n".join(words) + "\n")
            f.flush()
            subprocess.run(["gnuplot", f.name], check=True)


def table(head, lines):
    """Markdown; the first column to the left, numbers to the right."""
    text = ["| " + " | ".join(head) + " |", "| --- |" + " ---: |" * (len(head) - 1)]
    text += ["| " + " | ".join(str(c) for c in line) + " |" for line in lines]
    return "\n".join(text)


def machine():
    model = "an unknown processor"
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        for line in f:
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    return f"{os.cpu_count()} cores of {model}, {datetime.date.today()}"


def write(path, text):
    with open(path, "w", encoding="utf-8") as f:
        f.write(text.rstrip() + "\n")
    print(f"wrote {path}", file=sys.stderr)
