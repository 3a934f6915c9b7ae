/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mutations: every order of ring.h and of its callers is weakened, one call site and one step at a
 * time, and every error of a caller is made. Each must be found in some scenario.
 */
#include <stdio.h>
#include <string.h>

#include "parts.h"
#include "ring_sides.h"
#include "sites.h"

/* The sites by function and kind; a site without a label fails */
static const struct {
    const char *function;
    int kind;
    const char *label;
} labels[] = {
    {"tfa_ring_send", SITE_STORE, "A1"},
    {"tfa_ring_send", SITE_LOAD, "R3"},
    {"tfa_ring_reply_ready", SITE_LOAD, "R2"},
    {"tfa_ring_client_prepare_wait", SITE_STORE, "A4"},
    {"tfa_ring_client_prepare_wait", SITE_LOAD, "R2"},
    {"tfa_ring_client_end_wait", SITE_STORE, "A4"},
    {"tfa_ring_poll", SITE_LOAD, "R1"},
    {"tfa_ring_poll_last", SITE_LOAD, "R1"},
    {"tfa_ring_publish", SITE_STORE, "A2"},
    {"tfa_ring_publish", SITE_LOAD, "R4"},
    {"sleep_for", SITE_LOAD, "R2"},   /* local clients */
    {"set_asleep", SITE_STORE, "A3"}, /* show_asleep of worker.c */
    {"clear_asleep", SITE_STORE, "A3"},
};

/* Weakenings without effect, each with its reason; any other that survives fails. Stronger orders
 * need no exploration: they admit fewer executions. */
typedef struct harmless {
    const char *function;
    int kind;
    memory_order order; /* weakened to it */
    const char *reason;
} harmless;
static const harmless harmless_ones[] = {
    {"clear_asleep", SITE_STORE, memory_order_relaxed,
     "a flag that stays set costs one needless wake-up"},
};

static const char *label_of(const explorer_site *site)
{
    for (size_t k = 0; k < sizeof labels / sizeof *labels; k++)
        if (labels[k].kind == site->kind && strcmp(labels[k].function, site->function) == 0)
            return labels[k].label;
    return NULL;
}

static const harmless *harmless_at(const explorer_site *site)
{
    for (size_t k = 0; k < sizeof harmless_ones / sizeof *harmless_ones; k++) {
        const harmless *h = &harmless_ones[k];
        if (h->kind == site->kind && strcmp(h->function, site->function) == 0)
            return h;
    }
    return NULL;
}

/* Explores with the mutation that is in force. @return 1: it survives and no reason is listed, or
 * it is found and one is */
static int explore_mutation(const char *text, const char *reason)
{
    static int hint; /* neighbouring mutations are found by the same scenario */
    const char *finding = NULL;
    const char *scenario = scenarios_find(&finding, &hint);
    const bool good = (scenario == NULL) == (reason != NULL);
    if (scenario)
        printf("  %-74s %s (%s)%s\n", text, finding, scenario, good ? "" : "  LISTED AS HARMLESS");
    else
        printf("  %-74s %s%s\n", text, good ? "harmless: " : "NOT FOUND", good ? reason : "");
    return !good;
}

static int weaken(explorer_site *site)
{
    int failures = 0;
    const char *label = label_of(site);
    char text[200];
    if (!label || site->declared == memory_order_relaxed) {
        printf("  %-3s%-71s %s\n", label ? label : "", site_text(site),
               label ? "relaxed: nothing to weaken" : "NO LABEL");
        return label == NULL;
    }
    const harmless *h = harmless_at(site);
    for (memory_order order = site->declared; order != memory_order_relaxed;) {
        order = h && order == site->declared ? h->order : weaker_order(site->kind, order);
        snprintf(text, sizeof text, "%s %s %s -> %s", label, site_text(site),
                 order_text(site->declared), order_text(order));
        site->order = order;
        failures += explore_mutation(text, h && h->order == order ? h->reason : NULL);
        site->order = site->declared;
    }
    return failures;
}

static bool is_of_the_ring(const explorer_site *site)
{
    const char *name = strrchr(site->file, '/');
    name = name ? name + 1 : site->file;
    return strcmp(name, "ring.h") == 0 || strcmp(name, "ring_sides.c") == 0;
}

int mutations_run(void)
{
    int failures = 0;
    explorer_site *sites[64];
    int count = 0;
    for (explorer_site *s = sites_first(); s && count < 64; s = s->next)
        if (is_of_the_ring(s))
            sites[count++] = s;
    printf("\nmutation, found by: %d call sites\n", count);
    for (int k = 0; k < count; k++)
        failures += weaken(sites[k]);
    for (int k = ERROR_NONE + 1; k < RING_ERRORS; k++) {
        ring_error_made = (ring_error)k;
        failures += explore_mutation(ring_error_text(ring_error_made), NULL);
    }
    ring_error_made = ERROR_NONE;
    return failures;
}
