/* The three ways in which the wire is written down, collided.idl, collided.lcm and the schema, are held equal field by
 * field, and the schema covers every byte of the plain structs. */
#include "wire/wire_schema.h"

#include <ctype.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <cmocka.h>

enum { FIELDS_MAX = 64, TOKEN_MAX = 64, CONSTANTS_MAX = 256 };

/* ---- both languages as tokens: words, single marks; no comments ---- */

typedef struct scanner {
    char *text;
    const char *at;
    char token[TOKEN_MAX];
} scanner;

static scanner scan_file(const char *path)
{
    FILE *f = fopen(path, "rb");
    if (!f) fail_msg("cannot open %s", path);
    char *text = calloc(1, 1 << 16);
    size_t size = fread(text, 1, (1 << 16) - 1, f);
    assert_true(size > 500 && feof(f));
    fclose(f);
    return (scanner){.text = text, .at = text};
}

static void pass_blanks(scanner *s)
{
    for (;;) {
        while (isspace((unsigned char)*s->at)) s->at++;
        if (strncmp(s->at, "//", 2) != 0) return;
        s->at += strcspn(s->at, "\n");
    }
}

static const char *next(scanner *s)
{
    pass_blanks(s);
    size_t length = strspn(s->at, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    if (length == 0 && *s->at) length = 1;
    assert_true(length < TOKEN_MAX);
    memcpy(s->token, s->at, length);
    s->token[length] = '\0';
    s->at += length;
    return s->token;
}

static bool accept(scanner *s, const char *token)
{
    const char *before = s->at;
    if (strcmp(next(s), token) == 0) return true;
    s->at = before;
    return false;
}

static void expect(scanner *s, const char *token)
{
    if (!accept(s, token)) fail_msg("\"%s\" was expected, not \"%.40s\"", token, s->at);
}

/* ---- structs of either language ---- */

static void keep_name(char out[TOKEN_MAX], const char *token)
{
    snprintf(out, TOKEN_MAX, "%s", token);
}

typedef struct parsed_field {
    char name[TOKEN_MAX];
    wire_type type;
    bool key;
} parsed_field;

typedef struct parsed {
    char name[TOKEN_MAX];
    parsed_field fields[FIELDS_MAX];
    uint32_t count;
} parsed;

static wire_type array_of(wire_type single)
{
    return WIRE_U8S + (single - WIRE_U8);
}

static wire_type idl_type(scanner *s)
{
    if (accept(s, "octet")) return WIRE_U8;
    if (accept(s, "double")) return WIRE_F64;
    if (accept(s, "string")) return WIRE_STRING;
    if (accept(s, "sequence")) {
        expect(s, "<");
        wire_type element = idl_type(s);
        expect(s, ">");
        return array_of(element);
    }
    expect(s, "long");
    return accept(s, "long") ? WIRE_I64 : WIRE_I32;
}

static parsed_field idl_field(scanner *s)
{
    parsed_field f = {.key = accept(s, "@")};
    if (f.key) expect(s, "key");
    f.type = idl_type(s);
    const char *name = next(s);
    keep_name(f.name, *name == '_' ? name + 1 : name); /* IDL's way to write a name that is one of its own words */
    expect(s, ";");
    return f;
}

static wire_type lcm_type(scanner *s)
{
    if (accept(s, "byte")) return WIRE_U8;
    if (accept(s, "double")) return WIRE_F64;
    if (accept(s, "string")) return WIRE_STRING;
    if (accept(s, "int64_t")) return WIRE_I64;
    expect(s, "int32_t");
    return WIRE_I32;
}

/* An array has its count before it: int32_t NAME_n; TYPE NAME[NAME_n]; */
static parsed_field lcm_field(scanner *s)
{
    parsed_field f = {.type = lcm_type(s)};
    keep_name(f.name, next(s));
    expect(s, ";");
    size_t length = strlen(f.name);
    if (length < 3 || strcmp(f.name + length - 2, "_n") != 0) return f;
    assert_int_equal(f.type, WIRE_I32);
    char count[TOKEN_MAX];
    keep_name(count, f.name);
    f.name[length - 2] = '\0';
    f.type = array_of(lcm_type(s));
    expect(s, f.name);
    expect(s, "[");
    expect(s, count);
    expect(s, "]");
    expect(s, ";");
    return f;
}

/* ---- constants of either language ---- */

typedef struct constants {
    uint32_t count;
    struct {
        char name[TOKEN_MAX];
        long value;
    } at[CONSTANTS_MAX];
} constants;

static void add_constant(constants *all, const char *name, long value)
{
    assert_true(all->count < CONSTANTS_MAX);
    keep_name(all->at[all->count].name, name);
    all->at[all->count++].value = value;
}

/* const TYPE NAME = NUMBER; */
static void parse_constants(scanner *s, constants *all)
{
    while (accept(s, "const")) {
        char name[TOKEN_MAX];
        next(s);
        keep_name(name, next(s));
        expect(s, "=");
        add_constant(all, name, strtol(next(s), NULL, 10));
        expect(s, ";");
    }
}

static parsed parse_struct(scanner *s, parsed_field (*field)(scanner *), constants *own)
{
    parsed p = {.count = 0};
    expect(s, "struct");
    keep_name(p.name, next(s));
    expect(s, "{");
    if (own) parse_constants(s, own);
    while (!accept(s, "}")) {
        assert_true(p.count < FIELDS_MAX);
        p.fields[p.count++] = field(s);
    }
    return p;
}

static void expect_as_in_schema(const parsed *p, wire_kind kind)
{
    const wire_schema *s = wire_schema_of(kind);
    assert_string_equal(p->name, s->name);
    for (uint32_t i = 0; i < p->count && i < s->field_count; i++) {
        const wire_field *f = &s->fields[i];
        if (strcmp(p->fields[i].name, f->name) != 0 || p->fields[i].type != f->type)
            fail_msg("%s: field %u is %s (type %d), in the schema %s (type %d)", s->name, i, p->fields[i].name,
                (int)p->fields[i].type, f->name, (int)f->type);
    }
    assert_int_equal(p->count, s->field_count);
}

/* The keys tell DDS which samples are of one object: its client and its number (a status: the daemon's epoch). */
static void expect_keys(const parsed *p, wire_kind kind)
{
    static const char *const second[WIRE_KIND_COUNT] = {[WIRE_CLIENT] = "client_id",
        [WIRE_GEOMETRY] = "hash piece",
        [WIRE_BODY] = "body_id",
        [WIRE_SUBSCRIPTION] = "subscription_id",
        [WIRE_STATUS] = "epoch"};
    for (uint32_t i = 0; i < p->count; i++) {
        const char *name = p->fields[i].name;
        bool of_object = second[kind] && (strcmp(name, "client_id") == 0 || strstr(second[kind], name) != NULL);
        if (p->fields[i].key != of_object) fail_msg("%s: is %s a key?", p->name, name);
    }
}

/* "PoseBatch", "bad_hash" as IDL writes constants: POSE_BATCH, BAD_HASH. */
static const char *in_capitals(const char *prefix, const char *name)
{
    static char out[TOKEN_MAX];
    size_t at = (size_t)snprintf(out, sizeof out, "%s_", prefix), first = at;
    for (; *name; name++) {
        if (isupper((unsigned char)*name) && islower((unsigned char)name[-(at > first)])) out[at++] = '_';
        out[at++] = (char)toupper((unsigned char)*name);
    }
    out[at] = '\0';
    return out;
}

/* WIRE_EVENT_BEGIN = 1 of wire.h is EVENT_BEGIN; how narrow an interval is has no prefix there. */
static void constant_of_header(constants *all, const char *name, long value)
{
    static const char *const groups[] = {"LOST_", "GEOMETRY_", "MOTION_", "CCD_", "RULE_", "SHAPE_", "FACT_", "BY_",
        "QUERY_", "ANSWER_", "EVENT_", "CAUSE_", "HEALTH_"};
    static const char *const achieved[] = {"CERTAIN", "WITHIN", "WIDE", "STOPPED"};
    if (strcmp(name, "GEOMETRY_MAX") == 0) return;
    if (strcmp(name, "VERSION") == 0) add_constant(all, "WIRE_VERSION", value);
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++)
        if (strncmp(name, groups[i], strlen(groups[i])) == 0) add_constant(all, name, value);
    for (size_t i = 0; i < sizeof achieved / sizeof *achieved; i++)
        if (strcmp(name, achieved[i]) == 0) add_constant(all, in_capitals("ACHIEVED", name), value);
}

static void parse_header(constants *all)
{
    scanner s = scan_file(IDL_FOLDER "/wire/wire.h");
    while (*next(&s)) {
        char name[TOKEN_MAX];
        keep_name(name, s.token);
        if (strncmp(name, "WIRE_", 5) != 0 || !accept(&s, "=")) continue;
        constant_of_header(all, name + 5, strtol(next(&s), NULL, 10));
    }
    free(s.text);
    for (int k = WIRE_NOTHING; k < WIRE_KIND_COUNT; k++)
        add_constant(all, in_capitals("MESSAGE", wire_kind_name((wire_kind)k)), k);
    for (int r = WIRE_OK; r < WIRE_REASON_COUNT; r++)
        add_constant(all, in_capitals("REASON", wire_reason_name((wire_reason)r)), r);
}

static long value_of(const constants *all, const char *name)
{
    for (uint32_t i = 0; i < all->count; i++)
        if (strcmp(all->at[i].name, name) == 0) return all->at[i].value;
    fail_msg("there is no constant %s", name);
    return -1;
}

/* Each constant of wire.h, with its value, and no other. */
static void expect_constants(const constants *own)
{
    constants expected = {0};
    parse_header(&expected);
    assert_in_range(expected.count, 100, CONSTANTS_MAX);
    for (uint32_t i = 0; i < expected.count; i++)
        if (value_of(own, expected.at[i].name) != expected.at[i].value)
            fail_msg("%s is not %ld", expected.at[i].name, expected.at[i].value);
    for (uint32_t i = 0; i < own->count; i++) (void)value_of(&expected, own->at[i].name);
    assert_int_equal(own->count, expected.count);
}

static void idl_is_the_schema(void **state)
{
    (void)state;
    constants own = {0};
    scanner s = scan_file(IDL_FOLDER "/collided.idl");
    expect(&s, "module");
    expect(&s, "collided");
    expect(&s, "{");
    parse_constants(&s, &own);
    expect_constants(&own);
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        expect(&s, "@");
        expect(&s, "final");
        parsed p = parse_struct(&s, idl_field, NULL);
        expect(&s, ";");
        expect_as_in_schema(&p, (wire_kind)kind);
        expect_keys(&p, (wire_kind)kind);
    }
    expect(&s, "}");
    expect(&s, ";");
    expect(&s, "");
    free(s.text);
}

static void lcm_is_the_schema(void **state)
{
    (void)state;
    constants own = {0};
    scanner s = scan_file(IDL_FOLDER "/collided.lcm");
    expect(&s, "package");
    expect(&s, "collided");
    expect(&s, ";");
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        parsed p = parse_struct(&s, lcm_field, &own);
        expect_as_in_schema(&p, (wire_kind)kind);
    }
    expect_constants(&own);
    expect(&s, "");
    free(s.text);
}

/* Languages, and IDL itself, that do not tell names apart by case alone can read both files. */
static void expect_names_apart(const char *path)
{
    enum { NAMES_MAX = 4096 };
    char(*names)[TOKEN_MAX] = calloc(NAMES_MAX, sizeof *names);
    size_t count = 0;
    scanner s = scan_file(path);
    while (*next(&s)) {
        if (!isalpha((unsigned char)*s.token)) continue;
        for (size_t i = 0; i < count; i++)
            if (strcasecmp(names[i], s.token) == 0 && strcmp(names[i], s.token) != 0)
                fail_msg("%s: %s and %s differ in case alone", path, names[i], s.token);
        assert_true(count < NAMES_MAX);
        keep_name(names[count++], s.token);
    }
    free(names);
    free(s.text);
}

static void no_names_differ_in_case_alone(void **state)
{
    (void)state;
    expect_names_apart(IDL_FOLDER "/collided.idl");
    expect_names_apart(IDL_FOLDER "/collided.lcm");
    expect_names_apart(IDL_FOLDER "/collided_peer.idl");
}

/* ---- the plain structs ---- */

static const struct {
    size_t size, alignment;
} layout[] = {
    [WIRE_U8] = {1, 1},
    [WIRE_I32] = {4, 4},
    [WIRE_I64] = {8, _Alignof(int64_t)},
    [WIRE_F64] = {8, _Alignof(double)},
    [WIRE_STRING] = {sizeof(char *), _Alignof(char *)},
    [WIRE_U8S] = {sizeof(wire_u8s), _Alignof(wire_u8s)},
    [WIRE_I32S] = {sizeof(wire_i32s), _Alignof(wire_i32s)},
    [WIRE_I64S] = {sizeof(wire_i64s), _Alignof(wire_i64s)},
    [WIRE_F64S] = {sizeof(wire_f64s), _Alignof(wire_f64s)},
    [WIRE_STRINGS] = {sizeof(wire_strings), _Alignof(wire_strings)},
};

static size_t aligned(size_t offset, size_t alignment)
{
    return (offset + alignment - 1) / alignment * alignment;
}

/* Each field begins where the one before ends, but for alignment: a member that the schema lacks would leave a gap.
 * (One that fits into the padding would not; its absence from IDL and LCM would not be seen either.) */
static void the_schema_covers_the_plain_structs(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        const wire_schema *s = wire_schema_of((wire_kind)kind);
        size_t end = 0, widest = 1;
        for (uint32_t i = 0; i < s->field_count; i++) {
            wire_type type = s->fields[i].type;
            assert_int_equal(s->fields[i].offset, aligned(end, layout[type].alignment));
            end = s->fields[i].offset + layout[type].size;
            if (layout[type].alignment > widest) widest = layout[type].alignment;
        }
        assert_int_equal(s->size, aligned(end, widest));
    }
}

static void every_array_and_text_has_a_limit(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        const wire_schema *s = wire_schema_of((wire_kind)kind);
        for (uint32_t i = 0; i < s->field_count; i++)
            assert_int_equal(s->fields[i].limit > 0, s->fields[i].type >= WIRE_STRING);
    }
}

static void the_first_fields_are_version_and_client_the_last_extensions(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        const wire_schema *s = wire_schema_of((wire_kind)kind);
        assert_string_equal(s->fields[0].name, "version");
        assert_string_equal(s->fields[1].name, kind == WIRE_STATUS ? "epoch" : "client_id");
        assert_string_equal(s->fields[s->field_count - 1].name, "extensions");
        assert_string_equal(wire_kind_name((wire_kind)kind), s->name);
    }
    assert_null(wire_schema_of(WIRE_NOTHING));
    assert_null(wire_schema_of(WIRE_KIND_COUNT));
}

static void every_reason_has_a_name_of_its_own(void **state)
{
    (void)state;
    for (int a = WIRE_OK; a < WIRE_REASON_COUNT; a++) {
        assert_non_null(wire_reason_name((wire_reason)a));
        for (int b = WIRE_OK; b < a; b++)
            assert_string_not_equal(wire_reason_name((wire_reason)a), wire_reason_name((wire_reason)b));
    }
    assert_string_equal(wire_reason_name(WIRE_REASON_COUNT), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(idl_is_the_schema),
        cmocka_unit_test(lcm_is_the_schema),
        cmocka_unit_test(no_names_differ_in_case_alone),
        cmocka_unit_test(the_schema_covers_the_plain_structs),
        cmocka_unit_test(every_array_and_text_has_a_limit),
        cmocka_unit_test(the_first_fields_are_version_and_client_the_last_extensions),
        cmocka_unit_test(every_reason_has_a_name_of_its_own),
    };
    return cmocka_run_group_tests_name("wire_contract", tests, NULL, NULL);
}
