/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Warnings about inertias and lengths that no real body has, and notes about links that are only
 * frames.
 */
#include "model/eigen.h"
#include "model/report/report_messages.h"
#include "urdf/urdf.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* m, within a link: a crane's arm */
#define LONGEST 20.0

static double norm(const double x[3])
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

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

/* Least density of a body with this mass and second moment about its centre of mass, kg/m^3: that
 * of a ball, 3/5 m (3m / 4 pi density)^(2/3) = tr(I) / 2. */
static double least_density(double mass, const double moment[3])
{
    const double second = (moment[0] + moment[1] + moment[2]) / 2;
    return 3 * mass / (4 * M_PI) * pow(3 * mass / (5 * second), 1.5);
}

static void check_density(const tfa_link *link, const double moment[3], tfa_urdf_log *log)
{
    const double osmium = 22600, density = least_density(link->mass, moment);
    if (density > osmium)
        tfa_report_add_grouped(
            log->report, TFA_WARNING, link->line, "odd-density", "links", link->name,
            "link '%s': %g kg with gyration radii of %.2g to %.2g m have %.2g kg/m^3 or more, and "
            "osmium has %g; is <mass> in grams? It is in kg, <inertia> in kg m^2",
            link->name, link->mass, sqrt(moment[0] / link->mass), sqrt(moment[2] / link->mass),
            density, osmium);
}

/* A point of more than a tonne in a link of centimetres; its inertia says no size. */
static void check_point(const tfa_link *link, tfa_urdf_log *log)
{
    const double distance = norm(link->com);
    if (link->mass > 1000 && distance > 0 && distance < 0.1)
        tfa_report_add_grouped(
            log->report, TFA_WARNING, link->line, "odd-density", "links", link->name,
            "link '%s': %g kg without extent, %g m from its origin; is <mass> in grams? It is in "
            "kg",
            link->name, link->mass, distance);
}

static void check_gyration(const tfa_link *link, const double moment[3], tfa_urdf_log *log)
{
    double least = sqrt(moment[0] / link->mass);
    double most = sqrt(moment[2] / link->mass);
    if (least >= 1e-3 && most <= 2.0)
        check_density(link, moment, log);
    else
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
    if (norm(link->com) > LONGEST)
        tfa_report_add_grouped(
            log->report, TFA_WARNING, link->line, "odd-centre", "links", link->name,
            "link '%s': its centre of mass is %g m from its origin; is it in millimetres? xyz is "
            "in metres",
            link->name, norm(link->com));
    if (zero)
        check_point(link, log);
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

/* A fixed joint of the world may place a robot anywhere. */
static void check_joint(const tfa_description *d, const tfa_joint *joint, tfa_urdf_log *log)
{
    const char *parent = d->links[joint->parent].name;
    const double length = norm(joint->xyz);
    if (length > LONGEST && !(joint->type == TFA_JOINT_FIXED && strcmp(parent, "world") == 0))
        tfa_report_add_grouped(
            log->report, TFA_WARNING, joint->line, "odd-origin", "joints", joint->name,
            "joint '%s': its origin is %g m from that of link '%s'; is it in millimetres? xyz is "
            "in metres",
            joint->name, length, parent);
}

void tfa_urdf_inertia(const tfa_description *description, tfa_urdf_log *log)
{
    check_placeholders(description, log);
    for (size_t i = 0; i < description->link_count; i++)
        check_link(&description->links[i], log);
    for (size_t j = 0; j < description->joint_count; j++)
        check_joint(description, &description->joints[j], log);
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
