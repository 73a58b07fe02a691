/* fit_write: the scene of a fitted robot. Numbers have 17 digits, so that they are read back as they are; texts are
 * written as JSON's, which YAML reads, too. */
#include "fit_robot.h"

#include <stdlib.h>
#include <string.h>

static void write_text(FILE *out, const char *text)
{
    putc('"', out);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c == '"' || *c == '\\')
            fprintf(out, "\\%c", *c);
        else if (*c < ' ')
            fprintf(out, "\\x%02x", *c);
        else
            putc(*c, out);
    }
    putc('"', out);
}

/* Whole, if the file is there. */
static void write_path(FILE *out, const char *path)
{
    char *whole = realpath(path, NULL);
    write_text(out, whole ? whole : path);
    free(whole);
}

static void write_numbers(FILE *out, const double *numbers, int count)
{
    putc('[', out);
    for (int i = 0; i < count; i++) fprintf(out, "%s%.17g", i ? ", " : "", numbers[i]);
    putc(']', out);
}

static void write_points(FILE *out, const mesh_points *points)
{
    fputs("\n            points: [", out);
    for (size_t i = 0; i < points->count; i++) {
        fputs(i == 0 ? "" : i % 3 ? ", " : ",\n              ", out);
        write_numbers(out, points->at + 3 * i, 3);
    }
    putc(']', out);
}

static void write_sizes(FILE *out, const load_shape *from)
{
    const collided_shape *s = &from->shape;
    double sides[3] = {2 * s->half[0], 2 * s->half[1], 2 * s->half[2]}, rounding = s->radius;
    switch (s->type) {
    case COLLIDED_SPHERE:
        fprintf(out, "sphere, radius: %.17g", s->radius);
        rounding = 0;
        break;
    case COLLIDED_CAPSULE:
        fprintf(out, "capsule, radius: %.17g, length: %.17g", s->radius, sides[2]);
        rounding = 0;
        break;
    case COLLIDED_BOX:
        fputs("box, size: ", out);
        write_numbers(out, sides, 3);
        break;
    case COLLIDED_CYLINDER:
        fprintf(out, "cylinder, radius: %.17g, height: %.17g", s->half[0], sides[2]);
        break;
    case COLLIDED_MESH:
        fputs("mesh, mesh: ", out);
        write_path(out, from->mesh);
        fputs(", scale: ", out);
        write_numbers(out, from->scale, 3);
        break;
    default: /* a URDF and the fit have no others */
        fputs("hull", out);
        break;
    }
    if (rounding > 0) fprintf(out, ", rounding: %.17g", rounding);
    if (s->deviation > 0) fprintf(out, ", deviation: %.17g", s->deviation);
}

static void write_shape(FILE *out, const load_shape *s)
{
    const collided_pose *pose = &s->shape.pose;
    fputs("          - {type: ", out);
    write_sizes(out, s);
    fputs(",\n            pose: {position: ", out);
    write_numbers(out, pose->position, 3);
    fputs(", orientation: ", out);
    write_numbers(out, pose->orientation, 4);
    putc('}', out);
    if (s->shape.type == COLLIDED_HULL) {
        putc(',', out);
        write_points(out, &s->points);
    }
    fputs("}\n", out);
}

static void write_links(FILE *out, const fit_robot *f)
{
    fputs("    links:\n", out);
    for (size_t i = 0; i < f->link_count; i++) {
        const fit_link *l = &f->links[i];
        if (l->how == FIT_AS_IT_WAS) continue; /* the URDF says it */
        fputs("      - name: ", out);
        write_text(out, l->name);
        if (l->how == FIT_MESH)
            fprintf(out, " # its mesh, %s\n", l->note);
        else
            fprintf(out, " # exceeds the link by at most %.4g mm\n", 1e3 * l->excess_m);
        fputs("        shapes:\n", out);
        for (size_t k = 0; k < l->shape_count; k++) write_shape(out, &l->shapes[k]);
    }
}

static void write_apart(FILE *out, const fit_robot *f)
{
    fputs("    apart:\n", out);
    for (size_t i = 0; i < f->pair_count; i++) {
        const fit_pair *p = &f->pairs[i];
        if (p->answer.verdict != NEVER_PROVEN) continue;
        fputs("      - {link1: ", out);
        write_text(out, f->links[p->a].name);
        fputs(", link2: ", out);
        write_text(out, f->links[p->b].name);
        double mm = 1e3 * p->answer.clearance_m;
        fputs(", reason: \"proven: never meet within the joint limits", out);
        if (mm >= 0.1) fprintf(out, ", at least %.3g mm apart", mm);
        fputs("\"}\n", out);
    }
}

static bool has_fit(const fit_robot *f)
{
    for (size_t i = 0; i < f->link_count; i++)
        if (f->links[i].how != FIT_AS_IT_WAS) return true;
    return false;
}

static bool has_apart(const fit_robot *f)
{
    for (size_t i = 0; i < f->pair_count; i++)
        if (f->pairs[i].answer.verdict == NEVER_PROVEN) return true;
    return false;
}

void fit_robot_write(FILE *out, const fit_robot *f, double excess_m)
{
    const robot_source *s = &f->robot->source;
    fprintf(out,
        "# Made by collidectl fit: shapes that hold the links of %s and exceed them by at most %g m, and\n"
        "# pairs of links that never meet while the joints keep their limits.\nrobots:\n  - urdf: ",
        f->robot->model.name, excess_m);
    write_path(out, s->urdf);
    if (s->srdf) {
        fputs("\n    srdf: ", out);
        write_path(out, s->srdf);
    }
    fputs("\n    meshes: solid\n", out);
    if (s->package_count > 0) fputs("    packages:\n", out);
    for (size_t i = 0; i < s->package_count; i++) {
        fputs("      - {name: ", out);
        write_text(out, s->packages[i].name);
        fputs(", path: ", out);
        write_path(out, s->packages[i].path);
        fputs("}\n", out);
    }
    if (has_fit(f)) write_links(out, f);
    if (has_apart(f)) write_apart(out, f);
}
