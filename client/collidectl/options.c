/* options: one row of the table an option. A verb takes the options whose row names it; "" = every verb does. */
#include "options.h"

#include "loaders/text.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

#define AT(member) offsetof(ctl_options, member)

static const option table[] = {
    {"--connect", "URI", TEXT, AT(connect), 0, 0, "", "dds://DOMAIN or lcm://...; default: $COLLIDED_URI, or dds://0"},
    {"--as", "NAME", TEXT, AT(as), 0, 0, "", "whose bodies these are, over several runs; default collidectl"},
    {"--timeout", "S", NUMBER, AT(timeout_s), 0.01, 3600, "", "how long to wait for the daemon; default 5"},
    {"--interface", "NAME", TEXT, AT(interface), 0, 0, "",
        "network interface of the daemon, by name or address; default: this machine only"},
    {"--help", NULL, FLAG, AT(help), 0, 0, "", "this text, or that of the verb"},
    {"--json", NULL, FLAG, AT(json), 0, 0, "status top fit joints check watch query replay trade doctor",
        "JSON, one object a line; numbers that are not finite are null"},
    {"--brief", NULL, FLAG, AT(brief), 0, 0, "status",
        "a line for the daemon and one for each stream: contacts, nearest, soonest impact, oldest pose"},
    {"--wait", "S", NUMBER, AT(wait_s), 0, 86400, "status", "wait so long until it is ready; default 0"},
    {"--once", NULL, FLAG, AT(once), 0, 0, "top", "print one view, after two Status, and end"},
    {"--srdf", "FILE", TEXT, AT(srdf), 0, 0, "load fit", "states and disabled pairs of the URDF's robot"},
    {"--package", "NAME=PATH", PACKAGE, 0, 0, 0, "load fit",
        "where package://NAME/ is, unless it is found around the file, in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH; "
        "several times"},
    {"--prefix", "TEXT", TEXT, AT(prefix), 0, 0, "load", "put before the names of links and robot"},
    {"--meshes", "WHAT", TEXT, AT(meshes), 0, 0, "load",
        "what mesh files become: hull (default), solid, decompose or decompose:N (at most N hulls, default 16)"},
    {"--excess", "M", NUMBER, AT(excess_m), 1e-9, 1e6, "fit",
        "no point of a shape is farther than this from the link; default 0.005"},
    {"--output", "FILE", TEXT, AT(output), 0, 0, "fit film",
        "what it writes: of fit the scene, for 'load': FILE.yaml; of film FILE.html, which must not be there yet"},
    {"--mcap", "FILE", TEXT, AT(mcap), 0, 0, "export", "the MCAP file that it writes; it must not be there yet"},
    {"--pose", "X,Y,Z[,W,X,Y,Z]", POSE, 0, 0, 0, "load", "of the robot's root link: m, and a unit quaternion"},
    {"--state", "NAME", TEXT, AT(state), 0, 0, "load joints", "joint values from the SRDF"},
    {"--margin", "M", NUMBER, AT(margin_m), 0, 1e6, "check", "what is nearer than this counts as met; default 0"},
    {"--joints", "NAME=V,...", TEXT, AT(joints), 0, 0, "load", "joint values, rad or m, after --state"},
    {"--fixed", NULL, FLAG, AT(fixed), 0, 0, "load", "fixed: not checked against other fixed bodies"},
    {"--deadline", "S", NUMBER, AT(deadline_s), 0, 86400, "load",
        "poses older than this count as unknown, for a robot that is moved all the time; default 0 = never"},
    {"--stay", NULL, FLAG, AT(stay), 0, 0, "load", "stay until SIGINT; the bodies are this process's, and go with it"},
    {"--a", "PATTERN", TEXT, AT(select_a), 0, 0, "watch", "one body of each pair: name with * and ?, or group:NAME"},
    {"--b", "PATTERN", TEXT, AT(select_b), 0, 0, "watch", "the other one"},
    {"--facts", "LIST", FACTS, AT(facts), 0, 0, "watch",
        "of touch,distance,manifold,impact,predict,features,safe_step; default touch"},
    {"--horizon", "S", NUMBER, AT(horizon_s), 0.001, 86400, "watch export film",
        "what is predicted, so far ahead of the newest pose of a pair; default 1"},
    {"--range", "M", NUMBER, AT(range_m), 0, 1e6, "watch export film", "distances below this are told; default 0.1"},
    {"--accuracy", "WHAT", TEXT, AT(accuracy), 0, 0, "watch",
        "how far a pair is looked into: boxes (cheap bounds), tolerance (default), verdict (touch or not, proven)"},
    {"--tolerance", "M", NUMBER, AT(tolerance_m), 0, 1, "watch query",
        "width of the intervals; 0 = as narrow as arithmetic gives; default 1e-6, of watch as --relative says"},
    {"--relative", "SHARE", NUMBER, AT(relative_tolerance), 1e-15, 1, "watch",
        "the same as a share of the size of the two shapes; default 1e-6"},
    {"--hysteresis", "M", NUMBER, AT(hysteresis_m), 0, 1000, "watch",
        "a contact ends, and near turns far, only so much farther away; default 0"},
    {"--rate", "HZ", NUMBER, AT(rate_hz), 0, 100000, "watch export film",
        "updates at most so often; default 0 = each tick, of export and film 30"},
    {"--seconds", "N", NUMBER, AT(seconds), 0.001, 1e9, "top watch record trade",
        "end after so long; default: at SIGINT; of trade without a file, 10"},
    {"--length", "M", NUMBER, AT(length_m), 0, 1e9, "query",
        "of the ray or the cast, or how far to look for the nearest; default 1000"},
    {"--linear", "X,Y,Z", LINEAR, 0, 0, 0, "query move", "velocity, m/s: of a sweep, or to be published with the pose"},
    {"--angular", "X,Y,Z", ANGULAR, 0, 0, 0, "query move", "angular velocity, rad/s, world axes, likewise"},
    {"--span", "S", NUMBER, AT(span_s), 1e-6, 86400, "query", "how long a sweep takes; default 1"},
    {"--teleport", NULL, FLAG, AT(teleport), 0, 0, "move",
        "it did not move there, but is there: nothing on the way is met, and its contacts end"},
    {"--peer", "ADDRESS", TEXT, AT(peer), 0, 0, "doctor", "another host that should be heard: is it, and if not, why"},
    {"--list", NULL, FLAG, AT(list), 0, 0, "doctor", "list the checks and run none"},
    {"--system-root", "DIR", TEXT, AT(system_root), 0, 0, "doctor", "read DIR/proc instead of /proc, for tests"},
    {"--out", "PREFIX", TEXT, AT(out), 0, 0, "trade",
        "files of the picture: PREFIX.svg, PREFIX.png, PREFIX.tsv and PREFIX.gnuplot; default trade"},
    {"--speed", "X", NUMBER, AT(speed), 0, 1000000, "replay",
        "at so many times the recorded speed; default 0 = as fast as possible"},
    {"--workers", "N", COUNT, AT(workers), 1, 64, "replay trade export film",
        "threads of the narrow phase; of trade, export and film, default 1"},
};
enum { OPTIONS = sizeof table / sizeof *table };

const char *const options_facts[] = {
    "touch", "distance", "manifold", "impact", "predict", "features", "safe_step", NULL};

static const option_exit exits[] = {
    {EX_OK, "done"},
    {EX_USAGE, "wrong usage"},
    {EX_DATAERR, "refused data: a damaged file, or what the daemon did not take"},
    {EX_NOINPUT, "no such file"},
    {EX_UNAVAILABLE, "no daemon is heard, or doctor found a problem"},
    {EX_SOFTWARE, "a replay differs from its recording, or a trade found a bound that excludes the truth; both end as "
                  "collided does, "
                  "with its other statuses, too"},
    {EX_OSERR, "no process can be started for a trade"},
    {EX_OSFILE, "a library is missing"},
    {EX_CANTCREAT, "a file cannot be created"},
    {EX_IOERR, "output cannot be written"},
    {EX_TEMPFAIL, "not ready, or no answer in time"},
    {EX_CONFIG, "neither XDG_STATE_HOME nor HOME says where the names of bodies are kept"},
};

const option_exit *options_exits(int *count)
{
    *count = sizeof exits / sizeof *exits;
    return exits;
}

const option *options_table(int *count)
{
    *count = OPTIONS;
    return table;
}

bool options_takes(const option *o, const ctl_verb *verb)
{
    if (!*o->verbs) return true;
    size_t length = verb ? strlen(verb->name) : 0;
    for (const char *word = o->verbs; verb && *word; word += strcspn(word, " "), word += *word == ' ')
        if (strcspn(word, " ") == length && strncmp(word, verb->name, length) == 0) return true;
    return false;
}

/* ---- values ---- */

bool options_vector(const char *text, double out[3])
{
    return text_numbers(text, ",", out, 3) == 3;
}

bool options_pose(const char *text, collided_pose *out)
{
    double n[7];
    int count = text_numbers(text, ",", n, 7);
    if (count != 3 && count != 7) return false;
    *out = (collided_pose){{n[0], n[1], n[2]}, {1, 0, 0, 0}};
    if (count == 3) return true;
    double norm = sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
    for (int i = 0; i < 4; i++) out->orientation[i] = n[3 + i] / norm;
    return fabs(norm - 1) < 1e-3;
}

static int take_number_option(ctl_options *to, const option *o, const char *text)
{
    double value;
    bool ok = text_number(text, &value) && value >= o->least && value <= o->most;
    if (ok && o->kind == COUNT) ok = value == floor(value);
    if (!ok)
        return ctl_fail(EX_USAGE, "%s '%s': must be a %s from %g to %g", o->name, text,
            o->kind == COUNT ? "whole number" : "number", o->least, o->most);
    memcpy((char *)to + o->offset, &value, sizeof value);
    return 0;
}

#define FACT_WORDS "touch,distance,manifold,impact,predict,features,safe_step"

static int take_facts(ctl_options *to, const char *text)
{
    static const unsigned bits[] = {COLLIDED_TOUCH, COLLIDED_DISTANCE, COLLIDED_MANIFOLD, COLLIDED_IMPACT,
        COLLIDED_PREDICT, COLLIDED_FEATURES, COLLIDED_SAFE_STEP};
    to->facts = 0;
    for (const char *word = text; *word; word += strcspn(word, ","), word += *word == ',') {
        size_t length = strcspn(word, ",");
        unsigned bit = 0;
        for (int i = 0; options_facts[i]; i++)
            if (strlen(options_facts[i]) == length && strncmp(word, options_facts[i], length) == 0) bit = bits[i];
        if (!bit) return ctl_fail(EX_USAGE, "--facts '%s': must be some of " FACT_WORDS, text);
        to->facts |= bit;
    }
    return to->facts ? 0 : ctl_fail(EX_USAGE, "--facts '': must be some of " FACT_WORDS);
}

static int take_velocity(const option *o, const char *text, double out[3], bool *has)
{
    *has = options_vector(text, out);
    return *has ? 0 : ctl_fail(EX_USAGE, "%s '%s': must be X,Y,Z", o->name, text);
}

static int take_package(ctl *c, const char *text)
{
    const char *equals = strchr(text, '=');
    if (!equals || equals == text || !equals[1]) return ctl_fail(EX_USAGE, "--package '%s': must be NAME=PATH", text);
    if (c->options.package_count == PACKAGES_MAX)
        return ctl_fail(EX_USAGE, "--package: at most %d can be given", PACKAGES_MAX);
    c->options.packages[c->options.package_count++] =
        (load_package){pool_format(&c->pool, "%.*s", (int)(equals - text), text), equals + 1};
    return 0;
}

static int take_value(ctl *c, const option *o, const char *text)
{
    ctl_options *to = &c->options;
    switch (o->kind) {
    case FLAG:
        memcpy((char *)to + o->offset, &(bool){true}, sizeof(bool));
        return 0;
    case TEXT:
        memcpy((char *)to + o->offset, &text, sizeof text);
        return 0;
    case NUMBER:
    case COUNT:
        return take_number_option(to, o, text);
    case LINEAR:
        return take_velocity(o, text, to->linear, &to->has_linear);
    case ANGULAR:
        return take_velocity(o, text, to->angular, &to->has_angular);
    case FACTS:
        return take_facts(to, text);
    case PACKAGE:
        return take_package(c, text);
    case POSE:
        break;
    }
    to->posed = options_pose(text, &to->pose);
    return to->posed ? 0
                     : ctl_fail(EX_USAGE, "--pose '%s': must be X,Y,Z or X,Y,Z,W,X,Y,Z with a unit quaternion", text);
}

/* ---- the command line ---- */

static const option *find_option(const char *text, size_t length)
{
    for (int i = 0; i < OPTIONS; i++)
        if (strlen(table[i].name) == length && strncmp(text, table[i].name, length) == 0) return &table[i];
    return NULL;
}

/* argv[*at] is an option: takes it, and its value, which may be the next word. */
static int take_option(ctl *c, int argc, char **argv, int *at, const ctl_verb *verb)
{
    const char *word = strcmp(argv[*at], "-h") == 0 ? "--help" : argv[*at];
    size_t length = strcspn(word, "=");
    const option *o = find_option(word, length);
    const char *value = word[length] ? word + length + 1 : NULL;
    const char *of = verb ? verb->name : "";
    if (!o) return ctl_fail(EX_USAGE, "unknown option '%s': see 'collidectl help %s'", word, of);
    if (!options_takes(o, verb))
        return ctl_fail(EX_USAGE, "%s is not an option of '%s', but of: %s", o->name, of, o->verbs);
    if (o->kind == FLAG && value) return ctl_fail(EX_USAGE, "%s takes no value", o->name);
    if (o->kind != FLAG && !value) {
        if (*at + 1 >= argc) return ctl_fail(EX_USAGE, "%s needs a value: %s %s", o->name, o->name, o->value);
        value = argv[++*at];
    }
    return take_value(c, o, value);
}

static int check_name(const char *as)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    if (*as && *as != '.' && strlen(as) <= 64 && as[strspn(as, letters)] == '\0') return 0;
    return ctl_fail(EX_USAGE, "--as '%s': must be 1 to 64 letters, digits, '.', '_' or '-'", as);
}

static int check_count(const ctl *c, const ctl_verb *verb)
{
    if (c->options.help || (c->argument_count >= verb->least && c->argument_count <= verb->most)) return 0;
    return ctl_fail(EX_USAGE, "%s: too %s arguments: collidectl %s %s", verb->name,
        c->argument_count < verb->least ? "few" : "many", verb->name, verb->arguments);
}

static void set_defaults(ctl_options *o)
{
    const char *uri = getenv("COLLIDED_URI");
    *o = (ctl_options){.connect = uri && *uri ? uri : "dds://0",
        .as = "collidectl",
        .timeout_s = 5,
        .select_a = "*",
        .select_b = "*",
        .facts = COLLIDED_TOUCH,
        .range_m = 0.1,
        .accuracy = "tolerance",
        .tolerance_m = -1,        /* not given */
        .relative_tolerance = -1, /* likewise */
        .length_m = 1000,
        .horizon_s = 1,
        .span_s = 1,
        .out = "trade",
        .excess_m = 0.005,
        .pose = {{0, 0, 0}, {1, 0, 0, 0}}};
}

int options_parse(ctl *c, int argc, char **argv, const ctl_verb **verb)
{
    bool more = true; /* options; "--" ends them */
    *verb = NULL;
    set_defaults(&c->options);
    c->arguments = pool_alloc(&c->pool, (size_t)argc + 1, sizeof *c->arguments);
    for (int i = 1; i < argc; i++) {
        int status = 0;
        if (more && strcmp(argv[i], "--") == 0)
            more = false;
        else if (more && (strncmp(argv[i], "--", 2) == 0 || strcmp(argv[i], "-h") == 0))
            status = take_option(c, argc, argv, &i, *verb);
        else if (*verb)
            c->arguments[c->argument_count++] = argv[i];
        else if (!(*verb = ctl_find_verb(argv[i])))
            status = ctl_fail(EX_USAGE, "unknown verb '%s': see 'collidectl help'", argv[i]);
        if (status) return status;
    }
    int status = check_name(c->options.as);
    return status || !*verb ? status : check_count(c, *verb);
}

/* ---- help ---- */

static void print_options(FILE *out, const ctl_verb *verb, bool common)
{
    for (int i = 0; i < OPTIONS; i++) {
        const option *o = &table[i];
        if (common != !*o->verbs || !options_takes(o, verb)) continue;
        char left[64];
        snprintf(left, sizeof left, "%s %s", o->name, o->value ? o->value : "");
        fprintf(out, "  %-24s %s\n", left, o->help);
    }
}

void options_help(FILE *out, const ctl_verb *verb)
{
    if (verb) {
        fprintf(
            out, "collidectl %s %s\n%s.\n%s\nOptions:\n", verb->name, verb->arguments, verb->summary, verb->details);
        print_options(out, verb, false);
        print_options(out, verb, true);
        return;
    }
    fputs("collidectl [options] VERB ...: talks to the collision daemon collided(8).\n\nVerbs:\n", out);
    for (const ctl_verb *v = ctl_verbs; v->name; v++) fprintf(out, "  %-9s %s\n", v->name, v->summary);
    fputs("\nOptions of every verb:\n", out);
    print_options(out, NULL, true);
    fputs("\nExit status, by sysexits.h:\n", out);
    for (size_t i = 0; i < sizeof exits / sizeof *exits; i++)
        fprintf(out, "  %4d  %s\n", exits[i].status, exits[i].meaning);
    fputs("\n'collidectl help VERB' tells more, and so does 'man collidectl'.\n", out);
}
