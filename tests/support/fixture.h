/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots to test with: random ones, those of config/robots, and those of ../shared/robots where
 * that folder is there. Each comes with its oracle, its model and its workspaces.
 */
#ifndef TESTS_SUPPORT_FIXTURE_H
#define TESTS_SUPPORT_FIXTURE_H

#include <totalforce/totalforce.h>

#include "chains_scan.h"
#include "random_robot.h"

typedef struct test_robot {
    char name[96];
    char path[1024]; /* of its file; empty: there is none */
    uint64_t seed;
    bool random; /* made here, not read from a file */
    bool lent;   /* the description is another's */
    bool lossy;  /* damping and friction act */
    tfa_base base;
    tfa_description *description;
    oracle *o;
    tfa_model *model;
    tfa_workspace *f32, *f64, *f128;
    uint32_t n, nv, nq; /* rows of M, length of v, length of q */
} test_robot;

/** Opens robot `index` of the list. Returns 1; 0 after the last; -1 when the library refuses the
 * robot (a file of ../shared/robots only: says why and leaves nothing to close). */
int fixture_open(uint32_t index, tfa_base base, test_robot *robot);
/** Opens a chain of `links` behind the base: a test mechanism. */
void fixture_open_chain(chain_mechanism mechanism, uint32_t links, uint64_t seed, tfa_base base,
                        test_robot *robot);
/** Opens a description that outlives the robot, whose model must come about. */
void fixture_open_description(const char *name, tfa_description *d, tfa_base base,
                              test_robot *robot);
/** Opens a random robot of several trees on a fixed world: two of three of its joints there are
 * floating. */
void fixture_open_trees(uint64_t seed, test_robot *robot);
void fixture_close(test_robot *robot);

/** Calls `law` for the robot with two constraints, from the world to its last link and between its
 *  last and its middle link, as far as the library takes them; its workspaces have none. */
void fixture_constrained(const test_robot *robot, void (*law)(test_robot *constrained));

/** The options of its model */
tfa_model_options fixture_options(const test_robot *robot);

/** A workspace in memory full of NaN: what is read before it is written spoils the answer.
 * Release with tfa_workspace_free. */
tfa_workspace *fixture_workspace(const tfa_model *model, tfa_precision precision);
tfa_workspace *fixture_mixed(const tfa_model *model, tfa_precision factors, tfa_residual residual);

/** Calls `law` for every robot on both bases. `random_only` leaves the files out. */
void for_every_robot(void (*law)(test_robot *robot), bool random_only);
/** A test that does only this. */
#define EVERY_ROBOT(test, law, random_only)                                                        \
    TEST(test)                                                                                     \
    {                                                                                              \
        for_every_robot(law, random_only);                                                         \
    }

/** Random states of the robot; released by random_states_free. `salt` is added to its seed. */
random_states *fixture_states(const test_robot *robot, uint64_t salt, uint32_t states,
                              uint32_t wrenches);

/** A forward-dynamics request with everything in `x`: the wrenches and the gravity included. */
tfa_request fixture_request(const test_robot *robot, const random_states *x);

/** tfa_compute that must answer TFA_OK; names robot, method and failed field otherwise. */
void compute_ok(const test_robot *robot, tfa_workspace *w, const tfa_request *request,
                tfa_reply *reply);

/** Has the robot a body that the method cannot invert, or a joint that it has no place for? It says
 * so by name: singular.c, chains_cr.c. */
bool fixture_refuses(const test_robot *robot, tfa_method method);
/** The next method, from `m` on, that answers the op and does not refuse the robot; NO_METHOD after
 * the last. */
#define NO_METHOD UINT32_MAX
uint32_t fixture_method(const test_robot *robot, tfa_op op, uint32_t m);

/** The 2-norm */
double norm2(const double *x, size_t n);
/** |x - reference| / |reference| in the 2-norm; |x| where the reference is zero. */
double relative_error(const double *x, const double *reference, size_t n);

/** Fails when error > bound or NaN, naming robot and `what`; keeps the worst for the log. */
void assert_within(const test_robot *robot, const char *what, double error, double bound,
                   double *worst);

#endif
