/* billiards_picture: the balls' tracks over the table as SVG. One thread. */
#include "impact_scene.h"

static const double SCALE = 300, BORDER = 30; /* pixels a metre; pixels */

static double across(double x)
{
    return BORDER + SCALE * (x + TABLE_X);
}

static double down(double y)
{
    return BORDER + SCALE * (TABLE_Y - y);
}

static const char *colour(int ball)
{
    static const char *const COLOURS[] = {
        "#ffffff", "#f2c14e", "#4f86f7", "#e4572e", "#9b5de5", "#f79256", "#8ac926", "#a4343a", "#222222"};
    return COLOURS[ball == 0 ? 0 : 1 + (ball - 1) % 8];
}

static void draw_track(const scene_result *r, int ball, FILE *out)
{
    fprintf(out, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"%s\" stroke-opacity=\"0.8\" points=\"",
        colour(ball), ball == 0 ? "2" : "1");
    double last[2] = {-1e9, -1e9};
    for (size_t i = 0; i < r->track_count; i++) {
        const track_point *p = &r->tracks[i];
        double at[2] = {across(p->x), down(p->y)};
        double dx = at[0] - last[0], dy = at[1] - last[1];
        if (p->body != ball || dx * dx + dy * dy < 4) continue;
        fprintf(out, "%.1f,%.1f ", at[0], at[1]);
        last[0] = at[0];
        last[1] = at[1];
    }
    fputs("\"/>\n", out);
}

void scene_draw(const scene_result *r, const lockstep *l, FILE *out)
{
    double width = 2 * (SCALE * TABLE_X + BORDER), height = 2 * (SCALE * TABLE_Y + BORDER);
    fprintf(out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\">\n"
        "<rect width=\"%.0f\" height=\"%.0f\" fill=\"#5b3a1e\"/>\n"
        "<rect x=\"%.0f\" y=\"%.0f\" width=\"%.0f\" height=\"%.0f\" fill=\"#1f6f4a\"/>\n",
        width, height, width, height, BORDER, BORDER, 2 * SCALE * TABLE_X, 2 * SCALE * TABLE_Y);
    for (int i = (int)l->moving - 1; i >= 0; i--) draw_track(r, i, out);
    for (size_t i = 0; i < l->moving; i++)
        fprintf(out,
            "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\" stroke=\"#000000\" stroke-width=\"0.5\"/>\n",
            across(l->bodies[i].position.x), down(l->bodies[i].position.y), SCALE * BALL_RADIUS, colour((int)i));
    fputs("</svg>\n", out);
}
