/* srdf: from XML to states, disabled pairs and groups, each name looked up in the URDF. One thread a pool. */
#include "srdf.h"

#include "xml.h"

#include <string.h>

enum { SRDF_ENTRIES_MAX = 65536 /* elements of one kind */ };

typedef bool read_entry(const xml_file *f, const xmlNode *n, const urdf *u, srdf *out);

static bool read_value(const xml_file *f, const xmlNode *n, const urdf *u, srdf_value *out)
{
    const char *name = xml_need(f, n, "name");
    if (!name) return false;
    out->joint = urdf_find_joint(u, name);
    if (out->joint < 0) return xml_fail(f, n, "the joint '%s' is not in %s", name, u->file);
    return xml_need(f, n, "value") && xml_numbers(f, n, "value", &out->value, 1);
}

static bool read_state(const xml_file *f, const xmlNode *n, const urdf *u, srdf *out)
{
    srdf_state *s = &out->states[out->state_count++];
    s->name = xml_need(f, n, "name");
    s->group = xml_string(f, n, "group");
    if (!s->name) return false;
    s->values = pool_alloc(f->pool, xml_count(n, "joint"), sizeof *s->values);
    for (const xmlNode *j = xml_first(n, "joint"); j; j = xml_next(j, "joint"))
        if (!read_value(f, j, u, &s->values[s->value_count++])) return false;
    return true;
}

static bool read_disabled(const xml_file *f, const xmlNode *n, const urdf *u, srdf *out)
{
    const char *one = xml_need(f, n, "link1"), *two = xml_need(f, n, "link2");
    const char *reason = xml_string(f, n, "reason");
    if (!one || !two) return false;
    srdf_disabled d = {urdf_find_link(u, one), urdf_find_link(u, two), reason ? reason : "no reason given"};
    if (d.link1 < 0 || d.link2 < 0)
        load_warn(f->report, "%s:%d: the link '%s' is not in %s: this pair is passed over", f->name, xml_line(n),
            d.link1 < 0 ? one : two, u->file);
    else
        out->disabled[out->disabled_count++] = d;
    return true;
}

static const struct {
    const char *element, *attribute;
    srdf_member_kind kind;
} members[] = {
    {"link", "name", SRDF_LINK},
    {"joint", "name", SRDF_JOINT},
    {"passive_joint", "name", SRDF_PASSIVE_JOINT},
    {"chain", "base_link", SRDF_CHAIN},
    {"group", "name", SRDF_GROUP},
};
enum { MEMBER_KINDS = sizeof members / sizeof *members };

static bool read_group(const xml_file *f, const xmlNode *n, const urdf *u, srdf *out)
{
    (void)u;
    srdf_group *g = &out->groups[out->group_count++];
    g->name = xml_need(f, n, "name");
    if (!g->name) return false;
    size_t count = 0;
    for (int k = 0; k < MEMBER_KINDS; k++) count += xml_count(n, members[k].element);
    g->members = pool_alloc(f->pool, count, sizeof *g->members);
    for (int k = 0; k < MEMBER_KINDS; k++) {
        for (const xmlNode *m = xml_first(n, members[k].element); m; m = xml_next(m, members[k].element)) {
            srdf_member *out_member = &g->members[g->member_count++];
            out_member->kind = members[k].kind;
            out_member->name = xml_need(f, m, members[k].attribute);
            out_member->tip = out_member->kind == SRDF_CHAIN ? xml_need(f, m, "tip_link") : NULL;
            if (f->report->error[0]) return false;
        }
    }
    return true;
}

static bool read_each(const xml_file *f, const char *element, read_entry *read, const urdf *u, srdf *out)
{
    for (const xmlNode *n = xml_first(xml_root(f), element); n; n = xml_next(n, element))
        if (!read(f, n, u, out)) return false;
    return true;
}

static bool room_for_elements(const xml_file *f, const char *element, size_t size, void *out)
{
    size_t count = xml_count(xml_root(f), element);
    if (count > SRDF_ENTRIES_MAX)
        return load_fail(f->report, "%s: has %zu <%s>, more than %d", f->name, count, element, SRDF_ENTRIES_MAX);
    void *room = pool_alloc(f->pool, count, size);
    memcpy(out, &room, sizeof room);
    return true;
}

static bool read_srdf(const xml_file *f, const urdf *u, srdf *out)
{
    if (!room_for_elements(f, "group_state", sizeof *out->states, &out->states) ||
        !room_for_elements(f, "disable_collisions", sizeof *out->disabled, &out->disabled) ||
        !room_for_elements(f, "group", sizeof *out->groups, &out->groups))
        return false;
    const xmlNode *virtual_joint = xml_first(xml_root(f), "virtual_joint");
    if (virtual_joint) {
        out->virtual_joint = xml_need(f, virtual_joint, "name");
        out->virtual_parent = xml_need(f, virtual_joint, "parent_frame");
        if (!out->virtual_joint || !out->virtual_parent) return false;
    }
    return read_each(f, "group", read_group, u, out) && read_each(f, "group_state", read_state, u, out) &&
           read_each(f, "disable_collisions", read_disabled, u, out);
}

bool srdf_parse(srdf *out, pool *p, const urdf *u, const char *data, size_t size, const char *file, load_report *r)
{
    *out = (srdf){0};
    xml_file f = {.name = file, .pool = p, .report = r};
    if (!xml_open(&f, data, size, "robot")) return false;
    const char *name = xml_string(&f, xml_root(&f), "name");
    if (name && strcmp(name, u->name) != 0)
        load_warn(r, "%s: is for the robot '%s', but %s is '%s'", file, name, u->file, u->name);
    bool ok = read_srdf(&f, u, out);
    xml_close(&f);
    return ok;
}
