/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Warnings about inertias that no real body has, and notes about links that are only frames.
 */
#include "model/eigen.h"
#include "model/report/report_messages.h"
#include "urdf/urdf.h"

#include <math.h>
#include <stdbool.h>

/* Principal moments, ascending */
static void principal_moments(const double inertia[6], double moment[3])
{
    long double I[6], value[3];
    for (int k = 0; k < 6; k++)
        I[k] = inertia[k];
    tfa_eigen(I, value, NULL);
    for (int k = 0; k < 3; k++)
        moment[k] = (double)value[k];
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
    /* A point mass is valid. The model compiler handles inertias that are not positive
     * semidefinite, because it knows which links move; rounding of the file counts as 0. */
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

/* ---- notes ---- */

static bool is_frame(const tfa_link *link)
{
    bool massless = link->mass == 0.0;
    for (int i = 0; i < 6; i++)
        massless = massless && link->inertia[i] == 0.0;
    return massless;
}

/* Notes links that are only frames: without <inertial>, or with zeros in it. */
void tfa_urdf_notes(const tfa_description *d, tfa_urdf_log *log)
{
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_link *link = &d->links[d->joints[j].child];
        if (d->joints[j].type != TFA_JOINT_FIXED || !is_frame(link))
            continue;
        tfa_report_add_grouped(log->report, TFA_NOTE, link->line, "no-inertial", "links",
                               link->name, "link '%s': no mass, on a fixed joint: kept as a frame",
                               link->name);
    }
}
