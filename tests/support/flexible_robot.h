/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots with flexible links: random ones, and chains.
 */
#ifndef TESTS_SUPPORT_FLEXIBLE_ROBOT_H
#define TESTS_SUPPORT_FLEXIBLE_ROBOT_H

#include "fixture.h"
#include "oracle_modes.h"

typedef struct flexible_robot {
    test_robot robot; /**< its oracle is that of the robot without modes */
    tfa_link_modes *modes;
    size_t links;    /**< flexible ones: of modes */
    tfa_scene scene; /**< they; while it is opened also payloads on links without mass and a lock,
                          which the description has from then on */
    tfa_payload payload[2];
    tfa_lock lock;
    tfa_joint_type locked;  /**< type of that joint, which the description has as fixed */
    oracle_modes *o;        /**< NULL: not asked for */
    uint32_t n, mode_count; /**< n: base, joints and modes */
} flexible_robot;

/** Random modes of a link of the description, `count` of them, for flexible_modes_free. States have
 *  |eta| up to FLEXIBLE_ETA. */
#define FLEXIBLE_ETA 0.1
tfa_link_modes flexible_modes(random_source *s, const tfa_description *d, uint32_t link,
                              uint32_t count);
void flexible_modes_free(const tfa_link_modes *modes);

/** Opens the robot of a description with these modes, both released with it. */
void flexible_open(flexible_robot *f, tfa_description *d, tfa_link_modes *modes, size_t links,
                   bool with_oracle);
/** A chain whose links are all flexible, with 4 modes each */
void flexible_open_chain(flexible_robot *f, uint32_t links, uint64_t seed, bool with_oracle);
void flexible_close(flexible_robot *f);
/** Every random robot, on both bases: f is open. */
void for_every_flexible_robot(void (*law)(flexible_robot *f));
#define EVERY_FLEXIBLE_ROBOT(test, law)                                                            \
    TEST(test)                                                                                     \
    {                                                                                              \
        for_every_flexible_robot(law);                                                             \
    }

/** Random states; modes within FLEXIBLE_ETA, their rates within 1/s. */
typedef struct flexible_states {
    random_states *x;
    double *modes, *rates;
} flexible_states;
flexible_states flexible_states_make(const flexible_robot *f, uint64_t salt, uint32_t count,
                                     uint32_t wrenches);
void flexible_states_free(flexible_states *s);
tfa_request flexible_request(const flexible_robot *f, const flexible_states *s);

/** Accelerations of `count` states, each base, joints, modes; the request must succeed. `answers`:
 *  count, or NULL. */
void flexible_forward(const flexible_robot *f, tfa_workspace *w, const tfa_request *r, double *x,
                      tfa_answer *answers);

#endif
