"""hosts: what the cases of test_doctor.py share: hosts as network namespaces, what doctor said of them, and its
commands applied to them. Each host belongs to one thread."""
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
BIN, DOUBLE = sys.argv[2:4]
# --timeout of doctor: where nobody is, a second is enough; who is there is heard even on a busy machine.
NOBODY_S, SOMEBODY_S = 1, 6
PATIENCE_S = 60  # for what must come, on a machine that has ten other things to do
WITHOUT_DAEMON = {"daemon", "domain", "interfaces", "wire"}  # such problems leave none to be heard
US, PEER = "10.99.0.1", "10.99.0.2"


# A network with somebody at the other end of the cable.
NETWORK = ("ip link add net0 type veth peer name net9 && ip addr add 10.1.0.1/24 dev net0 && ip link set net0 up && "
           "ip link set net9 up && ip route replace 224.0.0.0/4 dev net0")
LCM_ROUTE = "ip route add 224.0.0.0/4 dev net0"


def until_it_holds(attempt):
    """What the attempt returns, once it fails no longer: others may not have been heard yet."""
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            return attempt()
        except AssertionError:
            if time.monotonic() > end:
                raise
            time.sleep(0.1)


def enter_namespace():
    if os.environ.get("DOCTOR_IN_NAMESPACE"):
        return
    # With process ids of its own where that is permitted: whoever ends this program then ends all that it started.
    family = ["--pid", "--fork", "--kill-child", "--mount-proc"]
    for mode in (["-Urn", *family], ["-n", *family], ["-Urn"], ["-n"]):
        tried = subprocess.run(["unshare", *mode, "true"], capture_output=True, text=True)
        if tried.returncode == 0:
            os.environ["DOCTOR_IN_NAMESPACE"] = "1"
            os.execvp("unshare", ["unshare", *mode, sys.executable] + sys.argv)
    print("skipped: a network namespace is not permitted here:", tried.stderr.strip())
    sys.exit(SKIPPED)


class Host:
    """A network namespace, held open by a process that sleeps. It has loopback as a fresh machine has it, and what LCM
    needs."""

    def __init__(self, lcm=True):
        self.holder = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo here; exec sleep 600"],
                                       stdout=subprocess.PIPE, text=True)
        self.holder.stdout.readline()
        self.running, self.environment, self.folder = [], dict(os.environ), tempfile.TemporaryDirectory()
        self.environment["PATH"] = f"{self.folder.name}:{BIN}:/usr/sbin:/sbin:/usr/bin:/bin"
        self.environment["XDG_STATE_HOME"] = self.folder.name
        self.environment.pop("COLLIDED_URI", None)
        self.environment.pop("CYCLONEDDS_URI", None)
        self.before = ""  # what the shell of a user has set: an export that mended something
        self.run("ip link set lo up")
        if lcm:
            self.run("ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo")

    def inside(self, command):
        return ["nsenter", f"--net=/proc/{self.holder.pid}/ns/net", "sh", "-c", command]

    def run(self, command, check=True):
        done = subprocess.run(self.inside(command), capture_output=True, text=True, env=self.environment, timeout=2 * PATIENCE_S)
        if check and done.returncode != 0:
            raise AssertionError(f"{command}: {done.returncode}: {done.stdout}{done.stderr}")
        return done

    def start(self, command, until, **environment):
        """Starts it, and waits for the line that says that it is there."""
        log = open(os.path.join(self.folder.name, f"log{len(self.running)}"), "w+b")
        process = subprocess.Popen(self.inside("exec " + command if " " in command and ";" not in command else command),
                                   stdout=log, stderr=log, env={**self.environment, **environment},
                                   start_new_session=True)
        self.running.append(process)
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            log.seek(0)
            text = log.read().decode()
            if until in text:
                return process
            if process.poll() is not None:
                break
            time.sleep(0.05)
        raise AssertionError(f"{command}: not '{until}', but: {text}")

    def daemon(self, options="--links 'dds://0 lcm://'", **environment):
        return self.start(f"collided --status-period 0.3 --settle 0 {options}", "is ready", **environment)

    def double(self, uri, **environment):
        return self.start(f"{DOUBLE} --links {uri}", "here", **environment)

    def place(self, name, script):
        """A program of that name, first in PATH."""
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\n" + script + "\n")
        os.chmod(path, 0o755)

    def doctor(self, options="", expected=None, maybe=(), patience=SOMEBODY_S):
        """All findings by check. The exit status must agree with them."""
        if WITHOUT_DAEMON & set(expected or ()) and "silence" not in expected:  # that takes an announcement to be heard
            patience = NOBODY_S
        done = self.run(f"{self.before} collidectl doctor --json --timeout {patience} {options}", check=False)
        return read_findings(done, expected, maybe)

    def doctor_says(self, check, words="", verdict="problem", options="", expected=None, maybe=(), patience=SOMEBODY_S):
        """What it says of that check, once it says so, beside the expected problems."""
        def attempt():
            found = self.doctor(options, expected, maybe, patience)[check]
            assert found["verdict"] == verdict and re.search(words, found["seen"]), f"'{words}' is not in: {found}"
            return found
        return until_it_holds(attempt)

    def end(self):
        for process in self.running:
            try:
                os.killpg(process.pid, signal.SIGKILL)  # also what a shell of it started
            except ProcessLookupError:
                pass
            process.wait()
        self.holder.kill()
        self.holder.wait()


def read_findings(done, expected=None, maybe=()):
    findings = {}
    for line in done.stdout.splitlines():
        finding = json.loads(line)
        assert set(finding) == {"check", "verdict", "seen", "mend"}, line
        assert finding["verdict"] in ("ok", "problem", "cannot tell"), line
        assert (finding["verdict"] == "problem") == bool(finding["mend"]), f"a problem has a command: {line}"
        findings[finding["check"]] = finding
    problems = [f for f in findings.values() if f["verdict"] == "problem"]
    assert done.returncode == (69 if problems else 0), f"{done.returncode}: {done.stdout}{done.stderr}"
    assert not done.stderr, done.stderr
    if expected is not None:
        assert {f["check"] for f in problems} - set(maybe) == set(expected), f"{expected} expected, not {problems}"
    return findings


def is_daemon(command):
    return re.search(r"\bcollided --", command)


def apply(host, command, hosts):
    """Runs a mend as it was printed."""
    remote = re.match(r"ssh (\S+) (.*)", command)
    if remote:
        return apply(hosts[remote[1]], remote[2], hosts)
    if re.match(r"export |unset ", command):
        host.before = command + ";"
    elif is_daemon(command):
        host.start(command, "is ready")
    elif command.startswith("collidectl doctor"):
        words = command.split("   #")[0]  # a comment is for people
        return read_findings(host.run(f"{words} --json --timeout {SOMEBODY_S}", check=False))
    else:
        host.run(command)
    return None


def triggered_and_mended(host, check, words, options="", mend=None, others=(), hosts=None, settle=0.0, maybe=(),
                         also=()):
    """The case itself: doctor finds it, with these words; its command is the expected one; after it, doctor says ok.
    The other problems are just these `others`, and `maybe`, which depends on who announced itself in that second; `also`
    is ok then, too. The mend is applied once; what is heard of it is asked until it is there."""
    found = host.doctor_says(check, words, options=options, expected=[check, *others], maybe=maybe)
    assert mend is None or re.search(mend, found["mend"]), f"'{mend}' is not in: {found}"
    after = apply(host, found["mend"], hosts or {})
    time.sleep(settle)
    alone = "daemon" in others and not hosts  # and remains so

    def ask_again():
        nonlocal after
        told, after = after, None
        if not told and found["mend"].startswith("collidectl doctor"):
            told = apply(host, found["mend"], hosts or {})
        told = told or host.doctor(options, patience=NOBODY_S if alone else SOMEBODY_S)
        for name in (check, *also):
            assert told[name]["verdict"] == "ok", f"mended by {found['mend']}, but: {told[name]}"
        return told

    after = until_it_holds(ask_again)
    print(f"{check}: {found['seen']}\n    mended by: {found['mend']}")
    return after


class Two:
    """Two hosts with a cable: this one, with doctor, and the other, with the daemon."""

    def __init__(self):
        self.here, self.there = Host(lcm=False), Host(lcm=False)
        self.hosts = {US: self.here, PEER: self.there}
        self.here.run(f"ip link add net0 type veth peer name net1 && ip link set net1 netns {self.there.holder.pid}")
        self.here.run(f"ip addr add {US}/24 dev net0 && ip link set net0 up")
        self.there.run(f"ip addr add {PEER}/24 dev net1 && ip link set net1 up")
        self.options = f"--interface net0 --peer {PEER}"

    def daemon(self):
        self.there.daemon("--links dds://0 --interface net1")

    def mended(self, check, words, mend, others=(), **more):
        return triggered_and_mended(self.here, check, words, self.options, mend, others, self.hosts, **more)

    def end(self):
        self.here.end()
        self.there.end()
