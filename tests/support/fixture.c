/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The list of robots the laws are tested with. See fixture.h.
 */
#include "fixture.h"

#include "kernels.h"
#include "models.h"
#include "test.h"

#include <glob.h>

static const struct {
    const char *name;
    random_robot_options options;
} kinds[] = {
    /* shape, joints, all types, fixed joints, armature, shuffled */
    {"one joint", {RANDOM_CHAIN, 1, true, 0, 0, false}},
    {"chain of 2", {RANDOM_CHAIN, 2, false, 0, 0, false}},
    {"chain of 7", {RANDOM_CHAIN, 7, false, 0.3, 0.5, false}},
    {"chain of 20", {RANDOM_CHAIN, 20, false, 0, 0, false}},
    {"mixed chain of 6", {RANDOM_CHAIN, 6, true, 0.3, 0.3, true}},
    {"star of 20", {RANDOM_STAR, 20, false, 0.2, 0.3, false}},
    {"mixed star of 15", {RANDOM_STAR, 15, true, 0.3, 0.3, true}},
    {"tree of 16", {RANDOM_BRANCHING, 16, false, 0.3, 0, true}},
    {"mixed tree of 24", {RANDOM_BRANCHING, 24, true, 0.4, 0.3, true}},
};
#define KINDS ((uint32_t)(sizeof kinds / sizeof *kinds))

/* Random robots of each kind */
static uint32_t count_seeds(void)
{
    return test_extent(1, 3);
}

/* File number `index`, in alphabetical order, our own first. 1 when there is one. */
static int find_file(uint32_t index, char *path, size_t size, bool *own)
{
    static const char *const folders[] = {TFA_SOURCE_DIR "/config/robots/*.urdf",
                                          TFA_SOURCE_DIR "/../shared/robots/*.urdf"};
    int found = 0;
    for (int k = 0; k < 2 && !found; k++) {
        glob_t g = {0};
        if (glob(folders[k], 0, NULL, &g) == 0) {
            if (index < g.gl_pathc) {
                snprintf(path, size, "%s", g.gl_pathv[index]);
                *own = k == 0;
                found = 1;
            } else {
                index -= (uint32_t)g.gl_pathc;
            }
        } else if (k == 1 && index == 0) {
            print_message("SKIP: no robots in %s\n", folders[k]);
        } else if (k == 0) {
            fail_msg("no robots in %s", folders[k]);
        }
        globfree(&g);
    }
    return found;
}

/* A robot that cannot be had: our own must be, others are skipped. The first error says why. */
static void give_up(const test_robot *robot, const tfa_report *report, bool own)
{
    size_t k = 0;
    while (k < report->count && report->messages[k].severity != TFA_ERROR)
        k++;
    char text[400] = "";
    if (k < report->count)
        tfa_report_format(report, k, text, sizeof text);
    if (own)
        fail_msg("%s: %s", robot->name, text);
    print_message("SKIP: %s: %s\n", robot->name, text);
}

static void make_random(uint32_t index, test_robot *robot)
{
    uint32_t kind = index / count_seeds();
    robot->random = true;
    robot->seed = 1 + index % count_seeds();
    snprintf(robot->name, sizeof robot->name, "%s, seed %u, %s base", kinds[kind].name,
             (unsigned)robot->seed, robot->base == TFA_BASE_FLOATING ? "floating" : "fixed");
    robot->description = random_robot_create(robot->seed * 1000 + kind, &kinds[kind].options);
    robot->lossy = kind % 3 != 1;
    random_source s = {robot->seed};
    for (size_t j = 0; robot->lossy && j < robot->description->joint_count; j++) {
        tfa_joint *joint = &robot->description->joints[j];
        if (joint->type == TFA_JOINT_FLOATING)
            continue; /* galilei.c lets them fly */
        joint->damping = random_uniform(&s, 0, 0.5);
        joint->friction = random_uniform(&s, 0, 1);
    }
}

tfa_model_options fixture_options(const test_robot *robot)
{
    return (tfa_model_options){
        .base = robot->base, .damping = robot->lossy, .friction = robot->lossy};
}

static int load_file(uint32_t index, test_robot *robot, tfa_report *report, bool *own)
{
    char *path = robot->path;
    if (!find_file(index, path, sizeof robot->path, own))
        return 0;
    robot->seed = 100 + index;
    snprintf(robot->name, sizeof robot->name, "%.60s, %s base", strrchr(path, '/') + 1,
             robot->base == TFA_BASE_FLOATING ? "floating" : "fixed");
    if (tfa_urdf_load(path, &robot->description, report) == TFA_OK)
        return 1;
    give_up(robot, report, *own);
    return -1;
}

tfa_workspace *fixture_workspace(const tfa_model *model, tfa_precision precision)
{
    return fixture_mixed(model, precision, TFA_RESIDUAL_SAME);
}

tfa_workspace *fixture_mixed(const tfa_model *model, tfa_precision factors, tfa_residual residual)
{
    const int own = factors != TFA_F128 && residual == TFA_RESIDUAL_SAME;
    const tfa_workspace_options options = {.precision = factors,
                                           .residual = residual,
                                           .methods = TFA_METHODS_ALL,
                                           .specialised = own ? kernels_find(model) : NULL};
    tfa_workspace *w = NULL;
    size_t size = (tfa_workspace_size(model, &options) + 63) / 64 * 64;
    void *memory = aligned_alloc(64, size);
    assert_non_null(memory);
    memset(memory, 0xff, size);
    assert_int_equal(tfa_workspace_init(memory, size, model, &options, &w), TFA_OK);
    return w;
}

static void open_workspaces(test_robot *robot)
{
    robot->f32 = fixture_workspace(robot->model, TFA_F32);
    robot->f64 = fixture_workspace(robot->model, TFA_F64);
    robot->f128 = fixture_workspace(robot->model, TFA_F128);
    robot->o = oracle_create(robot->description, robot->base);
    assert_non_null(robot->o);
    oracle_use_damping(robot->o, robot->lossy);
    oracle_use_friction(robot->o, robot->lossy ? TFA_FRICTION_VELOCITY : 0);
    robot->n = oracle_freedoms(robot->o);
    robot->nv = oracle_v_count(robot->o);
    robot->nq = oracle_q_count(robot->o);
    assert_int_equal(tfa_model_v_count(robot->model), robot->nv);
    assert_int_equal(tfa_model_q_count(robot->model), robot->nq);
    assert_int_equal(tfa_model_base_freedoms(robot->model), robot->n - robot->nv);
}

/* Compiles and opens robot->description. 1; -1 when the library refuses it. */
static int open_model(test_robot *robot, tfa_report *report, bool own)
{
    const tfa_model_options options = fixture_options(robot);
    if (tfa_model_create(robot->description, &options, report, &robot->model) != TFA_OK) {
        give_up(robot, report, own);
        fixture_close(robot);
        return -1;
    }
    open_workspaces(robot);
    return 1;
}

void fixture_constrained(const test_robot *robot, void (*law)(test_robot *constrained))
{
    const uint32_t frames = tfa_model_frame_count(robot->model);
    const char *const last = tfa_model_frame(robot->model, frames - 1).name;
    const tfa_constraint constraints[] = {
        {.name = "ground", .link = {NULL, last}, .rows = TFA_CONSTRAINT_POINT, .unilateral = 1},
        {.name = "rod",
         .link = {tfa_model_frame(robot->model, frames / 2).name, last},
         .pose = {{0.1, 0.2, 0, 0, 0.6, 0, 0.8}, {0, 0.1, 0.3, 0, 0, 0, 1}},
         .rows = TFA_CONSTRAINT_HINGE},
    };
    for (uint32_t count = 2; count > 0; count--) {
        const tfa_scene scene = {.constraints = constraints, .constraint_count = count};
        tfa_model_options options = fixture_options(robot);
        options.scene = &scene;
        tfa_report report = {0};
        test_robot constrained = *robot;
        const int status =
            tfa_model_create(robot->description, &options, &report, &constrained.model);
        tfa_report_free(&report);
        if (status != TFA_OK)
            continue; /* links that do not move against each other */
        law(&constrained);
        tfa_model_free(constrained.model);
        return;
    }
}

void fixture_open_description(const char *name, tfa_description *d, tfa_base base,
                              test_robot *robot)
{
    const tfa_model_options options = {.base = base};
    *robot = (test_robot){.base = base, .lent = true, .description = d};
    snprintf(robot->name, sizeof robot->name, "%s", name);
    robot->model = compiled(d, &options);
    open_workspaces(robot);
}

void fixture_open_chain(chain_mechanism mechanism, uint32_t links, uint64_t seed, tfa_base base,
                        test_robot *robot)
{
    tfa_report report = {0};
    *robot = (test_robot){.base = base, .seed = seed, .random = true};
    snprintf(robot->name, sizeof robot->name, "%s of %u, seed %u, %s base",
             chain_mechanism_names[mechanism], (unsigned)links, (unsigned)seed,
             base == TFA_BASE_FLOATING ? "floating" : "fixed");
    robot->description = chain_create(mechanism, links, seed);
    open_model(robot, &report, true);
    tfa_report_free(&report);
}

void fixture_open_trees(uint64_t seed, test_robot *robot)
{
    static const random_robot_options options = {RANDOM_STAR, 24, true, 0, 0.2, false};
    tfa_report report = {0};
    *robot = (test_robot){.base = TFA_BASE_FIXED, .seed = seed, .random = true};
    snprintf(robot->name, sizeof robot->name, "trees, seed %u", (unsigned)seed);
    robot->description = random_robot_create(seed, &options);
    for (size_t j = 0, on_root = 0; j < robot->description->joint_count; j++) {
        tfa_joint *joint = &robot->description->joints[j];
        if (joint->parent != 0 || on_root++ % 3 == 2)
            continue;
        joint->type = TFA_JOINT_FLOATING;
        joint->armature = 0;
    }
    open_model(robot, &report, true);
    tfa_report_free(&report);
}

int fixture_open(uint32_t index, tfa_base base, test_robot *robot)
{
    tfa_report report = {0};
    bool own = true;
    const uint32_t random = KINDS * count_seeds();
    *robot = (test_robot){.base = base};
    if (index < random) {
        make_random(index, robot);
    } else {
        int found = load_file(index - random, robot, &report, &own);
        if (found != 1) {
            tfa_report_free(&report);
            return found;
        }
    }
    const int opened = open_model(robot, &report, own);
    tfa_report_free(&report);
    return opened;
}

void fixture_close(test_robot *robot)
{
    tfa_workspace_free(robot->f128);
    tfa_workspace_free(robot->f64);
    tfa_workspace_free(robot->f32);
    oracle_free(robot->o);
    tfa_model_free(robot->model);
    if (robot->lent)
        return;
    if (robot->random)
        random_robot_free(robot->description);
    else
        tfa_description_free(robot->description);
}

void for_every_robot(void (*law)(test_robot *robot), bool random_only)
{
    int found = 1;
    for (uint32_t index = 0; found && !(random_only && index == KINDS * count_seeds()); index++)
        for (int base = 0; base < 2; base++) {
            test_robot robot;
            found = fixture_open(index, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED, &robot);
            if (found == 0)
                break;
            if (found < 0)
                continue;
            if (robot.n > 0 && !kernels_skip(robot.model))
                law(&robot);
            fixture_close(&robot);
        }
}

random_states *fixture_states(const test_robot *robot, uint64_t salt, uint32_t states,
                              uint32_t wrenches)
{
    return random_states_create(robot->seed + salt, robot->description, robot->o, states, wrenches);
}

tfa_request fixture_request(const test_robot *robot, const random_states *x)
{
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = x->count,
                     .q = x->q,
                     .v = x->v,
                     .tau = x->tau,
                     .qdd = x->qdd,
                     .gravity = x->gravity,
                     .wrench_count = x->wrench_count,
                     .wrenches = x->wrenches};
    if (robot->base == TFA_BASE_FLOATING) {
        r.base_pose = x->base_pose;
        r.base_twist = x->base_twist;
        r.base_wrench = x->base_wrench;
        r.base_acceleration = x->base_acceleration;
    }
    for (uint32_t k = 0; k < x->wrench_count; k++)
        r.wrench_frames[k] = x->wrench_links[k];
    return r;
}

/* Leaves NaN where the next call has its locals, for the same reason as in fixture_workspace. */
static __attribute__((noinline)) void poison_stack(void)
{
    volatile double below[4096];
    for (size_t k = 0; k < sizeof below / sizeof *below; k++)
        below[k] = NAN;
}

bool fixture_refuses(const test_robot *robot, tfa_method method)
{
    static const tfa_method inverting[] = {
        TFA_METHOD_TFA,    TFA_METHOD_TFA_ONE_SIDED, TFA_METHOD_TFA_CR,    TFA_METHOD_CFA,
        TFA_METHOD_CFA_CR, TFA_METHOD_DCA,           TFA_METHOD_HESSENBERG};
    const tfa_method_info *row = tfa_method_describe(method);
    const tfa_request r = {.op = row->lambda ? TFA_OP_OPERATIONAL_INERTIA : TFA_OP_FORWARD_DYNAMICS,
                           .method = method,
                           .count = 1,
                           .tip_count = row->lambda != 0};
    tfa_reply reply = {0};
    if ((row->lambda || row->forward_dynamics) &&
        tfa_request_check(robot->model, &r, &reply) == TFA_E_METHOD)
        return true;
    for (size_t k = 0; k < sizeof inverting / sizeof *inverting; k++)
        if (inverting[k] == method)
            return tfa_model_summarise(robot->model).singular_body >= 0;
    return false;
}

uint32_t fixture_method(const test_robot *robot, tfa_op op, uint32_t m)
{
    for (; tfa_method_describe(m); m++)
        if (tfa_method_describe(m)->ops & TFA_OP_BIT(op) && !fixture_refuses(robot, (tfa_method)m))
            return m;
    return NO_METHOD;
}

void compute_ok(const test_robot *robot, tfa_workspace *w, const tfa_request *request,
                tfa_reply *reply)
{
    poison_stack();
    int status = tfa_compute(w, request, reply);
    if (status != TFA_OK)
        fail_msg("%s: %s refine %d: %s (%s %u of state %u)", robot->name,
                 tfa_method_name((uint32_t)request->method), (int)request->refine,
                 tfa_status_text(status), tfa_field_name(reply->field), (unsigned)reply->index,
                 (unsigned)reply->state);
    assert_int_equal(reply->status, TFA_OK);
}

double norm2(const double *x, size_t n)
{
    double sum = 0;
    for (size_t k = 0; k < n; k++)
        sum += x[k] * x[k];
    return sqrt(sum);
}

double relative_error(const double *x, const double *reference, size_t n)
{
    double difference = 0, size = 0;
    for (size_t k = 0; k < n; k++) {
        difference += (x[k] - reference[k]) * (x[k] - reference[k]);
        size += reference[k] * reference[k];
    }
    return sqrt(size > 0 ? difference / size : difference);
}

void assert_within(const test_robot *robot, const char *what, double error, double bound,
                   double *worst)
{
    if (!(error <= bound))
        fail_msg("%s: %s: error %.3g, bound %g", robot->name, what, error, bound);
    if (worst && error > *worst)
        *worst = error;
}
