/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inertias that no body has: refused, told or repaired, link by link, as the policy says. What
 * does not move is only ever warned about. (The loader warns of broken triangles.)
 */
#include <math.h>
#include <string.h>

#include "model/draft.h"
#include "model/eigen.h"

/* Files round: at six digits a flat plate breaks the triangle inequality by that much. */
#define TRIANGLE_TOLERANCE 1e-6L

/* V diag(value) V^T with the negative values 0 */
static void clip(long double s[6], const long double value[3], const long double V[9])
{
    for (int k = 0; k < 6; k++) {
        s[k] = 0;
        for (int e = 0; e < 3; e++)
            s[k] += fmaxl(value[e], 0) * V[3 * ext_row[k] + e] * V[3 * ext_col[k] + e];
        s[k] = (double)s[k]; /* a number that the file could hold */
    }
}

static void tell_repaired(const tfa_link *link, const long double was[3], tfa_report *report)
{
    tfa_report_add(report, TFA_WARNING, link->line, "inertia-repaired",
                   "link '%s': its inertia has the principal moments %.6Lg %.6Lg %.6Lg kg m^2; "
                   "used as %.6Lg %.6Lg %.6Lg: correct <inertia>",
                   link->name, was[0], was[1], was[2], fmaxl(was[0], 0), fmaxl(was[1], 0),
                   fmaxl(was[2], 0));
}

static int check_negative(struct draft *d, size_t k, int moves, tfa_report *report)
{
    const tfa_link *link = &d->description->links[k];
    long double value[3], V[9];
    tfa_eigen(d->link[k].inertia, value, V);
    if (!tfa_eigen_negative(value))
        return TFA_OK;
    const tfa_inertia_policy policy = d->options->inertia;
    if (moves && policy == TFA_INERTIA_REPAIR) {
        clip(d->link[k].inertia, value, V);
        tell_repaired(link, value, report);
        return TFA_OK;
    }
    const int refused = moves && policy != TFA_INERTIA_WARN;
    tfa_report_add(report, refused ? TFA_ERROR : TFA_WARNING, link->line, "inertia-not-positive",
                   "link '%s': its inertia has the eigenvalue %.6Lg kg m^2; a body cannot have a "
                   "negative one: correct <inertia>%s",
                   link->name, value[0], refused ? ", or choose inertia = repair" : "");
    return refused ? TFA_E_MODEL : TFA_OK;
}

static int check_triangle(const struct draft *d, size_t k, tfa_report *report)
{
    const tfa_link *link = &d->description->links[k];
    long double value[3];
    tfa_eigen(d->link[k].inertia, value, NULL);
    if (value[2] <= (1 + TRIANGLE_TOLERANCE) * (value[0] + value[1]))
        return TFA_OK;
    tfa_report_add(report, TFA_ERROR, link->line, "triangle",
                   "link '%s': its principal moments of inertia are %.6Lg %.6Lg %.6Lg kg m^2; in a "
                   "body the largest does not exceed the sum of the others: correct <inertia>, or "
                   "choose inertia = strict",
                   link->name, value[0], value[1], value[2]);
    return TFA_E_MODEL;
}

static int check_link(struct draft *d, size_t k, int moves, tfa_report *report)
{
    int status = check_negative(d, k, moves, report);
    if (status == TFA_OK && moves && d->options->inertia == TFA_INERTIA_STRICT_PHYSICAL)
        status = check_triangle(d, k, report);
    return status;
}

/* Joints come parents first, and so do the links that they move. */
int tfa_draft_inertias(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    for (size_t k = 0; k < s->link_count; k++)
        for (int e = 0; e < 6; e++)
            d->link[k].inertia[e] = s->links[k].inertia[e];
    d->link[d->root].moves = d->options->base == TFA_BASE_FLOATING;
    for (size_t k = 0; k < s->joint_count; k++) {
        const tfa_joint *joint = &s->joints[d->order[k]];
        d->link[joint->child].moves = d->link[joint->parent].moves || draft_moves(d, d->order[k]);
    }
    int status = TFA_OK;
    for (size_t k = 0; k < s->link_count; k++)
        if (d->link[k].present && check_link(d, k, d->link[k].moves, report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}

/* Mass that a fixed base carries decides no answer. */
void tfa_draft_note_base(const struct draft *d, tfa_report *report)
{
    const tfa_link *root = &d->description->links[d->root];
    long double mass = 0;
    size_t links = 0;
    for (size_t k = 0; k < d->description->link_count; k++) {
        const double m = d->description->links[k].mass;
        if (!d->link[k].present || d->link[k].moves || m == 0)
            continue;
        mass += m;
        links++;
    }
    if (links)
        tfa_report_add(report, TFA_NOTE, root->line, "base-mass",
                       "link '%s': %zu of the links that are fixed to the world have mass, %.6Lg "
                       "kg: not used; choose the floating base if they move",
                       root->name, links, mass);
}
