/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cases of the laws of operational space. See operational.h.
 */
#include "operational.h"

#include "dynamics/reductions/reductions.h"
#include "model/model.h"
#include "test.h"

#define WRENCHES 2
#define SEEDS 40                      /* reduced robots */
#define CHAIN_SEEDS test_extent(1, 2) /* of each mechanism */

static void (*current_law)(op_case *c);

void *op_alloc(size_t count, size_t size)
{
    void *memory = calloc(count + 1, size);
    assert_non_null(memory);
    return memory;
}

/* ---- robots ---- */

/* A payload on a link that is not between fused joints, in both requests, after `before` others of
 * the model. */
static void add_payload(op_case *c, const double *before, const uint32_t *links, uint32_t count)
{
    uint32_t frame = random_below(&c->s, c->link_count);
    for (size_t k = 0; k < (size_t)count * TFA_PAYLOAD_NUMBERS; k++)
        c->all_numbers[k] = before[k];
    for (uint32_t k = 0; k < count; k++)
        c->whole_r.payload_frames[k] = links[k];
    c->whole_r.payloads = c->all_numbers;
    c->whole_r.payload_count = count;
    if (c->model->frame[frame].part)
        return;
    random_payload(&c->s, c->numbers);
    memcpy(c->all_numbers + (size_t)count * TFA_PAYLOAD_NUMBERS, c->numbers,
           TFA_PAYLOAD_NUMBERS * sizeof *c->numbers);
    c->r.payloads = c->numbers;
    c->r.payload_count = 1;
    c->r.payload_frames[0] = frame;
    c->whole_r.payload_frames[count] = c->link[frame];
    c->whole_r.payload_count = count + 1;
}

static void find_links(op_case *c)
{
    c->link_count = tfa_model_frame_count(c->model);
    assert_true(c->link_count <= OP_FREEDOMS && c->n <= OP_FREEDOMS);
    for (uint32_t f = 0; f < c->link_count; f++)
        for (uint32_t k = 0; k < c->whole->link_count; k++)
            if (strcmp(tfa_model_frame(c->model, f).name, c->whole->links[k].name) == 0)
                c->link[f] = k;
}

/* mechanism: -1: none */
static bool carries_heavy(int mechanism)
{
    return mechanism == CHAIN_SWELLING || mechanism == CHAIN_HEAVY_TIP ||
           mechanism == CHAIN_HEAVY_SPOTS || mechanism == CHAIN_LIGHT_HEAVY;
}

static void with_states(test_robot *robot, random_states *x, int mechanism)
{
    op_case c = {.base = robot->base,
                 .model = robot->model,
                 .f64 = robot->f64,
                 .f128 = robot->f128,
                 .f32 = robot->f32,
                 .whole = robot->description,
                 .o = robot->o,
                 .n = robot->n,
                 .six = robot->n - robot->nv,
                 .nv = robot->nv,
                 .nq = robot->nq,
                 .file = !robot->random,
                 .chain = mechanism >= 0,
                 .heavy = carries_heavy(mechanism),
                 .whole_nv = robot->nv,
                 .damped = robot->lossy,
                 .friction_velocity = robot->lossy ? TFA_FRICTION_VELOCITY : 0,
                 .s = {robot->seed * 7 + robot->n}};
    snprintf(c.name, sizeof c.name, "%s", robot->name);
    find_links(&c);
    c.r = c.whole_r = fixture_request(robot, x);
    if (robot->seed % 2)
        add_payload(&c, NULL, NULL, 0);
    current_law(&c);
}

static void with_fixture(test_robot *robot)
{
    random_states *x = fixture_states(robot, 31, OP_STATES, WRENCHES);
    with_states(robot, x, -1);
    random_states_free(x);
}

/* In the mechanism's own coordinates */
static void with_chain(chain_mechanism mechanism, uint64_t seed, tfa_base base)
{
    const uint32_t links = mechanism == CHAIN_HEAVY_SPOTS ? 42 : 8 + 4 * (uint32_t)seed;
    test_robot robot;
    fixture_open_chain(mechanism, links, seed, base, &robot);
    random_states *x = fixture_states(&robot, 31, OP_STATES, WRENCHES);
    for (uint64_t k = 0; k < OP_STATES; k++)
        chain_coordinates(mechanism, robot.description, seed + k, x->q + k * robot.nq);
    with_states(&robot, x, (int)mechanism);
    random_states_free(x);
    fixture_close(&robot);
}

static void with_reduced(uint64_t seed, tfa_base base)
{
    reduction r;
    question a;
    reduction_open(&r, seed, REDUCE_ANYTHING, base);
    if (r.n == 0 || !question_open(&a, &r, seed, OP_STATES, WRENCHES)) {
        reduction_close(&r);
        return;
    }
    op_case c = {.base = base,
                 .model = r.model,
                 .f64 = r.f64,
                 .f128 = r.f128,
                 .f32 = r.mixed,
                 .whole = r.whole,
                 .o = r.o,
                 .tie = r.tie,
                 .n = r.n,
                 .six = r.n - r.nv,
                 .nv = r.nv,
                 .nq = r.nq,
                 .whole_nv = r.whole_nv,
                 .damped = r.options.damping,
                 .friction_velocity = reduction_friction_velocity(&r.options),
                 .r = a.r,
                 .whole_r = a.whole,
                 .s = {seed}};
    snprintf(c.name, sizeof c.name, "%s", r.name);
    find_links(&c);
    add_payload(&c, r.payloads, r.payload_links, r.payload_count);
    current_law(&c);
    question_close(&a);
    reduction_close(&r);
}

void op_for_each(op_robots robots, void (*law)(op_case *c))
{
    current_law = law;
    if (robots & OP_FIXTURE)
        for_every_robot(with_fixture, false);
    for (int mechanism = 0; robots & OP_CHAINS && mechanism < CHAIN_MECHANISMS; mechanism++)
        for (uint64_t seed = 1; seed <= CHAIN_SEEDS; seed++)
            for (int base = 0; base < 2; base++)
                with_chain((chain_mechanism)mechanism, seed,
                           base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
    for (uint64_t seed = 5001; robots & OP_REDUCED && seed <= 5000 + SEEDS; seed++)
        for (int base = 0; base < 2; base++)
            with_reduced(seed, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
}

/* ---- locked joints ---- */

bool op_lock(op_case *c)
{
    uint8_t still[OP_FREEDOMS] = {0};
    const uint32_t all = c->six + c->whole_nv;
    assert_true(all <= OP_FREEDOMS);
    c->r.locked = c->locked;
    c->r.locked_count = 0;
    for (uint32_t k = 0; k < tfa_model_joint_count(c->model); k++) {
        const tfa_joint_info info = tfa_model_joint(c->model, k);
        if (random_below(&c->s, 3) > 0)
            continue;
        c->locked[c->r.locked_count++] = k;
        for (uint32_t i = 0; i < info.v_count; i++)
            still[c->six + info.v_index + i] = 1;
    }
    for (uint32_t k = 0; k < all; k++) {
        c->free_tie[k] = c->tie ? c->tie[k] : (oracle_tie){k, 1};
        c->locked_tie[k] = c->free_tie[k];
        if (c->locked_tie[k].to != ORACLE_STILL && still[c->locked_tie[k].to])
            c->locked_tie[k].to = ORACLE_STILL;
    }
    tfa_reply reply = {0};
    tfa_request r = c->r;
    r.op = TFA_OP_FORWARD_DYNAMICS;
    if (tfa_request_check(c->model, &r, &reply) != TFA_OK) /* followers without mass */
        c->r.locked_count = 0;
    return c->r.locked_count > 0;
}

void op_unlock(op_case *c)
{
    c->r.locked = NULL;
    c->r.locked_count = 0;
}

void op_set_state(op_case *c, uint32_t k)
{
    c->motion_of = 0;
    oracle_tie_freedoms(c->o, c->tie, c->n);
    oracle_set_state(c->o, &c->whole_r, k);
}

void op_set_motion(op_case *c, uint32_t k)
{
    if (c->motion_of != k + 1)
        op_set_state(c, k);
    c->motion_of = k + 1;
}

void op_set_state_locked(op_case *c, uint32_t k)
{
    c->motion_of = 0;
    oracle_tie_freedoms(c->o, c->r.locked_count ? c->locked_tie : c->tie, c->n);
    oracle_set_state(c->o, &c->whole_r, k);
}

/* ---- requests ---- */

void op_choose_tips(op_case *c, uint32_t count, tfa_rows rows, tfa_reference_frame frame)
{
    c->r.tip_count = c->whole_r.tip_count = count;
    c->r.rows = rows;
    c->r.frame = c->whole_r.frame = frame;
    for (uint32_t t = 0; t < count; t++) {
        c->r.tips[t] = random_below(&c->s, c->link_count);
        c->whole_r.tips[t] = c->link[c->r.tips[t]];
    }
}

void op_choose_method(op_case *c, tfa_request *r)
{
    const bool singular = tfa_model_summarise(c->model).singular_body >= 0;
    uint32_t methods = 0;
    while (tfa_method_describe(methods) &&
           !(tfa_method_describe(methods)->refuses & TFA_REFUSES_TIPS)) /* they stand last */
        methods++;
    r->estimate = (tfa_estimate)random_below(&c->s, 3);
    for (int attempt = 0; attempt < 20; attempt++) {
        const tfa_method_info *row = tfa_method_describe(random_below(&c->s, methods));
        tfa_reply reply = {0};
        r->method = row->method;
        if (c->chain && (row->refuses & TFA_REFUSES_NO_INVERSE || row->method == TFA_METHOD_CRBA))
            continue;
        if (!(singular && row->refuses & TFA_REFUSES_NO_INVERSE) &&
            tfa_request_check(c->model, r, &reply) == TFA_OK)
            return;
    }
    r->method = TFA_METHOD_AUTO;
}

oracle_tips op_tips(const op_case *c)
{
    return (oracle_tips){c->whole_r.tips, c->r.tip_count, c->r.rows == TFA_ROWS_POINT ? 3 : 6,
                         c->r.frame};
}

uint32_t op_rows(const op_case *c)
{
    return c->r.tip_count * (c->r.rows == TFA_ROWS_POINT ? 3 : 6);
}

void op_velocities(const op_case *c, uint32_t k, double *v)
{
    for (uint32_t i = 0; i < c->n; i++) {
        const double *from = i < c->six ? c->r.base_twist : c->r.v;
        const size_t at = i < c->six ? 6 * (size_t)k + i : (size_t)k * c->nv + i - c->six;
        v[i] = from ? from[at] : 0;
    }
}

static const double *advance(const double *x, size_t step)
{
    return x ? x + step : NULL;
}

tfa_request op_state(const op_case *c, uint32_t k)
{
    tfa_request r = c->r;
    const size_t joints = (size_t)k * c->nv, six = 6 * (size_t)k;
    r.count = 1;
    r.q = advance(r.q, (size_t)k * c->nq);
    r.v = advance(r.v, joints);
    r.tau = advance(r.tau, joints);
    r.qdd = advance(r.qdd, joints);
    r.base_pose = advance(r.base_pose, 7 * (size_t)k);
    r.base_twist = advance(r.base_twist, six);
    r.base_wrench = advance(r.base_wrench, six);
    r.base_acceleration = advance(r.base_acceleration, six);
    r.wrenches = advance(r.wrenches, six * r.wrench_count);
    r.task_acceleration = advance(r.task_acceleration, (size_t)k * op_rows(c));
    return r;
}

/* ---- answers ---- */

/* The arrays of doubles of a reply, and the numbers of each for a state. */
/* clang-format off */
#define ARRAYS(X) \
    X(qdd, a->nv) X(tau, a->nv) X(base_acceleration, 6) X(base_wrench, 6) X(lambda_inv, m * m) \
    X(mass_matrix, n * n) X(poses, a->tips * 7) X(frame_poses, a->frames * 7) \
    X(twists, a->tips * 6) X(jacobian, m * n) X(bias_acceleration, m) X(com, 3) X(com_velocity, 3) \
    X(com_jacobian, 3 * n) X(mass, 1) X(momentum, 6) X(energy, 2) X(lambda, m * m) X(mu, m) \
    X(p, m) X(lost, TFA_LOST_MAX * (2 + m)) X(gravity_force, n) X(velocity_force, n) \
    X(damping_force, n) X(external_force, n) X(armature_force, n) X(joint_forces, a->frames * 6) \
    X(friction_force, n) X(generalised_momentum, n) X(momentum_rate, n) \
    X(regressor, n * 10 * a->tips) X(joint_regressor, a->nv * 3)
/* clang-format on */

/* Lays out the arrays from `at` on; returns how many numbers they are. */
static size_t lay_out(op_answers *a, double *at)
{
    double *const start = at;
    const size_t n = a->n, m = a->rows;
#define PLACE(name, numbers)                                                                       \
    a->name = at;                                                                                  \
    at += a->count * (size_t)(numbers);
    ARRAYS(PLACE)
    return (size_t)(at - start);
}

static void fill_reply(op_answers *a)
{
#define INTO(name, numbers) .name = a->name,
    a->reply =
        (tfa_reply){ARRAYS(INTO).spectrum = a->spectrum, .rank = a->rank, .answers = a->answers};
}

op_answers *op_answers_create(const op_case *c, const tfa_request *r)
{
    op_answers *a = op_alloc(1, sizeof *a);
    a->count = r->count;
    a->n = c->n;
    a->nv = c->nv;
    a->tips = r->tip_count;
    a->rows = r->tip_count * (r->rows == TFA_ROWS_POINT ? 3 : 6);
    a->frames = c->link_count;
    a->memory = op_alloc(1, sizeof *a->memory);
    a->size = lay_out(a, a->memory);
    free(a->memory);
    a->memory = op_alloc(a->size, sizeof *a->memory);
    lay_out(a, a->memory);
    a->rank = op_alloc(r->count, sizeof *a->rank);
    a->spectrum = op_alloc(r->count, sizeof *a->spectrum);
    a->answers = op_alloc(r->count, sizeof *a->answers);
    op_answers_clear(a);
    return a;
}

void op_answers_clear(op_answers *a)
{
    for (size_t k = 0; k < a->size; k++)
        a->memory[k] = NAN;
    memset(a->rank, 0xff, a->count * sizeof *a->rank);
    memset(a->spectrum, 0xff, a->count * sizeof *a->spectrum);
    memset(a->answers, 0, a->count * sizeof *a->answers);
    fill_reply(a);
}

void op_answers_free(op_answers *a)
{
    free(a->answers);
    free(a->spectrum);
    free(a->rank);
    free(a->memory);
    free(a);
}

void op_compute(const op_case *c, tfa_workspace *w, const tfa_request *r, op_answers *a)
{
    op_answers_clear(a);
    const int status = tfa_compute(w, r, &a->reply);
    if (status != TFA_OK)
        fail_msg("%s: op %d, %s: %s (%s %u of state %u)", c->name, (int)r->op,
                 tfa_method_name((uint32_t)r->method), tfa_status_text(status),
                 tfa_field_name(a->reply.field), (unsigned)a->reply.index,
                 (unsigned)a->reply.state);
}

op_answers *op_answer(const op_case *c, tfa_workspace *w, const tfa_request *r)
{
    op_answers *a = op_answers_create(c, r);
    op_compute(c, w, r, a);
    return a;
}

/* ---- outputs ---- */

const tfa_op op_ops[OP_OPS] = {TFA_OP_KINEMATICS,          TFA_OP_FORWARD_DYNAMICS,
                               TFA_OP_INVERSE_DYNAMICS,    TFA_OP_MASS_MATRIX,
                               TFA_OP_OPERATIONAL_INERTIA, TFA_OP_BIAS,
                               TFA_OP_TASK_TORQUES,        TFA_OP_REGRESSOR};

bool op_has_lambda(tfa_op op)
{
    return op == TFA_OP_FORWARD_DYNAMICS || op == TFA_OP_OPERATIONAL_INERTIA ||
           op == TFA_OP_TASK_TORQUES;
}

uint32_t op_flags(tfa_op op)
{
    const uint32_t forces =
        op == TFA_OP_FORWARD_DYNAMICS || op == TFA_OP_INVERSE_DYNAMICS ? TFA_WANT_JOINT_FORCES : 0;
    const uint32_t others = TFA_WANT_ALL & ~(TFA_WANT_JOINT_FORCES | TFA_WANT_DELASSUS);
    return (op_has_lambda(op) ? others : OP_KINEMATICS) | forces;
}

const char *const op_output_names[TFA_WIRE_REPLY_BLOCKS] = {
#define NAME(name, member, ...) #member,
    TFA_OUTPUT_LIST(NAME)
#undef NAME
};

size_t op_numbers(const op_answers *a, uint32_t output)
{
    const tfa_extents n = {
        .v = a->nv, .base = a->n - a->nv, .links = a->frames, .tips = a->tips, .rows = a->rows};
    return tfa_extent(tfa_outputs[output].rows, &n) * tfa_extent(tfa_outputs[output].columns, &n);
}

void *op_output(const op_answers *a, uint32_t output, uint32_t state)
{
    char *at = tfa_output_buffer(&tfa_outputs[output], &a->reply);
    return at ? at + state * op_numbers(a, output) * tfa_outputs[output].size : NULL;
}

bool op_asked(const tfa_request *r, uint32_t output)
{
    return r->flags & tfa_outputs[output].flags || TFA_OP_BIT(r->op) & tfa_outputs[output].ops;
}

uint64_t op_outputs_of(uint32_t flags)
{
    uint64_t outputs = 0;
    for (uint32_t o = 0; o < TFA_WIRE_REPLY_BLOCKS; o++)
        outputs |= (uint64_t)((tfa_outputs[o].flags & flags) != 0) << o;
    return outputs;
}

void op_same(const op_case *c, const char *what, const op_answers *a, uint32_t k,
             const op_answers *b, uint32_t l, uint64_t outputs)
{
    for (uint32_t o = 0; o < TFA_WIRE_REPLY_BLOCKS; o++) {
        const void *x = op_output(a, o, k), *y = op_output(b, o, l);
        if (outputs >> o & 1 && x && memcmp(x, y, op_numbers(a, o) * tfa_outputs[o].size) != 0)
            fail_msg("%s, %s: %s of state %u differs", c->name, what, op_output_names[o],
                     (unsigned)k);
    }
}

void op_forces(const op_case *c, const op_answers *a, uint32_t k, double *tau)
{
    memcpy(tau, a->base_wrench + 6 * (size_t)k, c->six * sizeof *tau);
    memcpy(tau + c->six, a->tau + (size_t)k * c->nv, c->nv * sizeof *tau);
}

void op_move(const op_case *c, tfa_workspace *w, uint32_t k, const double *tau, double *qdd)
{
    tfa_request q = op_state(c, k);
    q.op = TFA_OP_FORWARD_DYNAMICS;
    q.tip_count = 0;
    q.tau = tau + c->six;
    q.base_wrench = tau;
    op_answers *b = op_answer(c, w, &q);
    memcpy(qdd, b->base_acceleration, c->six * sizeof *qdd);
    memcpy(qdd + c->six, b->qdd, c->nv * sizeof *qdd);
    op_answers_free(b);
}

double op_tip_acceleration(const op_answers *a, uint32_t k, const double *qdd, double *x)
{
    const uint32_t m = a->rows, n = a->n;
    const double *J = a->jacobian + (size_t)k * m * n;
    const double *bias = a->bias_acceleration + (size_t)k * m;
    for (uint32_t i = 0; i < m; i++) {
        x[i] = bias[i];
        for (uint32_t j = 0; j < n; j++)
            x[i] += J[(size_t)i * n + j] * qdd[j];
    }
    return norm2(J, (size_t)m * n) * norm2(qdd, n) + norm2(bias, m);
}

/* ---- numbers ---- */

void op_within(const op_case *c, op_bound *bound, double error)
{
    if (!(error <= bound->bound[c->set]))
        fail_msg("%s: %s (%u): error %.3g, bound %g", c->name, bound->name, (unsigned)c->set, error,
                 bound->bound[c->set]);
    bound->worst[c->set] = fmax(bound->worst[c->set], error);
}

void op_print(const op_bound *bounds, size_t count)
{
    for (const op_bound *b = bounds; b < bounds + count; b++)
        for (int set = 0; set < OP_SETS && b->bound[set] > 0; set++)
            print_message("  %-38s %d: worst %.2g, bound %g\n", b->name, set, b->worst[set],
                          b->bound[set]);
}

double op_norm_quad(const quad *x, size_t n)
{
    quad sum = 0;
    for (size_t k = 0; k < n; k++)
        sum += x[k] * x[k];
    return (double)quad_sqrt(sum);
}

static double ratio(double difference, double size)
{
    return size > 0 ? difference / size : difference;
}

double op_error(const double *x, const quad *want, size_t n, double scale)
{
    quad sum = 0;
    for (size_t k = 0; k < n; k++)
        sum += (x[k] - want[k]) * (x[k] - want[k]);
    const double size = fmax(op_norm_quad(want, n), scale);
    return isnan((double)sum) ? (double)NAN : ratio((double)quad_sqrt(sum), size);
}

double op_difference(const double *x, const double *want, size_t n, double scale)
{
    double sum = 0;
    for (size_t k = 0; k < n; k++)
        sum += (x[k] - want[k]) * (x[k] - want[k]);
    return ratio(sqrt(sum), fmax(norm2(want, n), scale));
}
