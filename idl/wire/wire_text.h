/* wire_text: what the files of this folder share about text: refusing with a line, and telling good text. Internal. */
#ifndef COLLIDED_WIRE_TEXT_H
#define COLLIDED_WIRE_TEXT_H

#include "wire.h"

#include <stdbool.h>

/* Fills in *refusal and returns the reason. */
__attribute__((format(printf, 3, 4))) wire_reason wire_refuse(
    wire_refusal *refusal, wire_reason reason, const char *format, ...);

bool wire_text_is_utf8(const char *text);      /* well-formed: no overlong forms, no surrogates */
bool wire_text_has_controls(const char *text); /* of well-formed text: U+0000 to 1F, 7F to 9F */
uint64_t wire_fnv1a(uint64_t hash, const void *bytes, size_t size);
#define WIRE_FNV1A_START UINT64_C(0xcbf29ce484222325)

#endif
