"""test_picture.py BIN: runs the cell with cell_picture, and checks that the picture is whole: well-formed, with every
body's name, the distance between its witness points, its label, and a time line. It moves into a network namespace of
its own first, so that nothing leaves it and no other test is met there."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as tree

SKIPPED = 77
URI = "dds://78"
AT_MM = 400
SVG = "{http://www.w3.org/2000/svg}"
NAMES = {"arm", "table", "vehicle", "parcel_west", "parcel_east", "workpiece", "bolt", "crate", "wedge"}


def enter_namespace():
    if os.environ.get("PICTURE_IN_NAMESPACE"):
        return
    for mode in ("-Urn", "-n"):
        setup = ["unshare", mode, "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
        tried = subprocess.run(setup + ["true"], capture_output=True, text=True)
        if tried.returncode == 0:
            os.environ["PICTURE_IN_NAMESPACE"] = "1"
            os.execvp("unshare", setup + [sys.executable] + sys.argv)
    print("skipped: a network namespace is not permitted here:", tried.stderr.strip())
    sys.exit(SKIPPED)


def draw(binaries, picture):
    """The cell, until the picture is drawn. Processes are ended whatever happens."""
    running = []
    with tempfile.TemporaryFile("w+") as log:
        try:
            running.append(subprocess.Popen([os.path.join(binaries, "collided"), "--links", URI], stdout=log, stderr=log))
            for _ in range(100):
                log.seek(0)
                if "is ready" in (text := log.read()):
                    break
                time.sleep(0.1)
            else:
                raise AssertionError(f"the daemon is not ready after 10 s: {text}")
            for name in ("vehicle_simulator", "arm_controller"):
                path = os.path.join(binaries, name)
                running.append(subprocess.Popen([path, "--connect", URI], stdout=subprocess.DEVNULL))
            drawing = [os.path.join(binaries, "cell_picture"), "--connect", URI, "--seconds", "8"]
            drawing += ["--at", str(AT_MM), "--out", picture]
            assert subprocess.run(drawing, timeout=30).returncode == 0, "cell_picture failed"
        finally:
            for process in reversed(running):
                process.terminate()
            for process in running:
                process.wait(10)


def check(picture):
    root = tree.parse(picture).getroot()
    assert root.tag == SVG + "svg", root.tag
    texts = {element.text for element in root.iter(SVG + "text")}
    assert NAMES <= texts, f"not named: {NAMES - texts}"
    label = root.find(f".//{SVG}text[@id='interval']").text
    lo, hi = (float(number) for number in re.fullmatch(r"(\S+) \.\. (\S+) mm", label).groups())
    assert 0 < lo <= hi < AT_MM, label
    line = root.find(f".//{SVG}path[@id='distance']").get("d")
    ends = [float(number) for number in re.fullmatch(r"M(\S+) (\S+)L(\S+) (\S+)", line).groups()]
    assert ends[:2] != ends[2:], f"a line without length: {line}"
    for number in re.findall(r"[\d.]+", " ".join(path.get("d", "") for path in root.iter(SVG + "path"))):
        assert float(number) < 2000, f"far off the page: {number}"
    curve = [path.get("d") for path in root.findall(f".//{SVG}path[@class='curve']")]
    assert curve and max(map(len, curve)) > 1000, "no time line"
    assert "nan" not in open(picture).read() and "inf " not in open(picture).read()


def check_rendering(picture):
    if not shutil.which("rsvg-convert"):
        print("not rendered: rsvg-convert is not installed")
        return
    image = subprocess.run(["rsvg-convert", "-w", "600", picture], capture_output=True)
    assert image.returncode == 0 and image.stdout.startswith(b"\x89PNG"), image.stderr
    assert len(image.stdout) > 20000, "an empty image"


if __name__ == "__main__":
    enter_namespace()
    with tempfile.TemporaryDirectory() as folder:
        svg = os.path.join(folder, "cell.svg")
        draw(sys.argv[1], svg)
        check(svg)
        check_rendering(svg)
