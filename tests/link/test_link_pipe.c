/* The frames between daemon and gateway: whole or not at all, and safe with a peer that lies. */
#include "harness.h"

#include "pipe/pipe.h"

#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static void put_text(pipe_buffer *b, const char *channel, const char *text)
{
    size_t size = strlen(text); /* without its NUL */
    uint8_t *data = pipe_put(b, PIPE_MESSAGE, channel, size);
    for (size_t i = 0; i < size; i++) data[i] = (uint8_t)text[i];
}

static void assert_frame(const pipe_frame *f, const char *channel, const char *text)
{
    assert_int_equal(f->channel_length, strlen(channel));
    assert_memory_equal(f->channel, channel, strlen(channel));
    assert_int_equal(f->size, strlen(text));
    assert_memory_equal(f->data, text, strlen(text));
}

static void feed(pipe_buffer *to, const uint8_t *bytes, size_t count)
{
    int ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    assert_int_equal(write(ends[0], bytes, count), count);
    if (count) assert_int_equal(pipe_read(to, ends[1]), count);
    close(ends[0]);
    close(ends[1]);
}

static void frames_that_come_in_any_pieces_are_the_same_frames(void **state)
{
    (void)state;
    pipe_buffer whole = {0};
    put_text(&whole, "collided.in.Body", "first");
    put_text(&whole, "", "second, without a channel");
    for (size_t cut = 0; cut <= pipe_used(&whole); cut++) {
        pipe_buffer b = {0};
        pipe_frame f;
        size_t got = 0;
        feed(&b, whole.at, cut);
        for (; pipe_take(&b, &f) == 1; got++)
            assert_frame(&f, got ? "" : "collided.in.Body", got ? "second, without a channel" : "first");
        feed(&b, whole.at + cut, pipe_used(&whole) - cut);
        for (; pipe_take(&b, &f) == 1; got++)
            assert_frame(&f, got ? "" : "collided.in.Body", got ? "second, without a channel" : "first");
        assert_int_equal(got, 2);
        assert_int_equal(pipe_used(&b), 0);
        pipe_free(&b);
    }
    pipe_free(&whole);
}

static void what_a_dead_peer_had_half_of_is_sent_again_whole(void **state)
{
    (void)state;
    enum { SIZE = 1 << 20 };
    int ends[2];
    pipe_buffer out = {0}, in = {0};
    pipe_frame f;
    memset(pipe_put(&out, PIPE_MESSAGE, "small", 1), 'a', 1);
    memset(pipe_put(&out, PIPE_MESSAGE, "large", SIZE), 'b', SIZE);
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    assert_true(pipe_send(&out, ends[0])); /* takes the small one and a part of the large one */
    assert_true(pipe_used(&out) > 0 && out.sent > 0);
    close(ends[1]);
    assert_false(pipe_send(&out, ends[0]));
    close(ends[0]);

    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    pipe_resend(&out);
    while (pipe_used(&out) || pipe_used(&in) < pipe_frame_size(5, SIZE)) {
        assert_true(pipe_send(&out, ends[0]));
        assert_true(pipe_read(&in, ends[1]) >= 0);
    }
    assert_int_equal(pipe_take(&in, &f), 1);
    assert_int_equal(f.size, SIZE);
    assert_int_equal(f.data[SIZE - 1], 'b');
    assert_int_equal(pipe_take(&in, &f), 0);
    close(ends[0]);
    close(ends[1]);
    pipe_free(&out);
    pipe_free(&in);
}

static int taken_from(const uint8_t *bytes, size_t count)
{
    pipe_buffer b = {0};
    pipe_frame f;
    feed(&b, bytes, count);
    int got = pipe_take(&b, &f);
    pipe_free(&b);
    return got;
}

static void what_is_no_frame_is_told_from_what_is_not_whole(void **state)
{
    (void)state;
    const uint8_t huge[] = {0xff, 0xff, 0xff, 0xff, PIPE_MESSAGE, 0};
    const uint8_t tiny[] = {1, 0, 0, 0, PIPE_MESSAGE};
    const uint8_t unknown[] = {2, 0, 0, 0, 9, 0};
    const uint8_t channel_beyond[] = {4, 0, 0, 0, PIPE_MESSAGE, 3, 'a', 'b'};
    const uint8_t long_channel[80] = {76, 0, 0, 0, PIPE_MESSAGE, 70};
    const uint8_t half[] = {9, 0, 0, 0, PIPE_MESSAGE, 3, 'a', 'b', 'c'};
    assert_int_equal(taken_from(huge, sizeof huge), -1);
    assert_int_equal(taken_from(tiny, sizeof tiny), -1);
    assert_int_equal(taken_from(unknown, sizeof unknown), -1);
    assert_int_equal(taken_from(channel_beyond, sizeof channel_beyond), -1);
    assert_int_equal(taken_from(long_channel, sizeof long_channel), -1);
    assert_int_equal(taken_from(half, sizeof half), 0);
    assert_int_equal(taken_from(half, 3), 0);
}

static bool passes(const pipe_refusal *r, pipe_refusal *out)
{
    pipe_buffer b = {0};
    pipe_frame f;
    pipe_put_refusal(&b, r);
    bool ok = pipe_take(&b, &f) == 1 && pipe_get_refusal(&f, out);
    pipe_free(&b);
    return ok;
}

static void a_refusal_passes_and_one_out_of_range_does_not(void **state)
{
    (void)state;
    pipe_refusal out = {0};
    pipe_refusal good = {.kind = WIRE_BODY, .reason = WIRE_BAD_SIZE, .client = 7, .sequence = 8, .text = "too flat"};
    pipe_refusal kind = good, reason = good, endless = good;
    assert_true(passes(&good, &out));
    assert_int_equal(out.sequence, 8);
    assert_string_equal(out.text, "too flat");
    kind.kind = WIRE_KIND_COUNT;
    reason.reason = -1;
    memset(endless.text, 'x', sizeof endless.text);
    assert_false(passes(&kind, &out));
    assert_false(passes(&reason, &out));
    assert_true(passes(&endless, &out));
    assert_int_equal(strlen(out.text), sizeof out.text - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_that_come_in_any_pieces_are_the_same_frames),
        cmocka_unit_test(what_a_dead_peer_had_half_of_is_sent_again_whole),
        cmocka_unit_test(what_is_no_frame_is_told_from_what_is_not_whole),
        cmocka_unit_test(a_refusal_passes_and_one_out_of_range_does_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
