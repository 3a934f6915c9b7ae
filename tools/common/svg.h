/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parts of inline SVG: axes, marks, text. Colours and fonts are classes of page.css.
 */
#ifndef TOOLS_COMMON_SVG_H
#define TOOLS_COMMON_SVG_H

#include <stddef.h>
#include <stdio.h>

/** Maps values from `low` to `high` to user units from `from` to `to`. */
typedef struct svg_axis {
    double low, high, from, to;
    int logarithmic;
} svg_axis;

/** Position of a value; a value outside has that of the nearer end. */
double svg_at(const svg_axis *axis, double value);

/** Text of a value on an axis */
typedef void svg_format(char *text, size_t size, double value);
/** 1e-8 as "10⁻⁸" */
svg_format svg_power;
/** 2500 as "2.5k" */
svg_format svg_number;
/** Microseconds as "20 ns", "0.5 µs", "3 ms" */
svg_format svg_microseconds;

/** An axis along the lower or the left edge of the rectangle, with lines across it. */
void svg_axis_x(FILE *out, const svg_axis *axis, double top, double bottom, svg_format *format);
void svg_axis_y(FILE *out, const svg_axis *axis, double left, double right, svg_format *format);

/** @param class of text: "tick", "end" (right-aligned), "label", ... */
void svg_text(FILE *out, double x, double y, const char *class, const char *text);

/** Begins a picture of that size, with the text for screen readers. */
void svg_begin(FILE *out, double width, double height, const char *class, const char *label);

#endif
