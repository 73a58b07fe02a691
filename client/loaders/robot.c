/* robot: loads both files, and sets and checks joint values. One thread a pool. */
#include "robot.h"

#include "text.h"
#include "xml.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool robot_load(robot *out, pool *p, const robot_source *source, load_report *r)
{
    *out = (robot){.pool = p, .source = *source};
    size_t size;
    const char *data = text_read_file(p, source->urdf, XML_SIZE_MAX, &size, r);
    if (!data || !urdf_parse(&out->model, p, data, size, source->urdf, r)) return false;
    return !source->srdf || robot_load_srdf(out, source->srdf, r);
}

bool robot_load_srdf(robot *b, const char *path, load_report *r)
{
    size_t size;
    const char *data = text_read_file(b->pool, path, XML_SIZE_MAX, &size, r);
    if (!data || !srdf_parse(&b->semantics, b->pool, &b->model, data, size, path, r)) return false;
    b->source.srdf = pool_copy(b->pool, path);
    return true;
}

void robot_default_values(const robot *b, double *values)
{
    for (int i = 0; i < b->model.joint_count; i++) {
        const urdf_joint *j = &b->model.joints[i];
        values[i] = j->limited ? fmin(fmax(0, j->lower), j->upper) : 0;
    }
}

static void warn_beyond_limits(const urdf_joint *j, double value, load_report *r)
{
    if (!j->limited || (value >= j->lower && value <= j->upper)) return;
    load_warn(r, "joint '%s': %g is beyond its limits %g to %g", j->name, value, j->lower, j->upper);
}

static void list_states(const robot *b, char *text, size_t size)
{
    size_t length = 0;
    text[0] = '\0';
    for (int i = 0; i < b->semantics.state_count && length < size; i++) {
        int n = snprintf(text + length, size - length, "%s%s", i ? ", " : "", b->semantics.states[i].name);
        length += n > 0 ? (size_t)n : 0;
    }
}

/* A state may also name joints that mimic others; what it says of them must then agree. */
static void check_mimic(const robot *b, const srdf_state *s, const srdf_value *v, const double *values, load_report *r)
{
    const urdf_joint *j = &b->model.joints[v->joint];
    double follows = j->mimic_factor * values[j->mimic] + j->mimic_offset;
    if (fabs(follows - v->value) <= 1e-9 * fmax(1, fabs(follows))) return;
    load_warn(r, "state '%s': joint '%s' mimics '%s' and gets %g, not %g", s->name, j->name,
        b->model.joints[j->mimic].name, follows, v->value);
}

static void take_state(const robot *b, const srdf_state *s, double *values, load_report *r)
{
    for (int i = 0; i < s->value_count; i++) {
        const urdf_joint *j = &b->model.joints[s->values[i].joint];
        if (j->mimic < 0) warn_beyond_limits(j, s->values[i].value, r);
        values[s->values[i].joint] = s->values[i].value;
    }
    for (int i = 0; i < s->value_count; i++)
        if (b->model.joints[s->values[i].joint].mimic >= 0) check_mimic(b, s, &s->values[i], values, r);
}

bool robot_state(const robot *b, const char *state, double *values, load_report *r)
{
    for (int i = 0; i < b->semantics.state_count; i++) {
        if (strcmp(b->semantics.states[i].name, state) != 0) continue;
        take_state(b, &b->semantics.states[i], values, r);
        return true;
    }
    if (!b->source.srdf) return load_fail(r, "state '%s': states come from an SRDF: add --srdf FILE", state);
    char known[512];
    list_states(b, known, sizeof known);
    return load_fail(r, "%s: has no state '%s'; it has: %s", b->source.srdf, state, *known ? known : "none");
}

bool robot_set(const robot *b, const char *joint, double value, double *values, load_report *r)
{
    int i = urdf_find_joint(&b->model, joint);
    if (i < 0) return load_fail(r, "%s: has no joint '%s'", b->model.file, joint);
    const urdf_joint *j = &b->model.joints[i];
    if (j->type == URDF_FIXED) return load_fail(r, "joint '%s' is fixed: leave it out", joint);
    if (j->mimic >= 0)
        return load_fail(r, "joint '%s' mimics '%s': set that one", joint, b->model.joints[j->mimic].name);
    warn_beyond_limits(j, value, r);
    values[i] = value;
    return true;
}

bool robot_set_list(const robot *b, const char *list, double *values, load_report *r)
{
    pool words = {0};
    bool ok = true;
    while (ok && *list) {
        size_t length = strcspn(list, ",");
        char *word = pool_format(&words, "%.*s", (int)length, list);
        char *equals = strchr(word, '=');
        double value;
        if (equals) *equals = '\0';
        if (!equals || !text_number(equals + 1, &value))
            ok = load_fail(r, "'%.*s' is not NAME=NUMBER (rad or m)", (int)length, list);
        else
            ok = robot_set(b, word, value, values, r);
        list += length;
        list += *list == ',';
    }
    pool_free(&words);
    return ok;
}
