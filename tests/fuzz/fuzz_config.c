/* Any bytes as the daemon's configuration: values within the table's ranges, or one line that says what is allowed. */
#include "fuzz.h"

#include "service/config.h"

#include <string.h>

static void expect_in_range(const config *c, const config_option *o)
{
    const char *field = (const char *)c + o->offset;
    double number = 0;
    if (o->type == CONFIG_TEXT || o->type == CONFIG_CHOICE) PROMISE(memchr(field, '\0', o->size));
    if (o->type != CONFIG_WHOLE && o->type != CONFIG_NUMBER) return;
    if (o->type == CONFIG_WHOLE) number = (double)*(const long *)(const void *)field;
    if (o->type == CONFIG_NUMBER) number = *(const double *)(const void *)field;
    PROMISE(number >= o->least && number <= o->most);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    config c;
    char why[512] = "";
    size_t count;
    config_default(&c);
    int result = config_parse(&c, (const char *)data, size, "fuzz.conf", why, sizeof why);
    PROMISE((result == 0) == !why[0]);
    PROMISE(result == 0 || strncmp(why, "fuzz.conf:", 10) == 0);
    const config_option *options = config_options(&count);
    for (size_t i = 0; i < count; i++) expect_in_range(&c, &options[i]);
    return 0;
}
