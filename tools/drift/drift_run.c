/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One line of the picture: a robot that swings freely, its accelerations by one method.
 */
#include "drift.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An energy off by this much of its scale ends a line. */
#define ENERGY_LOST 1e3

int drift_energy(const drift_case *c, const double *q, const double *v, double *energy)
{
    tfa_answer answer;
    const tfa_request request = {
        .op = TFA_OP_KINEMATICS, .count = 1, .flags = TFA_WANT_ENERGY, .q = q, .v = v};
    tfa_reply reply = {.energy = energy, .answers = &answer};
    return tfa_compute(c->chart.f128, &request, &reply);
}

static int find_scale(drift_case *c)
{
    double energy[2], com[3], velocity[3], mass;
    tfa_answer answer;
    const tfa_request request = {.op = TFA_OP_KINEMATICS,
                                 .count = 1,
                                 .flags = TFA_WANT_ENERGY | TFA_WANT_COM,
                                 .q = c->start,
                                 .v = c->start + c->n};
    tfa_reply reply = {
        .energy = energy, .com = com, .com_velocity = velocity, .mass = &mass, .answers = &answer};
    const int status = tfa_compute(c->chart.f128, &request, &reply);
    const double *g = tfa_model_summarise(c->chart.model).gravity;
    c->energy = energy[0] + energy[1];
    c->scale = energy[0] + mass * sqrt((g[0] * g[0] + g[1] * g[1] + g[2] * g[2]) *
                                       (com[0] * com[0] + com[1] * com[1] + com[2] * com[2]));
    return status;
}

/* Angles and displacements only, from a fixed base */
static int is_integrable(const tfa_model *model)
{
    for (uint32_t j = 0; j < tfa_model_joint_count(model); j++)
        if (tfa_model_joint(model, j).q_count != 1)
            return 0;
    return tfa_model_base_freedoms(model) == 0 && tfa_model_v_count(model) > 0;
}

static int refuse(drift_case *c, const char *why, int status)
{
    fprintf(stderr, "totalforce drift: %s: %s\n", c->chart.name, why);
    drift_case_close(c);
    return status;
}

int drift_case_open(drift_case *c, const drift_options *o)
{
    chart_options options = {.seed = o->seed, .turn = o->turn};
    *c = (drift_case){0};
    memcpy(options.precisions, o->precisions, sizeof options.precisions);
    options.precision_count = o->precision_count;
    int status = chart_case_open(&c->chart, &options, &o->target, o->bodies);
    if (status != TFA_OK)
        return status;
    if (!is_integrable(c->chart.model))
        return refuse(c, "only revolute, continuous and prismatic joints on a fixed base move here",
                      TFA_E_UNSUPPORTED);
    c->n = tfa_model_v_count(c->chart.model);
    c->start = calloc(2 * (size_t)c->n, sizeof *c->start);
    if (!c->start)
        return refuse(c, tfa_status_text(TFA_E_MEMORY), TFA_E_MEMORY);
    for (uint32_t j = 0; j < c->n; j++) {
        const int slides = tfa_model_joint(c->chart.model, j).type == TFA_JOINT_PRISMATIC;
        const double range = slides ? 0.1 * c->chart.turn : c->chart.turn;
        c->start[j] = mechanism_random_uniform(&c->chart.random, -range, range);
    }
    status = find_scale(c);
    return status == TFA_OK ? TFA_OK : refuse(c, tfa_status_text(status), status);
}

void drift_case_close(drift_case *c)
{
    free(c->start);
    c->start = NULL;
    chart_case_close(&c->chart);
}

/* The line's method */
typedef struct answers {
    const drift_case *c;
    const drift_line *line;
} answers;

static int answer(void *context, const double *q, const double *v, double *a)
{
    const answers *the = context;
    tfa_answer found;
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .method = (tfa_method)the->line->choice.method,
                                 .estimate = TFA_ESTIMATE_NEVER,
                                 .refine = the->line->choice.refine,
                                 .count = 1,
                                 .q = q,
                                 .v = v};
    tfa_reply reply = {.qdd = a, .answers = &found};
    tfa_workspace *exact = the->c->chart.f128;
    return tfa_compute(
        the->line->floor ? exact : the->c->chart.solvers[the->line->choice.precision].workspace,
        &request, &reply);
}

static int is_lost(const drift_line *line)
{
    const double error = line->error[line->count - 1];
    return !isfinite(error) || fabs(error) > ENERGY_LOST;
}

/* Steps and samples until the end, or until an answer fails */
static void swing(drift_line *line, const drift_case *c, const drift_options *o,
                  const drift_system *system, double *q)
{
    const uint64_t steps = (uint64_t)fmax(1.0, round(o->seconds / line->step));
    uint64_t done = 0;
    for (uint32_t k = 1; k <= o->samples; k++) {
        const uint64_t until = steps * k / o->samples;
        for (; done < until && line->status == TFA_OK; done++)
            line->status = drift_step(o->integrator, system, line->step, q, q + c->n);
        double energy[2];
        if (line->status == TFA_OK)
            line->status = drift_energy(c, q, q + c->n, energy);
        if (line->status != TFA_OK)
            return;
        line->time[line->count] = (double)done * line->step;
        line->error[line->count++] = (energy[0] + energy[1] - c->energy) / c->scale;
        if (is_lost(line))
            return;
    }
}

int drift_run(drift_line *line, drift_case *c, const drift_options *o, drift_accelerate *accelerate,
              void *context)
{
    answers own = {c, line};
    const chart_solver *solver = &c->chart.solvers[line->choice.precision];
    double *block = calloc((size_t)(DRIFT_SCRATCH + 2) * c->n, sizeof *block);
    line->time = calloc(2 * (size_t)o->samples, sizeof *line->time);
    if (!block || !line->time) {
        free(block);
        return TFA_E_MEMORY;
    }
    line->error = line->time + o->samples;
    line->status = line->floor || accelerate ? TFA_OK : solver->status;
    const drift_system system = {.n = c->n,
                                 .accelerate = accelerate ? accelerate : answer,
                                 .context = accelerate ? context : &own,
                                 .scratch = block + 2 * (size_t)c->n};
    memcpy(block, c->start, 2 * (size_t)c->n * sizeof *block);
    if (line->status == TFA_OK)
        swing(line, c, o, &system, block);
    free(block);
    return TFA_OK;
}

void drift_line_free(drift_line *line)
{
    free(line->time);
    line->time = line->error = NULL;
}

double drift_largest(const drift_line *line, uint32_t sample)
{
    double largest = 0.0;
    for (uint32_t k = 0; k <= sample && k < line->count; k++)
        largest = isfinite(line->error[k]) ? fmax(largest, fabs(line->error[k])) : INFINITY;
    return largest;
}

const char *drift_line_name(const drift_line *line, char *text, size_t size)
{
    static const char *const refined[] = {"", "+1", "+2"};
    const int mixed = chart_precisions[line->choice.precision].residual != TFA_RESIDUAL_SAME;
    snprintf(text, size, "%s%s %s", chart_method_name(line->choice.method),
             mixed ? "" : refined[line->choice.refine],
             chart_precision_words[line->choice.precision]);
    return text;
}
