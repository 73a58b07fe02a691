/* link_open: the table of all transports. The tick thread. */
#include "link_open.h"

#include "base/array.h"
#include "link_dds.h"
#include "link_lcm.h"
#include "link_memory.h"
#include "link_pipe.h"
#include "link_replay.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

static const link_ops *const transports[] = {
    &link_dds_ops, &link_lcm_ops, &link_memory_ops, &link_replay_ops, &link_pipe_ops};
enum { TRANSPORT_COUNT = sizeof transports / sizeof transports[0] };

/* What follows "scheme://", or NULL if that is not the URI's scheme. */
static const char *address_after(const char *uri, const char *scheme)
{
    size_t n = strlen(scheme);
    return strncmp(uri, scheme, n) == 0 && strncmp(uri + n, "://", 3) == 0 ? uri + n + 3 : NULL;
}

static const link_ops *transport_of(const char *uri, const char **address)
{
    for (size_t i = 0; i < TRANSPORT_COUNT; i++)
        if ((*address = address_after(uri, transports[i]->scheme)) != NULL) return transports[i];
    return NULL;
}

static void options_copy(link_options *to, const link_options *from, const char *address)
{
    *to = *from;
    to->address = base_strdup(address);
    to->interface = base_strdup(from->interface ? from->interface : "");
    to->security = base_strdup(from->security ? from->security : "");
    to->program = base_strdup(from->program ? from->program : "");
}

static void link_free(struct link *l)
{
    free((char *)l->options.address);
    free((char *)l->options.interface);
    free((char *)l->options.security);
    free((char *)l->options.program);
    free(l);
}

static int unknown(const char *uri, char *why, size_t why_size)
{
    snprintf(why, why_size, "%s: unknown transport; known are dds://, lcm://, memory:// and replay://", uri);
    return EX_CONFIG;
}

int link_check(const char *uri, const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    link_options o = *options;
    const link_ops *ops = transport_of(uri, &o.address);
    if (!ops) return unknown(uri, why, why_size);
    return ops->check(&o, key, why, why_size);
}

bool link_announces(const char *uri)
{
    const char *address;
    const link_ops *ops = transport_of(uri, &address);
    return ops && ops->announces;
}

struct link *link_open(const char *uri, const link_options *options, char *why, size_t why_size)
{
    const char *address;
    const link_ops *ops = transport_of(uri, &address);
    if (!ops) {
        unknown(uri, why, why_size);
        return NULL;
    }
    struct link *l = base_zalloc(1, ops->size);
    l->ops = ops;
    options_copy(&l->options, options, address);
    if (ops->open(l, &l->options, why, why_size) == 0) return l;
    link_free(l);
    return NULL;
}

void link_close(struct link *l)
{
    if (!l) return;
    l->ops->flush(l);
    l->ops->close(l);
    link_free(l);
}
