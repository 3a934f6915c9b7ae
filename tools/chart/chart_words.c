/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The words of the chart: right-hand sides, precisions, methods and peers, statuses.
 */
#include "chart.h"
#include "peer.h"

#include <math.h>
#include <string.h>

const char *const chart_rhs_words[CHART_RHS_COUNT] = {
#define CHART_RHS_WORD(name, word, what) word,
    CHART_RHS_LIST(CHART_RHS_WORD)
#undef CHART_RHS_WORD
};

const char *const chart_precision_words[CHART_PRECISION_COUNT] = {
#define CHART_PRECISION_WORD(name, word, precision, residual, what) word,
    CHART_PRECISION_LIST(CHART_PRECISION_WORD)
#undef CHART_PRECISION_WORD
};

const tfa_workspace_options chart_precisions[CHART_PRECISION_COUNT] = {
#define CHART_PRECISION_OPTIONS(name, word, first, second, what)                                   \
    {.precision = first, .residual = second, .methods = TFA_METHODS_ALL},
    CHART_PRECISION_LIST(CHART_PRECISION_OPTIONS)
#undef CHART_PRECISION_OPTIONS
};

const char *chart_method_name(uint32_t method)
{
    return method < CHART_PEER ? tfa_method_name(method) : peer_table[method - CHART_PEER]->name;
}

int32_t chart_method_find(const char *name)
{
    for (int32_t k = 0; peer_table[k]; k++)
        if (strcmp(peer_table[k]->name, name) == 0)
            return CHART_PEER + k;
    return tfa_method_find(name);
}

int chart_row_good(const chart_row *row)
{
    return !row->skipped && row->status == TFA_OK && row->answered_by == row->choice.method &&
           isfinite(row->error);
}

int chart_row_drawn(const chart_row *row)
{
    return chart_row_good(row) && row->same_as == 0;
}

const char *chart_row_status(const chart_row *row)
{
    if (row->skipped)
        return row->skipped;
    if (row->status == TFA_OK)
        return row->answered_by == row->choice.method ? "ok" : "fallback";
    return tfa_status_name(row->status);
}
