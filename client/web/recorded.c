/* recorded: a recording in place of a daemon (--file): the replay, which is a child of this process, and what pages ask
 * of it. To go back is to begin anew: the replay is the same each time. While a place is sought nobody observes, so
 * that nothing is computed for what is passed over. One thread. */
#include "web.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

/* Farther ahead than that, what lies between is passed over, and not told. */
static const int64_t TOLD_NS = 2000000000;

static int fail_recorded(const char *what, const char *why)
{
    fprintf(stderr, "collided-web: %s: %s\n", what, why);
    return EX_UNAVAILABLE;
}

/* Starts the replay, goes to that stamp, and connects. EX_OK, or a status after saying why not. */
static int start_replay(web *w, int64_t at_ns)
{
    char program[PLAYBACK_PROGRAM_MAX], why[256];
    playback *p = &w->replay;
    playback_program(program);
    if (!playback_open(p, program, w->options.file, 0, why, sizeof why)) {
        int status = playback_close(p); /* it has said why, unless we do */
        return *why ? fail_recorded(w->options.file, why) : status ? status : EX_SOFTWARE;
    }
    if (at_ns > p->at_ns) playback_seek(p, at_ns);
    while (!playback_rests(p) && !p->gone) {
        (void)poll(&(struct pollfd){.fd = p->answers, .events = POLLIN}, 1, -1);
        playback_poll(p);
    }
    collided_def def = collided_def_default();
    def.name = w->options.name;
    def.connect_timeout_s = 0;
    def.lease_s = 3600;
    w->client = collided_connect(playback_take_uri(p), &def);
    if (!w->client) return fail_recorded(w->options.file, collided_connect_error());
    w->client_fd = dup(collided_fd(w->client));
    w->replay_fd = dup(p->answers);
    return w->client_fd >= 0 && w->replay_fd >= 0 ? EX_OK : fail_recorded(w->options.file, strerror(errno));
}

int recorded_open(web *w)
{
    int status = start_replay(w, 0);
    if (status == EX_OK && *w->replay.damaged)
        fprintf(
            stderr, "collided-web: %s: damaged: %s: what comes before is shown\n", w->options.file, w->replay.damaged);
    return status;
}

void recorded_close(web *w)
{
    if (w->options.file) (void)playback_close(&w->replay);
}

static void begin_anew(web *w, int64_t at_ns)
{
    double speed = w->replay.speed;
    bool plays = w->replay.state == PLAYBACK_PLAYING;
    web_unwatch(w);
    collided_close(w->client);
    w->client = NULL;
    (void)playback_close(&w->replay);
    w->observes = w->watches = false;
    if (start_replay(w, at_ns) != EX_OK || !web_watch(w)) {
        w->stop = true;
        return;
    }
    if (plays) playback_play(&w->replay, speed);
    feed_watch(w);
}

void recorded_control(web *w, const request *q)
{
    double speed = isnan(q->speed) ? w->replay.speed : q->speed;
    if (!(speed > 0)) speed = 1;
    if (strcmp(q->what, "seek") == 0 && q->has & REQUEST_HAS_AT_NS) {
        w->seeks = true; /* the last of many that come while a slider is dragged */
        w->seek_ns = q->at_ns;
    }
    if (strcmp(q->what, "pause") == 0) playback_pause(&w->replay);
    if (strcmp(q->what, "step") == 0) playback_step(&w->replay);
    if (strcmp(q->what, "play") == 0 && w->replay.state == PLAYBACK_ENDED) w->seeks = true, w->seek_ns = 0;
    if (strcmp(q->what, "play") == 0) w->plays = true, w->play_speed = speed;
    if (strcmp(q->what, "speed") == 0 && w->replay.state == PLAYBACK_PLAYING) playback_play(&w->replay, speed);
}

void recorded_tend(web *w)
{
    if (!w->options.file || !w->client) return;
    playback_state before = w->replay.state;
    playback_poll(&w->replay);
    if (w->replay.gone) {
        (void)fail_recorded(w->options.file, "the replay has ended");
        w->stop = true;
        return;
    }
    if (w->seeks) {
        int64_t ahead = w->seek_ns - w->replay.at_ns;
        w->seeks = false;
        if (ahead < 0 || ahead > TOLD_NS)
            begin_anew(w, w->seek_ns);
        else
            playback_seek(&w->replay, w->seek_ns);
    }
    if (w->plays && !w->stop) playback_play(&w->replay, w->play_speed);
    w->plays = false;
    if (w->replay.state != before || w->replay.at_ns != w->told_ns) viewer_second(w);
    w->told_ns = w->replay.at_ns;
}
