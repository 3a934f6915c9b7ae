/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random robots up to the extremes where methods fail, and requests to them: the same for the same
 * seed on every machine.
 */
#ifndef TESTS_SUPPORT_HARD_ROBOT_H
#define TESTS_SUPPORT_HARD_ROBOT_H

#include <totalforce/totalforce.h>

#include "mechanism/mechanism.h"
#include "random_robot.h"

#define HARD_ROBOT_FREEDOMS 4096 /* more has none of them */

/** Where tau comes from. */
typedef enum hard_rhs {
    HARD_QDD,     /**< inverse dynamics of random accelerations: the hardest */
    HARD_TAU,     /**< random */
    HARD_GRAVITY, /**< none: at rest under gravity */
    HARD_RHS_COUNT
} hard_rhs;

typedef struct hard_robot {
    char name[160]; /**< what it is, to see it again */
    tfa_base base;
    tfa_description *description;
    void (*free_description)(tfa_description *);
    tfa_model *model;
    tfa_workspace *f64, *f128;
    uint32_t nv, six; /**< length of v; 6 where the base floats */
    double q[7 * HARD_ROBOT_FREEDOMS], v[HARD_ROBOT_FREEDOMS], tau[HARD_ROBOT_FREEDOMS];
    double qdd[HARD_ROBOT_FREEDOMS], base_pose[7], base_twist[6], base_acceleration[6];
    double base_wrench[6];
    double speed, length; /**< factors of velocities, and of coordinates that are lengths */
} hard_robot;

/** What makes a robot hard: X(NAME, text) */
#define HARD_FAMILY_LIST(X)                                                                        \
    X(LEVERS, "bodies of 0.1 m, levers to 1000 km")                                                \
    X(POINTS, "points of inertia to 1e-15 m^2 kg")                                                 \
    X(RODS, "rods, radii to 1 um")                                                                 \
    X(MICROMETRES, "robots of micrometres")                                                        \
    X(MASSES, "masses apart by up to 1e12")                                                        \
    X(FLYWHEEL, "one body up to 1e12 times heavier or larger")                                     \
    X(SPEEDS, "velocities to 1e6")

typedef enum hard_family {
#define HARD_FAMILY_ENUM(name, text) HARD_FAMILY_##name,
    HARD_FAMILY_LIST(HARD_FAMILY_ENUM)
#undef HARD_FAMILY_ENUM
        HARD_FAMILIES
} hard_family;

extern const char *const hard_family_text[HARD_FAMILIES];

/** A mechanism as mechanism_make gives it, with the model and workspaces. */
void hard_robot_mechanism(const mechanism_options *options, tfa_base base, hard_robot *robot);

/** A robot as URDF, without errors. */
void hard_robot_urdf(const char *text, tfa_base base, hard_robot *robot);

/** Robot of that seed: a mechanism with random parameters, a chain with joints of all types and
 * armature, or a random tree; 1 to 64 moving bodies, mostly few; base fixed or floating.
 * Returns 0, and nothing to close, when the library refuses to load it. */
int hard_robot_open(uint64_t seed, hard_robot *robot);
/** The same of one family: a random chain or tree of 1 to 20 joints, changed. */
int hard_robot_open_family(hard_family family, uint64_t seed, hard_robot *robot);
void hard_robot_close(hard_robot *robot);

/** Draws a state and the forces that go with `rhs`. */
void hard_robot_draw(hard_robot *robot, random_source *s, hard_rhs rhs);

/** The request for qdd in that state. */
tfa_request hard_robot_request(const hard_robot *robot, hard_rhs rhs);

#endif
