/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See cost_bound.h.
 */
#include "worker/cost_bound.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ipc/wire.h"
#include "ipc/wire_reply.h"
#include "worker/posture.h"

#define CALLS 3    /* the shortest one counts; two that are near each other suffice */
#define MARGIN 1.5 /* on the sum: docs/tuning.md */

/* ---- additions ---- */

static const uint32_t flag_groups[] = {
    TFA_WANT_SPECTRUM,
    TFA_WANT_LAMBDA,
    TFA_WANT_MU | TFA_WANT_P,
    TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_POSES | TFA_WANT_TWISTS,
    TFA_WANT_FRAME_POSES,
    TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY,
    TFA_WANT_JOINT_FORCES,
    TFA_WANT_DELASSUS,
};
enum { FLAG_GROUPS = sizeof flag_groups / sizeof *flag_groups, WRENCHES = FLAG_GROUPS };
enum { PAYLOADS = WRENCHES + 1, LOCKED = PAYLOADS + 1 };
_Static_assert(LOCKED + 1 == TFA_COST_ADDITIONS && TFA_METHOD_HYBRID + 1 == TFA_COST_METHODS,
               "one for each");

static bool has(const tfa_request *r, int addition)
{
    switch (addition) {
    case WRENCHES:
        return r->wrench_count != 0;
    case PAYLOADS:
        return r->payload_count != 0;
    case LOCKED:
        return r->locked_count != 0;
    default:
        return (r->flags & flag_groups[addition]) != 0;
    }
}

static void add(tfa_request *r, int addition)
{
    switch (addition) {
    case WRENCHES:
        r->wrench_count = TFA_MAX_WRENCHES;
        break;
    case PAYLOADS:
        r->payload_count = TFA_MAX_PAYLOADS;
        break;
    case LOCKED:
        r->locked_count = 1;
        break;
    default:
        r->flags = flag_groups[addition];
    }
}

/* ---- requests that are measured ---- */

/* A request that any op accepts, and memory for its answers */
typedef struct meter {
    const tfa_worker_robot *robot;
    tfa_request request;
    double *q[2]; /* in turns: a solver may keep the factors of the last one */
    double *numbers;
    void *reply;
    uint32_t constraints; /* of the robot */
} meter;

static const double pose[7] = {0, 0, 0, 0, 0, 0.6, 0.8};
#define PAYLOAD                                                                                    \
    {                                                                                              \
        1, 0, 0, 0.01, 0.01, 0, 0, 0.01, 0, 0.01                                                   \
    }
static const double payloads[TFA_MAX_PAYLOADS][TFA_PAYLOAD_NUMBERS] = {PAYLOAD, PAYLOAD, PAYLOAD,
                                                                       PAYLOAD};
static const uint32_t first_joint[1];

static void set_arrays(meter *m)
{
    const double *x = m->numbers;
    tfa_request *r = &m->request;
    *r = (tfa_request){.refine = TFA_REFINE_DEFAULT,
                       .count = 1,
                       .v = x,
                       .tau = x,
                       .qdd = x,
                       .task_acceleration = x,
                       .constraint_acceleration = x,
                       .wrenches = x,
                       .locked = first_joint,
                       .payloads = payloads[0]};
    if (m->robot->shape.base_freedoms) {
        r->base_pose = pose;
        r->base_twist = r->base_wrench = r->base_acceleration = x;
    }
}

/* The deepest frame of a body that is not taken; `none`: there is none. @param depth  by body; 0:
 * taken */
static uint32_t deepest_frame(const tfa_model *model, const uint32_t *depth, uint32_t none)
{
    uint32_t best = none, most = 0;
    for (uint32_t i = 0; i < tfa_model_frame_count(model); i++) {
        const int32_t body = tfa_model_frame(model, i).body;
        if (body >= 0 && depth[body] > most) {
            best = i;
            most = depth[body];
        }
    }
    return best;
}

/* Deep ones and some all over the tree in turns: which cost more depends on the method. */
static int set_tips(const tfa_model *model, tfa_request *r)
{
    const uint32_t frames = tfa_model_frame_count(model);
    const uint32_t bodies = tfa_model_summarise(model).bodies;
    uint32_t *depth = calloc((size_t)bodies + 1, sizeof *depth);
    if (!depth)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < bodies; i++) {
        const int32_t parent = tfa_model_body_parent(model, i);
        depth[i] = 1 + (parent < 0 ? 0 : depth[parent]);
    }
    for (uint32_t k = 0; k < TFA_MAX_TIPS; k++) {
        r->tips[k] = k % 2 ? (uint32_t)((uint64_t)frames * ((k * 5 / 2) % 16 + 1) / 17)
                           : deepest_frame(model, depth, r->tips[0]);
        const int32_t body = tfa_model_frame(model, r->tips[k]).body;
        if (body >= 0)
            depth[body] = 0;
    }
    for (uint32_t k = 0; k < TFA_MAX_WRENCHES; k++)
        r->wrench_frames[k] = r->payload_frames[k % TFA_MAX_PAYLOADS] = r->tips[0];
    free(depth);
    return TFA_OK;
}

static void close_meter(meter *m)
{
    free(m->q[0]);
    free(m->reply);
}

static int open_meter(const tfa_model *model, const tfa_worker_robot *robot, meter *m)
{
    const size_t states = robot->shape.v_count + 6 * TFA_MAX_TIPS, q = robot->shape.q_count;
    tfa_wire_shape shape = robot->shape;
    shape.max_batch = 1;
    *m = (meter){.robot = robot, .constraints = tfa_model_constraint_count(model)};
    m->q[0] = calloc(2 * q + states, sizeof(double));
    m->reply = calloc(1, tfa_wire_reply_capacity(&shape));
    if (!m->q[0] || !m->reply) {
        close_meter(m);
        return TFA_E_MEMORY;
    }
    m->q[1] = m->q[0] + q;
    m->numbers = m->q[1] + q;
    for (size_t i = 0; i < states; i++)
        m->numbers[i] = 0.3 - 0.1 * (double)(i % 7);
    tfa_posture_set(model, 0.1, pose + 3, m->q[0]);
    tfa_posture_set(model, 0.2, pose + 3, m->q[1]);
    set_arrays(m);
    const int status = set_tips(model, &m->request);
    if (status != TFA_OK)
        close_meter(m);
    return status;
}

/* ---- measuring ---- */

static uint64_t processor_time(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* As a value of tfa_cost_curve */
static uint32_t measure(const meter *m, const tfa_request *kind)
{
    const uint64_t most = CONFIG_STATE_US_MOST * 1000u;
    uint64_t least = UINT64_MAX;
    bool agree = false;
    tfa_reply reply = {0};
    const tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&m->robot->shape, kind);
    if (tfa_wire_check_reply_shape(&m->robot->shape, &shape, &reply.field) != TFA_OK)
        return 0;
    tfa_wire_reply_buffers(&m->robot->shape, &shape, m->reply, &reply);
    for (int k = 0; k < CALLS && !agree; k++) {
        tfa_request r = *kind;
        r.q = m->q[k % 2];
        const uint64_t start = processor_time();
        const int status = m->robot->solve(m->robot->self, &r, &reply, 0, 1);
        const uint64_t ns = processor_time() - start + 1;
        if (!tfa_wire_has_answers(status))
            return 0;
        agree = ns > 4 * most || (k && ns < least + least / 4);
        least = ns < least ? ns : least;
    }
    return least <= most ? (uint32_t)least : UINT32_MAX;
}

/* As many constraints as there are tips, if the robot has them */
static void set_constraints(const meter *m, tfa_request *kind)
{
    const uint32_t all = tfa_all_constraints(m->constraints), tips = kind->tip_count;
    kind->constraints = tips < TFA_MAX_CONSTRAINTS ? all & ((1u << tips) - 1) : all;
}

/* From few tips to many; once it takes too long, so does the rest. Constraints that are refused,
 * because they are on too many links, stand in proportion to fewer of them. */
static void measure_curve(const meter *m, tfa_request *kind, const uint32_t *tips,
                          tfa_cost_curve *curve)
{
    const bool constrained = (TFA_OP_BIT(kind->op) & TFA_OPS_CONSTRAINED) != 0;
    for (int k = 0; k < TFA_COST_POINTS; k++) {
        const uint32_t before = k ? curve->at[k - 1] : 0;
        kind->tip_count = tips[k];
        if (constrained)
            set_constraints(m, kind);
        curve->at[k] = before == UINT32_MAX ? UINT32_MAX : measure(m, kind);
        if (constrained && !curve->at[k] && before)
            curve->at[k] = (uint32_t)((uint64_t)before * tips[k] / tips[k - 1]);
    }
}

static void measure_method(const meter *m, tfa_cost_parts *parts, int op, int method)
{
    tfa_request kind = m->request;
    kind.op = (tfa_op)op;
    kind.method = (tfa_method)method;
    measure_curve(m, &kind, parts->tips, &parts->of[op][method].plain);
    kind.refine = TFA_MAX_REFINE;
    measure_curve(m, &kind, parts->tips, &parts->of[op][method].refined);
    kind.refine = TFA_REFINE_DEFAULT;
    kind.estimate = TFA_ESTIMATE_ALWAYS;
    measure_curve(m, &kind, parts->tips, &parts->of[op][method].estimated);
}

/* What it adds to requests of the same estimate, where that is more than before. */
static void measure_added(const meter *m, tfa_cost_parts *parts, tfa_request *kind,
                          const tfa_cost_curve *without, tfa_cost_curve *added)
{
    tfa_cost_curve with;
    measure_curve(m, kind, parts->tips, &with);
    for (int k = 0; k < TFA_COST_POINTS; k++) {
        const uint32_t more = with.at[k] == UINT32_MAX         ? UINT32_MAX
                              : with.at[k] > without->at[k] ? with.at[k] - without->at[k]
                                                            : 0;
        added->at[k] = more > added->at[k] ? more : added->at[k];
    }
}

/* An estimate of lambda costs more than those of both. */
static void measure_addition(const meter *m, tfa_cost_parts *parts, int op, int addition)
{
    tfa_request kind = m->request;
    kind.op = (tfa_op)op;
    add(&kind, addition);
    measure_added(m, parts, &kind, &parts->of[op][TFA_METHOD_AUTO].plain,
                  &parts->added[op][addition]);
    kind.estimate = TFA_ESTIMATE_ALWAYS;
    measure_added(m, parts, &kind, &parts->of[op][TFA_METHOD_AUTO].estimated,
                  &parts->added[op][addition]);
}

int tfa_cost_measure(const tfa_model *model, const tfa_worker_robot *robot, tfa_cost_parts *parts)
{
    meter m;
    const uint32_t most = robot->shape.max_tips;
    const int status = open_meter(model, robot, &m);
    if (status != TFA_OK)
        return status;
    static const uint32_t points[TFA_COST_POINTS] = {0, 1, 3, TFA_DEFAULT_TIPS, UINT32_MAX};
    memset(parts, 0, sizeof *parts);
    for (int k = 0; k < TFA_COST_POINTS; k++)
        parts->tips[k] = points[k] < most ? points[k] : most;
    for (int op = 1; op <= TFA_OP_LAST; op++) {
        for (int method = 0; method < TFA_COST_METHODS; method++)
            if (tfa_method_describe((uint32_t)method)->ops & TFA_OP_BIT(op))
                measure_method(&m, parts, op, method);
        for (int addition = 0; addition < TFA_COST_ADDITIONS; addition++)
            measure_addition(&m, parts, op, addition);
    }
    close_meter(&m);
    return TFA_OK;
}

/* ---- the bound ---- */

/* The line through the points; beyond the last one in proportion. */
static double between(const uint32_t *tips, const tfa_cost_curve *curve, uint32_t at)
{
    int k = 0;
    while (k < TFA_COST_POINTS && tips[k] < at)
        k++;
    if (k == TFA_COST_POINTS)
        return (double)curve->at[k - 1] * at / tips[k - 1];
    if (tips[k] == at)
        return curve->at[k];
    const double part = (double)(at - tips[k - 1]) / (tips[k] - tips[k - 1]);
    return curve->at[k - 1] + part * ((double)curve->at[k] - curve->at[k - 1]);
}

uint32_t tfa_cost_bound(const tfa_cost_parts *parts, const tfa_request *r)
{
    if (!parts)
        return UINT32_MAX;
    if ((int)r->op < 1 || r->op > TFA_OP_LAST || (uint32_t)r->method >= TFA_COST_METHODS)
        return 1;
    /* a point has half the rows of a pose, and the same path to the root */
    const uint32_t of_tips = r->rows == TFA_ROWS_POINT ? (3 * r->tip_count + 3) / 4 : r->tip_count;
    const uint32_t closed = (uint32_t)(tfa_constraint_numbers(r) / 6);
    const uint32_t tips = closed > of_tips ? closed : of_tips;
    const double plain = between(parts->tips, &parts->of[r->op][r->method].plain, tips);
    double ns = plain;
    if (r->refine <= TFA_MAX_REFINE) {
        const double more = between(parts->tips, &parts->of[r->op][r->method].refined, tips);
        ns += more > plain ? (more - plain) * r->refine / TFA_MAX_REFINE : 0;
    }
    if (r->estimate == TFA_ESTIMATE_ALWAYS) {
        const double more = between(parts->tips, &parts->of[r->op][r->method].estimated, tips);
        ns += more > plain ? more - plain : 0;
    }
    for (int k = 0; k < TFA_COST_ADDITIONS; k++)
        if (has(r, k))
            ns += between(parts->tips, &parts->added[r->op][k], tips);
    ns *= MARGIN;
    return ns < 1 ? 1 : ns < UINT32_MAX ? (uint32_t)ns : UINT32_MAX;
}
