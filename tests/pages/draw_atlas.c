/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page of an atlas whose rows stand in a file.
 *
 *   draw_atlas ROWS.csv PAGE.html
 */
#include "atlas/atlas.h"
#include "common/html_page.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_MAX = 1024 };

/* Position of a number in a list, to which it is added if need be */
static uint32_t place(uint32_t *list, uint32_t *count, uint32_t number)
{
    uint32_t k = 0;
    while (k < *count && list[k] != number)
        k++;
    if (k == *count)
        list[(*count)++] = number;
    return k;
}

/* The flags whose text the row has */
static uint32_t read_reason(const rows *r)
{
    for (uint32_t flag = 0; flag < 16; flag++)
        if (strcmp(tfa_fallback_text(TFA_ANSWER_FALLBACK | 1u << flag), rows_text(r, "reason")) ==
            0)
            return TFA_ANSWER_FALLBACK | 1u << flag;
    return 0;
}

static void read_answer(const rows *r, atlas_row *row)
{
    const char *by = rows_text(r, "answered_by"), *same = rows_text(r, "same_as");
    row->by_method = rows_whole(r, "own");
    row->fallback = rows_whole(r, "fallback");
    row->refused = rows_whole(r, "refused");
    row->status = row->refused ? rows_status(r, "status") : TFA_OK;
    snprintf(row->field, sizeof row->field, "%s", rows_text(r, "about"));
    row->answered_by = *by ? (uint32_t)tfa_method_find(by) : 0;
    row->reason = *rows_text(r, "reason") ? read_reason(r) : 0;
    row->same_as = *same ? (uint32_t)tfa_method_find(same) : 0;
    row->silent = rows_whole(r, "silent");
    row->unreported = rows_whole(r, "unsaid");
    row->error = rows_number(r, "error", INFINITY);
    row->error_low = rows_number(r, "error_low", INFINITY);
    row->error_high = rows_number(r, "error_high", INFINITY);
    row->worst = rows_number(r, "worst", 0.0);
    row->estimate = rows_number(r, "estimate", NAN);
    row->over = rows_number(r, "error_over_estimate", 0.0);
    row->floor = rows_number(r, "floor", NAN);
}

int main(int argc, char **argv)
{
    static atlas_row all[ROWS_MAX];
    static rows r;
    size_t count = 0;
    if (argc != 3)
        return 3;
    rows_open(&r, argv[1]);
    atlas_options o = {.states = 1, .seeds = 1, .command = r.command};
    for (; count < ROWS_MAX && rows_next(&r); count++) {
        atlas_row *row = &all[count], *before = count ? row - 1 : row;
        row->map = (atlas_map)rows_word(&r, "map", atlas_map_words, ATLAS_MAP_COUNT);
        row->mode = (atlas_mode)rows_word(&r, "mode", atlas_mode_words, ATLAS_MODE_COUNT);
        row->value = rows_number(&r, "value", NAN);
        row->bodies = rows_whole(&r, "bodies");
        row->method = (uint32_t)tfa_method_find(rows_text(&r, "method"));
        o.rhs = (chart_rhs)rows_word(&r, "rhs", chart_rhs_words, CHART_RHS_COUNT);
        read_answer(&r, row);
        /* values follow one another within a map and size */
        const int same = before->map == row->map && before->bodies == row->bodies;
        row->point = !same ? 0 : before->point + (before->value != row->value);
        if (o.points <= row->point)
            o.points = row->point + 1;
        o.maps |= 1u << row->map;
        place(o.sizes, &o.size_count, row->bodies);
        place(o.methods, &o.method_count, row->method);
    }
    FILE *page = html_open("atlas", argv[2]);
    return page ? atlas_page(page, &o, all, count) : 2;
}
