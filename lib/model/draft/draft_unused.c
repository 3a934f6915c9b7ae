/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Notes about items of a description that the model does not use: one for each kind, with count and
 * first line.
 */
#include <stdio.h>

#include "model/draft/draft.h"

/* Moving joints with an unused value */
struct tally {
    size_t count;
    uint32_t line; /* of the first one */
};

static void count_joint(struct tally *t, const tfa_joint *joint)
{
    if (t->count++ == 0)
        t->line = joint->line;
}

/* "; OPTION uses it" */
static void add_note(const struct tally *t, const char *code, const char *item, tfa_option option,
                     tfa_report *report)
{
    char more[96];
    if (t->count == 0)
        return;
    snprintf(more, sizeof more, "; %s uses it", tfa_option_text(report, option));
    tfa_report_add_unused(report, t->line, code, item, t->count, more);
}

void tfa_draft_note_unused(const struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    struct tally damping = {0}, friction = {0}, rotors = {0};
    for (size_t j = 0; j < s->joint_count; j++) {
        const tfa_joint *joint = &s->joints[j];
        if (!draft_moves(d, j))
            continue;
        if (joint->damping != 0 && !d->options->damping)
            count_joint(&damping, joint);
        if (joint->friction != 0 && !d->options->friction)
            count_joint(&friction, joint);
        if (joint->rotor != 0 && joint->armature == 0 && !d->options->rotor_inertia)
            count_joint(&rotors, joint);
    }
    add_note(&damping, "damping", "damping", TFA_OPTION_DAMPING, report);
    add_note(&friction, "friction", "friction", TFA_OPTION_FRICTION, report);
    add_note(&rotors, "rotor-inertia", "rotor inertia", TFA_OPTION_ROTOR_INERTIA, report);
    for (size_t k = 0; k < s->unused_count; k++)
        tfa_report_add_unused(report, s->unused[k].line, "not-used", s->unused[k].item,
                              s->unused[k].count, "");
}
