/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Limits of joints by name.
 */
#include "test.h"

#include <math.h>
#include <totalforce/limits.h>

static const char text[] =
    "<robot name=\"r\"><link name=\"a\"/>"
    "<joint name=\"both\" type=\"revolute\"><limit lower=\" -0.5\" upper=\"2\n\"/></joint>"
    "<joint name=\"one\" type=\"prismatic\">"
    "<limit upper=\"0.25\" effort=\"1.5\" velocity=\"-1\"/></joint>"
    "<joint name=\"none\" type=\"revolute\"><limit effort=\"0\" velocity=\"1\"/></joint>"
    "<joint name=\"reversed\" type=\"revolute\"><limit lower=\"2\" upper=\"1\"/></joint>"
    "<joint name=\"turns\" type=\"continuous\">"
    "<limit lower=\"-1\" upper=\"1\" effort=\"7\"/></joint>"
    "<!-- <joint name=\"absent\" type=\"revolute\"><limit lower=\"-1\" upper=\"1\"/></joint> -->"
    "</robot>";

TEST(test_ranges)
{
    static const char *const names[] = {"reversed", "one", "absent", "both", "none", "turns"};
    static const tfa_joint_limits wanted[] = {{0, 0, 0, INFINITY, INFINITY},
                                              {1, 0, 0.25, INFINITY, 1.5},
                                              {0, 0, 0, INFINITY, INFINITY},
                                              {1, -0.5, 2, INFINITY, INFINITY},
                                              {0, 0, 0, 1, 0},
                                              {0, 0, 0, INFINITY, 7}};
    tfa_joint_limits found[6];
    memset(found, 0xff, sizeof found);
    assert_int_equal(tfa_urdf_limits(text, sizeof text - 1, names, 6, found), TFA_OK);
    for (int k = 0; k < 6; k++) {
        assert_int_equal(found[k].limited, wanted[k].limited);
        assert_true(found[k].lower == wanted[k].lower && found[k].upper == wanted[k].upper);
        assert_true(found[k].velocity == wanted[k].velocity && found[k].effort == wanted[k].effort);
    }
}

TEST(test_refusals)
{
    static const char *const names[] = {"both"};
    tfa_joint_limits found[1];
    assert_int_equal(tfa_urdf_limits(NULL, 0, names, 1, found), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_limits(text, sizeof text - 1, NULL, 1, found), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_limits(text, sizeof text - 1, names, 1, NULL), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_limits(text, 40, names, 1, found), TFA_E_PARSE);
    assert_int_equal(tfa_urdf_limits(text, sizeof text - 1, NULL, 0, NULL), TFA_OK);
}
