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

const char *const chart_strategy_words[CHART_STRATEGY_COUNT] = {
#define CHART_STRATEGY_WORD(name, word, batch, specialised, what) word,
    CHART_STRATEGY_LIST(CHART_STRATEGY_WORD)
#undef CHART_STRATEGY_WORD
};

int chart_is_batch(uint32_t strategy)
{
    static const int batch_of[] = {
#define CHART_STRATEGY_BATCH(name, word, batch, specialised, what) batch,
        CHART_STRATEGY_LIST(CHART_STRATEGY_BATCH)
#undef CHART_STRATEGY_BATCH
    };
    return batch_of[strategy];
}

int chart_is_specialised(uint32_t strategy)
{
    static const int specialised_of[] = {
#define CHART_STRATEGY_SPECIALISED(name, word, batch, specialised, what) specialised,
        CHART_STRATEGY_LIST(CHART_STRATEGY_SPECIALISED)
#undef CHART_STRATEGY_SPECIALISED
    };
    return specialised_of[strategy];
}

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

/* Answered by the method itself, not by a fallback */
static int chart_row_own(const chart_row *row)
{
    return row->choice.method == TFA_METHOD_AUTO || row->answered_by == row->choice.method;
}

int chart_row_good(const chart_row *row)
{
    return !row->skipped && row->status == TFA_OK && chart_row_own(row) && isfinite(row->error);
}

int chart_row_drawn(const chart_row *row)
{
    return chart_row_good(row) && row->same_as == 0;
}

const char *chart_row_rhs(const chart_row *row)
{
    return row->choice.op == CHART_FORWARD ? chart_rhs_words[row->rhs] : "";
}

const char *chart_row_status(const chart_row *row)
{
    if (row->skipped)
        return row->skipped;
    if (row->status == TFA_OK)
        return chart_row_own(row) ? "ok" : "fallback";
    return tfa_status_name(row->status);
}
