#include "elementary_judge.h"

#include <stdio.h>

elementary_result elementary_ask(const elementary_query *q, double separation)
{
    elementary_result r;
    if (q->kind == ELEMENTARY_VF)
        elementary_vertex_face(q->start, q->end, separation, &r);
    else
        elementary_edge_edge(q->start, q->end, separation, &r);
    return r;
}

enum { MOMENTS = 8 };

/* Is any time that the answer calls free, of some, one at which they are within the separation? Exactly. */
static bool near_while_free(const elementary_query *q, double separation, const elementary_result *r)
{
    bool free = r->status == ELEMENTARY_FREE;
    for (int i = 0; i <= MOMENTS; i++) {
        double t = free ? (double)i / MOMENTS : r->t_lo * i / MOMENTS;
        if ((free || t < r->t_lo) && elementary_oracle_within(q, t, separation)) return true;
    }
    return false;
}

static const char *fault_of_hit(
    const elementary_query *q, double separation, const elementary_result *r, const elementary_truth *truth)
{
    bool contact = truth->touches && truth->lo <= r->t_hi;
    if (!(0 <= r->t_lo && r->t_lo <= r->t_hi && r->t_hi <= 1)) return "no bracket";
    if (truth->touches && r->t_lo > truth->hi) return "late";
    if (r->proof == ELEMENTARY_CERTAIN) {
        if (r->gap != 0) return "certain, and yet a gap";
        if (!contact && !(separation > 0 && elementary_oracle_within(q, r->t_hi, separation)))
            return "certain, but no contact by then";
        return NULL;
    }
    if (r->t_hi != r->t_lo) return "a bracket without a proof";
    if (!elementary_oracle_within(q, r->t_hi, separation + r->gap)) return "farther than the gap says";
    return NULL;
}

const char *elementary_fault(
    const elementary_query *q, double separation, const elementary_result *r, const elementary_truth *truth)
{
    if (separation > 0 && near_while_free(q, separation, r)) return "near, and called free";
    if (r->steps > ELEMENTARY_STEPS_MAX) return "more steps than there may be";
    if (r->status == ELEMENTARY_HIT) return fault_of_hit(q, separation, r, truth);
    if (truth->touches) return "missed";
    return r->proof == ELEMENTARY_CERTAIN && r->t_lo == 1 && r->t_hi == 1 && r->gap == 0 ? NULL
                                                                                         : "free, with conditions";
}

void elementary_count(elementary_tally *t, const elementary_result *r, const elementary_truth *truth)
{
    bool hit = r->status == ELEMENTARY_HIT;
    t->queries++, t->contacts += truth->touches, t->hits += hit, t->steps += (size_t)r->steps;
    t->certain += hit && r->proof == ELEMENTARY_CERTAIN;
    t->within += r->proof == ELEMENTARY_WITHIN;
    t->undecided += r->proof == ELEMENTARY_UNDECIDED;
    t->false_hits += hit && !truth->touches;
    if (hit && r->t_hi - r->t_lo > t->widest) t->widest = r->t_hi - r->t_lo;
}

void elementary_print_tally(const char *name, const elementary_tally *t)
{
    printf("%-14s %7zu queries, %6zu contacts, %6zu hits: %6zu certain, %6zu within, %4zu undecided; %5zu false; "
           "%.2f steps; widest bracket %.2g\n",
        name, t->queries, t->contacts, t->hits, t->certain, t->within, t->undecided, t->false_hits,
        (double)t->steps / (double)t->queries, t->widest);
}

void elementary_print(const elementary_query *q, const elementary_result *r, const elementary_truth *truth)
{
    printf("%s: status %d, proof %d, [%.17g, %.17g], gap %g, %d steps; truth %d [%.17g, %.17g]\n",
        q->kind == ELEMENTARY_VF ? "VF" : "EE", r->status, r->proof, r->t_lo, r->t_hi, r->gap, r->steps, truth->touches,
        truth->lo, truth->hi);
    for (int i = 0; i < 8; i++) {
        vec3 p = i < 4 ? q->start[i] : q->end[i - 4];
        printf("  %a %a %a\n", p.x, p.y, p.z);
    }
}
