/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Search for the options with which a refused robot compiles: the smallest set of policies.
 */
#include <stdio.h>
#include <string.h>

#include "model/draft/draft.h"

/* Candidates, the smallest change of the robot first */
static const tfa_option options_tried[] = {TFA_OPTION_INERTIA_STRICT, TFA_OPTION_INERTIA_REPAIR,
                                           TFA_OPTION_MIMIC_PROJECT,  TFA_OPTION_LOCK_LEAVES,
                                           TFA_OPTION_MIMIC_LOCK,     TFA_OPTION_BASE_FIXED};
enum { OPTIONS_TRIED = sizeof options_tried / sizeof *options_tried };

/* @return 0 if the option has that value already, or another option of the set decides it */
static int set_option(tfa_model_options *o, const tfa_model_options *given, tfa_option option)
{
    const tfa_model_options before = *o;
    switch (option) {
    case TFA_OPTION_INERTIA_STRICT:
        o->inertia = TFA_INERTIA_STRICT;
        return given->inertia == TFA_INERTIA_STRICT_PHYSICAL;
    case TFA_OPTION_INERTIA_REPAIR:
        o->inertia = TFA_INERTIA_REPAIR;
        return given->inertia != TFA_INERTIA_REPAIR && before.inertia == given->inertia;
    case TFA_OPTION_MIMIC_PROJECT:
        o->mimic = TFA_MIMIC_PROJECT;
        return given->mimic != TFA_MIMIC_PROJECT;
    case TFA_OPTION_MIMIC_LOCK:
        o->mimic = TFA_MIMIC_LOCK;
        return given->mimic != TFA_MIMIC_LOCK && before.mimic == given->mimic;
    case TFA_OPTION_LOCK_LEAVES:
        o->lock_massless_leaves = 1;
        return !given->lock_massless_leaves;
    case TFA_OPTION_BASE_FIXED:
        o->base = TFA_BASE_FIXED;
        return given->base != TFA_BASE_FIXED;
    default:
        return 0;
    }
}

/* 1: it compiles with the options of the set, each of which changes something */
static int compiles_with(const tfa_description *description, const tfa_model_options *given,
                         unsigned set)
{
    tfa_model_options options = *given;
    struct draft d;
    for (int k = 0; k < OPTIONS_TRIED; k++)
        if (set >> k & 1 && !set_option(&options, given, options_tried[k]))
            return 0;
    const int status = tfa_draft_make(&d, description, &options, NULL);
    tfa_draft_free(&d);
    return status == TFA_OK;
}

static int size_of(unsigned set)
{
    return __builtin_popcount(set);
}

const char *tfa_find_remedy(const tfa_description *description, const tfa_model_options *options,
                            const tfa_report *report, char *text, size_t size)
{
    static const tfa_model_options defaults = {0};
    const tfa_model_options *given = options ? options : &defaults;
    for (int most = 1; most <= 3; most++)
        for (unsigned set = 1; set < 1u << OPTIONS_TRIED; set++) {
            if (size_of(set) != most || !compiles_with(description, given, set))
                continue;
            size_t used = 0;
            for (int k = 0; k < OPTIONS_TRIED; k++)
                if (set >> k & 1 && used < size)
                    used += (size_t)snprintf(text + used, size - used, "%s%s", used ? " and " : "",
                                             tfa_option_text(report, options_tried[k]));
            return text;
        }
    return NULL;
}
