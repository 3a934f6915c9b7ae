/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One picture of the page: marks, front, labels.
 */
#include "chart_page.h"
#include "common/html_page.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* User units */
#define WIDE 400.0
#define HIGH 290.0
#define LEFT 38.0
#define RIGHT (WIDE - 10.0)
#define TOP 26.0 /* below the axis' title */
#define BOTTOM (HIGH - 34.0)
/* More than this between the shortest and the longest time: no axis for all panels */
#define SHARED_RANGE 2e3

/* A colour (--c0 .. of page.css) and a shape (svg_shape) for each method: a shape for a family */
static const struct {
    const char *method;
    unsigned colour, shape;
} marks[] = {{"aba", 0, 0},
             {"auto", 1, 6},
             {"crba", 2, 1},
             {"tfa", 3, 2},
             {"tfa-cr", 4, 2},
             {"hessenberg", 5, 5},
             {"cfa", 6, 4},
             {"cfa-cr", 7, 4},
             {"dca", 8, 8},
             {"scan", 9, 3},
             {"scan-two-pass", 10, 3},
             {"propagation", 3, 0},
             {"efpa", 13, 0},
             {"pv-osimr", 6, 0},
             {"tfa-one-sided", 9, 2},
             {"mujoco", 11, 7},
             {"kdl", 12, 8}};

static void find_mark(const char *method, unsigned *colour, unsigned *shape)
{
    *colour = 13;
    *shape = 1;
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++)
        if (strcmp(marks[i].method, method) == 0) {
            *colour = marks[i].colour;
            *shape = marks[i].shape;
        }
}

void chart_name_choice(char *text, size_t size, const chart_choice *choice)
{
    static const char *const steps[CHART_REFINE] = {"", "+1", "+2"};
    const int plain = choice->precision == CHART_F64;
    chart_choice named = *choice;
    char how[96];
    named.op = CHART_FORWARD; /* the panel names the op */
    snprintf(text, size, "%s%s%s%s%s", chart_method_name(choice->method), steps[choice->refine],
             plain ? "" : " ", plain ? "" : chart_precision_words[choice->precision],
             chart_name_how(&named, 0, how, sizeof how));
}

static void extend_by_panel(chart_range *times, chart_range *errors, const chart_panel *panel)
{
    for (size_t i = 0; i < panel->count; i++) {
        const chart_row *row = &panel->rows[i];
        if (!chart_row_drawn(row))
            continue;
        chart_range_extend(times, row->time_low);
        chart_range_extend(times, row->time_high);
        chart_range_extend(errors, chart_draw_error(row->error_low));
        chart_range_extend(errors, chart_draw_error(row->error_high));
        chart_range_extend(errors, chart_draw_floor(row));
    }
}

static svg_axis time_axis(const chart_range *times)
{
    const int empty = times->high <= 0.0;
    return (svg_axis){.low = empty ? 1.0 : times->low / 1.3,
                      .high = empty ? 10.0 : times->high * 1.3,
                      .from = LEFT,
                      .to = RIGHT,
                      .logarithmic = 1};
}

chart_page_axes chart_page_axes_of(const chart_panels *p)
{
    chart_range times = {0}, errors = {0};
    for (size_t k = 0; k < p->count; k++)
        extend_by_panel(&times, &errors, &p->all[k]);
    const int empty = errors.high <= 0.0;
    const svg_axis error = {
        .low = empty ? 1e-16 : fmax(CHART_ERROR_MIN, pow(10.0, floor(log10(errors.low) - 0.3))),
        .high = empty ? 1.0 : pow(10.0, ceil(log10(errors.high) + 1.5)),
        .from = BOTTOM,
        .to = TOP,
        .logarithmic = 1};
    return (chart_page_axes){
        .time = time_axis(&times), .error = error, .shared = times.high < SHARED_RANGE * times.low};
}

static void write_bars(FILE *out, const chart_page_axes *axes, const chart_row *row, double x,
                       double y)
{
    const double left = svg_at(&axes->time, row->time_low) - x,
                 right = svg_at(&axes->time, row->time_high) - x,
                 low = svg_at(&axes->error, row->error_low) - y,
                 high = svg_at(&axes->error, row->error_high) - y;
    if (right - left > 1.0 || low - high > 1.0)
        fprintf(out, "<path class=\"bar\" d=\"M%.1f 0H%.1fM0 %.1fV%.1f\"/>", left, right, low,
                high);
}

static void write_mark(FILE *out, const chart_page_axes *axes, const chart_row *row, size_t index)
{
    char name[128], time[32];
    unsigned colour, shape;
    const double x = svg_at(&axes->time, row->time), y = svg_at(&axes->error, row->error);
    find_mark(chart_method_name(row->choice.method), &colour, &shape);
    chart_name_choice(name, sizeof name, &row->choice);
    svg_microseconds(time, sizeof time, row->time);
    fprintf(out,
            "<g class=\"m k%u\" transform=\"translate(%.1f %.1f)\" data-r=\"%zu\" data-l=\"%s\" "
            "data-t=\"%s %s\">",
            colour, x, y, index, name, name, time);
    write_bars(out, axes, row, x, y);
    fprintf(out, "<path%s d=\"%s\"/></g>\n", row->choice.refine > 0 ? " class=\"f\"" : "",
            svg_shape(shape));
}

typedef struct front_point {
    double x, y, time;
    char text[160];
} front_point;

static int compare_times(const void *a, const void *b)
{
    const front_point *p = a, *q = b;
    return (p->time > q->time) - (p->time < q->time);
}

enum { FRONT_POINTS = 64 };

static size_t find_front(front_point *points, const chart_page_axes *axes, const chart_panel *panel)
{
    size_t n = 0;
    for (size_t i = 0; i < panel->count && n < FRONT_POINTS; i++) {
        const chart_row *row = &panel->rows[i];
        char name[96], time[32];
        if (!row->front)
            continue;
        chart_name_choice(name, sizeof name, &row->choice);
        svg_microseconds(time, sizeof time, row->time);
        points[n] = (front_point){.x = svg_at(&axes->time, row->time),
                                  .y = svg_at(&axes->error, row->error),
                                  .time = row->time};
        snprintf(points[n++].text, sizeof points->text, "%s %s", name, time);
    }
    qsort(points, n, sizeof *points, compare_times);
    return n;
}

typedef struct box {
    double left, right, y; /* y: of the text's line */
} box;

enum { MARKS = 1024 };

/* Obstacles of labels: the marks, of which those beyond MARKS do not count, and labels */
typedef struct obstacles {
    box marks[MARKS], labels[FRONT_POINTS];
    size_t mark_count, label_count;
} obstacles;

static int meets(const box *taken, size_t count, const box *b, double room)
{
    for (size_t i = 0; i < count; i++)
        if (b->left < taken[i].right && b->right > taken[i].left && fabs(b->y - taken[i].y) < room)
            return 1;
    return 0;
}

static void find_obstacles(obstacles *o, const chart_page_axes *axes, const chart_panel *panel)
{
    o->mark_count = o->label_count = 0;
    for (size_t i = 0; i < panel->count && o->mark_count < MARKS; i++) {
        const chart_row *row = &panel->rows[i];
        const double x = svg_at(&axes->time, row->time), y = svg_at(&axes->error, row->error);
        if (chart_row_drawn(row))
            o->marks[o->mark_count++] = (box){.left = x - 5.0, .right = x + 5.0, .y = y + 4.0};
    }
}

/* The nearest height above the point (below it where there is no room) without labels, and without
 * marks if there is one */
static double find_height(const obstacles *o, const front_point *p, box b)
{
    const double step = p->y - 13.0 > TOP ? -6.5 : 6.5, from = p->y + (step < 0.0 ? -10.0 : 20.0);
    double found = from;
    int least = 3;
    for (b.y = from; b.y > TOP && b.y < BOTTOM && least > 0; b.y += step) {
        const int cost = 2 * meets(o->labels, o->label_count, &b, 13.0) +
                         meets(o->marks, o->mark_count, &b, 11.0);
        if (cost < least) {
            least = cost;
            found = b.y;
        }
    }
    return found;
}

static size_t letters(const char *text)
{
    size_t count = 0;
    for (; *text; text++)
        count += (*text & 0xc0) != 0x80; /* of UTF-8 */
    return count;
}

/* Labels from the right to the left; page.js does the same when rows are filtered. */
static void write_labels(FILE *out, obstacles *o, const front_point *points, size_t count)
{
    fputs("<g class=\"labels\">", out);
    for (size_t i = count; i-- > 0;) {
        const front_point *p = &points[i];
        const double width = 5.9 * (double)letters(p->text);
        const int end = p->x + width > RIGHT;
        box b = {.left = end ? p->x - width : p->x - 3.0};
        b.right = b.left + width;
        b.y = find_height(o, p, b);
        if (b.y < p->y - 11.0 || b.y > p->y + 21.0)
            fprintf(out, "<path class=\"lead\" d=\"M%.1f %.1fV%.1f\"/>", p->x,
                    p->y + (b.y < p->y ? -5.0 : 5.0), b.y + (b.y < p->y ? 3.0 : -9.0));
        svg_text(out, end ? p->x + 3.0 : b.left, b.y, end ? "label-end" : "label", p->text);
        o->labels[o->label_count++] = b;
    }
    fputs("</g>\n", out);
}

static void write_front(FILE *out, const front_point *points, size_t count)
{
    fprintf(out, "<g class=\"front\" data-top=\"%g\" data-bottom=\"%g\" data-right=\"%g\">", TOP,
            BOTTOM, RIGHT);
    if (count > 0) {
        fprintf(out, "<path d=\"M%.1f %.1f", points->x, TOP);
        for (size_t i = 0; i < count; i++) {
            if (i > 0)
                fprintf(out, "H%.1f", points[i].x);
            fprintf(out, "V%.1f", points[i].y);
        }
        fprintf(out, "H%.1f\"/>", RIGHT);
    }
    fputs("</g>\n", out);
}

static void write_marks(FILE *out, const chart_page_axes *axes, const chart_panel *panel)
{
    front_point points[FRONT_POINTS];
    obstacles around;
    const size_t count = find_front(points, axes, panel);
    find_obstacles(&around, axes, panel);
    fprintf(out, "<path class=\"floor\" d=\"M%.1f %.1fH%.1f\"/>\n", LEFT,
            svg_at(&axes->error, chart_draw_floor(panel->rows)), RIGHT);
    write_front(out, points, count);
    for (size_t i = 0; i < panel->count; i++)
        if (chart_row_drawn(&panel->rows[i]))
            write_mark(out, axes, &panel->rows[i], panel->index[i]);
    write_labels(out, &around, points, count);
}

void chart_page_scatter(FILE *out, const chart_page_axes *shared, const chart_panel *panel)
{
    chart_page_axes axes = *shared;
    char name[128], label[256];
    if (!axes.shared) {
        chart_range times = {0}, errors = {0};
        extend_by_panel(&times, &errors, panel);
        axes.time = time_axis(&times);
    }
    chart_panel_name(name, sizeof name, panel);
    snprintf(label, sizeof label, "Error against time: %s; the numbers are in the table below",
             name);
    svg_begin(out, WIDE, HIGH, "scatter", label);
    svg_axis_x(out, &axes.time, TOP, BOTTOM, svg_microseconds);
    svg_axis_y(out, &axes.error, LEFT, RIGHT, svg_power);
    svg_text(out, RIGHT, HIGH - 6.0, "end", "time of a state");
    svg_text(out, 0.0, 10.0, "tick", "relative error");
    write_marks(out, &axes, panel);
    fputs("</svg>\n", out);
}

void chart_page_legend(FILE *out, const chart_options *o)
{
    fputs("<ul class=\"legend\">\n", out);
    for (uint32_t m = 0; m < o->method_count; m++) {
        const char *name = chart_method_name(o->methods[m]);
        unsigned colour, shape;
        find_mark(name, &colour, &shape);
        fprintf(out,
                "<li data-k=\"method\" data-v=\"%s\"><svg viewBox=\"-7 -7 14 14\" "
                "class=\"m k%u\" aria-hidden=\"true\"><path d=\"%s\"/></svg>%s</li>\n",
                name, colour, svg_shape(shape), name);
    }
    fputs("</ul>\n", out);
}
