/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inertias that no rigid body has: refused, repaired or reported, link by link, by policy. Links
 * that do not move cause warnings only. (The URDF front end warns of broken triangle inequalities.)
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "model/draft/draft.h"
#include "model/eigen.h"

/* Rounding of files with six digits: a flat plate breaks the triangle inequality by that much. */
#define TRIANGLE_TOLERANCE 1e-6L

/* V diag(value) V^T, values up to `least` replaced by 0 */
static void clip(long double s[6], const long double value[3], const long double V[9],
                 long double least)
{
    for (int k = 0; k < 6; k++) {
        s[k] = 0;
        for (int e = 0; e < 3; e++)
            s[k] +=
                (value[e] > least ? value[e] : 0) * V[3 * ext_row[k] + e] * V[3 * ext_col[k] + e];
        s[k] = (double)s[k]; /* a number that the file could hold */
    }
}

/* Rounding of the inertias of a file, kg m^2. Exporters compute them from terms m p^2 in the
 * frame of the assembly. With M the mass of the robot and L its longest distance, each
 * operation rounds by up to eps M L^2 / 2, and the dozens for one number leave 16 eps M L^2 (30
 * kg, 0.3 m: 1e-14). */
static long double rounding_of(const tfa_description *s)
{
    long double mass = 0, longest = 0; /* squared */
    for (size_t k = 0; k < s->link_count; k++) {
        const double *c = s->links[k].com;
        mass += s->links[k].mass;
        longest = fmaxl(longest, (long double)c[0] * c[0] + (long double)c[1] * c[1] +
                                     (long double)c[2] * c[2]);
    }
    for (size_t j = 0; j < s->joint_count; j++) {
        const double *r = s->joints[j].xyz;
        longest = fmaxl(longest, (long double)r[0] * r[0] + (long double)r[1] * r[1] +
                                     (long double)r[2] * r[2]);
    }
    return 16 * (long double)DBL_EPSILON * mass * longest;
}

static void find_bests(struct draft *d)
{
    for (size_t k = 0; k < d->description->link_count && !d->bests; k++) {
        long double value[3], *best = &d->link[d->link[k].carrier].best;
        tfa_eigen(d->link[k].inertia, value, NULL);
        if (d->link[k].present)
            *best = fmaxl(*best, value[0]);
    }
    d->bests = 1;
}

/* 1: half a unit u of the last printed decimal of each entry explains a negative moment with the
 * axis x, x^T dI x <= u/2 (|x0| + |x1| + |x2|)^2, and the link is a small part of a good body. */
static int is_last_digit(struct draft *d, size_t k, const long double value[3],
                         const long double V[9])
{
    const long double sum = fabsl(V[0]) + fabsl(V[3]) + fabsl(V[6]);
    if (-value[0] > d->description->links[k].last_digit / 2 * sum * sum)
        return 0;
    find_bests(d);
    return d->link[d->link[k].carrier].best > -value[0];
}

/* Replaces a negative moment of the size of rounding by 0, with a note: rounding of the file's
 * digits (tfa_eigen_negative, is_last_digit) or of the doubles that the file was computed with. */
static int is_rounded(struct draft *d, size_t k, const long double value[3], const long double V[9],
                      tfa_report *report)
{
    const tfa_link *link = &d->description->links[k];
    if (value[0] < -d->rounding && tfa_eigen_negative(value) && !is_last_digit(d, k, value, V))
        return 0;
    clip(d->link[k].inertia, value, V, value[0] < -d->rounding ? 0 : d->rounding);
    tfa_report_add_grouped(report, TFA_NOTE, link->line, "inertia-rounded", "links", link->name,
                           "link '%s': the principal moment %.6Lg kg m^2 of its inertia is "
                           "rounding of the file and used as 0",
                           link->name, value[0]);
    return 1;
}

static void warn_repaired(const tfa_link *link, const long double was[3], tfa_report *report)
{
    tfa_report_add_grouped(report, TFA_WARNING, link->line, "inertia-repaired", "links", link->name,
                           "link '%s': its inertia has the principal moments %.6Lg %.6Lg %.6Lg kg "
                           "m^2; used as %.6Lg %.6Lg %.6Lg: correct <inertia>",
                           link->name, was[0], was[1], was[2], fmaxl(was[0], 0), fmaxl(was[1], 0),
                           fmaxl(was[2], 0));
}

static int check_negative(struct draft *d, size_t k, int moves, tfa_report *report)
{
    const tfa_link *link = &d->description->links[k];
    long double value[3], V[9];
    tfa_eigen(d->link[k].inertia, value, V);
    if (value[0] >= 0 || (moves ? is_rounded(d, k, value, V, report) : !tfa_eigen_negative(value)))
        return TFA_OK;
    const tfa_inertia_policy policy = d->options->inertia;
    if (moves && policy == TFA_INERTIA_REPAIR) {
        clip(d->link[k].inertia, value, V, 0);
        warn_repaired(link, value, report);
        return TFA_OK;
    }
    const int refused = moves && policy != TFA_INERTIA_WARN;
    tfa_report_add_grouped(report, refused ? TFA_ERROR : TFA_WARNING, link->line,
                           "inertia-not-positive", "links", link->name,
                           "link '%s': its inertia has the eigenvalue %.6Lg kg m^2; a body cannot "
                           "have a negative one: correct <inertia>%s%s",
                           link->name, value[0], refused ? ", or choose " : "",
                           refused ? tfa_option_text(report, TFA_OPTION_INERTIA_REPAIR) : "");
    return refused ? TFA_E_MODEL : TFA_OK;
}

static int check_triangle(const struct draft *d, size_t k, tfa_report *report)
{
    const tfa_link *link = &d->description->links[k];
    long double value[3];
    tfa_eigen(d->link[k].inertia, value, NULL);
    if (value[2] <= (1 + TRIANGLE_TOLERANCE) * (value[0] + value[1]))
        return TFA_OK;
    tfa_report_add_grouped(
        report, TFA_ERROR, link->line, "triangle", "links", link->name,
        "link '%s': its principal moments of inertia are %.6Lg %.6Lg %.6Lg kg m^2; in a body the "
        "largest does not exceed the sum of the others: correct <inertia>, or choose %s",
        link->name, value[0], value[1], value[2],
        tfa_option_text(report, TFA_OPTION_INERTIA_STRICT));
    return TFA_E_MODEL;
}

static int check_link(struct draft *d, size_t k, int moves, tfa_report *report)
{
    int status = check_negative(d, k, moves, report);
    if (status == TFA_OK && moves && d->options->inertia == TFA_INERTIA_STRICT_PHYSICAL)
        status = check_triangle(d, k, report);
    return status;
}

/* Joints come parents first, and so do their child links. */
int tfa_draft_inertias(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    for (size_t k = 0; k < s->link_count; k++)
        for (int e = 0; e < 6; e++)
            d->link[k].inertia[e] = s->links[k].inertia[e];
    d->link[d->root].moves = d->options->base == TFA_BASE_FLOATING;
    d->link[d->root].carrier = d->root;
    for (size_t k = 0; k < s->joint_count; k++) {
        const tfa_joint *joint = &s->joints[d->order[k]];
        const int moves = draft_moves(d, d->order[k]);
        d->link[joint->child].moves = d->link[joint->parent].moves || moves;
        d->link[joint->child].carrier = moves ? joint->child : d->link[joint->parent].carrier;
    }
    d->rounding = rounding_of(s);
    int status = TFA_OK;
    for (size_t k = 0; k < s->link_count; k++)
        if (d->link[k].present && check_link(d, k, d->link[k].moves, report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}

void tfa_draft_note_base(const struct draft *d, tfa_report *report)
{
    const tfa_link *root = &d->description->links[d->root];
    long double mass = 0;
    int world = 0;
    for (size_t k = 0; k < d->description->link_count; k++) {
        const double m = d->description->links[k].mass;
        world |= strcmp(d->description->links[k].name, "world") == 0;
        if (d->link[k].present && !d->link[k].moves)
            mass += m;
    }
    const int is_free = d->description->root_is_free;
    const char *before = "; choose", *after = " if it moves";
    if (is_free) {
        before = ": the file gives it a free joint, and the base is fixed; choose";
        after = "";
    } else if (root->mass > 0 && !world) {
        before = ", and the file has no link 'world' that it is fixed to; did you mean";
        after = "?";
    }
    if (mass > 0 && strcmp(root->name, "world") != 0)
        tfa_report_add(
            report, is_free ? TFA_WARNING : TFA_NOTE, root->line, "base-mass",
            "link '%s': it and what is fixed to it have mass, %.6Lg kg, which is not used%s %s%s",
            root->name, mass, before, tfa_option_text(report, TFA_OPTION_BASE_FLOATING), after);
}

void tfa_draft_note_immobile(const struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    for (size_t j = 0; j < s->joint_count; j++)
        if (s->joints[j].type != TFA_JOINT_FIXED)
            return;
    tfa_report_add(
        report, TFA_WARNING, s->links[d->root].line, "nothing-moves",
        "robot: nothing moves: no joint but fixed ones (%zu), and a fixed base; did xacro "
        "call the macro? For a free base choose %s",
        s->joint_count, tfa_option_text(report, TFA_OPTION_BASE_FLOATING));
}
