#include "samples.h"

#include <stdio.h>
#include <stdlib.h>

unsigned samples_each(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 2000 : getenv("COLLIDED_BRIEF") ? 8 : 200;
}

static double reach_of(const shape *s)
{
    double reach = shape_reach(s);
    return isfinite(reach) ? reach : 0;
}

void sample_measure(sample *s)
{
    s->size = reach_of(&s->a) + reach_of(&s->b) + vec_norm(vec_sub(s->pa.p, s->pb.p));
    s->ulp = nextafter(s->size, INFINITY) - s->size;
}

sample sample_of(int type_a, int type_b, unsigned i)
{
    random_state r = {((uint64_t)type_a << 40) + ((uint64_t)type_b << 32) + i + 90210};
    sample s;
    s.a = random_shape(&r, (shape_type)type_a);
    s.b = random_shape(&r, (shape_type)type_b);
    random_poses(&r, &s.a, &s.b, (enum regime)(i % REGIME_COUNT), &s.pa, &s.pb);
    sample_measure(&s);
    return s;
}

static bool flat(const shape *s)
{
    return s->type == SHAPE_BOX || s->type == SHAPE_HULL || s->type == SHAPE_HALFSPACE;
}

double sample_slack(const sample *s, const narrow_result *r)
{
    return (r->lo > 0 || (flat(&s->a) && flat(&s->b)) ? 4 : 16) * s->ulp;
}

bool sample_agrees(const narrow_result *x, const narrow_result *y, double slack)
{
    static unsigned long asked, early;
    double change = fabs(middle(x) - middle(y)), widths = 0.5 * (x->hi - x->lo + y->hi - y->lo);
    asked++;
    if (change <= slack) return true;
    return change <= slack + widths && ++early <= 6 + asked * 2 / 10000;
}

const char *sample_name(const sample *s)
{
    static char text[64];
    snprintf(text, sizeof text, "%s-%s", shape_type_name(s->a.type), shape_type_name(s->b.type));
    return text;
}

narrow_result sample_ask(const sample *s)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    narrow_query_world(&s->a, s->pa, &s->b, s->pb, &request, case_scratch(), &r);
    return r;
}

double middle(const narrow_result *r)
{
    return r->lo + 0.5 * (r->hi - r->lo);
}
