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
        mechanism_defaults((mechanism_kind)random_below(s, MECHANISM_COIL), bodies);
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

/* ---- families ---- */

const char *const hard_family_text[] = {
#define HARD_FAMILY_TEXT(name, text) text,
    HARD_FAMILY_LIST(HARD_FAMILY_TEXT)
#undef HARD_FAMILY_TEXT
};

static void scale_inertia(tfa_link *link, double factor)
{
    for (int e = 0; e < 6; e++)
        link->inertia[e] *= factor;
}

static void set_inertia(tfa_link *link, double x, double y, double z)
{
    const double inertia[6] = {x, 0, 0, y, 0, z};
    memcpy(link->inertia, inertia, sizeof inertia);
}

static void scale_lengths(tfa_description *d, double factor)
{
    for (size_t i = 0; i < d->link_count; i++) {
        for (int e = 0; e < 3; e++)
            d->links[i].com[e] *= factor;
        scale_inertia(&d->links[i], factor * factor);
    }
    for (size_t j = 0; j < d->joint_count; j++)
        for (int e = 0; e < 3; e++)
            d->joints[j].xyz[e] *= factor;
}

/* Half of the joints on far ends, half of their frames parallel to those before */
static void stretch_levers(random_source *s, tfa_description *d)
{
    for (size_t j = 0; j < d->joint_count; j++) {
        tfa_joint *joint = &d->joints[j];
        const double factor = random_below(s, 2) ? log_uniform(s, 1, 1e6) : 1;
        const int straight = random_below(s, 2) > 0;
        for (int e = 0; e < 3; e++)
            joint->xyz[e] *= straight && e > 0 ? 0 : factor;
        if (random_below(s, 2))
            memcpy(joint->quat, (double[]){0, 0, 0, 1}, sizeof joint->quat);
    }
}

static void change_link(random_source *s, hard_family family, double ratio, tfa_link *link)
{
    const double m = link->mass, length = log_uniform(s, 0.1, 10), r = log_uniform(s, 1e-6, 0.1);
    if (m > 0 && family == HARD_FAMILY_POINTS) {
        const double I = m * log_uniform(s, 1e-15, 1e-2);
        set_inertia(link, I, I, I);
    } else if (m > 0 && family == HARD_FAMILY_RODS) {
        const double across = m * (3 * r * r + length * length) / 12;
        set_inertia(link, across, across, m * r * r / 2);
    } else if (family == HARD_FAMILY_MASSES) {
        const double factor = log_uniform(s, 1 / sqrt(ratio), sqrt(ratio));
        link->mass *= factor;
        scale_inertia(link, factor);
    }
}

static void change(random_source *s, hard_family family, hard_robot *robot)
{
    tfa_description *d = robot->description;
    const double ratio = log_uniform(s, 1, 1e12);
    for (size_t i = 0; i < d->link_count; i++)
        change_link(s, family, ratio, &d->links[i]);
    if (family == HARD_FAMILY_LEVERS)
        stretch_levers(s, d);
    if (family == HARD_FAMILY_MICROMETRES) {
        robot->length = log_uniform(s, 1e-6, 1e-2);
        scale_lengths(d, robot->length);
    }
    if (family == HARD_FAMILY_FLYWHEEL) {
        tfa_link *link = &d->links[random_below(s, (uint32_t)d->link_count)];
        scale_inertia(link, ratio);
        link->mass *= random_below(s, 2) ? ratio : 1;
    }
    robot->speed = family == HARD_FAMILY_SPEEDS ? log_uniform(s, 1, 1e6) : 1;
}

int hard_robot_open_family(hard_family family, uint64_t seed, hard_robot *robot)
{
    random_source s = {seed};
    const random_robot_options o = {.shape = (random_shape)random_below(&s, 3),
                                    .joints = (uint32_t)log_uniform(&s, 1, 20.999),
                                    .all_types = random_below(&s, 2),
                                    .armature_chance = 0.1};
    *robot = (hard_robot){.base = random_below(&s, 3) ? TFA_BASE_FIXED : TFA_BASE_FLOATING,
                          .free_description = random_robot_free};
    robot->description = random_robot_create(random_bits(&s), &o);
    change(&s, family, robot);
    snprintf(robot->name, sizeof robot->name, "%s, seed %llu, %u joints, %s base",
             hard_family_text[family], (unsigned long long)seed, (unsigned)o.joints,
             robot->base == TFA_BASE_FLOATING ? "floating" : "fixed");
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

static void draw_coordinates(hard_robot *robot, random_source *s)
{
    static const uint32_t lengths[] = {
        [TFA_JOINT_PRISMATIC] = 1, [TFA_JOINT_PLANAR] = 2, [TFA_JOINT_FLOATING] = 3};
    for (uint32_t j = 0; j < tfa_model_joint_count(robot->model); j++) {
        const tfa_joint_info joint = tfa_model_joint(robot->model, j);
        if (joint.v_count > 0)
            (void)random_coordinates(s, joint.type, robot->q + joint.q_index);
        for (uint32_t k = 0; robot->length > 0 && joint.v_count > 0 && k < lengths[joint.type]; k++)
            robot->q[joint.q_index + k] *= robot->length;
    }
}

void hard_robot_draw(hard_robot *robot, random_source *s, hard_rhs rhs)
{
    draw_coordinates(robot, s);
    random_quaternion(s, robot->base_pose + 3);
    fill(s, robot->v, robot->nv);
    fill(s, robot->base_twist, 6);
    for (uint32_t k = 0; robot->speed > 0 && k < robot->nv; k++)
        robot->v[k] *= robot->speed;
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
