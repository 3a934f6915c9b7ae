/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See hard_robot.h.
 */
#include "hard_robot.h"

#include "chains_scan.h"
#include "models.h"
#include "test.h"

static double log_uniform(random_source *s, double low, double high)
{
    return exp(log(low) + (log(high) - log(low)) * random_uniform(s, 0, 1));
}

/* 1 to 64, half of them up to 8 */
static uint32_t random_size(random_source *s)
{
    return (uint32_t)log_uniform(s, 1, 64.999);
}

static int open_model(hard_robot *robot)
{
    const tfa_model_options options = {.base = robot->base};
    const tfa_workspace_options quad = {.precision = TFA_F128};
    if (tfa_model_create(robot->description, &options, NULL, &robot->model) != TFA_OK) {
        robot->free_description(robot->description);
        return 0;
    }
    robot->f64 = workspace_for(robot->model, NULL);
    robot->f128 = workspace_for(robot->model, &quad);
    robot->nv = tfa_model_v_count(robot->model);
    robot->six = tfa_model_base_freedoms(robot->model);
    assert_true(robot->nv + robot->six <= HARD_ROBOT_FREEDOMS);
    return 1;
}

/* The fixed base of a mechanism weighs nothing: one that floats is a rod like the others. */
static void add_root_mass(tfa_description *d, double radius)
{
    tfa_link *root = &d->links[0];
    root->mass = 1;
    root->com[2] = 0.5;
    root->inertia[0] = root->inertia[3] = (3 * radius * radius + 1) / 12;
    root->inertia[5] = radius * radius / 2;
}

static int open_mechanism(const mechanism_options *o, hard_robot *robot)
{
    robot->description = mechanism_make(o);
    robot->free_description = mechanism_free;
    assert_non_null(robot->description);
    if (robot->base == TFA_BASE_FLOATING)
        add_root_mass(robot->description, o->radius);
    snprintf(robot->name, sizeof robot->name, "%s -n %u -r %.3g -m %.3g -t %.3g -c %.3g -s %u, %s",
             mechanism_name(o->kind), (unsigned)o->bodies, o->radius, o->ratio, o->taper, o->curl,
             (unsigned)o->seed, robot->base == TFA_BASE_FLOATING ? "floating" : "fixed");
    return open_model(robot);
}

void hard_robot_mechanism(const mechanism_options *options, tfa_base base, hard_robot *robot)
{
    *robot = (hard_robot){.base = base};
    assert_true(open_mechanism(options, robot));
}

void hard_robot_urdf(const char *text, tfa_base base, hard_robot *robot)
{
    tfa_report report = {0};
    *robot = (hard_robot){.base = base, .free_description = tfa_description_free};
    assert_int_equal(tfa_urdf_parse(text, strlen(text), NULL, &robot->description, &report),
                     TFA_OK);
    tfa_report_free(&report);
    snprintf(robot->name, sizeof robot->name, "%s", text);
    assert_true(open_model(robot));
}

static mechanism_options random_mechanism(random_source *s, uint32_t bodies)
{
    mechanism_options o =
        mechanism_defaults((mechanism_kind)random_below(s, MECHANISM_COUNT), bodies);
    o.radius = log_uniform(s, 1e-6, 1);
    o.ratio = log_uniform(s, 1, 1e12);
    o.taper = log_uniform(s, 1e-9, 1);
    o.curl = random_uniform(s, 0, 1);
    o.seed = random_below(s, 1u << 30);
    return o;
}

int hard_robot_open(uint64_t seed, hard_robot *robot)
{
    random_source s = {seed};
    const uint32_t bodies = random_size(&s), which = random_below(&s, 10);
    *robot = (hard_robot){.base = random_below(&s, 3) ? TFA_BASE_FIXED : TFA_BASE_FLOATING};
    if (which < 7) {
        const mechanism_options o = random_mechanism(&s, bodies);
        return open_mechanism(&o, robot);
    }
    if (which < 8) {
        const chain_mechanism kind = (chain_mechanism)random_below(&s, CHAIN_MECHANISMS);
        robot->description = chain_create(kind, bodies, random_bits(&s));
        robot->free_description = chain_free;
        snprintf(robot->name, sizeof robot->name, "chain, %s, %u bodies",
                 chain_mechanism_names[kind], (unsigned)bodies);
    } else {
        const random_robot_options o = {
            (random_shape)random_below(&s, 3), bodies, random_below(&s, 2), 0.2, 0.3, true};
        robot->description = random_robot_create(random_bits(&s), &o);
        robot->free_description = random_robot_free;
        snprintf(robot->name, sizeof robot->name, "tree of shape %d, %u bodies", (int)o.shape,
                 (unsigned)bodies);
    }
    return open_model(robot);
}

void hard_robot_close(hard_robot *robot)
{
    tfa_workspace_free(robot->f64);
    tfa_workspace_free(robot->f128);
    tfa_model_free(robot->model);
    robot->free_description(robot->description);
}

static void fill(random_source *s, double *x, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        x[k] = random_uniform(s, -1, 1);
}

void hard_robot_draw(hard_robot *robot, random_source *s, hard_rhs rhs)
{
    for (uint32_t j = 0; j < tfa_model_joint_count(robot->model); j++) {
        const tfa_joint_info joint = tfa_model_joint(robot->model, j);
        if (joint.v_count > 0)
            (void)random_coordinates(s, joint.type, robot->q + joint.q_index);
    }
    random_quaternion(s, robot->base_pose + 3);
    fill(s, robot->v, robot->nv);
    fill(s, robot->base_twist, 6);
    fill(s, robot->tau, robot->nv);
    fill(s, robot->base_wrench, 6);
    fill(s, robot->qdd, robot->nv);
    fill(s, robot->base_acceleration, 6);
    if (rhs != HARD_QDD)
        return;
    tfa_request r = hard_robot_request(robot, rhs);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.method = TFA_METHOD_RNEA;
    r.qdd = robot->qdd;
    r.base_acceleration = robot->base_acceleration;
    tfa_reply reply = {.tau = robot->tau, .base_wrench = robot->base_wrench};
    assert_int_equal(tfa_compute(robot->f128, &r, &reply), TFA_OK);
}

tfa_request hard_robot_request(const hard_robot *robot, hard_rhs rhs)
{
    const int moving = rhs != HARD_GRAVITY, base = robot->six > 0;
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = robot->q,
                         .v = moving ? robot->v : NULL,
                         .tau = moving ? robot->tau : NULL,
                         .base_pose = robot->base_pose,
                         .base_twist = moving && base ? robot->base_twist : NULL,
                         .base_wrench = moving && base ? robot->base_wrench : NULL};
}
