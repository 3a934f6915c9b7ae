/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What cannot be a model is refused, by name, with the remedy: every row one mistake in a sound
 * robot, with the exact message.
 */
#include "mistakes.h"
#include "test.h"

/* Of the arm: base -shoulder- upper -elbow- lower -flange(fixed)- tool */
static void check_report(const struct mistake *row, const tfa_report *report)
{
    size_t k = 0;
    while (k < report->count && report->messages[k].severity != TFA_ERROR)
        k++;
    if (k == report->count)
        fail_msg("%s: no error in the report", row->name);
    assert_string_equal(report->messages[k].text, row->text);
    assert_string_equal(report->messages[k].code, row->code);
    if (report->messages[k].line != row->line || report->errors != row->errors)
        fail_msg("%s: line %u, %zu errors", row->name, (unsigned)report->messages[k].line,
                 report->errors);
}

static void expect_status(const struct mistake *row, int status)
{
    if (status != row->status)
        fail_msg("%s: status %s, expected %s", row->name, tfa_status_name(status),
                 tfa_status_name(row->status));
}

TEST(test_rows)
{
    static _Alignas(64) char memory[1 << 16];
    for (size_t k = 0; k < mistake_count; k++) {
        const struct mistake *row = &mistakes[k];
        hand h;
        hand_arm(&h);
        if (row->spoil)
            row->spoil(&h);
        tfa_report created = {0}, placed = {0};
        tfa_model *model = (tfa_model *)memory;
        const tfa_model *placed_model = model;
        expect_status(row, tfa_model_create(&h.d, &row->options, &created, &model));
        assert_null(model);
        check_report(row, &created);
        expect_status(row, tfa_model_init(memory, sizeof memory, &h.d, &row->options, &placed,
                                          &placed_model));
        assert_null(placed_model);
        check_report(row, &placed);
        expect_status(row, tfa_model_create(&h.d, &row->options, NULL, &model));
        if (row->spoil) /* gravity and base do not change the size */
            assert_int_equal(tfa_model_size(&h.d, &row->options), 0);
        tfa_report_free(&created);
        tfa_report_free(&placed);
    }
}

/* The sound robot itself, and mistakes that are none. */
TEST(test_legal)
{
    hand h;
    hand_arm(&h);
    tfa_model_free(hand_model(&h, NULL));
    massless_leaf(&h);
    h.joint[3].armature = 0.01;
    tfa_model_free(hand_model(&h, NULL));
    hand_arm(&h);
    massless_leaf(&h);
    h.joint[3].rotor = 0.01;
    const tfa_model_options rotors = {.rotor_inertia = 1};
    tfa_model_free(hand_model(&h, &rotors));
    hand_arm(&h);
    massless_leaf(&h);
    h.joint[3].type = TFA_JOINT_FIXED;
    tfa_model_free(hand_model(&h, NULL));
    hand_arm(&h);
    massless_base(&h);
    tfa_model_free(hand_model(&h, NULL)); /* one link that does not move: no body at all */
    hand_arm(&h);
    h.joint[FLANGE].axis[1] = 0; /* fixed joints have no axis */
    h.joint[ELBOW].rotor = -1;   /* and nobody asked for rotors */
    h.joint[ELBOW].quat[3] = -7; /* any length will do */
    h.link[UPPER].inertia[0] *= 1 - 1e-9;
    tfa_model_free(hand_model(&h, NULL));
}

/* A flat plate rounded to six digits is a plate; one off by 1 % is a mistake. */
TEST(test_rounded_inertia)
{
    static const struct {
        double least;
        int status;
    } cases[] = {{0, TFA_OK}, {-1e-8, TFA_OK}, {-1e-3, TFA_E_MODEL}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        hand h;
        hand_arm(&h);
        memset(h.link[UPPER].com, 0, sizeof h.link[UPPER].com);
        const double inertia[6] = {0.1, 0, 0, 0.1, 0, cases[k].least};
        memcpy(h.link[UPPER].inertia, inertia, sizeof inertia);
        tfa_model *model = NULL;
        assert_int_equal(tfa_model_create(&h.d, NULL, NULL, &model), cases[k].status);
        tfa_model_free(model);
    }
}

TEST(test_null)
{
    hand h;
    hand_arm(&h);
    tfa_model *model = NULL;
    const tfa_model *placed = NULL;
    static _Alignas(64) char memory[1 << 14];
    assert_int_equal(tfa_model_create(NULL, NULL, NULL, &model), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_create(&h.d, NULL, NULL, NULL), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_init(NULL, 1 << 14, &h.d, NULL, NULL, &placed), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_init(memory, sizeof memory, NULL, NULL, NULL, &placed),
                     TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_init(memory, sizeof memory, &h.d, NULL, NULL, NULL), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_load(NULL, NULL, NULL, &model), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_load("x", NULL, NULL, NULL), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_size(NULL, NULL), 0);
    tfa_model_free(NULL);
}
