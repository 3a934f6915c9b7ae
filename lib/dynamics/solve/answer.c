/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers one state of a checked request by its operation; steps that operations share.
 */
#include "dynamics/solve/answer.h"

#include <math.h>
#include <string.h>

#include "dynamics/core/aba_step.h"
#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/frame.h"
#if NUM_LANES == 1
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/constraint_rows.h"
#endif
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "interface/traits.h"

/* Methods with I^-1 lose digits there that a step of refinement brings back (docs/accuracy.md). */
int TFA_V(wants_estimate)(const tfa_request *r, tfa_method method)
{
    return r->estimate == TFA_ESTIMATE_ALWAYS ||
           (r->estimate == TFA_ESTIMATE_DEFAULT && method_inverts(method));
}

/* At most: no step is made once the remainder is small (refine.c). Float has 7 digits, of which a
 * long chain takes 3 or 4, and every second step may gain little; with double one step is nearly
 * always enough. */
#define STEPS_MIXED (NUM_EPSILON > 0x1p-52 ? 4 : 2)

uint32_t TFA_V(refine_steps)(const struct state *s, const tfa_request *r, tfa_method method)
{
    if (r->refine != TFA_REFINE_DEFAULT)
        return r->refine;
    if (s->residual_kernel)
        return STEPS_MIXED;
    return method_inverts(method) && !TFA_V(method)(method)->osim_elimination ? 1 : 0;
}

uint16_t TFA_V(needs_fallback)(const num_doubles *estimate, int converging)
{
    for (int l = 0; l < NUM_LANES; l++) {
        if (!isfinite(estimate->lane[l]))
            return TFA_ANSWER_NOT_FINITE;
        if (estimate->lane[l] > FALLBACK_ESTIMATE)
            return TFA_ANSWER_INACCURATE;
    }
    return converging ? 0 : TFA_ANSWER_STALLED;
}

int TFA_V(sentinel_asks_estimate)(struct state *s, const tfa_request *r, tfa_method method,
                                  tfa_answer *out)
{
    if (r->estimate != TFA_ESTIMATE_DEFAULT)
        return 0;
    if (!TFA_V(sentinel_of)(s, method))
        return 0;
    out->flags |= TFA_ANSWER_SENTINEL;
    return 1;
}

void TFA_V(store_estimate)(const struct state *s, const tfa_request *r, const num_doubles *estimate,
                           tfa_answer *out)
{
    if (r->estimate == TFA_ESTIMATE_NEVER)
        return;
    out->flags |= TFA_ANSWER_ESTIMATED;
    for (uint32_t l = 0; l < s->lanes; l++)
        out[l].error_estimate = estimate->lane[l];
}

/* Bodies above this are not the cause of a failure. */
#define SINGULAR_RATIO (1e-2 / (double)NUM_EPSILON)

/* How far the projected inertia D of a body's joint is below its size G (core/sentinel.h): infinite
 * where it is not positive. Kept are 1/D, or those of its factors. */
static double inertia_ratio(const struct state *s, uint32_t i)
{
    const struct tfa_body *b = &s->body[i];
    const sym6 IA = aba_backward_inertia(s, i, b, s->locked || HAS_MODES(s) ? 0 : ABA_FULL_SWEEP);
    const struct sentinel_size G = sentinel_size(s, b, &IA);
    double most = 0;
    for (uint32_t k = 0; k < b->n; k++) {
        const num d = b->n == 1 ? s->Dinv[i] : s->joint_nd[b->joint_nd].L[7 * k];
        if (s->lock[b->v + k])
            continue;
        if (!(num_all(d > 0) && num_all(d - d == num_of(0))))
            return INFINITY;
        most = fmax(most, (double)num_lane(d * sentinel_size_of(s, b, k, &G), 0));
    }
    return most;
}

/* Returns 1, and the body whose ratio is the largest, where one is above SINGULAR_RATIO. */
static int find_singular_body(struct state *s, uint32_t *link)
{
    double largest = SINGULAR_RATIO;
    *link = 0;
    (void)TFA_V(factor)(s, METHOD_OF_ESTIMATES);
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++)
            if (inertia_ratio(s, i) > largest) {
                largest = inertia_ratio(s, i);
                *link = s->body[i].link;
            }
    return largest > SINGULAR_RATIO;
}

void TFA_V(report_singular_body)(struct state *s, tfa_reply *reply)
{
    uint32_t link;
    if (find_singular_body(s, &link)) {
        reply->field = TFA_FIELD_BODY;
        reply->index = link;
    }
}

/* Float by itself: double answers where float's factors are bad (run_batch). */
static int double_takes_over(const struct state *s)
{
    return NUM_EPSILON > 0x1p-30 && !s->residual_kernel;
}

int TFA_V(estimate_is_valid)(struct state *s, const tfa_request *r, tfa_method method,
                             const num_doubles *estimate)
{
    int certain = 1, below_one = 1;
    for (uint32_t l = 0; l < s->lanes; l++) {
        certain &= estimate->lane[l] <= ESTIMATE_UNCERTAIN;
        below_one &= estimate->lane[l] <= 1;
    }
    if (r->estimate == TFA_ESTIMATE_NEVER)
        return 1;
    if (double_takes_over(s))
        return certain && !TFA_V(sentinel_of)(s, method);
    if (certain)
        return 1;
    if (s->lanes > 1 || (!below_one && TFA_V(sentinel_of)(s, method)))
        return 0; /* of several, some alone may be valid */
    uint32_t link;
    return s->m->mimics || !find_singular_body(s, &link);
}

static int answer_inverse(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *out)
{
    out->method = (uint16_t)s->by.method;
    return TFA_V(inverse_dynamics)(s, k, reply) ? TFA_OK : TFA_E_NOT_COMPUTED;
}

/* Where freedom j stands in the public M, and with which factor: T^T M T */
static inline size_t public_freedom(const struct tfa_model *m, uint32_t j, double *multiplier)
{
    const uint32_t nb = m->base_freedoms;
    *multiplier = j < nb ? 1 : m->freedom[j - nb].multiplier;
    return j < nb ? j : nb + m->freedom[j - nb].from;
}

/* One entry of M to the matrix of every state, and to its mirror image. Returns whether all are
 * finite. */
static int add_entry(const struct state *s, double *M, size_t n, size_t a, size_t b, double factor,
                     num entry, int twice)
{
    int finite = 1;
    for (uint32_t l = 0; M && l < s->lanes; l++, M += n * n) {
        const double x = factor * (double)num_lane(entry, l);
        finite &= isfinite(x) != 0;
        M[a * n + b] += x;
        if (twice)
            M[b * n + a] += x;
    }
    return finite;
}

/* The same of a robot whose freedoms are public ones in their order: each entry is written twice,
 * to a matrix of zeros. */
static int write_mass(const struct state *s, double *M, size_t n)
{
    const struct tfa_model *m = s->m;
    double rest = 0;
    for (uint32_t l = 0; l < s->lanes; l++, M += n * n)
        for (uint32_t j = 0; j < n; j++) {
            const num *row = s->M + m->dof_row[j];
            for (int32_t i = (int32_t)j; i >= 0; i = m->dof_parent[i]) {
                const double x = (double)num_lane(row[m->dof_depth[i]], l);
                rest += x - x;
                M[j * n + (uint32_t)i] = M[(uint32_t)i * n + j] = x;
            }
        }
    return rest == 0;
}

/* Rows of M hold ancestors only; everything else of the dense answer is zero. */
static int answer_mass(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *out)
{
    const struct tfa_model *m = s->m;
    const size_t n = m->base_freedoms + m->v_count;
    TFA_V(crba)(s);
    out->method = (uint16_t)s->by.method;
    double *M = reply->mass_matrix ? reply->mass_matrix + n * n * k : NULL;
    if (M)
        memset(M, 0, n * n * s->lanes * sizeof *M);
    int finite = !M || !s->identity_map || write_mass(s, M, n);
    for (uint32_t j = 0; M && !s->identity_map && j < m->freedoms; j++)
        for (int32_t i = (int32_t)j; i >= 0; i = m->dof_parent[i]) {
            double left, right;
            const size_t a = public_freedom(m, j, &left),
                         b = public_freedom(m, (uint32_t)i, &right);
            finite &= add_entry(s, M, n, a, b, left * right, s->M[m->dof_row[j] + m->dof_depth[i]],
                                (uint32_t)i != j);
        }
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

#if NUM_LANES == 1
/* Forward dynamics with the posture torques; the rest is answer_operational's. */
static int answer_task(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply,
                       tfa_answer *answer)
{
    tfa_reply part = *reply;
    part.qdd = part.base_acceleration = NULL;
    if (s->closings)
        part.lambda_inv = NULL; /* the tips are not the request's */
    const int status = TFA_V(answer_forward)(s, request, k, &part, answer);
    reply->field = part.field;
    reply->index = part.index;
    return status;
}

/* The tips of the request give way to the links of its constraints. */
static int answer_constrained(struct state *s, const tfa_request *request, uint32_t k,
                              tfa_reply *reply, tfa_answer *answer)
{
    TFA_V(constraints_activate)(s, request->constraints);
    int status;
    if (request->op == TFA_OP_IMPACT)
        status = TFA_V(answer_impact)(s, request, k, reply, answer);
    else if (request->op == TFA_OP_CONSTRAINED_INVERSE_DYNAMICS)
        status = TFA_V(answer_constrained_inverse)(s, request, k, reply, answer);
    else if ((status = answer_task(s, request, k, reply, answer)) == TFA_OK)
        status = TFA_V(answer_constrained)(s, request, k, reply, answer);
    load_tips(s, request);
    return status;
}

static int is_operational(const tfa_request *r)
{
    return r->op == TFA_OP_TASK_TORQUES || (r->flags & FLAGS_LAMBDA && r->tip_count);
}
#endif

static int answer_op(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply,
                     tfa_answer *answer)
{
    switch (request->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        return TFA_V(answer_forward)(s, request, k, reply, answer);
#if NUM_LANES == 1 /* batches have no tips */
    case TFA_OP_OPERATIONAL_INERTIA:
        return TFA_V(answer_lambda)(s, request, k, reply, answer);
    case TFA_OP_BIAS:
        return TFA_V(answer_bias)(s, k, reply, answer);
    case TFA_OP_REGRESSOR:
        return TFA_V(answer_regressor)(s, k, reply, answer);
    case TFA_OP_TASK_TORQUES:
        return answer_task(s, request, k, reply, answer);
    case TFA_OP_CONSTRAINED_DYNAMICS:
    case TFA_OP_IMPACT:
    case TFA_OP_CONSTRAINED_INVERSE_DYNAMICS:
        return answer_constrained(s, request, k, reply, answer);
#endif
    case TFA_OP_DERIVATIVES:
        return TFA_V(answer_derivatives)(s, request, k, reply, answer);
    case TFA_OP_INVERSE_DYNAMICS_DERIVATIVES:
        return TFA_V(answer_inverse_derivatives)(s, request, reply, answer);
    case TFA_OP_INVERSE_DYNAMICS:
        return answer_inverse(s, k, reply, answer);
    case TFA_OP_MASS_MATRIX:
        return answer_mass(s, k, reply, answer);
    case TFA_OP_KINEMATICS:
        answer->method = (uint16_t)s->by.method;
        return TFA_OK;
    default:
        return TFA_E_UNSUPPORTED;
    }
}

/* Flags the states with a modal coordinate beyond its limit. */
static void see_limits(const struct state *s, tfa_answer *answer)
{
    for (uint32_t i = 0; i < s->m->flexible_bodies; i++) {
        const struct tfa_flexible *f = &s->m->flexible[i];
        for (uint32_t k = 0; k < f->n; k++)
            for (uint32_t l = 0; l < s->lanes; l++)
                if (fabs((double)num_lane(s->eta[f->first + k], l)) > f->limit[k])
                    answer[l].flags |= TFA_ANSWER_MODE_LIMIT;
    }
}

/* Float by itself leaves them to double. */
static int wants_joint_forces(const struct state *s, const tfa_request *r, const tfa_reply *reply)
{
    return NUM_EPSILON < 0x1p-30 && r->flags & TFA_WANT_JOINT_FORCES && reply->joint_forces &&
           TFA_OP_BIT(r->op) & (TRAIT_FD | TRAIT_ID) && !s->lanes_diverged;
}

int TFA_V(answer)(struct state *s, const tfa_request *request, struct tfa_resolved by, uint32_t k,
                  uint32_t count, tfa_reply *reply, tfa_answer *answer)
{
    s->by = by;
    for (uint32_t l = 0; l < count; l++)
        answer[l] = (tfa_answer){.error_estimate = NAN};
    s->lanes_diverged = 0;
    TFA_V(load)(s, request, k, count);
#if NUM_LANES == 1
    if (request->flags & (FLAGS_TIP_MOTION | TFA_WANT_POSES))
        TFA_V(locate_tips)(s);
#endif
    answer->status = answer_op(s, request, k, reply, answer);
    if (answer->status == TFA_OK && wants_joint_forces(s, request, reply) &&
        !TFA_V(answer_joint_forces_loaded)(s, request, reply))
        answer->status = TFA_E_NOT_COMPUTED;
#if NUM_LANES == 1
    if (answer->status == TFA_OK && is_operational(request))
        answer->status = TFA_V(answer_operational)(s, request, k, reply, answer);
    if (request->flags && !TFA_V(answer_motion_loaded)(s, request, request->flags, k, reply) &&
        answer->status == TFA_OK)
        answer->status = TFA_E_NOT_COMPUTED;
#endif
    if (answer->status == TFA_E_SINGULAR) {
        reply->field = TFA_FIELD_BODY;
        reply->index = s->body[s->bad_body].link;
    }
    for (uint32_t l = 1; l < count; l++) {
        answer[l].status = answer->status;
        answer[l].method = answer->method;
        answer[l].flags = answer->flags;
    }
    see_limits(s, answer);
    if (s->lanes_diverged) {
        s->have = 0;
        return TFA_E_NOT_COMPUTED;
    }
    return answer->status;
}
