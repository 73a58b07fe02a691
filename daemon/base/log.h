/* log: one line a message to standard error (the journal picks the level up from the "<N>" prefix when asked to).
 *
 * Any thread may log. A site is rate-limited: after LOG_BURST lines within a second it is muted until the second is
 * over, and the next line that it prints says how many were left out; nothing is dropped in silence. */
#ifndef COLLIDED_BASE_LOG_H
#define COLLIDED_BASE_LOG_H

#include <stdint.h>

typedef enum log_level { LOG_ERROR, LOG_WARNING, LOG_NOTICE, LOG_INFO, LOG_DEBUG } log_level;

enum { LOG_BURST = 10 }; /* lines a second and site; a flood of bad input must not fill a disk */

typedef struct log_site {
    _Atomic int64_t second;
    _Atomic uint32_t printed;
    _Atomic uint32_t muted;
} log_site;

/* Lines above `most` are not printed. `journal` adds the "<N>" prefixes of sd-daemon(3). Not thread-safe: call first.
 */
void log_setup(log_level most, int journal);

void log_write(log_site *site, log_level level, const char *format, ...) __attribute__((format(printf, 3, 4)));

#define LOG_AT(level, ...)                                                                                             \
    do {                                                                                                               \
        static log_site log_site_here;                                                                                 \
        log_write(&log_site_here, level, __VA_ARGS__);                                                                 \
    } while (0)
#define log_error(...) LOG_AT(LOG_ERROR, __VA_ARGS__)
#define log_warning(...) LOG_AT(LOG_WARNING, __VA_ARGS__)
#define log_notice(...) LOG_AT(LOG_NOTICE, __VA_ARGS__)
#define log_info(...) LOG_AT(LOG_INFO, __VA_ARGS__)
#define log_debug(...) LOG_AT(LOG_DEBUG, __VA_ARGS__)

#endif
