/* wire_rules: see wire_rules.h. */
#include "wire_rules.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

wire_reason check_count(const char *name, uint32_t count, uint32_t each, uint32_t things, wire_refusal *why)
{
    if (count == each * things) return WIRE_OK;
    FAIL(WIRE_MALFORMED, "%s has %u elements: it must have %u for each of %u", name, count, each, things);
}

wire_reason check_optional(const char *name, uint32_t count, uint32_t each, uint32_t things, wire_refusal *why)
{
    return count == 0 ? WIRE_OK : check_count(name, count, each, things, why);
}

wire_reason check_between(const char *name, int64_t value, int64_t least, int64_t most, wire_refusal *why)
{
    if (value >= least && value <= most) return WIRE_OK;
    FAIL(WIRE_MALFORMED, "%s is %" PRId64 ": %" PRId64 " to %" PRId64 " is allowed", name, value, least, most);
}

wire_reason check_all_between(const char *name, wire_u8s s, uint8_t least, uint8_t most, wire_refusal *why)
{
    for (uint32_t i = 0; i < s.count; i++)
        if (s.at[i] < least || s.at[i] > most)
            FAIL(WIRE_MALFORMED, "%s[%u] is %u: %u to %u is allowed", name, i, s.at[i], least, most);
    return WIRE_OK;
}

wire_reason check_at_least(const char *name, double value, double least, wire_refusal *why)
{
    if (value >= least) return WIRE_OK;
    FAIL(WIRE_BAD_NUMBER, "%s is %g: at least %g is allowed", name, value, least);
}

wire_reason check_magnitudes(const char *name, wire_f64s v, double most, wire_refusal *why)
{
    for (uint32_t i = 0; i < v.count; i++)
        if (fabs(v.at[i]) > most) FAIL(WIRE_TOO_LARGE, "%s[%u] is %g: at most %g is allowed", name, i, v.at[i], most);
    return WIRE_OK;
}

/* Near enough to 1 that normalising it is no guess. */
wire_reason check_rotation(const char *name, uint32_t i, const double q[4], wire_refusal *why)
{
    double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (squared >= 0.25 && squared <= 4) return WIRE_OK;
    FAIL(WIRE_BAD_ROTATION, "%s[%u..%u] has the norm %g: 0.5 to 2 is allowed", name, i, i + 3, sqrt(squared));
}

wire_reason check_poses(const char *name, wire_f64s poses, wire_refusal *why)
{
    for (uint32_t i = 0; i + 7 <= poses.count; i += 7) {
        for (uint32_t k = i; k < i + 3; k++)
            if (fabs(poses.at[k]) > WIRE_POSITION_MAX)
                FAIL(WIRE_TOO_LARGE, "%s[%u] is %g m: at most %g is allowed", name, k, poses.at[k], WIRE_POSITION_MAX);
        TRY(check_rotation(name, i + 3, poses.at + i + 3, why));
    }
    return WIRE_OK;
}

wire_reason check_label(const char *name, const char *text, wire_refusal *why)
{
    size_t length = text ? strnlen(text, WIRE_NAME_MAX + 1) : 0;
    if (length > WIRE_NAME_MAX) FAIL(WIRE_TOO_LARGE, "%s is longer than the allowed %d bytes", name, WIRE_NAME_MAX);
    if (length && wire_text_has_controls(text)) FAIL(WIRE_BAD_NAME, "%s must not have control characters", name);
    return WIRE_OK;
}

wire_reason check_name(const char *name, const char *text, wire_refusal *why)
{
    if (!text || !*text) FAIL(WIRE_BAD_NAME, "%s is empty: 1 to %d bytes are allowed", name, WIRE_NAME_MAX);
    return check_label(name, text, why);
}

/* A name with '*' and '?', or a group. */
wire_reason check_pattern(const char *name, const char *text, wire_refusal *why)
{
    TRY(check_name(name, text, why));
    if (strcmp(text, "group:") == 0) FAIL(WIRE_BAD_NAME, "%s is \"group:\" without the group's name", name);
    return WIRE_OK;
}

/* It names a DDS partition, where '*' would mean all of them, and an LCM channel, which is subscribed by a regular
 * expression. */
wire_reason check_stream(const char *text, wire_refusal *why)
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-:/";
    if (text && text[strspn(text, allowed)]) FAIL(WIRE_BAD_NAME, "stream: letters, digits and . _ - : / are allowed");
    return WIRE_OK;
}

wire_reason check_sender(int64_t client, int64_t sequence, wire_refusal *why)
{
    if (client == 0) FAIL(WIRE_UNKNOWN_CLIENT, "client_id is 0: any other number is allowed");
    return check_between("sequence", sequence, 1, INT64_MAX, why);
}

wire_reason check_rate(const char *name, double rate, wire_refusal *why)
{
    TRY(check_at_least(name, rate, 0, why));
    return check_magnitudes(name, (wire_f64s){1, &rate}, WIRE_SPEED_MAX, why);
}
