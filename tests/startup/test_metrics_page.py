"""The page for Prometheus: promtool finds nothing wrong, the figures are those of Status, probes are answered, requests
that make no sense are bounded, and nobody but this machine hears of it."""

import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time

from rig import BIN, DAEMON, check, finish, isolate, refused, until

WORK = sys.argv[2]  # promtool is unpacked there
MONITORING = sys.argv[3]
PORT = 9464
FAMILIES = {"in_": "messages_in_total", "reject_": "messages_rejected_total", "pairs_by_": "pairs_settled_total",
            "work_of_": "stream_work_units", "events_of_": "stream_events_total", "behind_of_": "stream_messages_behind",
            "contacts_of_": "stream_contacts", "unknown_of_": "stream_unknown_pairs", "nearest_nm_of_": "stream_nearest_nanometres",
            "soonest_ns_of_": "stream_soonest_impact_seconds", "oldest_pose_ns_of_": "stream_oldest_pose_seconds",
            "brief_cut_of_": "stream_brief_cut", "client_name_": "client_info",
            "lost_client_": "lost_client_bodies", "client_bodies_": "client_bodies",
            "client_silent_ns_": "client_silent_seconds", "client_pose_age_ns_": "client_pose_age_seconds",
            "client_poses_": "client_poses_total", "client_work_": "client_work_units",
            "client_spent_ms_": "client_spent_milliseconds_total"}
PROMTOOL = os.path.join(WORK, "prometheus", "usr", "bin", "promtool")


def unpack_promtool():
    """Its package is not installed: that would start a server. Before the network is gone."""
    if os.path.exists(PROMTOOL) or os.environ.get("STARTUP_ISOLATED") == "yes":
        return
    os.makedirs(WORK, exist_ok=True)
    script = "apt-get -q download prometheus && dpkg -x prometheus_*.deb prometheus && rm prometheus_*.deb"
    subprocess.run(["sh", "-c", script], cwd=WORK, capture_output=True, check=False)


def get(path, port=PORT):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
    connection.request("GET", path)
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


def figures(page):
    return dict(re.findall(r"^(collided_\S+) (\S+)$", page, re.M))


def start(settle_s):
    daemon = subprocess.Popen([DAEMON, "--links", "dds://0", "--metrics-port", str(PORT), "--status-period", "0.1",
                               "--settle", str(settle_s)], stderr=subprocess.PIPE, text=True)
    while "is ready" not in daemon.stderr.readline():
        check(daemon.poll() is None, "the daemon starts")
    return daemon


def end(daemon):
    daemon.send_signal(signal.SIGTERM)
    check(daemon.wait(timeout=60) == 0, "it ends in order")
    daemon.stderr.close()


def start_and_ask():
    """The daemon, and what it says while it starts. On a busy machine that may be over when it is asked: once more then,
    with longer to settle."""
    for settle_s in (1, 4, 16):
        daemon = start(settle_s)
        answer = get("/ready")
        first = subprocess.run([os.path.join(BIN, "collidectl"), "--connect", "dds://0", "status", "--timeout", "30"],
                               capture_output=True, text=True, timeout=60, check=False)
        if first.returncode != 0 or settle_s == 16:
            return daemon, answer, first.returncode, first.stderr
        end(daemon)


def a_page_that_promtool_accepts():
    status, page = get("/metrics")
    check(status == 200, f"/metrics: {status}")
    if not os.path.exists(PROMTOOL):
        print("skipped in part: promtool (package prometheus) cannot be had; the page was read all the same")
        return
    done = subprocess.run([PROMTOOL, "check", "metrics"], input=page, capture_output=True, text=True, check=False)
    check(done.returncode == 0 and not done.stderr, f"promtool: {done.stdout}{done.stderr}")
    done = subprocess.run([PROMTOOL, "check", "metrics"], input=page + 'collided_ticks_total{kind="x} 1\n', capture_output=True, text=True, check=False)
    check(done.returncode != 0, "promtool refuses what is broken")


def it_tells_what_happens():
    before = figures(get("/metrics")[1])
    asked = subprocess.run([os.path.join(BIN, "collidectl"), "--connect", "dds://0", "query", "bodies", "--timeout", "30"],
                           capture_output=True, text=True, timeout=60, check=False)
    check(asked.returncode == 0, f"collidectl query: {asked.stderr}")
    for seen in ('collided_messages_in_total{kind="Client"}', "collided_ticks_total"):
        check(until(30, lambda: int(figures(get("/metrics")[1])[seen]) > int(before[seen])), f"{seen}: {before[seen]}")
    after = figures(get("/metrics")[1])
    check(int(after["collided_tick_seconds_count"]) == int(after['collided_tick_seconds_bucket{le="+Inf"}']),
          "a histogram is whole")


def probes_are_answered():
    check(get("/")[0] == 200 and "/metrics" in get("/")[1], "/ says what there is")
    check(get("/etc/passwd")[0] == 404 and get("/" + "x" * 500)[0] == 404, "unknown paths")


def each_figure_has_help_of_its_own():
    """And every figure of Status is there, under its own name or as a member of a family. A client that stays makes sure
    of its figures: collidectl status is one, too, in its own Status, and may have gone from the page or not be there yet."""
    with subprocess.Popen([os.path.join(BIN, "collidectl"), "--connect", "dds://0", "watch"], stdout=subprocess.DEVNULL) as watcher:
        try:
            check(until(60, lambda: "# TYPE collided_stream_work_units" in get("/metrics")[1]), "a client and its stream are on the page")
            compare_with_status()
        finally:
            watcher.terminate()


def compare_with_status():
    page = get("/metrics")[1]
    helps = dict(re.findall(r"^# HELP collided_(\S+) (.*)$", page, re.M))
    types = dict(re.findall(r"^# TYPE collided_(\S+) (\S+)$", page, re.M))
    check(helps.keys() == types.keys() and len(helps) > 60, f"each has help and a type: {len(helps)}, {helps.keys() ^ types.keys()}")
    for name, text in helps.items():
        bare = re.sub("_(total|seconds)", "", name)
        check(len(text.split()) > 1 and text not in (name, bare), f"{name} has no help: {text!r}")
        check((types[name] == "counter") == name.endswith("_total"), f"{name} is a {types[name]}")
    twice = [text for text in helps.values() if list(helps.values()).count(text) > 1]
    check(not twice, f"help of several figures: {set(twice)}")
    status = subprocess.run([os.path.join(BIN, "collidectl"), "--connect", "dds://0", "status", "--json", "--timeout", "30"],
                            capture_output=True, text=True, timeout=60, check=False)
    check(status.returncode == 0, f"collidectl status: {status.stderr}")
    own = {"client_" + name for name in ("repeats", "announced_again", "foreign_messages", "malformed_messages",
                                         "rejections_dropped", "batches_lost", "unknown_events", "stalls", "send_failures", "unheard",
                                         "renewals", "silent_streams")}
    for name in json.loads(status.stdout)["counters"].keys() - own:
        family = next((f for prefix, f in FAMILIES.items() if name.startswith(prefix)), None)
        alone = [name.replace("_ns", "_seconds") + end for end in ("", "_total")]
        check(family in helps or any(a in helps for a in alone), f"{name} of Status is not on the page")


def monitoring_asks_for_figures_that_there_are():
    """docker/monitoring: Prometheus takes it, and each name in the dashboard and the alerts is on the page."""
    page = get("/metrics")[1]
    there = set(re.findall(r"^# TYPE (collided_\S+)", page, re.M)) | {"collided_" + name for name in FAMILIES.values()}
    with open(os.path.join(MONITORING, "collided.json"), encoding="utf-8") as file:
        panels = json.load(file)["panels"]
    with open(os.path.join(MONITORING, "rules.yml"), encoding="utf-8") as file:
        asked = re.findall(r"expr: (.*)", file.read())
    asked += [target["expr"] for panel in panels for target in panel["targets"]]
    check(len(panels) > 10 and len(asked) > 20, f"{len(panels)} panels, {len(asked)} expressions")
    for expression in asked:
        for name in re.findall(r"collided_\w+", expression):
            check(re.sub("_bucket$", "", name) in there, f"{name} in {expression} is not on the page")
    if not os.path.exists(PROMTOOL):
        return
    for arguments in (["config", "prometheus.yml"], ["rules", "rules.yml"]):
        done = subprocess.run([PROMTOOL, "check", *arguments], cwd=MONITORING, capture_output=True, text=True, check=False)
        check(done.returncode == 0, f"promtool check {arguments}: {done.stdout}{done.stderr}")


def it_is_ready_once_its_world_is_whole(daemon):
    check(first_answer[0] == 503 and first_answer[1].startswith("starting: "), f"/ready at the start: {first_answer}")
    check(first_health == 75 and "the daemon is starting" in first_words, f"status: {first_health}, {first_words}")
    check(until(60, lambda: get("/ready")[0] == 200), "it becomes ready")
    said = daemon.stderr.readline()
    check(re.search(r"the world is whole after \d+\.\d s: 0 bodies of \d clients", said), f"the log: {said}")
    check(get("/ready") == (200, "ready\n"), "/ready")


def nonsense_is_bounded():
    for text in (b"\0\0\0\0", b"GET", b"POST /metrics HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n", b"x" * 100000):
        with socket.create_connection(("127.0.0.1", PORT), timeout=30) as s:
            try:
                s.sendall(text)
            except OSError:
                pass  # it was hung up on while it wrote
    idle = [socket.create_connection(("127.0.0.1", PORT), timeout=30) for _ in range(70)]  # and say nothing
    end, answered = time.monotonic() + 60, False
    while not answered and time.monotonic() < end:
        try:
            answered = get("/ready")[0] == 200
        except OSError:
            time.sleep(0.2)
    check(answered, "it answers again once the idle have timed out")
    for s in idle:
        s.close()


def only_this_machine():
    listening = subprocess.run(["ss", "-Hltn"], capture_output=True, text=True, check=True).stdout
    lines = [line for line in listening.splitlines() if f":{PORT} " in line]
    check(lines and all(f"127.0.0.1:{PORT}" in line for line in lines), f"who listens: {lines}")


unpack_promtool()
isolate()
with socket.socket() as taken:
    taken.bind(("127.0.0.1", PORT))
    taken.listen()
    refused("a port that is taken", ["--links", "dds://1", "--metrics-port", str(PORT)], 69, f"metrics_port = {PORT}",
            "0 for none")
daemon, first_answer, first_health, first_words = start_and_ask()
try:
    it_is_ready_once_its_world_is_whole(daemon)
    a_page_that_promtool_accepts()
    it_tells_what_happens()
    each_figure_has_help_of_its_own()
    monitoring_asks_for_figures_that_there_are()
    probes_are_answered()
    only_this_machine()
    nonsense_is_bounded()
finally:
    end(daemon)
finish()
