/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What must hold of a description: finite numbers, unit vectors, one tree, mimics that end.
 */
#include "invariants.h"

#include <math.h>
#include <string.h>

static void require_finite(const double *v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        REQUIRE(isfinite(v[i]));
}

static void require_unit(const double *v, size_t n)
{
    double square = 0;
    for (size_t i = 0; i < n; i++)
        square += v[i] * v[i];
    REQUIRE(fabs(square - 1) < 1e-12);
}

/* A unit vector in two parts, the second of which is less than the rounding of the first */
static void require_parts(const double *high, const double *low, size_t n)
{
    require_unit(high, n);
    for (size_t i = 0; i < n; i++)
        REQUIRE(fabs(low[i]) <= 0x1p-53 * fabs(high[i]) + 0x1p-1074);
}

static void require_link(const tfa_link *link)
{
    REQUIRE(link->name && strlen(link->name) > 0 && strlen(link->name) <= 255);
    require_finite(link->com, 3);
    require_finite(link->inertia, 6);
    require_parts(link->quat, link->quat_low, 4);
    REQUIRE(isfinite(link->mass) && link->mass >= 0);
}

static void require_joint(const tfa_description *d, const tfa_joint *joint)
{
    REQUIRE(joint->name && strlen(joint->name) > 0 && strlen(joint->name) <= 255);
    REQUIRE(joint->parent < d->link_count && joint->child < d->link_count);
    REQUIRE(joint->parent != joint->child);
    REQUIRE(joint->mimic >= TFA_MIMIC_UNKNOWN && joint->mimic < (int64_t)d->joint_count);
    REQUIRE(isfinite(joint->armature) && joint->armature >= 0);
    const double numbers[4] = {joint->damping, joint->friction, joint->multiplier, joint->offset};
    require_finite(numbers, 4);
    require_finite(joint->xyz, 3);
    require_parts(joint->quat, joint->quat_low, 4);
    require_parts(joint->axis, joint->axis_low, 3);
}

/* With one joint above every link but one, one tree is what remains when no walk up is endless. */
static void require_tree(const tfa_description *d)
{
    REQUIRE(d->link_count > 0 && d->joint_count + 1 == d->link_count);
    size_t *parent = calloc(d->link_count, sizeof *parent);
    REQUIRE(parent);
    for (size_t i = 0; i < d->link_count; i++)
        parent[i] = SIZE_MAX;
    for (size_t j = 0; j < d->joint_count; j++) {
        REQUIRE(parent[d->joints[j].child] == SIZE_MAX);
        parent[d->joints[j].child] = d->joints[j].parent;
    }
    for (size_t i = 0; i < d->link_count; i++) {
        size_t steps = 0;
        for (size_t k = i; parent[k] != SIZE_MAX; k = parent[k])
            REQUIRE(++steps < d->link_count);
    }
    free(parent);
}

static void require_mimics_end(const tfa_description *d)
{
    for (size_t j = 0; j < d->joint_count; j++) {
        size_t steps = 0;
        for (int32_t k = (int32_t)j; k >= 0; k = d->joints[k].mimic)
            REQUIRE(steps++ < d->joint_count);
    }
}

static void require_constraint(const tfa_description *d, const tfa_constraint *c)
{
    REQUIRE(c->name && strlen(c->name) > 0 && strlen(c->name) <= 255);
    REQUIRE(c->rows && !(c->rows & ~TFA_CONSTRAINT_WELD) && !c->unilateral);
    for (int side = 0; side < 2; side++) {
        size_t link = 0;
        while (c->link[side] && link < d->link_count && d->links[link].name != c->link[side])
            link++;
        REQUIRE(!c->link[side] || link < d->link_count);
        require_finite(c->pose[side], 3);
        require_unit(c->pose[side] + 3, 4);
    }
}

void check_report(const tfa_report *report, int status)
{
    REQUIRE((report->errors > 0) == (status != TFA_OK));
    for (size_t i = 0; i < report->count; i++) {
        char text[4096];
        REQUIRE(tfa_report_format(report, i, text, sizeof text) > 0);
        REQUIRE(!strchr(text, '\n'));
    }
}

static void require_description(const tfa_description *d)
{
    for (size_t i = 0; i < d->link_count; i++)
        require_link(&d->links[i]);
    for (size_t j = 0; j < d->joint_count; j++)
        require_joint(d, &d->joints[j]);
    REQUIRE(d->constraint_count <= TFA_MAX_CONSTRAINTS);
    for (size_t k = 0; k < d->constraint_count; k++)
        require_constraint(d, &d->constraints[k]);
    require_tree(d);
    require_mimics_end(d);
}

tfa_description *check_parse(const char *text, size_t length)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    int status = tfa_urdf_parse(text, length, "fuzz", &d, &report);
    REQUIRE(status == TFA_OK || status == TFA_E_PARSE || status == TFA_E_FILE);
    REQUIRE((d != NULL) == (status == TFA_OK));
    check_report(&report, status);
    /* What urdfdom refuses the lint pass should have refused before, with a line. */
    for (size_t i = 0; i < report.count; i++)
        REQUIRE(strcmp(report.messages[i].code, "urdfdom") != 0);
    if (d)
        require_description(d);
    tfa_report_free(&report);
    return d;
}
