/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parts of inline SVG.
 */
#include "svg.h"
#include "html_page.h"

#include <math.h>
#include <string.h>

static double place(const svg_axis *a, double value)
{
    return a->logarithmic ? log10(fmax(value, 1e-300)) : value;
}

double svg_at(const svg_axis *a, double value)
{
    const double low = place(a, a->low), high = place(a, a->high);
    const double way = high > low ? (place(a, value) - low) / (high - low) : 0.5;
    return a->from + fmin(fmax(way, 0.0), 1.0) * (a->to - a->from);
}

void svg_power(char *text, size_t size, double value)
{
    static const char *const low[] = {"⁰", "¹", "²", "³", "⁴"};
    static const char *const high[] = {"⁵", "⁶", "⁷", "⁸", "⁹"};
    const int exponent = (int)lround(log10(value)), e = exponent < 0 ? -exponent : exponent;
    const int tens = e / 10 % 10, ones = e % 10;
    const char *sign = exponent < 0 ? "⁻" : "";
    if (exponent >= 0 && exponent <= 2)
        snprintf(text, size, "%g", value);
    else
        snprintf(text, size, "10%s%s%s", sign,
                 tens == 0  ? ""
                 : tens < 5 ? low[tens]
                            : high[tens - 5],
                 ones < 5 ? low[ones] : high[ones - 5]);
}

void svg_number(char *text, size_t size, double value)
{
    static const char *const units[] = {"", "k", "M", "G"};
    int unit = 0;
    for (; unit < 3 && fabs(value) >= 1e3; unit++)
        value /= 1e3;
    snprintf(text, size, "%.3g%s", value, units[unit]);
}

void svg_microseconds(char *text, size_t size, double value)
{
    static const char *const units[] = {"ns", "µs", "ms", "s"};
    int unit = value > 0.0 && value < 0.0995 ? 0 : 1;
    value *= unit == 0 ? 1e3 : 1.0;
    for (; unit < 3 && value >= 995.0; unit++)
        value /= 1e3;
    snprintf(text, size, value < 99.5 ? "%.2g %s" : "%.3g %s", value, units[unit]);
}

/* Calls `tick` at round values, on average at least `room` user units apart. */
static void each_tick(const svg_axis *a, double room, void (*tick)(void *data, double value),
                      void *data)
{
    static const double steps[] = {1.0, 2.0, 5.0};
    const double length = fabs(a->to - a->from);
    if (!a->logarithmic) {
        const double least = (a->high - a->low) * room / length;
        double step = pow(10.0, floor(log10(least)));
        for (int k = 1; step < least; k = (k + 1) % 3)
            step *= k == 2 ? 2.5 : 2.0;
        for (double at = ceil(a->low / step - 1e-9) * step; at <= a->high + 1e-9 * step; at += step)
            tick(data, fabs(at) < 1e-9 * step ? 0.0 : at);
        return;
    }
    const double decade = length / log10(a->high / a->low);
    const int every = (int)fmax(1.0, ceil(room / decade)), parts = decade >= 3.4 * room ? 3 : 1;
    for (int e = (int)floor(log10(a->low)); e <= (int)ceil(log10(a->high)); e++)
        for (int k = 0; k < parts; k++) {
            const double at = steps[k] * pow(10.0, e);
            if (e % every == 0 && at >= a->low * 0.999 && at <= a->high * 1.001)
                tick(data, at);
        }
}

typedef struct edge {
    FILE *out;
    const svg_axis *axis;
    double near, far; /* ends of the lines across */
    svg_format *format;
} edge;

static void tick_x(void *data, double value)
{
    const edge *e = data;
    char text[32];
    const double x = svg_at(e->axis, value);
    fprintf(e->out, "<path class=\"grid\" d=\"M%.1f %.1fV%.1f\"/>", x, e->near, e->far);
    e->format(text, sizeof text, value);
    svg_text(e->out, x, e->near + 14, "tick mid", text);
}

static void tick_y(void *data, double value)
{
    const edge *e = data;
    char text[32];
    const double y = svg_at(e->axis, value);
    fprintf(e->out, "<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", e->near, y, e->far);
    e->format(text, sizeof text, value);
    svg_text(e->out, e->near - 5, y + 3.5, "tick end", text);
}

void svg_axis_x(FILE *out, const svg_axis *axis, double top, double bottom, svg_format *format)
{
    edge e = {.out = out, .axis = axis, .near = bottom, .far = top, .format = format};
    each_tick(axis, 48, tick_x, &e);
    fprintf(out, "<path class=\"edge\" d=\"M%.1f %.1fH%.1f\"/>\n", axis->from, bottom, axis->to);
}

void svg_axis_y(FILE *out, const svg_axis *axis, double left, double right, svg_format *format)
{
    edge e = {.out = out, .axis = axis, .near = left, .far = right, .format = format};
    each_tick(axis, 24, tick_y, &e);
    fprintf(out, "<path class=\"edge\" d=\"M%.1f %.1fV%.1f\"/>\n", left, axis->from, axis->to);
}

void svg_text(FILE *out, double x, double y, const char *class, const char *text)
{
    fprintf(out, "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\">", class, x, y);
    html_text(out, text);
    fputs("</text>", out);
}

void svg_begin(FILE *out, double width, double height, const char *class, const char *label)
{
    fprintf(out,
            "<svg class=\"%s\" viewBox=\"0 0 %g %g\" role=\"img\" tabindex=\"0\" aria-label=\"",
            class, width, height);
    html_text(out, label);
    fputs("\">\n", out);
}
