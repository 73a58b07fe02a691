/* link_dds_rooms: rooms of the link, for a crowd on loopback (wire_dds_qos.h says what they are). The thread that gives
 * turns opens them, the tick thread reads and writes in them, and none is closed before the link is. */
#include "base/log.h"
#include "link_dds_own.h"
#include "wire/dds/wire_dds_leave.h"
#include "wire/dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <stdlib.h>

enum { CONFIG_BYTES = 4096 };

static bool may_have_rooms(void *link)
{
    const link_dds *l = link;
    const link_options *o = &l->head.options;
    return o->rooms && !(o->interface && *o->interface) && !(o->security && *o->security) && wire_dds_has_rooms();
}

link_dds *link_dds_next_room(link_dds *l, unsigned *number)
{
    while (*number <= WIRE_DDS_ROOMS) {
        link_dds *room = atomic_load(&l->rooms[(*number)++]);
        if (room) return room;
    }
    return NULL;
}

link_dds *link_dds_home(link_dds *l, int64_t client)
{
    unsigned number = speakers_room(&l->speakers, client);
    return number ? atomic_load(&l->rooms[number]) : l;
}

static unsigned room_present(void *link, unsigned number)
{
    link_dds *l = link;
    const link_dds *in = number ? atomic_load(&l->rooms[number]) : l;
    dds_publication_matched_status_t status;
    size_t i = 0;
    if (!in) return 0;
    /* Of the writer of Status: each client reads it once. */
    while (i < LINK_DDS_OUT && in->writers[i].kind != WIRE_STATUS) i++;
    bool known =
        i < LINK_DDS_OUT && dds_get_publication_matched_status(in->writers[i].entity, &status) == DDS_RETCODE_OK;
    return known ? status.current_count : 0;
}

static void room_free(link_dds *room)
{
    if (room->participant > 0) dds_delete(room->participant);
    if (!wire_dds_leave(room->domain)) log_warning("room %u: %s", room->room, WIRE_DDS_LEFT_BEHIND);
    turns_free(&room->waiting);
    free(room);
}

/* What all share is the link's. */
static link_dds *room_create(link_dds *l, unsigned number)
{
    link_dds *room = base_zalloc(1, sizeof *room);
    room->whole = l;
    room->room = number;
    room->messages_in = l->messages_in;
    room->refused = l->refused;
    room->foreign = l->foreign;
    room->history_full = l->history_full;
    room->messages_out = l->messages_out;
    room->write_failed = l->write_failed;
    room->no_stream = l->no_stream;
    room->samples_lost = l->samples_lost;
    turns_init(&room->waiting);
    return room;
}

static dds_return_t join(link_dds *room)
{
    char config[CONFIG_BYTES];
    uint32_t domain = link_dds_domain(room->whole), number = wire_dds_room_domain(domain, room->room);
    if (!wire_dds_config_room(config, sizeof config, domain, room->room, WIRE_DDS_DAEMON)) return DDS_RETCODE_ERROR;
    room->domain = dds_create_domain(number, config);
    if (room->domain < 0) return room->domain;
    room->participant = dds_create_participant(number, NULL, NULL);
    return room->participant < 0 ? room->participant : DDS_RETCODE_OK;
}

static bool room_open(void *link, unsigned number)
{
    link_dds *l = link;
    if (atomic_load(&l->rooms[number])) return true;
    if (l->room_fails[number] || !may_have_rooms(l)) return false;
    link_dds *room = room_create(l, number);
    dds_return_t joined = join(room);
    if (joined == DDS_RETCODE_OK && link_dds_open_ends(room)) {
        atomic_store(&l->rooms[number], room);
        metric_count(l->joiners.rooms_open, 1);
        return true;
    }
    log_warning("DDS: room %u for clients that come at once cannot be opened: %s: its UDP port is taken, perhaps",
        number, joined < 0 ? dds_strretcode(joined) : "no readers and writers");
    l->room_fails[number] = true;
    room_free(room);
    return false;
}

joiners_rooms link_dds_rooms(link_dds *l)
{
    return (joiners_rooms){l, may_have_rooms, room_open, room_present};
}

void link_dds_rooms_close(link_dds *l)
{
    for (unsigned i = 1; i <= WIRE_DDS_ROOMS; i++) {
        link_dds *room = atomic_exchange(&l->rooms[i], NULL);
        if (!room) continue;
        link_dds_drop_waiting(room);
        room_free(room);
    }
}
