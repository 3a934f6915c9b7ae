/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The two tables of urdf.md and the tests of every row; see urdf_messages.h for the notation.
 */
#include "urdf_messages.h"

#include <stddef.h>

const urdf_case urdf_messages[] = {
    /* What urdfdom does silently. */
    {"malformed number in `<inertial>`: `1,5`, `1.5 ` (trailing blank), `nan`, `inf`, `0x1p3`, "
     "`1.5kg`, empty, `${m}`, newline inside a value",
     "comma; trailing blank; leading blank; nan; inf; hexadecimal; unit; empty number; "
     "xacro expression; xacro argument; newline in a number; newline as a character number; "
     "tests/urdf/corpus/comma.expect:bad-number; "
     "tests/urdf/test_attributes.c:test_every_attribute"},
    {"COM or inertia vector with 2 or 4 numbers, tabs or newlines between numbers",
     "vector of 2; vector of 4; vector of 6; empty vector; tab in a vector; newline in a vector; "
     "tab in an inertia; tests/urdf/test_attributes.c:test_every_vector"},
    {"`1e-400`", "underflow; underflow in a vector; zero written long; smallest number; "
                 "tests/urdf/test_report.c:test_number_grammar"},
    {"mass -1, ixx -0.01, triangle inequality broken",
     "negative mass; negative inertia; triangle; triangle, off the axes; "
     "tests/model/mistakes.c:inertia-not-positive"},
    {"axis `0 0 0` on a moving joint / length 2",
     "zero axis, moving; zero axis, continuous; zero axis, prismatic; zero axis, planar; "
     "zero axis, fixed; zero axis, floating; axis of length 2; axis too short; "
     "axis a little long; axis a little too long; "
     "tests/urdf/test_values.c:test_axis_is_normalised"},
    {"joint with parent = child, two parents, detached cycle",
     "joint of itself; two parents; two joints between the same links; closed chain; "
     "detached cycle; long cycle beside the robot; nothing but a cycle"},
    {"mimic of a missing joint or of itself",
     "mimic of a missing joint; mimic of itself; mimic in a circle; "
     "mimic that leads into a circle; mimic of a fixed joint; mimic by a floating joint; "
     "mimic by a fixed joint; mimic without a joint; two mimics"},
    {"two `<inertial>` in a link", "two inertials; two masses; two inertias; two origins"},
    {"revolute/prismatic without `<limit>`, empty `<dynamics/>`",
     "revolute without limit; prismatic without limit; continuous without limit; "
     "limit without effort; malformed limit; empty dynamics"},
    {"`version=\"1.1\"`, undeclared link `world`",
     "version 1.1; version 1.0; version 2.0; world; world declared; unknown child; "
     "tests/urdf/test_values.c:test_world"},
    {"duplicate names, unknown joint type",
     "two links of one name; two joints of one name; unknown type; type in capitals; no type; "
     "link in another case"},
    {"joint order", "children before parents; tests/urdf/test_values.c:test_document_order; "
                    "tests/urdf/test_values.c:test_published_order; "
                    "tests/model/merging.c:test_order; tests/model/making.c:test_hash"},

    /* What to do with each case. */
    {"no `<inertial>`, on a fixed joint",
     "no inertial, fixed joint; mass 0, fixed joint; no inertial, moving joint"},
    {"massless moving body with massive descendants (universal joints, iCub, Romeo)",
     "inertia without mass; tests/urdf/test_robots.c:romeo.urdf; "
     "tests/urdf/corpus/no_inertial_between.expect:massless-link; "
     "tests/urdf/corpus/zero_inertial_between.expect:exit 0; "
     "tests/model/messages.c:test_no_inertial; tests/model/derived.c:test_fused; "
     "tests/model/derived.c:test_six_parts_at_most"},
    {"massless moving **leaf** (PR2 gripper tips)",
     "no inertial, moving joint; tests/urdf/test_robots.c:pr2.urdf; "
     "tests/urdf/corpus/many_fingers.expect:joints like it: 9; "
     "tests/model/mistakes.c:massless-leaf; tests/model/policies.c:test_massless_leaves"},
    {"rank-deficient inertia (point mass, rod)",
     "point mass; rod; mass 0, inertia 0; tests/dynamics/core/singular.c:tfa_names_the_body; "
     "tests/model/derived.c:test_body_info"},
    {"mass < 1e-4 kg, gyration < 1 mm or > 2 m",
     "small mass; small point mass; ill-conditioned small mass; mass just large enough; "
     "small gyration; large gyration; gyration of 1 mm and of 2 m; gyration a little beyond 2 m; "
     "placeholder inertia; placeholder inertias"},
    {"inertia not positive definite",
     "negative inertia; nearly negative inertia; "
     "tests/urdf/corpus/not_rounded.expect:inertia-not-positive; "
     "tests/urdf/corpus/rounded_moment.expect:inertia-rounded; "
     "tests/model/messages.c:test_rounded; tests/model/messages.c:test_rounding_scales; "
     "tests/model/mistakes.c:inertia-not-positive; "
     "tests/model/policies.c:test_inertia_rows; tests/model/policies.c:test_repaired"},
    {"triangle inequality violated",
     "triangle; triangle, a little; triangle, off the axes; triangle, rotated; only one moment; "
     "flat plate, rounded; tests/model/policies.c:test_inertia_rows"},
    {"root inertial, fixed base",
     "tests/urdf/corpus/root_with_mass.expect:did you mean "
     "--base=floating?; tests/urdf/test_values.c:test_numbers_are_exact; "
     "tests/model/merging.c:test_merged_is_unmerged; "
     "tests/model/policies.c:test_massless_root"},
    {"rotated inertial origin", "triangle, rotated; tests/urdf/test_values.c:test_rpy; "
                                "tests/model/merging.c:test_merged_is_unmerged"},
    {"mimic", "mimic in a chain; malformed multiplier; malformed offset; "
              "tests/urdf/test_values.c:test_mimic_and_defaults; "
              "tests/model/policies.c:test_mimic_free; tests/model/policies.c:test_mimic_project; "
              "tests/model/policies.c:test_mimic_lock"},
    {"continuous", "continuous without limit; tests/urdf/test_values.c:test_document_order; "
                   "tests/dynamics/core/relations.c:windings_do_not_matter"},
    {"planar / floating", "planar and floating; tests/urdf/test_values.c:test_document_order; "
                          "tests/engine/requests.c:joint quaternion"},
    {"joint damping", "damping; negative damping; malformed damping; friction; "
                      "negative friction; "
                      "friction of two joints; malformed friction; empty dynamics; "
                      "tests/urdf/corpus/damping.expect:--damping uses it; "
                      "tests/urdf/corpus/friction.expect:--friction uses it; "
                      "tests/model/messages.c:test_unused; "
                      "tests/urdf/test_values.c:test_damping_and_friction; "
                      "tests/model/policies.c:test_damping_and_friction"},
    {"rotor inertia", "negative rotor inertia; malformed rotor inertia; rotor of nobody; "
                      "two rotors of nobody; reduction that is no number; reduction of nobody; "
                      "tests/urdf/test_values.c:test_reductions; "
                      "tests/urdf/corpus/rotor_inertia.expect:--rotor-inertia uses it; "
                      "tests/urdf/test_values.c:test_rotors; "
                      "tests/model/making.c:test_rotors"},
    {"xacro left in", "tests/urdf/corpus/macro.expect:xacro macro.urdf.xacro > macro.urdf; "
                      "xacro element; xacro element, deep; xacro include; old xacro; "
                      "xacro in a name; xacro in a vector; xacro in a joint type; "
                      "xacro expression; xacro name space; xacro where nobody looks; "
                      "braces that are no xacro"},
    {"loops, two parents, islands",
     "joint of itself; detached cycle; long cycle beside the robot; two parents; closed chain; "
     "two roots; islands"},
    {NULL, NULL},
};
