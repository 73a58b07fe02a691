/* fuzz: what every target is: a function that libFuzzer calls with bytes, again and again, on one thread. Broken
 * promises abort, so that the fuzzer keeps the bytes that broke them. */
#ifndef COLLIDED_TESTS_FUZZ_FUZZ_H
#define COLLIDED_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define PROMISE(that)                                                                                                  \
    do {                                                                                                               \
        if (!(that)) {                                                                                                 \
            fprintf(stderr, "%s:%d: broken: %s\n", __FILE__, __LINE__, #that);                                         \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

#endif
