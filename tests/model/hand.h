/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots made by hand, link by link.
 */
#ifndef TESTS_MODEL_HAND_H
#define TESTS_MODEL_HAND_H

#include <stdbool.h>
#include <totalforce/totalforce.h>

#define HAND_LINKS 12

/** A description with room of its own; it points into itself, so do not copy it. */
typedef struct hand {
    tfa_description d;
    tfa_link link[HAND_LINKS];
    tfa_joint joint[HAND_LINKS];
} hand;

/** An empty robot. */
void hand_begin(hand *h);

/** A link with its mass at `com` and an isotropic inertia of 0.01 kg m^2 for each kg; declared in
 * line 10 + its index, which is returned. */
uint32_t hand_link(hand *h, const char *name, double mass, double x, double y, double z);

/** A joint about y at the origin of its parent; declared in line 100 + its index. */
tfa_joint *hand_joint(hand *h, const char *name, tfa_joint_type type, uint32_t parent,
                      uint32_t child);

/** base -shoulder- upper -elbow- lower -flange(fixed)- tool: lines 10..13 and 100..102. */
void hand_arm(hand *h);

/** The model of a description that must compile; release with tfa_model_free. */
tfa_model *hand_model(const hand *h, const tfa_model_options *options);

/** A function that changes a robot in a statement or two */
#define CHANGE(name, statement)                                                                    \
    static void name(hand *h)                                                                      \
    {                                                                                              \
        statement;                                                                                 \
    }

/** Whatever becomes of a description; released by hand_forget. */
struct outcome {
    int status;
    tfa_model *model;
    tfa_report report;
};

struct outcome hand_outcome(const hand *h, const tfa_model_options *options,
                            tfa_option_syntax words);
void hand_forget(struct outcome *o);
/** The message with this code; fails unless there is exactly one. */
const tfa_message *hand_said(const struct outcome *o, const char *code);
/** Whether there is a message with this code */
bool hand_says(const struct outcome *o, const char *code);

/** Fails unless |x - expected| <= bound. */
void hand_near(double x, double expected, double bound);

#endif
