/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What cannot be computed is refused here: inertias that are not positive semidefinite, and
 * moving parts without mass.
 */
#include <math.h>
#include <stdlib.h>

#include "model/draft.h"

/* Written inertias carry a handful of digits: a relative deficit below this is rounding of the
 * file (six significant digits in most of 190 real URDFs), above it is a wrong number. */
#define PSD_TOLERANCE 1e-6L

static const char *body_link(const struct draft *d, uint32_t i)
{
    return d->description->links[d->body[i].link].name;
}

/* Smallest eigenvalue of a symmetric 3 x 3 matrix xx xy xz yy yz zz (trigonometric formula). */
static ext smallest_eigenvalue(const ext s[6])
{
    ext q = (s[0] + s[3] + s[5]) / 3;
    ext a = s[0] - q, b = s[3] - q, c = s[5] - q;
    ext off = s[1] * s[1] + s[2] * s[2] + s[4] * s[4];
    ext p = sqrtl((a * a + b * b + c * c + 2 * off) / 6);
    if (!(p > 0))
        return q;
    ext det = a * (b * c - s[4] * s[4]) - s[1] * (s[1] * c - s[4] * s[2]) +
              s[2] * (s[1] * s[4] - b * s[2]);
    ext r = fminl(1, fmaxl(-1, det / (2 * p * p * p)));
    return q + 2 * p * cosl(acosl(r) / 3 + 2 * acosl(-1.0L) / 3);
}

/* Inertia about the centre of mass: I - m (c.c 1 - c c^T), and its trace. */
static ext central_inertia(const struct draft_body *b, ext out[6])
{
    ext c[3] = {0, 0, 0}, m = b->mass;
    for (int i = 0; m > 0 && i < 3; i++)
        c[i] = b->h[i] / m;
    ext cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    static const int row[6] = {0, 0, 0, 1, 1, 2}, col[6] = {0, 1, 2, 1, 2, 2};
    for (int k = 0; k < 6; k++)
        out[k] = b->I[k] - m * ((row[k] == col[k] ? cc : 0) - c[row[k]] * c[col[k]]);
    return b->I[0] + b->I[3] + b->I[5];
}

static int check_inertia(const struct draft *d, uint32_t i, tfa_report *report)
{
    const struct draft_body *b = &d->body[i];
    ext Ic[6];
    ext scale = central_inertia(b, Ic);
    ext least = smallest_eigenvalue(Ic);
    uint32_t line = d->description->links[b->link].line;
    if (least < -PSD_TOLERANCE * fmaxl(scale, 0) - 1e-300L) {
        tfa_report_add(report, TFA_ERROR, line, "inertia-not-positive",
                       "link '%s': the inertia of its body has the eigenvalue %Lg kg m^2; a body "
                       "cannot have a negative one: correct <inertia>",
                       body_link(d, i), least);
        return TFA_E_MODEL;
    }
    return TFA_OK;
}

/* Does anything with mass move when joint i moves? Children come after parents: sum backwards. */
static int check_moving_mass(const struct draft *d, tfa_report *report)
{
    uint8_t *heavy = calloc(d->bodies + 1, 1);
    if (!heavy)
        return TFA_E_MEMORY;
    int status = TFA_OK;
    for (uint32_t i = d->bodies; i-- > 0;) {
        const struct draft_body *b = &d->body[i];
        heavy[i] |= b->mass > 0 || b->I[0] + b->I[3] + b->I[5] > 0;
        if (b->parent >= 0)
            heavy[b->parent] |= heavy[i];
        if (heavy[i] || b->armature > 0)
            continue;
        status = TFA_E_NO_MASS;
        const char *joint = b->joint >= 0 ? d->description->joints[b->joint].name : "(base)";
        uint32_t line = b->joint >= 0 ? d->description->joints[b->joint].line : 0;
        tfa_report_add(report, TFA_ERROR, line, "massless-leaf",
                       "joint '%s': nothing with mass moves with it, so the mass matrix is "
                       "singular; make it fixed, or give link '%s' mass or the joint armature",
                       joint, body_link(d, i));
    }
    free(heavy);
    return status;
}

int tfa_draft_check(const struct draft *d, tfa_report *report)
{
    int status = TFA_OK;
    for (uint32_t i = 0; i < d->bodies; i++) {
        int s = check_inertia(d, i, report);
        if (s != TFA_OK)
            status = s;
    }
    return status == TFA_OK ? check_moving_mass(d, report) : status;
}
