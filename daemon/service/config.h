/* config: what can be set, as one table: parser, defaults, ranges and --help all come from it.
 *
 * A file has lines "key = value"; '#' begins a comment. The command line has --key value, --key=value, and --key alone
 * for yes. Later settings win: first the file that --config names, then the command line. */
#ifndef COLLIDED_SERVICE_CONFIG_H
#define COLLIDED_SERVICE_CONFIG_H

#include <stdbool.h>
#include <stddef.h>

enum { CONFIG_TEXT_MAX = 1024 };

typedef struct config {
    char name[64];
    char links[CONFIG_TEXT_MAX];
    char interface[64];
    char security[CONFIG_TEXT_MAX];
    char user[64];
    char gateway[CONFIG_TEXT_MAX];
    char record[CONFIG_TEXT_MAX];
    char record_dir[CONFIG_TEXT_MAX];
    char runtime_dir[CONFIG_TEXT_MAX];
    char replay[CONFIG_TEXT_MAX];
    char replay_pipe[CONFIG_TEXT_MAX];
    char log[16];
    char metrics_address[64];
    char metrics_hosts[CONFIG_TEXT_MAX];
    char cpus[128];
    char engine[16];
    char broad[16];
    char step_policy[16];
    long workers, metrics_port, fifo_priority;
    bool caches, json, journal, trade, lock_memory, record_events, standby;
    double record_keep_free, record_max_time;
    long record_max_size, record_max_files;
    double margin, rate, budget_us, slice_us, settle, replay_speed, status_period, lease, heartbeat, step_timeout,
        standby_lease;
    long max_clients, max_bodies, max_shapes, max_pairs, max_subscriptions, max_geometries, max_step_poses;
    long max_soft_vertices;
    long max_client_bodies, max_client_shapes, max_client_subscriptions, max_client_geometry;
    long max_client_messages, max_client_poses, memory_limit;
    long share, max_client_work, max_query_work, max_waiting;
} config;

typedef enum config_type { CONFIG_TEXT, CONFIG_CHOICE, CONFIG_WHOLE, CONFIG_NUMBER, CONFIG_YES } config_type;

typedef struct config_option {
    const char *key;
    config_type type;
    size_t offset, size;     /* of the field in config */
    double least, most;      /* of numbers */
    const char *choices;     /* "a|b|c" */
    const char *value;       /* default, as text */
    const char *unit, *help; /* help: a phrase of at most two lines, for --help */
    const char *details;     /* what else a stranger needs to know, whole sentences, for the manual; "" = nothing */
} config_option;

const config_option *config_options(size_t *count);

void config_default(config *c);

/* 0, or -1 with one line in `why`: file, line, key, and what is allowed. */
int config_set(config *c, const char *key, const char *value, char *why, size_t why_size);
/* The same for text in memory; `path` is only for messages. */
int config_parse(config *c, const char *text, size_t size, const char *path, char *why, size_t why_size);
/* 0, or the exit status, negated, with one line in `why`: -EX_NOINPUT (no such file), -EX_CONFIG (what it says). */
int config_read(config *c, const char *path, char *why, size_t why_size);
/* The same, or -EX_USAGE. Reads --config first, wherever it stands. 1: --help or --version was asked for, and *asked is
 * set to it. */
int config_arguments(config *c, int argc, char **argv, const char **asked, char *why, size_t why_size);

/* What decides which commands are refused and which numbers are told, as far as it is not the default: lines of
 * key = value, of at most CONFIG_DECIDING_MAX characters. A recording has it. */
enum { CONFIG_DECIDING_MAX = 1024 };
void config_report_deciding(const config *c, char text[CONFIG_DECIDING_MAX]);
/* Takes it over from there, but for what c has that is not the default. -1: it is not such text, one line in `why`. */
int config_take_deciding(config *c, const char *text, size_t size, char *why, size_t why_size);

/* How the daemon ends: by sysexits.h. */
typedef struct config_exit {
    int status;
    const char *name, *meaning;
} config_exit;

const config_exit *config_exits(size_t *count);

void config_help(void); /* to standard output */

#endif
