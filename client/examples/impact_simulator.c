/* impact_simulator: rigid bodies whose impacts the collision daemon predicts, in lock-step with it: billiards, and a
 * stack of boxes. Shows prediction (COLLIDED_PREDICT) with its bracket, manifolds, stated accelerations, and a
 * simulation that two runs repeat bit for bit, over DDS as over LCM. At the end a summary tells what came of it, and
 * the exit status whether the bounds that it states were kept. One thread. */
#include "impact_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

/* Takes an option of this program's own out of the arguments: its value, or `otherwise`. */
static const char *take(int *argc, char **argv, const char *name, const char *otherwise)
{
    for (int i = 1; i + 1 < *argc; i++) {
        if (strcmp(argv[i], name) != 0) continue;
        const char *value = argv[i + 1];
        for (int k = i; k + 2 < *argc; k++) argv[k] = argv[k + 2];
        *argc -= 2;
        return value;
    }
    return otherwise;
}

static void summary(const example *e, const char *scene, const scene_result *r, const lockstep *l, double wall_s)
{
    double energy = r->elastic ? r->energy_change : r->energy_gain;
    double trips_a_step = (double)l->round_trips / (double)(r->advances ? r->advances : 1);
    bool holds = scene_holds(r, l);
    if (e->json)
        printf(
            "{\"event\":\"summary\",\"link\":\"%s\",\"scene\":\"%s\",\"hash\":\"%016llx\",\"holds\":%s,\"at_rest\":%s,"
            "\"time_s\":%.9g,\"steps\":%ld,\"impacts\":%ld,\"round_trips_per_step\":%.3f,\"steps_per_s\":%.0f,"
            "\"energy_first_j\":%.17g,\"energy_last_j\":%.17g,\"energy_error\":%.3g,\"energy_bound\":%.3g,"
            "\"momentum_error\":%.3g,\"momentum_bound\":%.3g,\"deepest_m\":%.3g,\"depth_bound_m\":%.3g}\n",
            e->link, scene, (unsigned long long)r->hash, holds ? "true" : "false", r->at_rest ? "true" : "false",
            r->time_s, r->advances, r->impacts, trips_a_step, (double)r->advances / wall_s, r->first_j, r->last_j,
            energy, r->energy_bound, r->momentum_change, r->momentum_bound, l->deepest_m, r->depth_bound_m);
    else
        printf("%s: %.3f s, %ld steps, %ld impacts, %s; hash %016llx\n"
               "energy %.6g -> %.6g J, worst %s %.2g (bound %.2g); momentum %.2g (bound %.2g); "
               "deepest %.2g m (bound %.2g m): %s\n%.0f steps/s, %.2f round trips a step\n",
            scene, r->time_s, r->advances, r->impacts, r->at_rest ? "at rest" : "still moving",
            (unsigned long long)r->hash, r->first_j, r->last_j, r->elastic ? "change" : "growth in a step", energy,
            r->energy_bound, r->momentum_change, r->momentum_bound, l->deepest_m, r->depth_bound_m,
            holds ? "all kept" : "BROKEN", (double)r->advances / wall_s, trips_a_step);
}

static bool draw(const char *path, const scene_result *r, const lockstep *l)
{
    FILE *out = fopen(path, "w");
    if (!out) return perror(path), false;
    scene_draw(r, l, out);
    return fclose(out) == 0;
}

static bool run(const char *scene, lockstep *l, double span_s, scene_result *r)
{
    if (strcmp(scene, "billiards") == 0)
        scene_billiards(l, span_s > 0 ? span_s : 3, false, r);
    else if (strcmp(scene, "break") == 0)
        scene_billiards(l, span_s > 0 ? span_s : 60, true, r);
    else if (strcmp(scene, "stack") == 0)
        scene_stack(l, span_s > 0 ? span_s : 5, r);
    else
        return false;
    return true;
}

int main(int argc, char **argv)
{
    const char *scene = take(&argc, argv, "--scene", "billiards"), *picture = take(&argc, argv, "--picture", NULL);
    char *rest;
    const double span_s = strtod(take(&argc, argv, "--simulate", "0"), &rest);
    if (*rest || !(span_s >= 0 && span_s <= 3600))
        return fprintf(stderr, "--simulate: seconds, up to 3600\n"), EX_USAGE;
    const example e = example_start(argc, argv);
    static lockstep l;
    if (!lockstep_connect(&l, &e)) return EX_UNAVAILABLE;
    scene_result r = {.tracks = picture ? malloc(TRACK_POINTS * sizeof(track_point)) : NULL};
    bool known = run(scene, &l, span_s, &r);
    if (known) summary(&e, scene, &r, &l, 1e-9 * (double)(example_now_ns() - l.begin_ns));
    if (!known) fprintf(stderr, "--scene %s: there are billiards, break and stack\n", scene);
    bool drawn = !known || !r.tracks || draw(picture, &r, &l);
    free(r.tracks);
    collided_close(l.client);
    return !known ? EX_USAGE : drawn && scene_holds(&r, &l) ? EX_OK : EX_SOFTWARE;
}
