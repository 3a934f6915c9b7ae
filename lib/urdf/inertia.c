/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Warnings about inertias that can be computed with but that no real body has.
 */
#include "model/report/report_messages.h"
#include "urdf/urdf.h"

#include <math.h>
#include <stdbool.h>

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

static bool is_identity(const double inertia[6])
{
    static const double identity[6] = {1, 0, 0, 1, 0, 1};
    bool same = true;
    for (int i = 0; i < 6; i++)
        same = same && inertia[i] == identity[i];
    return same;
}

static void check_mass(const tfa_link *link, const double moment[3], tfa_urdf_log *log)
{
    if (link->mass >= 1e-4)
        return;
    double condition = moment[0] > 0.0 ? moment[2] / moment[0] : INFINITY;
    tfa_report_add_grouped(
        log->report, TFA_WARNING, link->line, "small-mass", "links", link->name,
        "link '%s': mass %g kg is below 1e-4 kg, condition number of its inertia %.3g; give it the "
        "mass of the real part, or 0 if it is only a frame",
        link->name, link->mass, condition);
}

/* One warning for the robot: a file that has one placeholder has them everywhere. */
static void check_placeholders(const tfa_description *d, tfa_urdf_log *log)
{
    for (size_t i = 0; i < d->link_count; i++) {
        const tfa_link *link = &d->links[i];
        if (link->mass != 0.0 && is_identity(link->inertia))
            tfa_report_add_grouped(
                log->report, TFA_WARNING, link->line, "placeholder-inertia", "links", link->name,
                "link '%s': <inertia> is the identity matrix, as exporters write when they know "
                "none; give it the inertia of the real part",
                link->name);
    }
}

static void check_gyration(const tfa_link *link, const double moment[3], tfa_urdf_log *log)
{
    double least = sqrt(moment[0] / link->mass);
    double most = sqrt(moment[2] / link->mass);
    if (least < 1e-3 || most > 2.0)
        tfa_report_add_grouped(log->report, TFA_WARNING, link->line, "odd-gyration", "links",
                               link->name,
                               "link '%s': gyration radii %g to %g m, condition number %.3g; real "
                               "parts have 1 mm to 2 m: check the units of <mass> and <inertia>",
                               link->name, least, most, moment[2] / moment[0]);
}

static void check_triangle(const tfa_link *link, const double moment[3], tfa_urdf_log *log)
{
    double excess = moment[2] / (moment[0] + moment[1]) - 1.0;
    if (excess > 1e-6) /* files round: at six digits a flat plate is off by that much */
        tfa_report_add_grouped(
            log->report, TFA_WARNING, link->line, "triangle", "links", link->name,
            "link '%s': its largest principal moment of inertia is %.3g %% larger than the other "
            "two together, which no body has; correct <inertia>",
            link->name, 100.0 * excess);
}

static void check_link(const tfa_link *link, tfa_urdf_log *log)
{
    double moment[3];
    principal_moments(link->inertia, moment);
    bool zero = moment[0] == 0.0 && moment[2] == 0.0;
    if (link->mass == 0.0 && !zero)
        tfa_report_add_grouped(log->report, TFA_WARNING, link->line, "inertia-without-mass",
                               "links", link->name,
                               "link '%s': mass 0, but an inertia that is not 0; give it the mass "
                               "of the real part, or no <inertial> if it is only a frame",
                               link->name);
    if (link->mass == 0.0)
        return;
    check_mass(link, moment, log);
    /* A point mass is well. Not positive semidefinite is the model compiler's business, which
     * knows what moves; what is negative by the rounding of the file counts as 0. */
    if (zero || moment[0] < -1e-6 * (moment[1] + moment[2]))
        return;
    moment[0] = fmax(moment[0], 0.0);
    if (moment[1] > 0.0) {
        check_gyration(link, moment, log);
        check_triangle(link, moment, log);
    } else
        tfa_report_add_grouped(log->report, TFA_WARNING, link->line, "triangle", "links",
                               link->name,
                               "link '%s': only one of its principal moments of inertia is not "
                               "zero, which no body has; correct <inertia>",
                               link->name);
}

void tfa_urdf_inertia(const tfa_description *description, tfa_urdf_log *log)
{
    check_placeholders(description, log);
    for (size_t i = 0; i < description->link_count; i++)
        check_link(&description->links[i], log);
}
