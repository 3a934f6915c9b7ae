/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Right angles that a file spells as 1.5708: exact when it is asked for, and what that changes is
 * said.
 */
#include "model/model.h"
#include "models.h"
#include "test.h"

#include <totalforce/totalforce.h>

static tfa_model *model_of(const tfa_description *d, double snap, tfa_report *report)
{
    tfa_model *model;
    const tfa_model_options options = {.snap = snap};
    assert_int_equal(tfa_model_create(d, &options, report, &model), TFA_OK);
    return model;
}

/* Entries of constant rotations that are neither 0 nor +-1 */
static int general_entries(const tfa_model *m)
{
    int count = 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        for (int k = 0; k < 9; k++)
            count += m->body[i].E[k] != 0 && fabs(m->body[i].E[k]) != 1;
    return count;
}

static void rotate_x(double quat[4], double angle)
{
    quat[0] = sin(angle / 2);
    quat[1] = quat[2] = 0;
    quat[3] = cos(angle / 2);
}

static const char *note_of(const tfa_report *report)
{
    for (size_t k = 0; k < report->count; k++)
        if (strcmp(report->messages[k].code, "snapped") == 0)
            return report->messages[k].text;
    return "";
}

TEST(noise_goes)
{
    tfa_report report = {0};
    tfa_description *d = bundled_description("arm7.urdf");
    for (size_t j = 1; j < 7; j++) /* joint 0 fixes the base */
        rotate_x(d->joints[j + 1].quat, (j & 1 ? 1 : -1) * 1.5708);
    tfa_model *as_written = model_of(d, 0, &report);
    assert_string_equal(note_of(&report), "");
    assert_true(general_entries(as_written) > 0);
    tfa_model *snapped = model_of(d, 1e-5, &report);
    assert_int_equal(general_entries(snapped), 0);
    /* 1.5708 is 3.673e-06 more than a right angle */
    assert_non_null(strstr(note_of(&report),
                           "right angles: 6, within 1e-05 rad; the largest change "
                           "is 3.67e-06 rad"));
    assert_memory_not_equal(tfa_model_hash(as_written), tfa_model_hash(snapped), 32);
    tfa_model_free(as_written);
    tfa_model_free(snapped);
    tfa_report_free(&report);
    tfa_description_free(d);
}

/* What is further away stays, to the bit. */
TEST(other_angles_stay)
{
    tfa_report report = {0};
    tfa_description *d = bundled_description("arm7.urdf");
    for (size_t j = 0; j < d->joint_count; j++)
        rotate_x(d->joints[j].quat, 0.3 + 0.1 * (double)j);
    rotate_x(d->joints[2].quat, 1.5708);
    for (size_t k = 0; k < d->link_count; k++)
        rotate_x(d->links[k].quat, 0.01 * (double)(k + 1));
    tfa_model *as_written = model_of(d, 0, &report), *snapped = model_of(d, 3e-6, &report);
    assert_memory_equal(tfa_model_hash(as_written), tfa_model_hash(snapped), 32);
    assert_non_null(strstr(note_of(&report), "right angles: 0,"));
    tfa_model_free(as_written);
    tfa_model_free(snapped);
    tfa_report_free(&report);
    tfa_description_free(d);
}

/* Every rotation by right angles, shaken by less than the limit, comes back; the answer is that of
 * a rotation, never of a reflection. */
TEST(all_right_angles_are_found)
{
    const double h = 0.5, s = sqrt(0.5);
    const double quats[][4] = {{0, 0, 0, 1},  {1, 0, 0, 0},  {0, 1, 0, 0},  {0, 0, 1, 0},
                               {s, 0, 0, s},  {0, s, 0, s},  {0, 0, s, s},  {-s, 0, 0, s},
                               {s, s, 0, 0},  {s, 0, -s, 0}, {0, s, s, 0},  {h, h, h, h},
                               {h, h, -h, h}, {-h, h, h, h}, {h, -h, -h, h}};
    for (size_t k = 0; k < sizeof quats / sizeof *quats; k++) {
        tfa_report report = {0};
        tfa_description *d = bundled_description("arm7.urdf");
        for (int e = 0; e < 4; e++)
            d->joints[4].quat[e] = quats[k][e] + 1e-7 * (e - 1.3);
        tfa_model *snapped = model_of(d, 1e-5, &report);
        const tfa_body_info body = tfa_model_body(snapped, 3);
        assert_true(body.mass > 0);
        assert_int_equal(general_entries(snapped), 0);
        tfa_model_free(snapped);
        tfa_report_free(&report);
        tfa_description_free(d);
    }
}

TEST(silly_limits_are_refused)
{
    const double limits[] = {-1e-9, 0.0101, 1, (double)NAN, (double)INFINITY};
    tfa_description *d = bundled_description("arm7.urdf");
    for (size_t k = 0; k < sizeof limits / sizeof *limits; k++) {
        tfa_report report = {0};
        tfa_model *model;
        const tfa_model_options options = {.snap = limits[k]};
        assert_int_equal(tfa_model_create(d, &options, &report, &model), TFA_E_VALUE);
        assert_string_equal(report.messages[0].code, "bad-snap");
        tfa_report_free(&report);
    }
    tfa_description_free(d);
}
