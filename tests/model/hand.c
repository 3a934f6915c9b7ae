/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots made by hand. See hand.h.
 */
#include "hand.h"

#include "test.h"

void hand_begin(hand *h)
{
    memset(h, 0, sizeof *h);
    h->d.name = "hand";
    h->d.links = h->link;
    h->d.joints = h->joint;
}

uint32_t hand_link(hand *h, const char *name, double mass, double x, double y, double z)
{
    uint32_t k = (uint32_t)h->d.link_count++;
    assert_true(k < HAND_LINKS);
    double i = 0.01 * mass;
    h->link[k] = (tfa_link){.name = name,
                            .line = 10 + k,
                            .mass = mass,
                            .com = {x, y, z},
                            .quat = {0, 0, 0, 1},
                            .inertia = {i, 0, 0, i, 0, i},
                            .inertial = 1};
    return k;
}

tfa_joint *hand_joint(hand *h, const char *name, tfa_joint_type type, uint32_t parent,
                      uint32_t child)
{
    uint32_t k = (uint32_t)h->d.joint_count++;
    assert_true(k < HAND_LINKS);
    h->joint[k] = (tfa_joint){.name = name,
                              .line = 100 + k,
                              .type = type,
                              .parent = parent,
                              .child = child,
                              .quat = {0, 0, 0, 1},
                              .axis = {0, 1, 0},
                              .mimic = -1};
    return &h->joint[k];
}

void hand_arm(hand *h)
{
    hand_begin(h);
    uint32_t base = hand_link(h, "base", 4, 0, 0, 0.1);
    uint32_t upper = hand_link(h, "upper", 2, 0.2, 0, 0);
    uint32_t lower = hand_link(h, "lower", 1, 0.15, 0, 0);
    uint32_t tool = hand_link(h, "tool", 0.5, 0, 0, 0.05);
    hand_joint(h, "shoulder", TFA_JOINT_REVOLUTE, base, upper)->xyz[2] = 0.3;
    hand_joint(h, "elbow", TFA_JOINT_REVOLUTE, upper, lower)->xyz[0] = 0.4;
    hand_joint(h, "flange", TFA_JOINT_FIXED, lower, tool)->xyz[0] = 0.3;
}

tfa_model *hand_model(const hand *h, const tfa_model_options *options)
{
    tfa_report report = {0};
    tfa_model *model = NULL;
    int status = tfa_model_create(&h->d, options, &report, &model);
    if (status != TFA_OK) {
        char text[400] = "";
        tfa_report_format(&report, 0, text, sizeof text);
        fail_msg("%s: %s", tfa_status_text(status), text);
    }
    tfa_report_free(&report);
    return model;
}

void hand_near(double x, double expected, double bound)
{
    if (!(fabs(x - expected) <= bound))
        fail_msg("%.17g, expected %.17g within %g", x, expected, bound);
}

struct outcome hand_outcome(const hand *h, const tfa_model_options *options,
                            tfa_option_syntax words)
{
    struct outcome o = {.report.syntax = words};
    o.status = tfa_model_create(&h->d, options, &o.report, &o.model);
    assert_int_equal(o.status == TFA_OK, o.model != NULL);
    return o;
}

void hand_forget(struct outcome *o)
{
    tfa_model_free(o->model);
    tfa_report_free(&o->report);
}

static size_t messages_of(const struct outcome *o, const char *code, const tfa_message **last)
{
    size_t count = 0;
    for (size_t k = 0; k < o->report.count; k++)
        if (strcmp(o->report.messages[k].code, code) == 0) {
            *last = &o->report.messages[k];
            count++;
        }
    return count;
}

bool hand_says(const struct outcome *o, const char *code)
{
    const tfa_message *last;
    return messages_of(o, code, &last) > 0;
}

const tfa_message *hand_said(const struct outcome *o, const char *code)
{
    const tfa_message *last = NULL;
    const size_t count = messages_of(o, code, &last);
    if (count != 1)
        fail_msg("%zu messages with code %s", count, code);
    return last;
}
