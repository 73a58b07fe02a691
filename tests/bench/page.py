"""page: what the pages of the benchmarks share."""
import datetime
import os


def fixed(value):
    """A time in ns with three figures: 9.1, 27, 1,280."""
    if value < 9.95:
        return f"{value:.1f}"
    digits = max(0, len(str(int(value))) - 3)
    return f"{round(value, -digits):,.0f}"


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
    print(f"wrote {path}", file=__import__("sys").stderr)
