/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of a long chain by partitions: the interface to the rest of the library.
 */
#include <math.h>
#include <string.h>

#include "dynamics/simd/partition.h"
#include "dynamics/solve/answer.h"
#include "interface/kernel_table.h"

static size_t size(const tfa_model *model)
{
    struct partition *none;
    return TFA_V(partition_walk)(model, NULL, &none);
}

static const double *state_of(const double *array, uint32_t stride, uint32_t k)
{
    return array ? array + (size_t)stride * k : NULL;
}

static void load(struct partition *p, const tfa_request *r, uint32_t k)
{
    const struct tfa_model *m = p->m;
    p->q = state_of(r->q, m->q_count, k);
    p->qd = state_of(r->v, m->v_count, k);
    p->tau = state_of(r->tau, m->v_count, k);
    p->gravity = v3_load(r->gravity ? r->gravity : m->gravity);
    p->moving = 0;
    for (uint32_t j = 0; p->qd && !p->moving && j < m->v_count; j++)
        p->moving = p->qd[j] != 0;
}

/* Sum over lanes and groups, partition by partition */
static double sum_of(const struct partition *p, const num *x)
{
    double sum = 0;
    for (uint32_t g = 0; g < p->groups; g++)
        for (uint32_t l = 0; l < NUM_LANES; l++)
            sum += num_lane(x[g], l);
    return sum;
}

/* Do sums of squares keep their digits? Otherwise the kernel of one state answers, whose norms
 * are scaled. */
static int is_in_range(double sum)
{
    return sum == 0 || (sum > 1e-280 && sum < 1e300);
}

/* One step of refinement: |dx| / |qdd| before it */
static double refine(struct partition *p)
{
    TFA_V(partition_residual)(p, 0);
    TFA_V(partition_correct)(p);
    return sqrt(sum_of(p, p->sum_dx) / sum_of(p, p->sum_qdd));
}

/* The relative correction of qdd by factors without inverse inertias; not a number where there
 * is none */
static double correction(struct partition *p, struct tfa_error_solver *solver, int perturbed)
{
    double sum = 0;
    TFA_V(partition_residual)(p, perturbed);
    if (!solver->solve(solver, p->residual, p->change))
        return (double)NAN;
    for (uint32_t j = 0; j < p->m->v_count; j++)
        sum += p->change[j] * p->change[j];
    for (uint32_t g = 0; g < p->groups; g++) {
        const struct block_row *r = group_rows(p, g);
        p->sum_qdd[g] = num_of(0);
        for (uint32_t row = 1; row <= p->rows; row++)
            p->sum_qdd[g] += r[row].qdd * r[row].qdd;
    }
    return sqrt(sum / sum_of(p, p->sum_qdd));
}

/* The error of qdd, by a perturbed residual and a plain one (refine.c), whose correction goes to
 * *plain */
static double estimate_error(struct partition *p, struct tfa_error_solver *solver, double *plain)
{
    const double perturbed = correction(p, solver, 1);
    *plain = correction(p, solver, 0);
    return ESTIMATE_SAFETY * (*plain > perturbed ? *plain : perturbed);
}

/* ---- the solution before its corrections ---- */

/* qdd, and where the residual of each partition starts */
static void save_unrefined(struct partition *p)
{
    const size_t width6 = (size_t)6 * p->width;
    for (uint32_t g = 0; g < p->groups; g++)
        for (uint32_t row = 1; row <= p->rows; row++)
            group_rows(p, g)[row].unrefined = group_rows(p, g)[row].qdd;
    memcpy(p->unrefined, interface_at(p, INTERFACE_MOTION, 0), width6 * sizeof *p->interface);
    memcpy(p->unrefined + width6, interface_at(p, INTERFACE_FORCE, 0),
           width6 * sizeof *p->interface);
}

static void swap(double *a, double *b, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        const double x = a[k];
        a[k] = b[k];
        b[k] = x;
    }
}

static void swap_unrefined(struct partition *p)
{
    const size_t width6 = (size_t)6 * p->width;
    for (uint32_t g = 0; g < p->groups; g++)
        for (uint32_t row = 1; row <= p->rows; row++) {
            struct block_row *r = &group_rows(p, g)[row];
            const num x = r->qdd;
            r->qdd = r->unrefined;
            r->unrefined = x;
        }
    swap(p->unrefined, interface_at(p, INTERFACE_MOTION, 0), width6);
    swap(p->unrefined + width6, interface_at(p, INTERFACE_FORCE, 0), width6);
}

static void write_qdd(const struct partition *p)
{
    for (uint32_t g = 0; p->qdd && g < p->groups; g++)
        for (uint32_t row = 1; row <= p->rows; row++)
            for (uint32_t l = 0; l < NUM_LANES; l++)
                if (group_bodies(p, g)[row].real[l])
                    p->qdd[group_bodies(p, g)[row].v[l]] = num_lane(group_rows(p, g)[row].qdd, l);
}

/* As in refine.c: the solution before its corrections, unless the refined one has a clearly smaller
 * estimate. Returns the estimate of the one that stands. */
static double keep_better_solution(struct partition *p, struct tfa_error_solver *by, double refined)
{
    double plain;
    swap_unrefined(p);
    const double unrefined = estimate_error(p, by, &plain);
    if (refined_is_better(unrefined, refined)) {
        swap_unrefined(p);
        return refined;
    }
    write_qdd(p);
    return unrefined;
}

static int partition_answer(struct partition *p, struct tfa_executor *executor,
                            const tfa_request *r, uint32_t k, struct tfa_error_solver *by,
                            tfa_reply *reply, tfa_answer *out)
{
    const uint32_t steps = r->refine == TFA_REFINE_DEFAULT ? 1 : r->refine;
    const int never_estimated = r->estimate == TFA_ESTIMATE_NEVER;
    double estimate = (double)NAN, first = (double)NAN, plain = (double)NAN;
    load(p, r, k);
    p->executor = executor;
    p->qdd = reply->qdd ? reply->qdd + (size_t)p->m->v_count * k : NULL;
    TFA_V(partition_forward)(p);
    if (!never_estimated && steps > 0)
        save_unrefined(p);
    for (uint32_t step = 0; step < steps; step++) {
        const double before = estimate;
        estimate = refine(p);
        first = step > 0 ? first : estimate;
        if (step > 0 && !never_estimated && !(estimate * SHRINK <= before || estimate < ROUNDING))
            return 0;
    }
    if (!never_estimated && steps > 0 && !(estimate <= FALLBACK_ESTIMATE))
        return 0;
    if (!never_estimated)
        estimate = estimate_error(p, by, &plain);
    if (!never_estimated && steps > 0 && refinement_stagnated(first, plain))
        estimate = keep_better_solution(p, by, estimate);
    *out = (tfa_answer){.method = (uint16_t)r->method,
                        .flags = never_estimated ? 0 : (uint16_t)TFA_ANSWER_ESTIMATED,
                        .error_estimate = never_estimated ? (double)NAN : estimate};
    return sum_of(p, p->finite) == 0 && (never_estimated || (is_in_range(sum_of(p, p->sum_qdd)) &&
                                                             estimate <= FALLBACK_ESTIMATE));
}

static int partition_answer_lambda(struct partition *p, struct tfa_executor *executor,
                                   const tfa_request *r, uint32_t k, tfa_reply *reply,
                                   tfa_answer *out)
{
    const struct tfa_frame *f = &p->m->frame[r->tips[0]];
    double lambda[36], check = 0;
    if (f->body + 1 != (int32_t)p->length || f->part)
        return 0;
    load(p, r, k);
    p->qd = p->tau = NULL;
    p->moving = 0;
    p->executor = executor;
    TFA_V(partition_lambda)(p, r, lambda);
    for (size_t e = 0; e < 36; e++) {
        check += lambda[e] - lambda[e];
        if (reply->lambda_inv)
            reply->lambda_inv[36 * (size_t)k + e] = lambda[e];
    }
    *out = (tfa_answer){.method = (uint16_t)r->method, .error_estimate = (double)NAN};
    return check == 0;
}

const struct tfa_partition_kernel TFA_V(partition) = {
    .size = size,
    .init = TFA_V(partition_init),
    .answer = partition_answer,
    .answer_lambda = partition_answer_lambda,
};
