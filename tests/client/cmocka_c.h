/* cmocka_c: cmocka and the headers that it wants to have been included before it. */
#ifndef COLLIDED_TESTS_CLIENT_CMOCKA_C_H
#define COLLIDED_TESTS_CLIENT_CMOCKA_C_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
