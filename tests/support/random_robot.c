/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random robots and random states from seeds.
 */
#include "random_robot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define NAME_SIZE 32

static const double pi = 3.14159265358979323846;

uint64_t random_bits(random_source *s)
{
    uint64_t z = s->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

uint32_t random_below(random_source *s, uint32_t n)
{
    return (uint32_t)((random_bits(s) >> 32) * n >> 32);
}

double random_uniform(random_source *s, double low, double high)
{
    return low + (high - low) * ((double)(random_bits(s) >> 11) * 0x1p-53);
}

static bool chance(random_source *s, double probability)
{
    return random_uniform(s, 0, 1) < probability;
}

static void random_vector(random_source *s, double reach, double *x, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        x[i] = random_uniform(s, -reach, reach);
}

/* Uniform on the unit sphere of dimension n <= 4: points of a cube, those in the ball kept. */
static void random_direction(random_source *s, double *x, uint32_t n)
{
    double norm2;
    do {
        random_vector(s, 1, x, n);
        norm2 = 0;
        for (uint32_t i = 0; i < n; i++)
            norm2 += x[i] * x[i];
    } while (norm2 > 1 || norm2 < 0.01);
    for (uint32_t i = 0; i < n; i++)
        x[i] /= sqrt(norm2);
}

void random_quaternion(random_source *s, double quat[4])
{
    random_direction(s, quat, 4);
}

static void random_pose(random_source *s, double *pose)
{
    random_vector(s, 0.5, pose, 3);
    random_quaternion(s, pose + 3);
    double off = 1 + random_uniform(s, -1e-6, 1e-6);
    for (int i = 3; i < 7; i++)
        pose[i] *= off;
}

uint32_t random_coordinates(random_source *s, tfa_joint_type type, double *q)
{
    switch (type) {
    case TFA_JOINT_FIXED:
        return 0;
    case TFA_JOINT_REVOLUTE:
        q[0] = random_uniform(s, -pi, pi);
        return 1;
    case TFA_JOINT_CONTINUOUS:
        q[0] = random_uniform(s, -20, 20);
        return 1;
    case TFA_JOINT_PRISMATIC:
        q[0] = random_uniform(s, -0.5, 0.5);
        return 1;
    case TFA_JOINT_PLANAR:
        random_vector(s, 0.5, q, 2);
        q[2] = random_uniform(s, -pi, pi);
        return 3;
    case TFA_JOINT_FLOATING:
        random_pose(s, q);
        return 7;
    }
    return 0;
}

/* Weights in tenths: half of the joints revolute, the rest of all kinds. */
static tfa_joint_type random_type(random_source *s)
{
    static const tfa_joint_type tenths[10] = {
        TFA_JOINT_REVOLUTE,   TFA_JOINT_REVOLUTE,  TFA_JOINT_REVOLUTE,  TFA_JOINT_REVOLUTE,
        TFA_JOINT_REVOLUTE,   TFA_JOINT_PRISMATIC, TFA_JOINT_PRISMATIC, TFA_JOINT_CONTINUOUS,
        TFA_JOINT_CONTINUOUS, TFA_JOINT_PLANAR};
    return chance(s, 0.08) ? TFA_JOINT_FLOATING : tenths[random_below(s, 10)];
}

/* Rows of the rotation matrix of a unit quaternion. */
static void rotation(const double quat[4], double R[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            int a = (i + 1) % 3, b = (i + 2) % 3;
            double turn = k == a ? -quat[3] : quat[3]; /* R01, R12, R20 take the minus sign */
            R[i][k] = i == k ? 1 - 2 * (quat[a] * quat[a] + quat[b] * quat[b])
                             : 2 * (quat[i] * quat[k] + turn * quat[3 - i - k]);
        }
}

/* The inertia of a homogeneous box, seen along axes turned at random: all six numbers are used. */
static void random_inertia(random_source *s, tfa_link *link)
{
    double side2[3], quat[4], R[3][3];
    link->mass = pow(10, random_uniform(s, -1, 1));
    random_vector(s, 0.2, link->com, 3);
    random_quaternion(s, link->quat);
    random_quaternion(s, quat);
    rotation(quat, R);
    for (int i = 0; i < 3; i++)
        side2[i] = pow(random_uniform(s, 0.05, 0.4), 2);
    for (int i = 0, n = 0; i < 3; i++)
        for (int k = i; k < 3; k++, n++)
            for (int axis = 0; axis < 3; axis++) {
                double box = link->mass / 12 * (side2[(axis + 1) % 3] + side2[(axis + 2) % 3]);
                link->inertia[n] += R[i][axis] * box * R[k][axis];
            }
}

static void random_joint(random_source *s, tfa_joint *j, tfa_joint_type type, double armature)
{
    j->type = type;
    j->mimic = -1;
    random_vector(s, 0.3, j->xyz, 3);
    random_quaternion(s, j->quat);
    random_direction(s, j->axis, 3);
    if (chance(s, 0.3)) { /* along a coordinate axis, as most are in real files */
        double sign = chance(s, 0.5) ? 1 : -1;
        uint32_t along = random_below(s, 3);
        for (uint32_t i = 0; i < 3; i++)
            j->axis[i] = i == along ? sign : 0;
    }
    if (type != TFA_JOINT_FIXED && chance(s, armature)) {
        j->armature = random_uniform(s, 0.01, 0.5);
        j->rotor = j->armature / 3; /* for nobody, unless the model is asked to add it */
    }
}

/* Link that the next moving joint hangs from, of links 0 .. made - 1. */
static uint32_t random_parent(random_source *s, const random_robot_options *options,
                              uint32_t moving, uint32_t last, uint32_t made)
{
    const uint32_t branch = 5;
    switch (options->shape) {
    case RANDOM_CHAIN:
        return last;
    case RANDOM_STAR:
        return moving % branch == 0 ? 0 : last;
    case RANDOM_BRANCHING:
        return random_below(s, made);
    }
    return 0;
}

/* Puts link `made` and joint `made - 1` at the end. */
static void append(random_source *s, tfa_description *d, uint32_t parent, tfa_joint_type type,
                   double armature)
{
    uint32_t made = (uint32_t)d->link_count++;
    tfa_joint *j = &d->joints[d->joint_count++];
    random_joint(s, j, type, armature);
    j->parent = parent;
    j->child = made;
    d->links[made].quat[3] = 1;
    if (type != TFA_JOINT_FIXED || chance(s, 0.5))
        random_inertia(s, &d->links[made]);
}

static void shuffle(random_source *s, tfa_description *d)
{
    uint32_t n = (uint32_t)d->link_count;
    for (uint32_t k = n; k-- > 1;) {
        uint32_t other = random_below(s, k + 1);
        tfa_link link = d->links[k];
        d->links[k] = d->links[other];
        d->links[other] = link;
        for (size_t j = 0; j < d->joint_count; j++) {
            uint32_t *ends[2] = {&d->joints[j].parent, &d->joints[j].child};
            for (int e = 0; e < 2; e++)
                *ends[e] = *ends[e] == k ? other : *ends[e] == other ? k : *ends[e];
        }
    }
    for (uint32_t k = (uint32_t)d->joint_count; k-- > 1;) {
        uint32_t other = random_below(s, k + 1);
        tfa_joint joint = d->joints[k];
        d->joints[k] = d->joints[other];
        d->joints[other] = joint;
    }
}

static void write_names(tfa_description *d, char (*names)[NAME_SIZE])
{
    d->name = "random";
    for (size_t k = 0; k < d->link_count; k++, names++) {
        snprintf(*names, NAME_SIZE, "link_%zu", k);
        d->links[k].name = *names;
    }
    for (size_t k = 0; k < d->joint_count; k++, names++) {
        snprintf(*names, NAME_SIZE, "joint_%zu", k);
        d->joints[k].name = *names;
    }
}

tfa_description *random_robot_create(uint64_t seed, const random_robot_options *options)
{
    random_source s = {seed};
    size_t most = 2 * (size_t)options->joints + 1;
    tfa_description *d = calloc(1, sizeof *d);
    if (!d)
        return NULL;
    d->links = calloc(most, sizeof *d->links);
    d->joints = calloc(most, sizeof *d->joints);
    char(*names)[NAME_SIZE] = calloc(2 * most, sizeof *names);
    if (!d->links || !d->joints || !names)
        abort();
    d->link_count = 1;
    d->links[0].quat[3] = 1;
    random_inertia(&s, &d->links[0]);
    uint32_t last = 0;
    for (uint32_t k = 0; k < options->joints; k++) {
        uint32_t parent = random_parent(&s, options, k, last, (uint32_t)d->link_count);
        if (chance(&s, options->fixed_fraction)) {
            append(&s, d, parent, TFA_JOINT_FIXED, 0);
            parent = (uint32_t)d->link_count - 1;
        }
        tfa_joint_type type = options->all_types ? random_type(&s) : TFA_JOINT_REVOLUTE;
        append(&s, d, parent, type, options->armature_chance);
        last = (uint32_t)d->link_count - 1;
    }
    if (options->shuffled)
        shuffle(&s, d);
    write_names(d, names);
    return d;
}

/* Whether every moving joint moves something with mass */
static bool all_heavy(const tfa_description *d, bool *heavy)
{
    for (size_t k = 0; k < d->link_count; k++)
        heavy[k] = d->links[k].mass > 0;
    for (size_t pass = 0; pass < d->joint_count; pass++)
        for (size_t j = 0; j < d->joint_count; j++)
            heavy[d->joints[j].parent] |= heavy[d->joints[j].child];
    for (size_t j = 0; j < d->joint_count; j++)
        if (d->joints[j].type != TFA_JOINT_FIXED && !heavy[d->joints[j].child])
            return false;
    return true;
}

/* Bodies without mass between joints of more than six freedoms make M singular at every q: none is
 * next to a joint of several. */
static bool is_next_to_many(const tfa_description *d, uint32_t link)
{
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_joint *joint = &d->joints[j];
        const bool many = joint->type == TFA_JOINT_PLANAR || joint->type == TFA_JOINT_FLOATING;
        if (many && (joint->parent == link || joint->child == link))
            return true;
        if (joint->type == TFA_JOINT_FIXED && joint->parent == link &&
            is_next_to_many(d, joint->child))
            return true;
    }
    return false;
}

void random_robot_empty_links(random_source *s, tfa_description *d, double fraction)
{
    bool *heavy = calloc(d->link_count, sizeof *heavy);
    for (size_t j = 0; heavy && j < d->joint_count; j++) {
        tfa_link *link = &d->links[d->joints[j].child], before = *link;
        if (!chance(s, fraction) || is_next_to_many(d, d->joints[j].child))
            continue;
        link->mass = 0;
        for (int i = 0; i < 6; i++)
            link->inertia[i] = 0;
        if (!all_heavy(d, heavy))
            *link = before;
    }
    free(heavy);
}

static bool has_one_freedom(const tfa_joint *j)
{
    return j->type == TFA_JOINT_REVOLUTE || j->type == TFA_JOINT_CONTINUOUS ||
           j->type == TFA_JOINT_PRISMATIC;
}

/* Few bits: q of a follower is exact in double when its leader's has few, too. */
static double in_256ths(double x)
{
    return round(x * 256) / 256;
}

void random_robot_add_mimics(random_source *s, tfa_description *d, double fraction)
{
    for (size_t j = 0; j < d->joint_count; j++) {
        tfa_joint *follower = &d->joints[j];
        if (!has_one_freedom(follower) || !chance(s, fraction))
            continue;
        uint32_t leader = random_below(s, (uint32_t)d->joint_count);
        bool circle = false;
        for (int32_t k = (int32_t)leader; k >= 0; k = d->joints[k].mimic)
            circle |= k == (int32_t)j;
        if (circle || !has_one_freedom(&d->joints[leader]))
            continue;
        follower->mimic = (int32_t)leader;
        follower->multiplier = in_256ths(random_uniform(s, 0.4, 1.5) * (chance(s, 0.5) ? 1 : -1));
        follower->offset = chance(s, 0.5) ? in_256ths(random_uniform(s, -0.5, 0.5)) : 0;
    }
}

void random_payload(random_source *s, double payload[TFA_PAYLOAD_NUMBERS])
{
    tfa_link box = {.name = ""};
    random_inertia(s, &box);
    double scale = random_uniform(s, 0.1, 3) / box.mass;
    payload[0] = scale * box.mass;
    for (int i = 0; i < 3; i++)
        payload[1 + i] = box.com[i];
    for (int i = 0; i < 6; i++)
        payload[4 + i] = scale * box.inertia[i];
}

void random_robot_free(tfa_description *d)
{
    if (!d)
        return;
    free((void *)(uintptr_t)d->links[0].name); /* the names are one block that begins here */
    free(d->joints);
    free(d->links);
    free(d);
}

/* Cuts `n` numbers off the block, uniform within +-reach. */
static double *take_numbers(random_source *s, double **block, size_t n, double reach)
{
    double *x = *block;
    random_vector(s, reach, x, (uint32_t)n);
    *block += n;
    return x;
}

random_states *random_states_create(uint64_t seed, const tfa_description *description,
                                    const oracle *o, uint32_t count, uint32_t wrench_count)
{
    random_source s = {seed};
    size_t nq = oracle_q_count(o), nv = oracle_v_count(o);
    random_states *x = calloc(1, sizeof *x);
    double *block = calloc(count * (nq + 3 * nv + 25 + 6 * (size_t)wrench_count), sizeof *block);
    if (!x || !block)
        abort();
    *x = (random_states){.count = count, .wrench_count = wrench_count, .memory = block};
    random_vector(&s, 10, x->gravity, 3);
    for (uint32_t w = 0; w < wrench_count; w++)
        x->wrench_links[w] = random_below(&s, (uint32_t)description->link_count);
    x->v = take_numbers(&s, &block, count * nv, 1);
    x->tau = take_numbers(&s, &block, count * nv, 10);
    x->qdd = take_numbers(&s, &block, count * nv, 10);
    x->base_pose = take_numbers(&s, &block, count * 7, 1);
    x->base_twist = take_numbers(&s, &block, count * 6, 1);
    x->base_wrench = take_numbers(&s, &block, count * 6, 20);
    x->base_acceleration = take_numbers(&s, &block, count * 6, 10);
    x->wrenches = take_numbers(&s, &block, count * 6 * (size_t)wrench_count, 10);
    double *q = x->q = block;
    for (uint32_t state = 0; state < count; state++) {
        random_pose(&s, x->base_pose + 7 * (size_t)state);
        for (uint32_t k = 0, within; k < nv; k++) {
            const tfa_joint *j = &description->joints[oracle_joint_of_freedom(o, k, &within)];
            if (within == 0)
                q += random_coordinates(&s, j->type, q);
        }
    }
    return x;
}

void random_states_free(random_states *states)
{
    if (!states)
        return;
    free(states->memory);
    free(states);
}

uint32_t description_root(const tfa_description *d)
{
    uint32_t root = 0;
    for (size_t pass = 0; pass < d->joint_count; pass++)
        for (size_t j = 0; j < d->joint_count; j++)
            root = d->joints[j].child == root ? d->joints[j].parent : root;
    return root;
}
