/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What an atlas counts, on rows that are made up: broken promises, failures, who answered.
 */
#include "atlas/atlas.h"

#include "test.h"

static const struct {
    const char *what;
    atlas_row row;
    int kept, failed, fell_back, refused;
} made_up[] = {
    {"good",
     {.by_method = 3, .error = 1e-9, .worst = 1e-9, .floor = 1e-12, .over = 29.0},
     1,
     0,
     0,
     0},
    {"estimate too small",
     {.by_method = 3, .error = 1e-9, .floor = 1e-12, .over = 31.0},
     0,
     0,
     0,
     0},
    {"silent", {.by_method = 3, .error = 1e-5, .floor = 1e-12, .silent = 1}, 0, 0, 0, 0},
    {"wrong", {.by_method = 3, .error = 1e-3, .floor = 1e-6}, 1, 1, 0, 0},
    {"data allow no better", {.by_method = 3, .error = 1e-3, .floor = 1e-4}, 1, 0, 0, 0},
    {"fallback", {.by_method = 1, .fallback = 2, .error = 1e-9, .floor = 1e-12}, 1, 0, 1, 0},
    {"refused", {.refused = 3, .status = TFA_E_SINGULAR, .error = INFINITY}, 1, 0, 0, 1},
    {"not finite", {.refused = 3, .status = TFA_E_NOT_COMPUTED, .error = INFINITY}, 1, 1, 0, 1},
};

TEST(rows_are_judged)
{
    for (size_t i = 0; i < sizeof made_up / sizeof *made_up; i++) {
        atlas_row row = made_up[i].row;
        row.method = TFA_METHOD_TFA;
        row.mode = ATLAS_SERVICE;
        const atlas_summary summary = atlas_summarise(&row, 1);
        if (atlas_promises_kept(&summary, &row, 1) != made_up[i].kept ||
            atlas_failed(&row) != made_up[i].failed ||
            atlas_fell_back(&row) != made_up[i].fell_back ||
            atlas_refused(&row) != made_up[i].refused)
            fail_msg("%s", made_up[i].what);
    }
}

TEST(a_summary_finds_the_worst)
{
    atlas_row rows[3] = {
        {.mode = ATLAS_SERVICE, .by_method = 2, .worst = 1e-6, .floor = 1e-6, .unreported = 2},
        {.mode = ATLAS_SERVICE,
         .by_method = 1,
         .fallback = 1,
         .worst = 1e-9,
         .floor = 1e-15,
         .over = 2.0},
        {.mode = ATLAS_PLAIN, .by_method = 2, .worst = 1e3, .floor = 1e-15, .unreported = 2},
    };
    const atlas_summary s = atlas_summarise(rows, 3);
    assert_ptr_equal(s.worst, &rows[0]);
    assert_ptr_equal(s.far, &rows[1]);
    assert_ptr_equal(s.over, &rows[1]);
    assert_int_equal(s.answers[ATLAS_SERVICE][0], 3);
    assert_int_equal(s.answers[ATLAS_SERVICE][1], 1);
    assert_int_equal(s.unreported, 2); /* what a method alone does is no word of the service */
}

TEST(axes_end_where_they_should)
{
    for (int map = 0; map < ATLAS_MAP_COUNT; map++) {
        const double first = atlas_value((atlas_map)map, 0, 13);
        const double last = atlas_value((atlas_map)map, 12, 13);
        assert_true(first == (map == ATLAS_CURL ? 0.0 : 1.0));
        const mechanism_options a = atlas_mechanism((atlas_map)map, first, 5, 1);
        const mechanism_options b = atlas_mechanism((atlas_map)map, last, 5, 1);
        assert_true(memcmp(&a, &b, sizeof a) != 0); /* the value goes somewhere */
        char why[128];
        assert_int_equal(mechanism_check(&b, why, sizeof why), 0);
    }
    assert_true(fabs(atlas_value(ATLAS_RATIO, 6, 13) / 1e6 - 1.0) < 1e-12);
}

TEST(numbers_are_short)
{
    static const struct {
        double value;
        const char *text;
    } cases[] = {{0.0, "0"},       {1.0, "1"},     {10.0, "10"},   {100.0, "1e2"},
                 {1e12, "1e12"},   {0.01, "0.01"}, {1e-3, "1e-3"}, {3.1623e-6, "3.2e-6"},
                 {0.0278, "0.028"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[32];
        atlas_short(text, sizeof text, cases[i].value);
        assert_string_equal(text, cases[i].text);
    }
}
