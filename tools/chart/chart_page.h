/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parts of the page of a chart.
 */
#ifndef TOOLS_CHART_CHART_PAGE_H
#define TOOLS_CHART_CHART_PAGE_H

#include "chart.h"
#include "common/svg.h"

/** Rows of one robot, size and right-hand side: one picture, with a front of its own */
typedef struct chart_panel {
    chart_row *rows; /**< copies, whose front is that of the panel */
    size_t *index;   /**< of each of them among all rows */
    size_t count;
} chart_panel;

/** All panels of a chart, in the order of their first rows */
typedef struct chart_panels {
    chart_panel *all;
    size_t count;
    chart_row *rows; /**< of all panels */
    size_t *index;
} chart_panels;

/** @return 0, or -1 without memory */
int chart_panels_make(chart_panels *p, const chart_row *rows, size_t count);
void chart_panels_free(chart_panels *p);
/** Shown before anything is filtered: of the first right-hand side. */
int chart_panel_first(const chart_panels *p, const chart_panel *panel);
/** "arm7, 7 bodies, qdd" */
void chart_panel_name(char *text, size_t size, const chart_panel *panel);

/** "aba+1 f32, 2 threads, batch" */
void chart_name_choice(char *text, size_t size, const chart_choice *choice);

/** Axes of all panels: the time of each panel, where they are too far apart for one axis. */
typedef struct chart_page_axes {
    svg_axis time, error;
    int shared;
} chart_page_axes;

chart_page_axes chart_page_axes_of(const chart_panels *p);
/** One picture */
void chart_page_scatter(FILE *out, const chart_page_axes *axes, const chart_panel *panel);
/** The methods and their marks */
void chart_page_legend(FILE *out, const chart_options *options);

/** The fastest row of those for which `fits` holds, or NULL */
const chart_row *chart_fastest(const chart_panel *panel, int (*fits)(const chart_row *row));
/** Exact to rounding: within ten times the floor of the data */
int chart_is_exact(const chart_row *row);
/** Title: the answer that is fastest among the exact ones */
void chart_page_title(char *text, size_t size, const chart_panels *p);
/** For each panel the answers to use and their times */
void chart_page_choices(FILE *out, const chart_panels *p);
/** All numbers */
void chart_page_numbers(FILE *out, const chart_row *rows, size_t count);

#endif
