/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See chains_scan.h.
 */
#include "chains_scan.h"

#include <math.h>
#include <stdlib.h>

#include "random_robot.h"

const char *const chain_mechanism_names[CHAIN_MECHANISMS] = {
    "straight",    "helix",       "random",          "taper",       "swelling", "heavy tip",
    "heavy spots", "alternating", "alternating 1e9", "thin",        "compact",  "points",
    "mixed",       "zigzag",      "planar",          "light-heavy", "massless", "branches"};

/* A uniform rod along x from the joint on */
static void rod(tfa_link *link, double mass, double length, double radius)
{
    const double along = mass * radius * radius / 2;
    const double across = mass * (3 * radius * radius + length * length) / 12;
    link->mass = mass;
    link->com[0] = length / 2;
    link->quat[3] = 1;
    link->inertia[0] = along;
    link->inertia[3] = link->inertia[5] = across;
}

static void make_link(chain_mechanism mechanism, uint32_t i, uint32_t n, tfa_link *link)
{
    const double at = (double)i / (double)n;
    double mass = 1;
    switch (mechanism) {
    case CHAIN_TAPER:
        mass = pow(1e-2, at);
        break;
    case CHAIN_SWELLING:
        mass = pow(1e6, at);
        break;
    case CHAIN_HEAVY_TIP:
        mass = i + 1 == n ? 1e6 : 1;
        break;
    case CHAIN_HEAVY_SPOTS:
        mass = i % 40 == 39 ? 1e6 : 1;
        break;
    case CHAIN_ALTERNATING:
        mass = i % 2 ? 1e-6 : 1;
        break;
    case CHAIN_ALTERNATING9:
        mass = i % 2 ? 1e-9 : 1;
        break;
    case CHAIN_LIGHT_HEAVY:
        mass = i >= n / 2 ? 1e6 : 1;
        break;
    case CHAIN_MASSLESS:
        mass = (n - 1 - i) % 2 ? 0 : 1;
        break;
    default:
        break;
    }
    if (mechanism == CHAIN_COMPACT) {
        rod(link, mass, 1e-3, 1e-3);
    } else if (mechanism == CHAIN_POINTS && i % 3) {
        rod(link, mass, 0, 0);
        link->com[0] = 1;
    } else {
        rod(link, mass, 1, mechanism == CHAIN_THIN ? 1e-4 : 0.1);
    }
}

/* Links go by fours: two of the chain, then two that hang from the first of them as a branch. */
static uint32_t parent_of(chain_mechanism mechanism, uint32_t i)
{
    if (mechanism != CHAIN_BRANCHES || i == 0 || i % 4 % 2 == 1)
        return i;
    return i % 4 == 0 ? i - 2 : i - 1;
}

/* Where the joint frame stands, and its axis in that frame */
static void turn_joint(chain_mechanism mechanism, uint32_t i, random_source *s, tfa_joint *joint)
{
    joint->axis[mechanism == CHAIN_STRAIGHT ? 1 + i % 2
                : mechanism == CHAIN_ZIGZAG ? 2 - i % 2
                                            : 2] = 1;
    if (mechanism == CHAIN_STRAIGHT)
        return;
    if (mechanism == CHAIN_HELIX) {
        joint->quat[0] = 0.09983341664682815; /* 0.2 rad about x */
        joint->quat[3] = 0.9950041652780258;
    } else if (mechanism == CHAIN_ZIGZAG || mechanism == CHAIN_PLANAR) { /* about y; about z */
        const double angle = mechanism == CHAIN_PLANAR ? random_uniform(s, -1.5, 1.5)
                             : i % 2                   ? 1
                                                       : -1;
        joint->quat[mechanism == CHAIN_PLANAR ? 2 : 1] = sin(angle / 2);
        joint->quat[3] = cos(angle / 2);
    } else {
        random_quaternion(s, joint->quat);
    }
}

static void make_joint(chain_mechanism mechanism, uint32_t i, random_source *s, tfa_joint *joint)
{
    static const tfa_joint_type types[] = {
        TFA_JOINT_REVOLUTE, TFA_JOINT_CONTINUOUS, TFA_JOINT_PRISMATIC, TFA_JOINT_REVOLUTE,
        TFA_JOINT_PLANAR,   TFA_JOINT_CONTINUOUS, TFA_JOINT_FLOATING,  TFA_JOINT_REVOLUTE};
    *joint = (tfa_joint){.type = TFA_JOINT_CONTINUOUS,
                         .parent = parent_of(mechanism, i),
                         .child = i + 1,
                         .xyz = {i > 0, 0, 0},
                         .quat = {0, 0, 0, 1},
                         .mimic = -1};
    if (mechanism == CHAIN_MIXED) {
        joint->type = types[random_below(s, 8)];
        joint->armature = random_below(s, 2) ? random_uniform(s, 0, 0.3) : 0;
    }
    turn_joint(mechanism, i, s, joint);
}

tfa_description *chain_create(chain_mechanism mechanism, uint32_t n, uint64_t seed)
{
    random_source s = {seed};
    tfa_description *d = calloc(1, sizeof *d);
    tfa_link *links = calloc(n + 1, sizeof *links);
    tfa_joint *joints = calloc(n, sizeof *joints);
    char(*names)[2][16] = calloc(n + 1, sizeof *names);
    if (!d || !links || !joints || !names)
        abort();
    *d = (tfa_description){.name = chain_mechanism_names[mechanism],
                           .links = links,
                           .link_count = n + 1,
                           .joints = joints,
                           .joint_count = n};
    for (uint32_t i = 0; i <= n; i++) {
        for (uint32_t kind = 0; kind < 2; kind++) {
            char *name = names[i][kind];
            *name++ = kind ? 'j' : 'l';
            for (uint32_t digit = 100000; digit > 0; digit /= 10)
                *name++ = (char)('0' + i / digit % 10);
        }
        links[i].name = names[i][0];
        links[i].quat[3] = 1;
        if (i > 0)
            make_link(mechanism, i - 1, n, &links[i]);
        else
            rod(&links[0], 1, 1, 0.1); /* counts where the base floats */
        if (i < n) {
            make_joint(mechanism, i, &s, &joints[i]);
            joints[i].name = names[i][1];
        }
    }
    return d;
}

void chain_free(tfa_description *d)
{
    free((void *)(uintptr_t)d->links[0].name);
    free(d->joints);
    free(d->links);
    free(d);
}

void chain_coordinates(chain_mechanism mechanism, const tfa_description *d, uint64_t seed,
                       double *q)
{
    random_source s = {seed};
    for (size_t k = 0; k < d->joint_count; k++) {
        const uint32_t n = random_coordinates(&s, d->joints[k].type, q);
        if (mechanism == CHAIN_STRAIGHT)
            q[0] = 0;
        else if (mechanism == CHAIN_HELIX)
            q[0] = 0.2 + 0.02 * (double)(seed % 8);
        else if (mechanism == CHAIN_ZIGZAG)
            q[0] *= 5e-5; /* to 1e-3 rad */
        q += n;
    }
}
