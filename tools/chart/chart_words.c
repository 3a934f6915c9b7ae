/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The words of cases: right-hand sides, precisions, methods.
 */
#include "chart.h"
#include "common/commands.h"

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
    return tfa_method_name((tfa_method)method);
}

uint32_t chart_mark(uint32_t method)
{
    return method == TFA_METHOD_AUTO ? CHART_METHODS - 1 : method;
}

uint32_t chart_read_size(struct argp_state *state, const char *name, const char *word)
{
    return (uint32_t)option_unsigned(state, name, word, 1, MECHANISM_BODIES_MAX);
}

uint32_t chart_read_precision(struct argp_state *state, const char *name, const char *word)
{
    return (uint32_t)option_word(state, name, word, chart_precision_words, CHART_PRECISION_COUNT);
}
