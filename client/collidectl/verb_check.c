/* verb_check: would a loaded robot meet anything in some configurations, or on the straight ways between them in joint
 * space? Nothing moves. */
#include "json.h"
#include "loaders/robot_tree.h"
#include "recall.h"
#include "store_file.h"
#include "verbs.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>

static const char *const verdicts[] = {"free", "meets", "undecided", "not done"};

/* "now", a state of the SRDF, or values of joints. Those that it does not name stay as they were. */
static bool read_configuration(ctl *c, const robot *r, const char *text, double *values)
{
    if (strcmp(text, "now") == 0) return true;
    if (strchr(text, '=')) return robot_set_list(r, text, values, &c->report);
    return robot_state(r, text, values, &c->report);
}

static void print_names(const collided_check_item *item)
{
    if (item->name_a) printf("  %s", item->name_a);
    if (item->name_b) printf(", %s", item->name_b);
}

static void print_item(const ctl *c, const collided_check_item *item, const char *from, const char *to)
{
    const char *verdict = verdicts[item->verdict <= COLLIDED_CHECK_NOT_DONE ? item->verdict : COLLIDED_CHECK_UNDECIDED];
    if (c->options.json) {
        json j = {.out = stdout};
        json_open(&j, NULL, '{');
        json_text(&j, "from", from);
        if (to) json_text(&j, "to", to);
        json_text(&j, "verdict", verdict);
        if (to) json_number(&j, "first_lo", item->first_lo), json_number(&j, "first_hi", item->first_hi);
        if (!to) json_number(&j, "lo", item->lo), json_number(&j, "hi", item->hi);
        if (item->name_a) json_text(&j, "name_a", item->name_a);
        if (item->name_b) json_text(&j, "name_b", item->name_b);
        json_close(&j, '}');
        json_end_line(&j);
        return;
    }
    printf("%-9s  %s", verdict, from);
    if (to) printf(" -> %s", to);
    if (to && item->verdict == COLLIDED_CHECK_MEETS)
        printf("  at %.6f .. %.6f of the way", item->first_lo, item->first_hi);
    if (to && item->verdict == COLLIDED_CHECK_UNDECIDED) printf("  free up to %.6f of the way", item->first_lo);
    if (!to && isfinite(item->hi)) printf("  %.9f .. %.9f m", item->lo, item->hi);
    print_names(item);
    putchar('\n');
}

static int ask_and_print(ctl *c, const robot_checked *tree, const double *positions, size_t configurations)
{
    collided_check_options options = collided_check_options_default();
    options.margin_m = c->options.margin_m;
    options.measure = configurations == 1;
    bool edges = configurations > 1;
    size_t items = edges ? configurations - 1 : 1, n = tree->coordinates;
    double *numbers = pool_alloc(&c->pool, 2 * items * n + 1, sizeof *numbers);
    for (size_t i = 0; i < items; i++)
        memcpy(numbers + i * (edges ? 2 : 1) * n, positions + i * n, (edges ? 2 : 1) * n * sizeof *numbers);
    collided_checked done;
    collided_status status =
        edges ? collided_check_edges(c->client, &tree->robot, &options, numbers, items, c->options.timeout_s, &done)
              : collided_check_states(c->client, &tree->robot, &options, numbers, items, c->options.timeout_s, &done);
    int result = status == COLLIDED_UNSUPPORTED || status == COLLIDED_UNKNOWN_ID
                     ? ctl_fail(EX_DATAERR, "check: %s", collided_error(c->client))
                     : ctl_check(c, status, "check");
    for (size_t i = 0; !result && i < items; i++)
        print_item(c, &done.items[i], c->arguments[i + 1], edges ? c->arguments[i + 2] : NULL);
    if (!result && *done.text) fprintf(stderr, "collidectl: check: %s\n", done.text);
    for (size_t i = 0; !result && i < items; i++)
        if (done.items[i].verdict != COLLIDED_CHECK_FREE) result = EX_DATAERR;
    collided_checked_free(&done);
    return result;
}

static int check_robot_of(ctl *c, const store *s)
{
    store_robot *of;
    robot r;
    double *values;
    robot_checked tree;
    int status = recall_robot(c, s, "check", c->arguments[0], &of, &r, &values);
    if (status) return status;
    if (!robot_make_tree(&r, of->base, &c->pool, &tree, &c->report)) return ctl_fail_loading(c);
    size_t configurations = (size_t)c->argument_count - 1;
    double *positions = pool_alloc(&c->pool, configurations * tree.coordinates + 1, sizeof *positions);
    for (size_t i = 0; i < configurations; i++) {
        if (!read_configuration(c, &r, c->arguments[i + 1], values)) return ctl_fail_loading(c);
        robot_configuration(&tree, values, positions + i * tree.coordinates);
    }
    status = ctl_connect_guest(c);
    return status ? status : ask_and_print(c, &tree, positions, configurations);
}

int verb_check(ctl *c)
{
    store s;
    int status = store_open(&s, c);
    if (status) return status;
    status = check_robot_of(c, &s);
    ctl_disconnect(c);
    store_close(&s);
    return status;
}
