/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Warnings about inertias that can be computed with but that no real body has.
 */
#include "urdf/urdf.h"

#include <math.h>

/* One Jacobi rotation that makes a[p][q] zero. */
static void jacobi_rotate(double a[3][3], int p, int q)
{
    if (a[p][q] == 0.0)
        return;
    double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    double t = copysign(1.0, theta) / (fabs(theta) + hypot(theta, 1.0));
    double c = 1.0 / sqrt(t * t + 1.0);
    double s = t * c;
    int r = 3 - p - q;
    double apr = a[p][r];
    double aqr = a[q][r];
    a[p][p] -= t * a[p][q];
    a[q][q] += t * a[p][q];
    a[p][q] = a[q][p] = 0.0;
    a[p][r] = a[r][p] = c * apr - s * aqr;
    a[q][r] = a[r][q] = s * apr + c * aqr;
}

/* Principal moments, ascending. The matrix is scaled first, so any finite input gives numbers. */
static void principal_moments(const double inertia[6], double moment[3])
{
    double scale = 0.0;
    for (int i = 0; i < 6; i++)
        scale = fmax(scale, fabs(inertia[i]));
    double s[6] = {0};
    for (int i = 0; scale > 0.0 && i < 6; i++)
        s[i] = inertia[i] / scale;
    double a[3][3] = {{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
    for (int sweep = 0; sweep < 8; sweep++) { /* quadratic: five reach the last bit */
        jacobi_rotate(a, 0, 1);
        jacobi_rotate(a, 0, 2);
        jacobi_rotate(a, 1, 2);
    }
    double low = fmin(a[0][0], fmin(a[1][1], a[2][2]));
    double high = fmax(a[0][0], fmax(a[1][1], a[2][2]));
    double middle = fmax(fmin(a[0][0], a[1][1]), fmin(fmax(a[0][0], a[1][1]), a[2][2]));
    moment[0] = low * scale;
    moment[1] = middle * scale;
    moment[2] = high * scale;
}

static void check_link(const tfa_link *link, tfa_urdf_log *log)
{
    double moment[3];
    principal_moments(link->inertia, moment);
    if (link->mass < 1e-4)
        tfa_urdf_say(log, TFA_WARNING, link->line, "small-mass",
                     "link '%s': mass %g kg is below 1e-4 kg; give it the mass of the real part, "
                     "or 0 if it is only a frame",
                     link->name, link->mass);
    /* Not positive semidefinite is the model compiler's business, which knows what moves. */
    if (moment[0] < 0.0 || moment[2] <= 0.0)
        return;
    double least = sqrt(moment[0] / link->mass);
    double most = sqrt(moment[2] / link->mass);
    if (least < 1e-3 || most > 2.0)
        tfa_urdf_say(log, TFA_WARNING, link->line, "odd-gyration",
                     "link '%s': gyration radii %g to %g m, condition number %.3g; real parts have "
                     "1 mm to 2 m: check the units of <mass> and <inertia>",
                     link->name, least, most, moment[2] / moment[0]);
    if (moment[0] + moment[1] <= 0.0) {
        tfa_urdf_say(log, TFA_WARNING, link->line, "triangle",
                     "link '%s': only one of its principal moments of inertia is not zero, which "
                     "no body has; correct <inertia>",
                     link->name);
        return;
    }
    double excess = moment[2] / (moment[0] + moment[1]) - 1.0;
    if (excess > 1e-6) /* files round: at six digits a flat plate is off by that much */
        tfa_urdf_say(log, TFA_WARNING, link->line, "triangle",
                     "link '%s': its largest principal moment of inertia is %.3g %% larger than "
                     "the other two together, which no body has; correct <inertia>",
                     link->name, 100.0 * excess);
}

void tfa_urdf_inertia(const tfa_description *description, tfa_urdf_log *log)
{
    for (size_t i = 0; i < description->link_count; i++)
        if (description->links[i].mass > 0.0)
            check_link(&description->links[i], log);
}
