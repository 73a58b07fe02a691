#!/usr/bin/env python3
"""run_cell.py COMPOSE [ENV_FILE] --image IMAGE --cgroup PARENT -- PODMAN...: brings up the services of a compose file of ours, each in a
container with a network of its own on one bridge, or all on the host's, which is this process's, and holds the watcher's
lines against what the cell must show. Runs in network, mount and pid namespaces that end with it (test_docker makes them),
so that nothing remains. Fields of the file that it does not know are an error: what is tested is what is written there."""
import json
import os
import re
import subprocess
import sys
import time

import yaml

KNOWN = {"image", "network_mode", "networks", "read_only", "cap_drop", "security_opt", "stop_grace_period", "depends_on",
         "healthcheck", "build", "command", "entrypoint", "environment", "volumes", "restart"}
ORDER = ["daemon", "watcher", "vehicle", "arm"]
SUBNET = "10.79.0"


def read_compose(path, env_file):
    variables = {}
    for line in open(env_file) if env_file else []:
        if not line.startswith("#"):
            name, value = line.rstrip("\n").split("=", 1)
            variables[name] = value
    return substituted(yaml.safe_load(open(path)), variables)


def substituted(tree, variables):
    """${NAME:-DEFAULT} as compose reads it: DEFAULT when NAME is not set or empty."""
    if isinstance(tree, dict):
        return {key: substituted(value, variables) for key, value in tree.items()}
    if isinstance(tree, list):
        return [substituted(value, variables) for value in tree]
    if isinstance(tree, str):
        return re.sub(r"\$\{(\w+):-([^}]*)\}", lambda m: variables.get(m[1]) or m[2], tree)
    return tree


def run(*command, check=True):
    done = subprocess.run(command, capture_output=True, text=True)
    if check and done.returncode != 0:
        sys.exit(f"failed: {' '.join(command)}\n{done.stdout}{done.stderr}")
    return done


def make_bridge(names):
    """One network namespace a container, with eth0 on a bridge that lies in ours."""
    os.makedirs("/run/netns", exist_ok=True)
    run("mount", "-t", "tmpfs", "tmpfs", "/run/netns")  # names that nobody else sees
    run("ip", "link", "add", "br0", "type", "bridge")
    run("ip", "link", "set", "br0", "up")
    for number, name in enumerate(names, 2):
        run("ip", "netns", "add", name)
        run("ip", "link", "add", f"v{number}", "type", "veth", "peer", "name", "eth0", "netns", name)
        run("ip", "link", "set", f"v{number}", "master", "br0", "up")
        run("ip", "-n", name, "addr", "add", f"{SUBNET}.{number}/24", "dev", "eth0")
        for link in ("lo", "eth0"):
            run("ip", "-n", name, "link", "set", link, "up")
        run("ip", "-n", name, "route", "add", "default", "via", f"{SUBNET}.1")


def arguments(name, service, image):
    """What compose makes of a service, as arguments of 'podman run'."""
    unknown = set(service) - KNOWN
    if unknown:
        sys.exit(f"{name}: this test does not know {sorted(unknown)}")
    words = ["--name", name, "--detach"]
    host = service.get("network_mode") == "host"
    words += ["--network", "host"] if host else ["--network", f"ns:/run/netns/{name}"]
    if not host:
        words += [f"--add-host={other}:{SUBNET}.{number}" for number, other in enumerate(ORDER, 2)]
    if service.get("read_only"):
        words += ["--read-only", "--read-only-tmpfs=false"]
    words += [f"--cap-drop={capability}" for capability in service.get("cap_drop", [])]
    words += [f"--security-opt={option.replace(':true', '')}" for option in service.get("security_opt", [])]
    words += [f"--env={key}={value}" for key, value in service.get("environment", {}).items()]
    words += [f"--volume={volume}" for volume in service.get("volumes", [])]
    if service.get("healthcheck", {}).get("disable"):
        words += ["--no-healthcheck"]
    if "entrypoint" in service:
        words += ["--entrypoint", json.dumps(service["entrypoint"])]
    return words + [image] + service.get("command", [])


class Cell:
    def __init__(self, podman, services, image, cgroup):
        self.podman, self.services, self.image, self.cgroup = podman, services, image, cgroup

    def start(self, name):
        run(*self.podman, "run", "--cgroup-parent", self.cgroup, *arguments(name, self.services[name], self.image))

    def wait_healthy(self, name, within_s=20):
        until = time.monotonic() + within_s
        while time.monotonic() < until:
            if run(*self.podman, "healthcheck", "run", name, check=False).returncode == 0:
                return
            time.sleep(0.3)
        sys.exit(f"failed: {name} is not healthy within {within_s} s:\n{self.log(name)}")

    def log(self, name):
        done = run(*self.podman, "logs", name, check=False)
        return done.stdout + done.stderr

    def stop(self, name):
        run(*self.podman, "stop", "--time", "10", name)
        status = run(*self.podman, "inspect", "--format", "{{.State.ExitCode}}", name).stdout.strip()
        if status != "0":
            sys.exit(f"failed: {name} ended with status {status}:\n{self.log(name)}")

    def clear(self):
        run(*self.podman, "rm", "--all", "--force", "--volumes", check=False)


def check_lines(cell, seconds):
    """Contacts begin and end, the arm stops: poses and contacts went through."""
    until = time.monotonic() + seconds
    counts = {}
    while time.monotonic() < until:
        time.sleep(0.5)
        watcher, arm = cell.log("watcher"), cell.log("arm")
        counts = {"begins": len(re.findall(r"^[0-9:.]+ +begin ", watcher, re.M)),
                  "ends": len(re.findall(r"^[0-9:.]+ +end ", watcher, re.M)),
                  "stops": len(re.findall(r"^[0-9:.]+ +stop ", arm, re.M))}
        if all(counts.values()):
            return counts
    sys.exit(f"failed: after {seconds} s only {counts}\n" + "\n".join(cell.log(name)[-2000:] for name in ORDER))


def main():
    own, podman = sys.argv[1:sys.argv.index("--")], sys.argv[sys.argv.index("--") + 1:]
    image, cgroup = own[own.index("--image") + 1], own[own.index("--cgroup") + 1]
    files = own[:own.index("--image")]
    services = read_compose(files[0], files[1] if len(files) > 1 else None)["services"]
    if sorted(services) != sorted(ORDER):
        sys.exit(f"failed: services are {sorted(services)}")
    if any(services[name].get("network_mode") != "host" for name in ORDER):
        make_bridge(ORDER)
    cell = Cell(podman, services, image, cgroup)
    try:
        cell.start("daemon")
        cell.wait_healthy("daemon")
        for name in ORDER[1:]:
            cell.start(name)
        counts = check_lines(cell, 30)
        for name in ["arm", "vehicle", "watcher", "daemon"]:
            cell.stop(name)
    finally:
        cell.clear()
    print(f"{' '.join(os.path.basename(file) for file in files)}: {counts}")


main()
