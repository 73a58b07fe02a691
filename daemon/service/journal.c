/* journal: entries are a kind, a link, a size, and so many bytes. Tick thread. */
#include "journal.h"

typedef struct head {
    uint64_t size;
    uint8_t kind, link, unused[6];
} head;

static void put_entry_head(bytes_out *to, journal_entry_kind kind, uint8_t link, size_t size)
{
    head h = {.size = size, .kind = (uint8_t)kind, .link = link};
    bytes_put(to, &h, sizeof h);
}

void journal_put_message(bytes_out *to, uint8_t link, const wire_message *m)
{
    size_t size = wire_lcm_size(m);
    put_entry_head(to, ENTRY_MESSAGE, link, size);
    array_reserve(to, to->count + size);
    to->count += wire_lcm_encode(m, to->at + to->count, size);
}

void journal_put_lost(bytes_out *to, uint8_t link, int64_t client)
{
    put_entry_head(to, ENTRY_LOST, link, sizeof client);
    bytes_put(to, &client, sizeof client);
}

void journal_put_reader(bytes_out *to, uint8_t link, const char *stream)
{
    put_entry_head(to, ENTRY_READER, link, strlen(stream) + 1);
    bytes_put_text(to, stream);
}

void journal_put_build(bytes_out *to, int64_t client, int64_t hash, bool ready)
{
    const int64_t numbers[3] = {client, hash, ready};
    put_entry_head(to, ENTRY_BUILD, 0, sizeof numbers);
    bytes_put(to, numbers, sizeof numbers);
}

void journal_put_tick(bytes_out *to, int64_t epoch, const wire_log_tick *t)
{
    put_entry_head(to, ENTRY_TICK, 0, sizeof epoch + sizeof *t);
    bytes_put(to, &epoch, sizeof epoch);
    bytes_put(to, t, sizeof *t);
}

static bool read_body(bytes_in *body, wire_memory *memory, journal_entry *out)
{
    wire_refusal why;
    switch (out->kind) {
    case ENTRY_MESSAGE:
        wire_memory_reset(memory);
        return wire_lcm_decode(body->at, body->left, memory, &out->message, &why) == WIRE_OK;
    case ENTRY_LOST:
        return bytes_get(body, &out->client, sizeof out->client);
    case ENTRY_BUILD:
        return bytes_get(body, &out->client, sizeof out->client) && bytes_get(body, &out->hash, sizeof out->hash) &&
               bytes_get(body, &out->ready, sizeof out->ready);
    case ENTRY_READER:
        out->stream = bytes_get_text(body);
        return !body->broken;
    case ENTRY_TICK:
        return bytes_get(body, &out->epoch, sizeof out->epoch) && bytes_get(body, &out->tick, sizeof out->tick);
    }
    return false;
}

bool journal_next(bytes_in *r, wire_memory *memory, journal_entry *out)
{
    head h;
    if (!r->left || !bytes_get(r, &h, sizeof h)) return false;
    if (h.size > r->left) {
        r->broken = true;
        return false;
    }
    bytes_in body = {.at = r->at, .left = (size_t)h.size};
    r->at += h.size;
    r->left -= (size_t)h.size;
    *out = (journal_entry){.kind = (journal_entry_kind)h.kind, .link = h.link};
    if (read_body(&body, memory, out)) return true;
    r->broken = true;
    return false;
}
