"""test_doctor.py GROUP BIN DOUBLE [CASE...]: makes each finding of 'collidectl doctor' happen, runs the very command
that doctor printed, and expects doctor to say ok then. Each case has network namespaces of its own: one for each host,
in a user namespace where this is not root.

What cannot be had for real is replaced, and this is all of it: net.core.rmem_max cannot be written in a namespace, so
doctor reads a copy of it (--system-root), and a `sysctl` in PATH writes that copy; clocks are not in namespaces, so a
double of the daemon is ahead, and `timedatectl` (or `chronyc`) in PATH sets its clock; a daemon of another wire or
release is that double; "ssh HOST" is run in HOST's namespace; a host that is down is one that lost its address. Where a
command only tells when something outside is mended (a cable, somebody's program), the case mends that."""
import concurrent.futures
import os
import re
import shutil
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True  # the source folder stays as it is
from hosts import (DOUBLE, LCM_ROUTE, NETWORK, NOBODY_S, PEER, SKIPPED, US, Host, Two, apply, enter_namespace,
                   triggered_and_mended)

HERE = os.path.dirname(os.path.abspath(__file__))
SIDE_BY_SIDE = 4  # cases: they mostly wait

# ---- this host ----


def loopback_without_multicast(host):
    host.run("ip link set lo multicast off")
    triggered_and_mended(host, "multicast", "lo does no multicast", mend="ip link set lo multicast on",
                         others=["daemon"])


def no_route_for_multicast(host):
    host.run("ip route del 224.0.0.0/4")
    triggered_and_mended(host, "route", "no route", mend="224.0.0.0/4 dev lo", others=["daemon"])


def multicast_leads_elsewhere(host):
    host.run(NETWORK)
    triggered_and_mended(host, "route", "leads to net0", others=["daemon"])


def loopback_is_down(host):
    host.run("ip link set lo down")
    triggered_and_mended(host, "interface", "lo is down", others=["daemon", "route"])


def interface_is_down(host):
    host.run(NETWORK + " && ip link set net0 down")
    triggered_and_mended(host, "interface", "net0 is down", "--interface net0", others=["daemon", "route"])


def interface_without_carrier(host):
    host.run(NETWORK + " && ip link set net9 down")
    found = host.doctor_says("interface", "no carrier", options="--interface net0", patience=NOBODY_S)
    assert found["mend"].startswith("ip link show net0"), found
    host.run("ip link set net9 up")  # its other end
    host.doctor_says("interface", verdict="ok", options="--interface net0", patience=NOBODY_S)
    assert "LOWER_UP" in host.run(found["mend"]).stdout


def interface_without_address(host):
    host.run("ip link add net0 type veth peer name net9 && ip link set net0 up && ip link set net9 up && "
             "ip route replace 224.0.0.0/4 dev net0")
    found = host.doctor("--interface net0", patience=NOBODY_S)["interface"]
    assert "no IPv4 address" in found["seen"], found
    host.run(found["mend"].replace("ADDRESS/PREFIX", "10.1.0.1/24"))
    assert host.doctor("--interface net0", patience=NOBODY_S)["interface"]["verdict"] == "ok"


def loopback_without_address(host):
    host.run("ip addr flush dev lo")
    found = host.doctor(patience=NOBODY_S)["interface"]
    assert found["mend"] == "ip address add 127.0.0.1/8 dev lo", found
    host.run(found["mend"])
    assert host.doctor(patience=NOBODY_S)["interface"]["verdict"] == "ok"


def interface_does_not_exist(host):
    host.daemon()
    triggered_and_mended(host, "interface", "no interface eth9; up are: lo", "--interface eth9",
                         "doctor --interface lo", others=["interfaces"])


def small_receive_buffers(host):
    root = os.path.join(host.folder.name, "root")
    os.makedirs(root + "/proc/sys/net/core")
    for name in ("net", "self"):
        if not os.path.exists(f"{root}/proc/{name}"):
            os.symlink(f"/proc/{name}", f"{root}/proc/{name}")
    limit = root + "/proc/sys/net/core/rmem_max"
    with open(limit, "w", encoding="ascii") as file:
        file.write("212992\n")
    host.place("sysctl", f'test "$1" = -w && echo "${{2#net.core.rmem_max=}}" > {limit}')
    host.daemon()
    triggered_and_mended(host, "buffers", "212992 bytes, and 4194304", f"--system-root {root}",
                         "sysctl -w net.core.rmem_max=4194304")


HOLD_PORTS = """import socket, sys, time
held = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(int(sys.argv[2]))]
[s.bind((sys.argv[3], 7410 + 2 * (i + int(sys.argv[1])))) for i, s in enumerate(held)]
print('here', flush=True)
time.sleep(600)"""


def participants_without_room(host):
    host.start(f"{sys.executable} -c \"{HOLD_PORTS}\" 0 64 0.0.0.0", "here")
    triggered_and_mended(host, "participants", "64 of the 64", mend=r"kill \d+   # python3.* 64", others=["daemon"],
                         settle=0.1)


def participants_run_out(host):
    host.daemon()
    host.start(f"{sys.executable} -c \"{HOLD_PORTS}\" 5 58 127.0.0.1", "here")
    triggered_and_mended(host, "participants", "59 of the 64", mend=r"kill \d+   # python3.* 58", settle=0.1)


def help_tells_of_every_check(host):
    checks = [line.split()[0] for line in host.run("collidectl doctor --list").stdout.splitlines()]
    text = host.run("collidectl help doctor").stdout
    assert len(checks) == 19 and not [c for c in checks if not re.search(rf"\b{c}\b", text)], checks
    assert list(host.doctor(patience=NOBODY_S)) == checks


# ---- the daemon ----


def no_daemon(host):
    triggered_and_mended(host, "daemon", "none was heard on dds://0 within 1 s", mend="collided --links dds://0")


def no_daemon_over_lcm(host):
    triggered_and_mended(host, "daemon", "none was heard on lcm://", "--connect lcm://", "collided --links lcm://")


def cyclone_does_not_start(host):
    """And when it does, there is no daemon."""
    host.before = "export CYCLONEDDS_URI='<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>';"
    found = host.doctor_says("daemon", "does not start", expected=["daemon"])
    assert found["mend"] == "unset CYCLONEDDS_URI", found
    apply(host, found["mend"], {})
    triggered_and_mended(host, "daemon", "none was heard", mend="collided --links")


def cyclone_does_not_start_where_a_daemon_is(host):
    host.daemon("--links dds://0")
    host.before = "export CYCLONEDDS_URI='<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>';"
    triggered_and_mended(host, "interfaces", "heard only without CYCLONEDDS_URI", mend="unset CYCLONEDDS_URI")


def two_daemons(host):
    first = host.daemon()
    second = host.daemon("--links dds://0")
    triggered_and_mended(host, "single", "2 daemons of equal strength", mend=f"kill {first.pid}$", settle=0.3)
    assert first.wait(30) == 0 and second.poll() is None


def limits_reached(host):
    host.daemon("--links dds://0 --max-bodies 1")
    for name in ("one", "two"):
        host.run(f"collidectl load {HERE}/data/table.urdf --prefix {name}", check=False)
    triggered_and_mended(host, "health", "degraded, limits were reached: max_bodies",
                         mend=r"kill \d+; \S*collided .*--max-bodies 1 --max_bodies 3", settle=0.3)


ASK_FOR_TURNS = """import socket, time
held = [socket.socket(socket.AF_UNIX) for _ in range(120)]
[s.connect(chr(0) + 'collided/turns/0') for s in held]
print('here', flush=True)
time.sleep(20)"""


def a_crowd_waits(host):
    host.daemon("--links dds://0")
    host.start(f"{sys.executable} -c \"{ASK_FOR_TURNS}\"", "here")
    triggered_and_mended(host, "health", "clients wait for their turn to join over DDS", mend="status --wait 60")


def gateway_is_down(host):
    daemon = host.daemon()
    host.run("ip route del 224.0.0.0/4")
    host.run(f"kill -9 $(cat /proc/{daemon.pid}/task/*/children)")
    time.sleep(0.4)
    triggered_and_mended(host, "gateway", "collided-lcm does not run", mend="ip route replace", others=["route"],
                         maybe=["losses"], settle=6)  # link_lcm tries again every 5 s


def gateway_dies_again_and_again(host):
    daemon = host.daemon()
    host.start("exec 2>&-; echo here; "
               f"while sleep 0.1; do kill -9 $(cat /proc/{daemon.pid}/task/*/children); done", "here")
    triggered_and_mended(host, "gateway", "does not run|does not stay up", mend=r"kill \d+; \S*collided ", settle=0.4,
                         maybe=["losses"])


def still_starting(host):
    double = host.double("dds://0", DOUBLE_STARTING="1")
    found = host.doctor_says("health", "is starting", expected=["health"])
    assert found["mend"] == "collidectl status --wait 30", found
    double.send_signal(signal.SIGUSR1)  # it has started: to a daemon that merely starts, time is all that is needed
    time.sleep(0.4)
    host.doctor_says("health", verdict="ok")


def another_release(host):
    host.double("dds://0", DOUBLE_RELEASE="0.0.9")
    triggered_and_mended(host, "release", "of release 0.0.9", mend=r"kill \d+; \S*collided --links dds://0", settle=0.3)


def clock_is_ahead(host, uri="dds://0"):
    double = host.double(uri, DOUBLE_CLOCK="5")
    for name in ("timedatectl", "chronyc"):
        host.place(name, f"kill -USR1 {double.pid}")
    triggered_and_mended(host, "clock", r"\+(5\.0|4\.9)\d+ s from ours, to within 0\.0", f"--connect {uri}",
                         "timedatectl set-ntp true|chronyc makestep", settle=0.1)


def clock_is_ahead_over_lcm(host):
    clock_is_ahead(host, "lcm://")


# ---- a daemon elsewhere ----


def another_domain(host):
    host.daemon("--links dds://7")
    triggered_and_mended(host, "domain", r"is on dds://7, and you asked on dds://0",
                         mend="export COLLIDED_URI=dds://7", also=["daemon"])


def another_transport(host):
    host.daemon("--links dds://7")
    triggered_and_mended(host, "domain", "is on dds://7, and you asked on lcm://", "--connect lcm://",
                         "collidectl doctor --connect dds://7")


def another_interface(host):
    host.run(NETWORK + " && ip route replace 224.0.0.0/4 dev lo")
    host.daemon("--links dds://0 --interface net0")
    triggered_and_mended(host, "interfaces", "is on net0, and you asked on lo", mend="doctor --interface net0",
                         also=["daemon"])


def cyclone_leads_elsewhere(host):
    host.daemon("--links dds://0")
    host.before = ("export CYCLONEDDS_URI='<CycloneDDS><Domain><Discovery><Ports><Base>9000</Base></Ports></Discovery>"
                   "</Domain></CycloneDDS>';")
    triggered_and_mended(host, "interfaces", "is heard only without CYCLONEDDS_URI", mend="unset CYCLONEDDS_URI")


def loopback_instead_of_the_network(host):
    host.run(NETWORK)
    host.daemon("--links dds://0")
    triggered_and_mended(host, "interfaces", "is on lo, and you asked on net0", "--interface net0")


# ---- another wire ----


def wire(uri, words, **costume):
    def case(host):
        host.double(uri, **costume)
        triggered_and_mended(host, "wire", words, f"--connect {uri}", rf"kill \d+; \S*collided --links {uri}",
                             settle=0.3)
    case.__name__ = "_".join(["wire", uri[:3], *costume]).lower()
    return case


# ---- clients ----


def lost_client(loss):
    def case(host):
        host.daemon("--links dds://0")
        holder = host.start(f"{DOUBLE} holder dds://0 {loss}", "here")
        host.doctor_says("lost", verdict="ok")
        refused = host.run("collidectl forget 0000000000000007 --timeout 30", check=False)
        assert refused.returncode == 65 and "no bodies of a lost client" in refused.stderr, refused
        holder.kill()
        holder.wait()
        time.sleep(1)
        triggered_and_mended(host, "lost", r"1 client\(s\) were lost and left 1 bodies",
                             mend="collidectl forget [0-9a-f]{16}$", settle=0.4)
        assert not host.run("collidectl query bodies").stdout.count("held")
    case.__name__ = f"lost_client_{loss}"
    return case


def stale_bodies(host):
    host.daemon("--links dds://0")
    host.run(f"collidectl load {HERE}/data/table.urdf --deadline 0.2")
    time.sleep(0.6)
    triggered_and_mended(host, "stale", "1 bodies are past their deadline.* top", mend="collidectl remove top",
                         settle=0.4)


def refusals_grow(host):
    host.daemon("--links dds://0")
    bad = host.start(f"{DOUBLE} bad dds://0", "here")
    time.sleep(0.5)
    found = host.doctor_says("losses", r"reject_unknown_body \+\d+.*the last: PoseBatch of client [0-9a-f]{16}: ",
                             expected=["losses"])
    assert found["mend"].startswith("journalctl -u collided"), found
    # It names the program that has to be mended, which is done here.
    bad.kill()
    bad.wait()
    time.sleep(0.7)
    host.doctor_says("losses", "since the start: reject_unknown_body", "ok", expected=[])


# ---- two hosts ----


def two_hosts_that_hear_each_other(two):
    two.daemon()
    two.here.run(LCM_ROUTE)
    two.here.doctor_says("peer", re.escape(PEER), "ok", two.options, expected=[])
    two.here.doctor_says("daemon", "net1", "ok", two.options, expected=[])


def peer_does_not_listen(two):
    two.here.run(LCM_ROUTE)
    two.mended("peer", "nobody listens", f"ssh {PEER} .*collided --links dds://0 --interface {PEER}", ["daemon"])


def peer_is_down(two):
    two.here.run(LCM_ROUTE)
    two.daemon()
    two.there.run("ip addr del 10.99.0.2/24 dev net1")  # to the other side it is as if it were switched off
    found = two.here.doctor_says("peer", "is down", options=two.options, expected=["peer", "daemon"])
    assert found["mend"].startswith(f"ping -c 3 {PEER}"), found
    two.there.run(f"ip addr add {PEER}/24 dev net1")  # its power, cable and address
    two.here.run(found["mend"]) if os.access("/usr/bin/ping", os.X_OK) else None
    two.here.doctor_says("peer", verdict="ok", options=two.options)


def no_route_to_the_peer(two):
    two.daemon()
    two.here.run(f"ip addr del {US}/24 dev net0 && ip addr add {US}/32 dev net0 && " + LCM_ROUTE)
    two.mended("peer", "no route", f"ip route add {PEER} dev net0", ["daemon"],
               maybe=["silence"])


def udp_dropped_here(two):
    two.daemon()
    two.here.run(LCM_ROUTE + f" && iptables -A INPUT -s {PEER} -p udp -j DROP")
    two.mended("peer", "answers are dropped here", f"iptables -I INPUT -s {PEER} -p udp -j ACCEPT", ["daemon"],
               also=["daemon"])


def udp_dropped_there(two):
    two.daemon()
    two.here.run(LCM_ROUTE)
    two.there.run("iptables -A INPUT -p udp -j DROP")
    two.mended("peer", "not even a closed UDP port answers", f"ssh {PEER} iptables -I INPUT -s {US}", ["daemon"],
               maybe=["silence"])


def udp_not_let_out(two):
    two.daemon()
    two.here.run(LCM_ROUTE + f" && iptables -A OUTPUT -d {PEER} -p udp -j DROP")
    two.mended("peer", "own firewall lets no UDP out", f"iptables -I OUTPUT -d {PEER}", ["daemon"],
               maybe=["silence"])


def unicast_dropped(two):
    """Multicast passes: the participant is seen, and none of its endpoints."""
    two.daemon()
    two.here.run(LCM_ROUTE + f" && iptables -A INPUT -d {US} -p udp -j DROP")
    two.mended("silence", "none of their endpoints is heard", "iptables -I INPUT -i net0 -p udp -j ACCEPT",
               ["daemon", "peer"])


def everything_dropped_there(two):
    two.daemon()
    two.here.run(LCM_ROUTE)
    two.there.run(f"iptables -A INPUT -s {US} -j DROP")
    two.mended("peer", "answers neither TCP nor UDP", f"ssh {PEER} iptables -I INPUT -s {US}", ["daemon"],
               maybe=["silence"])


def multicast_dropped(two):
    """One direction is enough: who hears an announcement answers by unicast."""
    two.daemon()
    two.here.run(LCM_ROUTE + " && iptables -A INPUT -d 224.0.0.0/4 -j DROP")
    two.there.run("iptables -A INPUT -d 224.0.0.0/4 -j DROP")
    two.mended("peer", "by multicast do not get through", f"ssh {PEER} iptables -I INPUT -d 224.0.0.0/4", ["daemon"],
               also=["daemon"])


def another_domain_on_the_network(two):
    two.there.daemon("--links dds://9 --interface net1")
    two.here.run(LCM_ROUTE)
    two.options = "--interface net0"
    two.mended("domain", "is on dds://9, and you asked on dds://0", "export COLLIDED_URI=dds://9")


def lcm_dropped_here(two):
    two.there.run("ip route add 224.0.0.0/4 dev net1")
    two.there.daemon("--links 'lcm://udpm://239.255.76.67:7667?ttl=1' --interface net1")
    two.here.run(LCM_ROUTE + f" && iptables -A INPUT -s {PEER} -p udp -j DROP")
    two.options += " --connect 'lcm://udpm://239.255.76.67:7667?ttl=1'"
    two.mended("peer", "port 7667, unlike a closed one, is silent", f"iptables -I INPUT -s {PEER}", ["daemon"])


def lcm_that_stays_at_home(two):
    two.there.run("ip route add 224.0.0.0/4 dev net1")
    two.there.daemon("--links 'lcm://udpm://239.255.76.67:7667?ttl=1' --interface net1")
    two.here.run(LCM_ROUTE)
    two.options += " --connect lcm://"
    two.mended("peer", "ttl=0 does not leave", "ttl=1")


GROUPS = {
    "host": [help_tells_of_every_check, loopback_without_multicast, no_route_for_multicast, multicast_leads_elsewhere,
             loopback_is_down, interface_is_down, interface_without_carrier, interface_without_address,
             loopback_without_address,
             interface_does_not_exist, participants_without_room, small_receive_buffers, participants_run_out],
    "daemon": [no_daemon, no_daemon_over_lcm, cyclone_does_not_start,
               cyclone_does_not_start_where_a_daemon_is, two_daemons, limits_reached, a_crowd_waits, gateway_is_down,
               gateway_dies_again_and_again, still_starting, another_release, clock_is_ahead, clock_is_ahead_over_lcm],
    "elsewhere": [another_domain, another_transport, another_interface, cyclone_leads_elsewhere,
                  loopback_instead_of_the_network],
    "wire": [wire("dds://0", "version 2 of the wire, not our 1", DOUBLE_VERSION="2"),
             wire("dds://0", "as type collided::Reject, not as our collided::Status", DOUBLE_TYPE="1"),
             wire("lcm://", "version 2 of the wire, not our 1", DOUBLE_VERSION="2"),
             wire("lcm://", "another fingerprint", DOUBLE_FINGERPRINT="1")],
    "clients": [lost_client("hold"), lost_client("keep"), stale_bodies, refusals_grow],
    "peer": [two_hosts_that_hear_each_other, peer_does_not_listen, peer_is_down, no_route_to_the_peer, udp_dropped_here,
             udp_dropped_there, udp_not_let_out, unicast_dropped, everything_dropped_there,
             multicast_dropped, another_domain_on_the_network, lcm_dropped_here, lcm_that_stays_at_home],
}


def run_case(case):
    began, host = time.monotonic(), None
    try:
        host = (Two if GROUP == "peer" else Host)()
        case(host)
        verdict = "passed"
    except (AssertionError, ValueError, subprocess.TimeoutExpired) as why:
        verdict = f"FAILED: {why}"
    finally:
        if host:
            host.end()
    print(f"{case.__name__}: {verdict}, {time.monotonic() - began:.1f} s", flush=True)
    return verdict == "passed"


if __name__ == "__main__":
    GROUP, only = sys.argv[1], sys.argv[4:]
    if GROUP == "peer" and not shutil.which("iptables", path="/usr/sbin:/sbin:/usr/bin:/bin"):
        print("skipped: iptables is not installed")
        sys.exit(SKIPPED)
    enter_namespace()
    cases = [case for case in GROUPS[GROUP] if not only or case.__name__ in only]
    with concurrent.futures.ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        sys.exit(0 if all(list(pool.map(run_case, cases))) else 1)
