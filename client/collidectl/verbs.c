/* verbs: the table of all verbs, in the order in which help shows them. */
#include "verbs.h"

#include <limits.h>
#include <string.h>

const ctl_verb ctl_verbs[] = {
    {"status", "", 0, 0, verb_status, "How the daemon is; exit status 0 only if it is ready", ""},
    {"load", "FILE.urdf|FILE.yaml", 1, 1, verb_load, "Creates the bodies of a robot or a scene",
        "They stay when collidectl ends, unless --stay is given. Loading a name again replaces that body.\n"},
    {"remove", "PATTERN", 1, 1, verb_remove, "Removes bodies that were loaded under the same --as",
        "The pattern may have * and ?.\n"},
    {"move", "NAME X,Y,Z[,W,X,Y,Z]", 2, 2, verb_move, "Moves a body that was loaded under the same --as",
        "Metres and a unit quaternion; without one the orientation is the world's.\n"},
    {"joints", "ROBOT [NAME=VALUE...]", 1, INT_MAX, verb_joints, "Moves the joints of a loaded robot",
        "rad or m. Joints that are not named keep their values. All links move in one message.\n"},
    {"watch", "", 0, 0, verb_watch, "Prints contacts and distances as they happen", ""},
    {"query", "KIND ...", 1, 4, verb_query, "Asks once",
        "  query ray X,Y,Z DX,DY,DZ       the first body along a ray\n"
        "  query distance A B             certified distance of two bodies\n"
        "  query box X,Y,Z[,W,X,Y,Z] SX,SY,SZ\n"
        "                                 which bodies overlap that box (full sides)\n"
        "  query cast X,Y,Z[,W,X,Y,Z] SX,SY,SZ DX,DY,DZ\n"
        "                                 the first body that this box meets on its way\n"
        "  query nearest BODY|X,Y,Z [COUNT]\n"
        "                                 the nearest bodies, within --length\n"
        "  query explain A B              why is this pair checked, or not\n"
        "  query bodies [PATTERN]         bodies and their poses\n"},
    {"record", "NAME", 1, 1, verb_record, "Records, on the daemon, all that it is told",
        "The daemon chooses the folder.\n"},
    {"replay", "FILE", 1, 1, verb_replay, "Runs a recording through a daemon of its own, without network",
        "Runs 'collided --replay', found beside collidectl or in PATH.\n"},
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
