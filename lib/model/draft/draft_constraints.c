/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constraints of file and scene: loops that the tree leaves open, contacts.
 */
#include <math.h>
#include <string.h>

#include "model/draft/draft.h"

#define CODE "scene-constraint"
#define NORM_TOLERANCE 1e-3 /* of a quaternion: more is an error, not rounding */

static long double square_of(const double *quat)
{
    long double sum = 0;
    for (int k = 0; k < 4; k++)
        sum += (long double)quat[k] * quat[k];
    return sum;
}

void tfa_constraint_axes(ext R[9], const double pose[7])
{
    static const double none[4] = {0, 0, 0, 1};
    ext q[4];
    ext_from_double(q, square_of(pose + 3) > 0 ? pose + 3 : none, 4);
    ext_rotation(R, q);
}

static int refuse(const tfa_constraint *c, const char *what, tfa_report *report)
{
    return TFA_REFUSE(report, TFA_E_MODEL, 0, CODE, "constraint '%s': %s",
                      c->name ? c->name : "(none)", what);
}

/* What is wrong with it by itself; NULL: nothing */
static const char *fault(const tfa_constraint *c)
{
    if (!c->name || !*c->name)
        return "it has no name; give it one, by which requests call it";
    if (!c->rows || c->rows & ~TFA_CONSTRAINT_WELD)
        return "its rows are none of the six components of a motion; choose from bits 0 to 5";
    if (c->unilateral && !(c->rows & 4))
        return "it is unilateral, but does not hold z of its first frame; hold row z";
    if (!c->link[0] && !c->link[1])
        return "both frames are of the world; one of them must be on a link of the robot";
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < 7; k++)
            if (!isfinite(c->pose[side][k]))
                return "a number of its poses is not finite; correct it";
        const long double square = square_of(c->pose[side] + 3);
        if (square > 0 && fabsl(sqrtl(square) - 1) > NORM_TOLERANCE)
            return "the norm of a quaternion is off from 1 by more than 1e-3; correct it (x y z, "
                   "then x y z w)";
    }
    return NULL;
}

/* Why the constraint holds nothing in this robot; NULL: it does, or `unknown` is a link that does
 * not exist. */
static const char *vain(const struct draft *d, const tfa_constraint *c, const char **unknown)
{
    const struct draft_frame *frame[2] = {NULL, NULL};
    for (int side = 0; side < 2; side++) {
        const int32_t link = tfa_draft_find_link(d, c->link[side]);
        if (!c->link[side])
            continue;
        if (link < 0) {
            *unknown = c->link[side];
            return NULL;
        }
        if (!d->link[link].present)
            return "one of its links is not part of the scene";
        frame[side] = &d->frame[link];
    }
    const int32_t body[2] = {frame[0] ? frame[0]->body : -1, frame[1] ? frame[1]->body : -1};
    const int same_part = !frame[0] || !frame[1] || frame[0]->part == frame[1]->part;
    if (body[0] == body[1] && same_part)
        return "its frames do not move against each other: their links are one body, or fixed to "
               "the world";
    return NULL;
}

static int add(struct draft *d, const tfa_constraint *c, int of_file, tfa_report *report)
{
    const char *unknown = NULL, *wrong = fault(c);
    if (wrong)
        return refuse(c, wrong, report);
    const char *why = vain(d, c, &unknown);
    if (unknown)
        return tfa_draft_refuse_link(d, CODE, unknown,
                                     "a constraint is on a link that does not exist; name a link "
                                     "of the robot, or the world",
                                     report);
    if (why && of_file) {
        tfa_report_add(report, TFA_NOTE, c->line, "loop-joint",
                       "constraint '%s': %s; it is left out", c->name, why);
        return TFA_OK;
    }
    if (why)
        return TFA_REFUSE(report, TFA_E_MODEL, 0, CODE,
                          "constraint '%s': %s; constrain others, or leave it out", c->name, why);
    for (uint32_t other = 0; other < d->constraints; other++)
        if (strcmp(d->constraint[other]->name, c->name) == 0)
            return refuse(c, "another one has this name; rename one of them", report);
    if (d->constraints == TFA_MAX_CONSTRAINTS)
        return refuse(c, "32 constraints are the most of a model; leave some out", report);
    d->constraint[d->constraints++] = c;
    return TFA_OK;
}

int tfa_draft_constraints(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    const tfa_scene *scene = d->options->scene;
    for (size_t k = 0; k < s->constraint_count; k++)
        if (add(d, &s->constraints[k], 1, report) != TFA_OK)
            return TFA_E_MODEL;
    for (size_t k = 0; scene && k < scene->constraint_count; k++)
        if (add(d, &scene->constraints[k], 0, report) != TFA_OK)
            return TFA_E_MODEL;
    return TFA_OK;
}
