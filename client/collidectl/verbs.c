/* verbs: the table of all verbs, in the order in which help shows them. */
#include "verbs.h"

#include <limits.h>
#include <string.h>

const ctl_verb ctl_verbs[] = {
    {"status", "", 0, 0, verb_status, "How the daemon is; exit status 0 only if it is ready", ""},
    {"top", "", 0, 0, verb_top, "Shows the daemon at work, once a second",
        "Health; ticks a second and the load of the thread that ticks; latency, from the stamp of the newest pose to\n"
        "the events, and duration of ticks, as percentiles of the last second, at most an eighth too high; what is in\n"
        "the world; the budget and what it left; pairs by the stage that settled them; what was refused, dropped or\n"
        "lost, since the start and per second; clients and streams, the costliest first. Work is in units a tick\n"
        "(about ns). SILENT: since the last sign of life. Ends by q or SIGINT. Where standard output is no terminal:\n"
        "plain lines, a block a second; with --json an object a second. A daemon that ends is waited for.\n"},
    {"load", "FILE.urdf|FILE.yaml", 1, 1, verb_load, "Creates the bodies of a robot or a scene",
        "They stay when collidectl ends, unless --stay is given. Loading a name again replaces that body.\n"
        "With --meshes decompose a concave mesh becomes several hulls, which contain it; how far they reach beyond it\n"
        "is told for each mesh, on standard error, and the upper bounds of distances include it.\n"},
    {"fit", "FILE.urdf", 1, 1, verb_fit, "Finds simpler shapes for a robot's links, and links that never meet",
        "Each link gets the cheapest of sphere, capsule, box (rounded or not), rounded hull and hull that contains it\n"
        "and of which no point is farther than --excess from it: both are proven, for the meshes as they are. A "
        "concave\n"
        "mesh becomes several of these; where none fit, the mesh stays, and that is said. Pairs of links that cannot\n"
        "meet while the joints keep their limits are proven, too, and become rules; what the SRDF disables and is not\n"
        "proven is listed. Costs are of a table (ns a query). With --output, 'load' takes the scene that it writes.\n"},
    {"remove", "PATTERN", 1, 1, verb_remove, "Removes bodies that were loaded under the same --as",
        "The pattern may have * and ?.\n"},
    {"move", "NAME X,Y,Z[,W,X,Y,Z]", 2, 2, verb_move, "Moves a body that was loaded under the same --as",
        "Metres and a unit quaternion; without one the orientation is the world's.\n"
        "Velocities tell what it does from here on, for what is predicted.\n"},
    {"joints", "[ROBOT [NAME=VALUE...]]", 0, INT_MAX, verb_joints, "Tells, or moves, the joints of a loaded robot",
        "rad or m. Joints that are not named keep their values. All links move in one message. Without values and\n"
        "--state: the joints with their values and limits, and the states of the SRDF, as the last run that moved\n"
        "them left them. Without a robot: the robots that were loaded under the same --as.\n"},
    {"check", "ROBOT CONFIGURATION...", 2, INT_MAX, verb_check,
        "Tries out configurations of a loaded robot, and motions",
        "A configuration is a state of the SRDF, NAME=VALUE,..., or now; joints that it does not name keep their\n"
        "values from the one before. One configuration: is it free, and how far is the nearest? Several: is the\n"
        "straight way in joint space free, from each to the next? Free and meets are proven, for the whole way.\n"
        "Nothing moves. Exit status 0 only if all is free.\n"},
    {"watch", "", 0, 0, verb_watch, "Prints contacts, distances, impacts and what is predicted",
        "Contacts begin, go on (update) and end; what is within --range is near, and then far; what is past\n"
        "its deadline is unknown, and then known. impact: they met on their way from one pose to the next,\n"
        "of bodies with ccd. predicted: they will meet within --horizon, and averted: no more. The times of\n"
        "both are in seconds from the pose that the motion began with, or from the newest pose: apart before\n"
        "the first, touching at the second, both proven; inf is a contact that is not proven. alive (JSON:\n"
        "heartbeat): nothing has changed for a second. missing: clients in lock-step that a step was done\n"
        "without. starves: nothing whole has come for 3 s, though the daemon is heard.\n"},
    {"query", "KIND ...", 1, 4, verb_query, "Asks once",
        "  query ray X,Y,Z DX,DY,DZ       the first body along a ray\n"
        "  query distance A B             certified distance of two bodies\n"
        "  query box X,Y,Z[,W,X,Y,Z] SX,SY,SZ\n"
        "                                 which bodies overlap that box (full sides)\n"
        "  query cast X,Y,Z[,W,X,Y,Z] SX,SY,SZ DX,DY,DZ\n"
        "                                 the first body that this box meets on its way\n"
        "  query sweep BODY               the first body that this one would meet, and when (s), if it moved\n"
        "                                 and turned by --linear and --angular, for --span\n"
        "  query nearest BODY|X,Y,Z [COUNT]\n"
        "                                 the nearest bodies, within --length\n"
        "  query explain A B              why is this pair checked, or not\n"
        "  query bodies [PATTERN]         bodies and their poses\n"},
    {"record", "NAME", 1, 1, verb_record, "Records, on the daemon, all that it is told",
        "The daemon chooses the folder. It may begin at any time: the whole state of the daemon is in it, so that a\n"
        "replay by the same release is equal, tick by tick.\n"},
    {"replay", "FILE", 1, 1, verb_replay, "Runs a recording through a daemon of its own, without network",
        "Runs 'collided --replay', found beside collidectl or in PATH. Each tick is held against what was recorded; of "
        "the\n"
        "first that differs it tells the event and the fields, with both values.\n"},
    {"export", "FILE", 1, 1, verb_export, "Writes a recording as a file for Foxglove and its like (MCAP)",
        "The recording is replayed with one more client, who observes all bodies, and subscribes to all pairs:\n"
        "touches, distances below --range, impacts, and what is predicted within --horizon. The file has, as JSON by\n"
        "Foxglove's schemas or our own:\n"
        "  /collided/scene       bodies with their shapes; all of them, when something changes, at most each second\n"
        "  /collided/transforms  poses, world to body:NAME, --rate times a second at most\n"
        "  /collided/contacts    what touches, is near or is predicted: axes and witness points\n"
        "  /collided/distances   counts; the nearest pair with its interval, the soonest prediction: to plot\n"
        "  /collided/events      begins, ends, impacts, gaps, ...; /collided/log has the same in words\n"
        "  /collided/raw/...     the recorded messages, in LCM's encoding\n"
        "Contacts have other numbers than in the recording, since this client asks for more. Of a recording that is\n"
        "damaged what comes before the damage is written, and the exit status is 65.\n"},
    {"film", "FILE", 1, 1, verb_film, "Writes a recording as one HTML file that shows it from disk",
        "The page of collided-web with the session in it: picture, pairs, timeline and proofs, with a slider; nothing "
        "is\n"
        "fetched from anywhere. The recording is replayed as by 'export'. Needs the built page (package "
        "collided-web).\n"},
    {"trade", "[FILE]", 0, 1, verb_trade, "Tells what accuracy costs in a recorded session, and which to use",
        "The recording is replayed at each accuracy side by side, by 'collided --replay FILE --trade'. Without FILE\n"
        "the daemon records itself first, for --seconds, in its record_dir. Prints, per pair of shape types and\n"
        "accuracy (bounds by boxes, which stand for a while and have no manifold; or the width of an interval,\n"
        "as a share of the pair's size; or exact, as narrow as arithmetic gives):\n"
        "\n"
        "  time    of one answer from nothing, by one thread, the least of three: mean and 99th percentile\n"
        "  error   how far the farther end of an interval can be from the truth, at worst and in the mean, of\n"
        "          the answers within what somebody asked; the truth is the narrowest interval,\n"
        "          which of overlapping meshes may be wide\n"
        "  missed  what the exact run reported (contact, nearness, impact, contact to come) and this one did not,\n"
        "          within two ticks of it; bounds never exclude the truth, so that it is 0\n"
        "  false   what this run reported without the exact one reporting it within two ticks\n"
        "  kB/s    of the batches of events, in LCM's encoding, if somebody reads every stream; 'bodies'\n"
        "          is what was reported of whole ones\n"
        "  tick    deciding and reporting, the least of three replays: mean without the slowest 1 %, and 99th\n"
        "          percentile; ticks in which a geometry, a body or a subscription is announced are left out\n"
        "\n"
        "Recommended is, of the accuracies that tell the same events as exact, the finest that costs at most a\n"
        "tenth more per tick than the cheapest; subscriptions ask for it by relative_tolerance, watch by --relative,\n"
        "and bounds by boxes by their accuracy. A budget of the recorded daemon is not kept. The picture shows\n"
        "time against error; what no other accuracy beats in both is joined by a line (the Pareto front). It\n"
        "needs gnuplot (package gnuplot-nox).\n"},
    {"doctor", "", 0, 0, verb_doctor, "Finds out what is wrong, and names the command that mends it",
        "One line a check: ok, problem or cannot tell, and what was seen; under a problem, the command\n"
        "that mends it, to be run as root where it is the system's. 'ssh HOST COMMAND' is for that host;\n"
        "what follows a '#' is for you. With --json: objects with check, verdict, seen and mend. It\n"
        "changes nothing itself. Exit status: 0 no problem, 69 at least one.\n"
        "\n"
        "Of this host: interface (up, with an address), multicast (of loopback, for LCM), route\n"
        "(224.0.0.0/4, for LCM), buffers (net.core.rmem_max), participants (of the 120 that a DDS domain\n"
        "has room for on loopback). Of who can be heard: wire (daemons of another version), silence (DDS\n"
        "participants without endpoints: a firewall), peer (is the host of --peer down, does nobody\n"
        "listen there, or is it dropped), interfaces and domain (a daemon, but elsewhere). Of the daemon:\n"
        "daemon (is there one), single (or two of equal strength), release, health (limits), gateway (of\n"
        "LCM), clock (its offset from ours, by query round trips as in NTP; a problem beyond 10 ms), lost\n"
        "(clients whose bodies stayed), stale (bodies past their deadline), losses (what is being refused\n"
        "or dropped).\n"},
    {"forget", "CLIENT", 1, 1, verb_forget, "Removes the bodies that a lost client left",
        "CLIENT: its number, 16 hex digits, as doctor and status (lost_client_...) tell it. A client that\n"
        "lives is not touched.\n"},
    {"version", "", 0, 0, verb_version, "The version of collidectl", ""},
    {"help", "[VERB]", 0, 1, verb_help, "This text, or that of a verb", ""},
    {0},
};

const ctl_verb *ctl_find_verb(const char *name)
{
    for (const ctl_verb *v = ctl_verbs; v->name; v++)
        if (strcmp(v->name, name) == 0) return v;
    return NULL;
}
