/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mutations of a subject.
 */
#include <stdio.h>
#include <string.h>

#include "sites.h"
#include "subject.h"

static const subject_label *label_at(const subject *s, const explorer_site *site)
{
    for (const subject_label *l = s->labels; l->function; l++)
        if (l->kind == site->kind && strcmp(l->function, site->function) == 0)
            return l;
    return NULL;
}

static const subject_harmless *harmless_at(const subject *s, const explorer_site *site)
{
    for (const subject_harmless *h = s->harmless; h && h->function; h++)
        if (h->kind == site->kind && strcmp(h->function, site->function) == 0)
            return h;
    return NULL;
}

/* Explores with the mutation that is in force. @return 1: it survives and no reason is listed, or
 * it is found and one is */
static int explore_mutation(const subject *s, const char *text, const char *reason)
{
    static int hint; /* neighbouring mutations are found by the same scenario */
    const char *finding = NULL;
    const char *scenario = scenarios_find(s, &finding, &hint);
    const bool good = (scenario == NULL) == (reason != NULL);
    if (scenario)
        printf("  %-74s %s (%s)%s\n", text, finding, scenario, good ? "" : "  LISTED AS HARMLESS");
    else
        printf("  %-74s %s%s\n", text, good ? "harmless: " : "NOT FOUND", good ? reason : "");
    return !good;
}

static int weaken(const subject *s, explorer_site *site)
{
    int failures = 0;
    const subject_label *listed = label_at(s, site);
    const char *label = listed ? listed->label : NULL;
    char text[200];
    if (listed && !label)
        return 0;
    if (!label || site->declared == memory_order_relaxed) {
        printf("  %-4s%-70s %s\n", label ? label : "", site_text(site),
               label ? "relaxed: nothing to weaken" : "NO LABEL");
        return label == NULL;
    }
    const subject_harmless *h = harmless_at(s, site);
    for (memory_order order = site->declared; order != memory_order_relaxed;) {
        order = h && order == site->declared ? h->order : weaker_order(site->kind, order);
        snprintf(text, sizeof text, "%s %s %s -> %s", label, site_text(site),
                 order_text(site->declared), order_text(order));
        site->order = order;
        failures += explore_mutation(s, text, h && h->order == order ? h->reason : NULL);
        site->order = site->declared;
    }
    return failures;
}

static bool is_of(const subject *s, const explorer_site *site)
{
    const char *name = strrchr(site->file, '/');
    name = name ? name + 1 : site->file;
    for (const char *const *file = s->files; *file; file++)
        if (strcmp(name, *file) == 0)
            return true;
    return false;
}

int mutations_run(const subject *s)
{
    int failures = 0;
    explorer_site *sites[64];
    int count = 0;
    for (explorer_site *at = sites_first(); at && count < 64; at = at->next)
        if (is_of(s, at))
            sites[count++] = at;
    printf("\nmutation, found by: %d call sites\n", count);
    for (int k = 0; k < count; k++)
        failures += weaken(s, sites[k]);
    for (int error = 1; error < s->errors; error++) {
        s->make_error(error);
        failures += explore_mutation(s, s->error_text(error), NULL);
    }
    s->make_error(0);
    return failures;
}
