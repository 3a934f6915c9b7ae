/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A mechanism or robot to chart: its model and all that answers for it.
 */
#include "chart.h"
#include "common/load_model.h"

#include <inttypes.h>
#include <string.h>

static mechanism_options options_of(const chart_options *o, const chart_target *target,
                                    uint32_t bodies)
{
    mechanism_options m = mechanism_defaults(target->kind, bodies);
    m.seed = o->seed;
    if (target->value > 0.0 && target->kind == MECHANISM_TAPER)
        m.taper = target->value;
    else if (target->value > 0.0 && target->kind == MECHANISM_THIN)
        m.radius = target->value;
    else if (target->value > 0.0)
        m.ratio = target->value;
    return m;
}

/* Mechanisms have their shape at q = 0; robots any configuration. */
#define TURN_MECHANISM 1e-3
#define TURN_ROBOT 3.0

static int compile_mechanism(chart_case *c, const chart_options *o, const mechanism_options *m,
                             const char *label)
{
    char why[128];
    if (mechanism_check(m, why, sizeof why) != 0) {
        fprintf(stderr, "totalforce: %s: %s\n", label, why);
        return TFA_E_ARGUMENT;
    }
    tfa_description *description = mechanism_make(m);
    if (!description)
        return TFA_E_MEMORY;
    const tfa_model_options options = {.base = TFA_BASE_FIXED};
    int status = tfa_model_create(description, &options, NULL, &c->model);
    if (status == TFA_OK)
        status = chart_floor_open(c, description, &options);
    mechanism_free(description);
    snprintf(c->name, sizeof c->name, "%s", label);
    c->bodies = m->bodies;
    c->turn = o->turn > 0.0 ? o->turn : TURN_MECHANISM;
    return status;
}

static int compile_file(chart_case *c, const chart_options *o, const chart_target *target)
{
    tfa_report report = {0};
    tfa_model_options options = {.base = o->base, .lock_massless_leaves = 1};
    tfa_description *description = NULL;
    c->model = load_model(target->file, &options, TFA_ERROR, &report);
    tfa_report_free(&report);
    if (!c->model)
        return TFA_E_MODEL;
    int status = tfa_urdf_load(target->file, &description, &report);
    if (status == TFA_OK)
        status = chart_floor_open(c, description, &options);
    tfa_report_free(&report);
    tfa_description_free(description);
    if (status != TFA_OK)
        return status;
    /* the name is a word of CSV, JSON and file names */
    snprintf(c->name, sizeof c->name, "%s", tfa_model_name(c->model));
    for (char *at = c->name; *at; at++)
        if (!strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_", *at))
            *at = '_';
    c->bodies = tfa_model_summarise(c->model).bodies;
    c->turn = o->turn > 0.0 ? o->turn : TURN_ROBOT;
    return TFA_OK;
}

/* Those that the exact answers and the floor stand on, and those that were asked for, which may be
 * absent */
static int make_workspaces(chart_case *c, const chart_options *o)
{
    for (uint32_t k = 0; k < o->precision_count; k++) {
        const uint32_t p = o->precisions[k];
        c->solvers[p].status =
            tfa_workspace_create(c->model, &chart_precisions[p], &c->solvers[p].workspace);
    }
    const int status = tfa_workspace_create(c->model, &chart_precisions[CHART_F64], &c->f64);
    return status == TFA_OK
               ? tfa_workspace_create(c->model, &chart_precisions[CHART_F128], &c->f128)
               : status;
}

/* The message for a model that was compiled with that status; a file that was refused has its own.
 * bodies: of a mechanism, 0 of a file */
static int open_compiled(chart_case *c, const chart_options *options, int status, const char *label,
                         uint32_t bodies)
{
    if (status == TFA_OK) {
        c->tip = chart_find_tip(c->model, options->tip);
        status = make_workspaces(c, options);
    }
    if (status == TFA_OK)
        return TFA_OK;
    if (bodies)
        fprintf(stderr, "totalforce: %s, %" PRIu32 " bodies: %s\n", label, bodies,
                tfa_status_text(status));
    else if (status != TFA_E_MODEL)
        fprintf(stderr, "totalforce: %s: %s\n", label, tfa_status_text(status));
    chart_case_close(c);
    return status;
}

int chart_case_open(chart_case *c, const chart_options *options, const chart_target *target,
                    uint32_t bodies)
{
    *c = (chart_case){.random = options->seed};
    const mechanism_options m = options_of(options, target, bodies);
    const int status = target->file ? compile_file(c, options, target)
                                    : compile_mechanism(c, options, &m, target->label);
    return open_compiled(c, options, status, target->label, target->file ? 0 : bodies);
}

int chart_case_open_mechanism(chart_case *c, const mechanism_options *mechanism, const char *label)
{
    const chart_options plain = {0};
    *c = (chart_case){.random = mechanism->seed};
    const int status = compile_mechanism(c, &plain, mechanism, label);
    return open_compiled(c, &plain, status, label, mechanism->bodies);
}

void chart_case_close(chart_case *c)
{
    chart_floor_close(c);
    for (int p = 0; p < CHART_PRECISION_COUNT; p++)
        tfa_workspace_free(c->solvers[p].workspace);
    tfa_workspace_free(c->f64);
    tfa_workspace_free(c->f128);
    tfa_model_free(c->model);
    *c = (chart_case){0};
}
