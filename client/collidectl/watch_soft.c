/* watch_soft: see watch_soft.h. */
#include "watch_soft.h"

#include "json.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

void watch_soft_text(void *context, const collided_soft_steps *steps)
{
    (void)context;
    for (size_t i = 0; i < steps->pair_count; i++) {
        const collided_soft_pair *p = &steps->pairs[i];
        printf("%12s %-8s %-24s %-24s frames %" PRId64 " %" PRId64 ": %" PRIu64 " vertex-face, %" PRIu64
               " edge-edge, %" PRIu64 " face-shape; free up to %.9g of the way%s%s",
            "", p->proposed ? "proposed" : "step", p->name_a, p->name_b, p->frame_a, p->frame_b, p->vertex_face,
            p->edge_edge, p->face_shape, p->safe_lo, p->within + p->undecided ? ", some as near as rounding tells" : "",
            p->unfinished ? ", UNFINISHED: the rest is unknown" : "");
        if (p->left_out) printf(", %" PRIu64 " left out", p->left_out);
        printf("\n");
    }
    fflush(stdout);
}

void watch_soft_json(void *context, const collided_soft_steps *steps)
{
    (void)context;
    for (size_t i = 0; i < steps->pair_count; i++) {
        const collided_soft_pair *p = &steps->pairs[i];
        json j = {.out = stdout};
        json_open(&j, NULL, '{');
        json_text(&j, "event", p->proposed ? "proposed" : "step");
        json_integer(&j, "tick", steps->tick);
        json_integer(&j, "stamp_ns", steps->stamp_ns);
        json_text(&j, "a", p->name_a);
        json_text(&j, "b", p->name_b);
        json_integer(&j, "contact", p->contact);
        json_integer(&j, "frame_a", p->frame_a);
        json_integer(&j, "frame_b", p->frame_b);
        json_integer(&j, "vertex_face", (int64_t)p->vertex_face);
        json_integer(&j, "edge_edge", (int64_t)p->edge_edge);
        json_integer(&j, "face_shape", (int64_t)p->face_shape);
        json_integer(&j, "within", (int64_t)p->within);
        json_integer(&j, "undecided", (int64_t)p->undecided);
        json_integer(&j, "left_out", (int64_t)p->left_out);
        json_bool(&j, "unfinished", p->unfinished);
        json_number(&j, "safe_lo", p->safe_lo);
        json_number(&j, "safe_hi", p->safe_hi);
        json_close(&j, '}');
        json_end_line(&j);
    }
    fflush(stdout);
}
