/* journal: entries are a kind, a link, a size, and so many bytes. Tick thread. */
#include "journal.h"

#include <string.h>

void journal_put(journal_bytes *to, const void *data, size_t size)
{
    array_reserve(to, to->count + size);
    if (size) memcpy(to->at + to->count, data, size);
    to->count += size;
}

void journal_put_text(journal_bytes *to, const char *text)
{
    journal_put(to, text, strlen(text) + 1);
}

bool journal_get(journal_reader *r, void *data, size_t size)
{
    if (size > r->left) {
        r->broken = true;
        r->left = 0;
        memset(data, 0, size);
        return false;
    }
    if (size) memcpy(data, r->at, size);
    r->at += size;
    r->left -= size;
    return true;
}

const char *journal_get_text(journal_reader *r)
{
    const char *text = (const char *)r->at;
    const void *end = r->left ? memchr(r->at, '\0', r->left) : NULL;
    if (!end) {
        r->broken = true;
        r->left = 0;
        return "";
    }
    r->left -= strlen(text) + 1;
    r->at += strlen(text) + 1;
    return text;
}

typedef struct head {
    uint64_t size;
    uint8_t kind, link, unused[6];
} head;

static void put_head(journal_bytes *to, journal_entry_kind kind, uint8_t link, size_t size)
{
    head h = {.size = size, .kind = (uint8_t)kind, .link = link};
    journal_put(to, &h, sizeof h);
}

void journal_put_message(journal_bytes *to, uint8_t link, const wire_message *m)
{
    size_t size = wire_lcm_size(m);
    put_head(to, ENTRY_MESSAGE, link, size);
    array_reserve(to, to->count + size);
    to->count += wire_lcm_encode(m, to->at + to->count, size);
}

void journal_put_lost(journal_bytes *to, uint8_t link, int64_t client)
{
    put_head(to, ENTRY_LOST, link, sizeof client);
    journal_put(to, &client, sizeof client);
}

void journal_put_reader(journal_bytes *to, uint8_t link, const char *stream)
{
    put_head(to, ENTRY_READER, link, strlen(stream) + 1);
    journal_put_text(to, stream);
}

void journal_put_tick(journal_bytes *to, int64_t epoch, const wire_log_tick *t)
{
    put_head(to, ENTRY_TICK, 0, sizeof epoch + sizeof *t);
    journal_put(to, &epoch, sizeof epoch);
    journal_put(to, t, sizeof *t);
}

static bool read_body(journal_reader *body, wire_memory *memory, journal_entry *out)
{
    wire_refusal why;
    switch (out->kind) {
    case ENTRY_MESSAGE:
        wire_memory_reset(memory);
        return wire_lcm_decode(body->at, body->left, memory, &out->message, &why) == WIRE_OK;
    case ENTRY_LOST:
        return journal_get(body, &out->client, sizeof out->client);
    case ENTRY_READER:
        out->stream = journal_get_text(body);
        return !body->broken;
    case ENTRY_TICK:
        return journal_get(body, &out->epoch, sizeof out->epoch) && journal_get(body, &out->tick, sizeof out->tick);
    }
    return false;
}

bool journal_next(journal_reader *r, wire_memory *memory, journal_entry *out)
{
    head h;
    if (!r->left || !journal_get(r, &h, sizeof h)) return false;
    if (h.size > r->left) {
        r->broken = true;
        return false;
    }
    journal_reader body = {.at = r->at, .left = (size_t)h.size};
    r->at += h.size;
    r->left -= (size_t)h.size;
    *out = (journal_entry){.kind = (journal_entry_kind)h.kind, .link = h.link};
    if (read_body(&body, memory, out)) return true;
    r->broken = true;
    return false;
}
