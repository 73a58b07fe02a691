/* wire_dds: messages to and from the types that idlc generates. Only the layout of samples is known here, no DDS calls
 * are made; the library wire_dds (not wire) carries it, so that nobody else links the generated code. */
#ifndef COLLIDED_WIRE_DDS_H
#define COLLIDED_WIRE_DDS_H

#include "wire/wire.h"

#include <stdbool.h>

struct dds_topic_descriptor;

const struct dds_topic_descriptor *wire_dds_descriptor(wire_kind kind);
size_t wire_dds_sample_size(wire_kind kind);

/* A message that borrows from the sample: valid as long as the sample is. The sequences of plain numbers are not
 * copied. Checked by wire_check. */
wire_reason wire_dds_decode(wire_kind kind, const void *sample, wire_message *out, wire_refusal *refusal);

/* The same from a sample's bytes, as a reader gets them (CDR, with its header of 4 bytes): the message borrows from
 * these. False, and nothing is reported: it has to be decoded by Cyclone, because it is of another byte order, another
 * encoding than plain XCDR 1, or a kind that has texts; or because the bytes behind the header are not aligned to 8. */
bool wire_dds_decode_bytes(
    wire_kind kind, const void *bytes, size_t size, wire_message *out, wire_reason *reason, wire_refusal *refusal);

int64_t wire_dds_client_of_ack(const void *sample); /* of the generated type; whom it is for */

/* A sample that borrows from the message: to be written at once, never freed by dds_sample_free. `sample` has
 * wire_dds_sample_size bytes. */
void wire_dds_encode(const wire_message *m, void *sample);

#endif
