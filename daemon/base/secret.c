/* secret: drawn from the kernel once. Where that has none to give, the clock and the place of the code must do. */
#include "secret.h"

#include "clock.h"

#include <pthread.h>
#include <sys/random.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static uint64_t drawn;

static void draw(void)
{
    uint64_t number = 0;
    if (getrandom(&number, sizeof number, GRND_NONBLOCK) != (ssize_t)sizeof number)
        number = (uint64_t)clock_monotonic_ns() * UINT64_C(0x9e3779b97f4a7c15) ^ (uint64_t)(uintptr_t)&drawn;
    drawn = number ? number : 1;
}

uint64_t secret(void)
{
    pthread_once(&once, draw);
    return drawn;
}
