/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes at all give either a sound description or an error with a message.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/description.h>
#include <totalforce/model.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define REQUIRE(condition)                                                                         \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "line %d: not true: %s\n", __LINE__, #condition);                      \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

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

static void require_link(const tfa_link *link)
{
    REQUIRE(link->name && strlen(link->name) > 0 && strlen(link->name) <= 255);
    require_finite(link->com, 3);
    require_finite(link->inertia, 6);
    require_unit(link->quat, 4);
    REQUIRE(isfinite(link->mass) && link->mass >= 0);
}

static void require_joint(const tfa_description *d, const tfa_joint *joint)
{
    REQUIRE(joint->name && strlen(joint->name) > 0 && strlen(joint->name) <= 255);
    REQUIRE(joint->parent < d->link_count && joint->child < d->link_count);
    REQUIRE(joint->parent != joint->child);
    REQUIRE(joint->mimic >= -1 && joint->mimic < (int64_t)d->joint_count);
    REQUIRE(isfinite(joint->armature) && joint->armature >= 0);
    const double numbers[3] = {joint->damping, joint->multiplier, joint->offset};
    require_finite(numbers, 3);
    require_finite(joint->xyz, 3);
    require_unit(joint->quat, 4);
    require_unit(joint->axis, 3);
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

static void require_report(const tfa_report *report, int status)
{
    REQUIRE((report->errors > 0) == (status != TFA_OK));
    for (size_t i = 0; i < report->count; i++) {
        char text[4096];
        REQUIRE(tfa_report_format(report, i, text, sizeof text) > 0);
        REQUIRE(!strchr(text, '\n'));
    }
}

/* What parsed must compile or be refused with a reason, on both bases. */
static void require_model(const tfa_description *d)
{
    for (int base = TFA_BASE_FIXED; base <= TFA_BASE_FLOATING; base++) {
        const tfa_model_options options = {.base = (tfa_base)base, .rotor_inertia = 1};
        tfa_report report = {0};
        tfa_model *model = NULL;
        int status = tfa_model_create(d, &options, &report, &model);
        REQUIRE((model != NULL) == (status == TFA_OK));
        REQUIRE((report.errors > 0) == (status != TFA_OK));
        tfa_model_free(model);
        tfa_report_free(&report);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    int status = tfa_urdf_parse((const char *)data, size, "fuzz", &d, &report);
    REQUIRE(status == TFA_OK || status == TFA_E_PARSE || status == TFA_E_FILE);
    REQUIRE((d != NULL) == (status == TFA_OK));
    require_report(&report, status);
    for (size_t i = 0; d && i < d->link_count; i++)
        require_link(&d->links[i]);
    for (size_t j = 0; d && j < d->joint_count; j++)
        require_joint(d, &d->joints[j]);
    if (d) {
        require_tree(d);
        require_mimics_end(d);
        require_model(d);
    }
    tfa_description_free(d);
    tfa_report_free(&report);
    return 0;
}
