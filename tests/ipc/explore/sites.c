/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Call sites, listed at run time.
 */
#include "sites.h"

#include <stdio.h>
#include <string.h>

static explorer_site *first, **end = &first;
static int count;

memory_order site_order(explorer_site *site, int kind, memory_order declared, const char *function)
{
    if (site->id == 0) {
        site->id = ++count;
        site->kind = kind;
        site->function = function;
        site->declared = site->order = declared;
        *end = site;
        end = &site->next;
    }
    return site->order == site->declared ? declared : site->order;
}

explorer_site *sites_first(void)
{
    return first;
}

const char *site_text(const explorer_site *site)
{
    static const char *const kinds[] = {"load", "store", "exchange"};
    static char text[120];
    const char *name = strrchr(site->file, '/');
    snprintf(text, sizeof text, "%s:%d %s %s", name ? name + 1 : site->file, site->line,
             site->function, kinds[site->kind]);
    return text;
}

const char *order_text(memory_order order)
{
    static const char *const names[] = {"relaxed", "acquire", "release", "acq_rel", "seq_cst"};
    return names[order];
}

memory_order weaker_order(int kind, memory_order order)
{
    if (order != memory_order_seq_cst)
        return memory_order_relaxed;
    return kind == SITE_LOAD    ? memory_order_acquire
           : kind == SITE_STORE ? memory_order_release
                                : memory_order_acq_rel;
}
