"""Whatever is wrong at start is told in one line, with the exit status of sysexits.h, and nothing is half-started."""

import os
import resource
import shutil
import socket
import subprocess
import tempfile

from rig import BIN, DAEMON, check, children, finish, isolate, refused, set_expected_sockets

EX_USAGE, EX_DATAERR, EX_NOINPUT, EX_NOHOST, EX_UNAVAILABLE = 64, 65, 66, 68, 69
EX_OSERR, EX_OSFILE, EX_CANTCREAT, EX_NOPERM, EX_CONFIG = 71, 72, 73, 77, 78
WITHOUT_RIGHTS = ("setpriv", "--bounding-set=-all", "--inh-caps=-all")
# A shell in a mount table of its own, in which the file $0 is empty.
HIDE = ("unshare", "-m", "sh", "-c", 'mount --bind /dev/null "$0" && exec "$@"')

isolate()
work = tempfile.mkdtemp()


def write(name, text, mode=0o644):
    path = os.path.join(work, name)
    with open(path, "w", encoding="utf-8") as f:
        f.write(text)
    os.chmod(path, mode)
    return path


def library(program, name):
    """Where the loader finds the library of that name for the program, or None."""
    out = subprocess.run(["ldd", os.path.join(BIN, program)], capture_output=True, text=True, check=True).stdout
    for line in out.splitlines():
        if name in line:
            return os.path.realpath(line.split()[2])
    return None


def command_line():
    refused("unknown option", ["--bogus", "1"], EX_USAGE, "bogus", "--help")
    refused("no option", ["bogus"], EX_USAGE, "bogus", "--help")
    refused("missing value", ["--workers"], EX_USAGE, "--workers needs a value")
    refused("too many workers", ["--workers", "65"], EX_USAGE, "from 0 to 64")
    refused("out of range", ["--rate", "-1"], EX_USAGE, "rate", "from 0 to")
    refused("not a number", ["--lease", "2s"], EX_USAGE, "lease", "0.05")
    refused("wrong choice", ["--engine", "magic"], EX_USAGE, "auto|gjk|ccd|mpr")


def configuration():
    refused("no configuration", ["--config", "/nowhere.conf"], EX_NOINPUT, "/nowhere.conf", "--config")
    secret = write("secret.conf", "rate = 1\n", 0)
    refused("unreadable configuration", ["--config", secret], EX_NOINPUT, "Permission denied", before=WITHOUT_RIGHTS)
    refused("a folder as configuration", ["--config", work], EX_NOINPUT, "directory")
    for name, text, words in (("no equals", "rate = 1\nwhat\n", (":2:", "key = value")),
                              ("unknown key", "\n\nspeed = 3\n", (":3:", "speed")),
                              ("bad value", "max_bodies = many\n", (":1:", "whole number")),
                              ("not text", "rate = 1\nname = \0\n", (":2:", "not text"))):
        refused(f"configuration: {name}", ["--config", write("bad.conf", text)], EX_CONFIG, "bad.conf", *words)


def links():
    refused("unknown interface", ["--interface", "nope0"], EX_NOHOST, "nope0", "lo (127.0.0.1)")
    refused("unknown address", ["--interface", "10.1.2.3"], EX_NOHOST, "10.1.2.3", "lo (127.0.0.1)")
    for name, uri, words in (("domain out of range", "dds://231", ("0 to 230",)),
                             ("domain that is no number", "dds://x", ("0 to 230",)),
                             ("unknown scheme", "http://0", ("dds://", "lcm://")),
                             ("no scheme", "dds", ("dds://", "lcm://")),
                             ("no link", "", ("dds://", "lcm://")),
                             ("twice DDS", "dds://0 dds://", ("twice",)),
                             ("twice LCM", "lcm:// lcm://udpm://239.255.76.67:7667", ("twice",)),
                             ("no group", "lcm://udpm://localhost", ("udpm://239.255.76.67:7667",)),
                             ("not multicast", "lcm://udpm://10.0.0.1:7667", ("udpm://239.255.76.67:7667",)),
                             ("port out of range", "lcm://udpm://239.255.76.67:66000", ("PORT",)),
                             ("other LCM", "lcm://memq://", ("udpm://",)),
                             ("leaves the machine", "lcm://udpm://239.255.76.67:7667?ttl=1", ("interface",))):
        refused(f"links: {name}", ["--links", uri], EX_CONFIG, *words)


def files():
    folder = os.path.join(work, "closed")
    os.mkdir(folder, 0o500)
    there = write("there.lcmlog", "")
    refused("recording exists", ["--record", there], EX_CANTCREAT, "there.lcmlog", "another name")
    refused("recording without a folder", ["--record", "/nowhere/a.lcmlog"], EX_CANTCREAT, "/nowhere/a.lcmlog", "mount")
    refused("recording not permitted", ["--record", folder + "/a"], EX_NOPERM, folder, before=WITHOUT_RIGHTS)
    refused("no folder for recordings", ["--record-dir", "/nowhere"], EX_CANTCREAT, "record_dir", "/nowhere", "mount")
    refused("file as folder", ["--record-dir", there], EX_CANTCREAT, "record_dir", "irectory")
    refused("folder not permitted", ["--record-dir", folder], EX_NOPERM, "record_dir", folder, before=WITHOUT_RIGHTS)
    refused("no folder for what is carried out", ["--runtime-dir", "/nowhere"], EX_CANTCREAT, "runtime_dir", "/nowhere")
    fixed = os.path.join(work, "fixed")
    os.mkdir(fixed)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "none", fixed], check=True)
    refused("disk that is read-only", ["--record", fixed + "/a"], EX_CANTCREAT, "Read-only", fixed)
    subprocess.run(["umount", fixed], check=True)
    refused("no recording to replay", ["--replay", "/nowhere"], EX_NOINPUT, "/nowhere")
    refused("not a recording", ["--replay", write("text", "no recording at all, but long enough\n")], EX_DATAERR,
            "damaged at byte 0", "recording")


def limits():
    refused("few open files", [], EX_OSERR, "ulimit -n",
            preexec=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (32, 32)))


def gateway():
    both = ["--links", "dds://0 lcm://", "--record", "recording", "--gateway"]
    refused("no gateway", both + ["/nowhere/collided-lcm"], EX_OSFILE, "/nowhere/collided-lcm", "--reinstall collided")
    refused("gateway not a program", both + [write("gateway", "x")], EX_OSFILE, "not a program")
    refused("gateway of no known form", both + [write("gateway", "x", 0o755)], EX_UNAVAILABLE, "Exec format error")
    refused("gateway that fails", both + ["/bin/false"], EX_UNAVAILABLE, "/bin/false", "exit status 1")
    lcm = library("collided-lcm", "liblcm")
    refused("gateway without liblcm", both[:-1], EX_UNAVAILABLE, "liblcm.so.1", "--reinstall liblcm1",
            before=HIDE + (lcm,))


def network():
    both = ["--links", "dds://0 lcm://", "--record", "recording"]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("", 7667))
        set_expected_sockets(1)
        refused("LCM's port is taken", both, EX_UNAVAILABLE, "port 7667", "ss -ulnp")
    taken = []
    for index in range(1, 121):
        taken.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        taken[-1].bind(("", 7410 + 2 * index))
    set_expected_sockets(len(taken))
    refused("no participant index is free", ["--links", "dds://0", "--record", "recording"], EX_UNAVAILABLE,
            "participant index", "dds://1")
    for each in taken:
        each.close()
    set_expected_sockets(0)
    subprocess.run(["ip", "route", "del", "224.0.0.0/4", "dev", "lo"], check=True)
    refused("no route for multicast", both, EX_UNAVAILABLE, "ip link set lo multicast on",
            "ip route add 224.0.0.0/4 dev lo")


def libraries():
    for program, name, package in (("collided", "libccd.so", "libccd2"), ("collided", "libddsc.so", "libddsc0debian"),
                                   ("collided", "libqhull_r.so", "libqhull-r8.0"),
                                   ("collidectl", "libddsc.so", "libddsc0debian"),
                                   ("collidectl", "libassimp.so", "libassimp5")):
        path = library(program + ".so", name)
        check(path, f"{program} does not use {name}")
        refused(f"{program} without {name}", ["--version"], EX_OSFILE, name, "apt-get install --reinstall " + package,
                program=os.path.join(BIN, program), before=HIDE + (path,))
    alone = shutil.copy(DAEMON, work)
    refused("collided without its module", ["--version"], EX_OSFILE, "collided.so", "--reinstall collided", program=alone)


def the_launcher_is_not_to_be_seen():
    link = os.path.join(work, "link")
    os.symlink(DAEMON, link)
    said = subprocess.run([link, "--version"], capture_output=True, text=True, check=False)
    check(said.returncode == 0 and said.stdout.startswith("collided "), f"by a link: {said}")
    daemon = subprocess.Popen([DAEMON, "--links", "dds://0"], stderr=subprocess.PIPE, text=True)
    while "is ready" not in daemon.stderr.readline():
        check(daemon.poll() is None, "the daemon starts")
    with open(f"/proc/{daemon.pid}/comm", encoding="ascii") as f:
        check(f.read() == "collided\n", "its name is collided")
    daemon.terminate()
    daemon.communicate()
    check(daemon.returncode == 0 and not children(), "it ends in order")


for group in (command_line, configuration, links, files, limits, gateway, libraries, the_launcher_is_not_to_be_seen,
              network):
    group()
shutil.rmtree(work)
finish()
