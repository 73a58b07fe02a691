/* findings: what a test finds wrong, by kind: the first few of each are printed, all are counted, and any is a failure
 * at the end. So one run says what there is to look at. After cmocka.h. */
#ifndef COLLIDED_TESTS_NARROW_FINDINGS_H
#define COLLIDED_TESTS_NARROW_FINDINGS_H

#include <stdio.h>
#include <string.h>

enum { FINDING_KINDS = 32, FINDINGS_PRINTED = 4 };

typedef struct finding {
    const char *kind;
    size_t count;
} finding;

static finding findings[FINDING_KINDS];

/* `what`: which pair, and by how much. */
static inline void found(const char *kind, const char *what)
{
    int k = 0;
    while (k < FINDING_KINDS - 1 && findings[k].kind && strcmp(findings[k].kind, kind) != 0) k++;
    findings[k].kind = kind;
    if (findings[k].count++ < FINDINGS_PRINTED) print_message("%s: %s\n", kind, what);
}

static inline void assert_nothing_found(void)
{
    size_t all = 0;
    for (int k = 0; k < FINDING_KINDS && findings[k].kind; k++) {
        print_message("%zu: %s\n", findings[k].count, findings[k].kind);
        all += findings[k].count;
    }
    memset(findings, 0, sizeof findings);
    assert_true(all == 0);
}

#endif
