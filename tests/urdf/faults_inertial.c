/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows about inertials: which are refused, which a warning is about, which are only frames.
 */
#include "faults.h"

/* A link on line 2 with these diagonal moments */
#define BODY(mass, x, y, z)                                                                        \
    ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"" mass "\"/>",                                     \
                             "<inertia ixx=\"" x "\" ixy=\"0\" ixz=\"0\" iyy=\"" y                 \
                             "\" iyz=\"0\" izz=\"" z "\"/>"))
#define NINE(name, yx)                                                                             \
    "<link name=\"" name "\"><inertial><mass value=\"1\"/>\n<inertia ixx=\"0.1\" ixy=\"0.01\" "    \
    "ixz=\"-0.02\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\" iyx=\"" yx "\" izx=\"-0.02\" "                \
    "izy=\"0\"/></inertial></link>\n"
#define AGAIN "iyx, izx and izy of <inertia> say again what ixy, ixz and iyz say; links like it: "
#define VERSION_1_1(origin)                                                                        \
    "<robot name=\"r\" version=\"1.1\">\n" LINK_WITH_INERTIAL(origin, "<mass value=\"1\"/>",       \
                                                              INERTIA) "</robot>"

#define UNIT(name)                                                                                 \
    "<link name=\"" name "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" " \
    "iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\n"

const urdf_fault urdf_inertial_faults[] = {
    {"negative mass", MASS("-1"), REFUSED, 4, "negative-mass",
     "link 'arm': mass -1 kg is negative; correct it"},
    {"small mass",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1e-5\"/>",
         "<inertia ixx=\"1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"1e-9\" iyz=\"0\" izz=\"1e-9\"/>")),
     WARNED, 2, "small-mass",
     "link 'arm': mass 1e-05 kg is below 1e-4 kg, condition number of its inertia 1; give it the "
     "mass of the real part, or 0 if it is only a frame"},
    {"small gyration",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"1e-8\" ixy=\"0\" ixz=\"0\" iyy=\"1e-8\" iyz=\"0\" izz=\"1e-8\"/>")),
     WARNED, 2, "odd-gyration",
     "link 'arm': gyration radii 0.0001 to 0.0001 m, condition number 1; real parts have 1 mm to 2 "
     "m: check the units of <mass> and <inertia>"},
    {"large gyration", MASS("0.02"), WARNED, 2, "odd-gyration",
     "link 'arm': gyration radii 2.23607 to 2.23607 m, condition number 1; real parts have 1 mm to "
     "2 m: check the units of <mass> and <inertia>"},
    {"triangle", IXX("3"), WARNED, 2, "triangle",
     "link 'arm': its largest principal moment of inertia is 50 % larger than the other two "
     "together, which no body has; correct <inertia>"},
    {"triangle, rotated",
     ROBOT(LINK_WITH_INERTIAL(
         "<origin rpy=\"0.3 0.2 0.1\"/>", "<mass value=\"1\"/>",
         "<inertia ixx=\"2\" ixy=\"0.4\" ixz=\"0\" iyy=\"2\" iyz=\"0\" izz=\"1\"/>")),
     LOADS},
    {"triangle, off the axes",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"2\" ixy=\"1.5\" ixz=\"0\" iyy=\"2\" iyz=\"0\" izz=\"1\"/>")),
     WARNED, 2, "triangle",
     "link 'arm': its largest principal moment of inertia is 133 % larger than the other two "
     "together, which no body has; correct <inertia>"},
    {"negative inertia", IXX("-0.01"), LOADS}, /* refused by the model compiler */
    {"point mass",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")),
     LOADS},
    {"quaternion origin",
     ROBOT(LINK_WITH_INERTIAL("<origin quat_xyzw=\"0 0 0 1\"/>", "<mass value=\"1\"/>", INERTIA)),
     REFUSED, 3, "quaternion-origin",
     "link 'arm': <origin> has quat_xyzw, which URDF 1.0 does not know; write rpy instead, or "
     "version=\"1.1\" in <robot>"},
    {"quaternion of version 1.1", VERSION_1_1("<origin quat_xyzw=\"0 0.6 0 0.8\"/>"), LOADS},
    {"quaternion, not quite of length 1", VERSION_1_1("<origin quat_xyzw=\"0 0.6 0 0.8007\"/>"),
     LOADS},
    {"quaternion of length 2", VERSION_1_1("<origin quat_xyzw=\"0 0 0 2\"/>"), REFUSED, 3,
     "bad-quaternion",
     "link 'arm': quat_xyzw=\"0 0 0 2\" of <origin> is no rotation: its norm is not 1; correct it"},
    {"quaternion of zeros", VERSION_1_1("<origin quat_xyzw=\"0 0 0 0\"/>"), REFUSED, 3,
     "bad-quaternion",
     "link 'arm': quat_xyzw=\"0 0 0 0\" of <origin> is no rotation: its norm is not 1; correct it"},
    {"quaternion of three", VERSION_1_1("<origin quat_xyzw=\"0 0 1\"/>"), REFUSED, 3, "bad-vector",
     "link 'arm': quat_xyzw=\"0 0 1\" of <origin> has 3 numbers; write four with blanks between "
     "them"},
    {"quaternion beside angles", VERSION_1_1("<origin rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\"/>"),
     REFUSED, 3, "quaternion-origin",
     "link 'arm': <origin> has rpy and quat_xyzw; remove one of them"},
    {"nine entries", ROBOT(NINE("a", "0.01")), NOTED, 3, "nine-entries", "link 'a': " AGAIN "1"},
    {"nine entries, rounded",
     ROBOT(LINK("r") NINE("a", "0.0100002") NINE("b", "0.01") JOINT("i", "continuous", "r", "a", "")
               JOINT("j", "continuous", "r", "b", "")),
     NOTED, 4, "nine-entries", "link 'a': " AGAIN "2"},
    {"nine entries, another sign", ROBOT(NINE("a", "-0.01")), REFUSED, 3, "asymmetric-inertia",
     "link 'a': iyx=-0.01 of <inertia>, but ixy=0.01; a tensor of inertia is symmetric: correct "
     "one "
     "of them"},
    {"nine entries, one wrong", ROBOT(NINE("a", "0.011")), REFUSED, 3, "asymmetric-inertia",
     "link 'a': iyx=0.011 of <inertia>, but ixy=0.01; a tensor of inertia is symmetric: correct "
     "one "
     "of them"},
    {"mass in grams", BODY("1200", "0.02", "0.018", "0.006"), WARNED, 2, "odd-density",
     "link 'arm': 1200 kg with gyration radii of 0.0022 to 0.0041 m have 1.7e+09 kg/m^3 or more, "
     "and osmium has 22600; is <mass> in grams? It is in kg, <inertia> in kg m^2"},
    {"a little denser than osmium", BODY("1", "1.8e-4", "1.8e-4", "1.8e-4"), WARNED, 2,
     "odd-density",
     "link 'arm': 1 kg with gyration radii of 0.013 to 0.013 m have 2.5e+04 kg/m^3 or more, and "
     "osmium has 22600; is <mass> in grams? It is in kg, <inertia> in kg m^2"},
    {"a ball of platinum", BODY("1", "2e-4", "2e-4", "2e-4"), LOADS},
    {"a tonne at a point",
     ROBOT(LINK_WITH_INERTIAL("<origin xyz=\"0 0 0.05\"/>", "<mass value=\"1500\"/>",
                              "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" "
                              "izz=\"0\"/>")),
     WARNED, 2, "odd-density",
     "link 'arm': 1500 kg without extent, 0.05 m from its origin; is <mass> in grams? It is in kg"},
    {"a foundation", BODY("1573", "89", "107", "172"), LOADS},
    {"centre of mass in millimetres", COM("0 20 100"), WARNED, 2, "odd-centre",
     "link 'arm': its centre of mass is 101.98 m from its origin; is it in millimetres? xyz is in "
     "metres"},
    {"centre of mass a little too far", COM("0 0 -20.5"), WARNED, 2, "odd-centre",
     "link 'arm': its centre of mass is 20.5 m from its origin; is it in millimetres? xyz is in "
     "metres"},
    {"inertial inside a visual",
     ROBOT("<link name=\"a\"><visual>\n<inertial><mass value=\"1\"/>" INERTIA
           "</inertial></visual></link>"),
     WARNED, 3, "misplaced-element",
     "link 'a': <inertial> inside <visual> is not read: move it into <link>"},
    {"inertial inside the robot",
     ROBOT(LINK("a") "<inertial><mass value=\"1\"/>" INERTIA "</inertial>"), WARNED, 3,
     "misplaced-element", "robot: <inertial> inside <robot> is not read: move it into <link>"},
    {"mass without an inertial", ROBOT("<link name=\"a\"><mass value=\"1\"/></link>"), WARNED, 2,
     "misplaced-element", "link 'a': <mass> inside <link> is not read: move it into <inertial>"},
    {"misspelled rpy",
     ROBOT(LINK_WITH_INERTIAL("<origin ryp=\"0 0 1\"/>", "<mass value=\"1\"/>", INERTIA)), WARNED,
     3, "unknown-attribute", "link 'arm': ryp of <origin> is ignored; is it misspelled?"},
    {"inertia attribute missing",
     ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"1\"/>",
                              "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\"/>")),
     REFUSED, 5, "missing-attribute", "link 'arm': <inertia> has no izz; add izz=\"...\""},
    {"no mass", ROBOT(LINK_WITH_INERTIAL("", "", INERTIA)), REFUSED, 2, "missing-element",
     "link 'arm': <inertial> has no <mass>; add it"},
    {"no inertia", ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"1\"/>", "")), REFUSED, 2,
     "missing-element", "link 'arm': <inertial> has no <inertia>; add it"},
    {"two inertials",
     ROBOT("<link name=\"arm\"><inertial><mass value=\"1\"/>" INERTIA
           "</inertial>\n<inertial><mass value=\"2\"/>" INERTIA "</inertial></link>\n"),
     REFUSED, 3, "duplicate-inertial",
     "link 'arm': a second <inertial>, the first is on line 2; remove one"},
    {"two masses", ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"1\"/><mass value=\"2\"/>", INERTIA)),
     REFUSED, 4, "duplicate-element",
     "link 'arm': a second <mass>, the first is on line 4; remove one"},
    {"misspelled inertial", ROBOT("<link name=\"arm\">\n<inertail/></link>\n"), REFUSED, 3,
     "misspelled-element", "link 'arm': <inertail> in <link>: did you mean <inertial>?"},
    {"meshes are never looked at",
     ROBOT("<link name=\"a\"><visual><origin xyz=\"x\"/><geometry><mesh "
           "filename=\"package://none\"/></geometry></visual><collision><geometry><mesh "
           "filename=\"/dev/zero\"/></geometry></collision></link>"),
     LOADS},
    {"only one moment",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0.1\"/>")),
     WARNED, 2, "triangle",
     "link 'arm': only one of its principal moments of inertia is not zero, which no body has; "
     "correct <inertia>"},
    {"rod",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/>")),
     WARNED, 2, "odd-gyration",
     "link 'arm': gyration radii 0 to 0.1 m, condition number inf; real parts have 1 mm to 2 m: "
     "check the units of <mass> and <inertia>"},
    {"small point mass",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1e-5\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")),
     WARNED, 2, "small-mass",
     "link 'arm': mass 1e-05 kg is below 1e-4 kg, condition number of its inertia inf; give it the "
     "mass of the real part, or 0 if it is only a frame"},
    {"ill-conditioned small mass",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"9.9e-5\"/>",
         "<inertia ixx=\"1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"/>")),
     WARNED, 2, "small-mass",
     "link 'arm': mass 9.9e-05 kg is below 1e-4 kg, condition number of its inertia 1e+03; give it "
     "the mass of the real part, or 0 if it is only a frame"},
    {"mass just large enough",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1e-4\"/>",
         "<inertia ixx=\"1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"1e-9\" iyz=\"0\" izz=\"1e-9\"/>")),
     LOADS},
    {"gyration of 1 mm and of 2 m",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"1.000001e-6\" ixy=\"0\" ixz=\"0\" iyy=\"4\" iyz=\"0\" izz=\"4\"/>")),
     LOADS},
    {"gyration a little beyond 2 m",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"4.01\" iyz=\"0\" izz=\"4.01\"/>")),
     WARNED, 2, "odd-gyration",
     "link 'arm': gyration radii 1 to 2.0025 m, condition number 4.01; real parts have 1 mm to 2 "
     "m: check the units of <mass> and <inertia>"},
    {"placeholder inertia",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"4\"/>",
         "<inertia ixx=\"1.0\" ixy=\"0\" ixz=\"0.0\" iyy=\"1\" iyz=\"-0\" izz=\"1e0\"/>")),
     WARNED, 2, "placeholder-inertia",
     "link 'arm': <inertia> is the identity matrix, as exporters write when they know none; give "
     "it the inertia of the real part"},
    {"placeholder inertias",
     ROBOT(LINK("a") UNIT("b") UNIT("c") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "continuous", "b", "c", "")),
     WARNED, 3, "placeholder-inertia",
     "link 'b': <inertia> is the identity matrix, as exporters write when they know none; give it "
     "the inertia of the real part; links like it: 2 ('b', 'c')"},
    {"nearly negative inertia",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"-1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/>")),
     WARNED, 2, "odd-gyration",
     "link 'arm': gyration radii 0 to 0.316228 m, condition number inf; real parts have 1 mm to 2 "
     "m: check the units of <mass> and <inertia>"},
    {"mass 0, inertia 0",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"0\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")),
     LOADS},
    {"mass 0 in a longer spelling",
     ROBOT(LINK_WITH_INERTIAL(
         "<origin xyz=\"1 2 3\"/>", "<mass value=\"-0.000e5\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")),
     LOADS},
    {"inertia without mass",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"0\"/>",
         "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/>")),
     WARNED, 2, "inertia-without-mass",
     "link 'arm': mass 0, but an inertia that is not 0; give it the mass of the real part, or no "
     "<inertial> if it is only a frame"},
    {"no inertial, fixed joint",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "fixed", "a", "b", "")
               JOINT("j", "fixed", "b", "c", "")),
     NOTED, 3, "no-inertial",
     "link 'b': no mass, on a fixed joint: kept as a frame; links like it: 2 ('b', 'c')"},
    {"mass 0, fixed joint",
     ROBOT(LINK("a") LINK_WITH_INERTIAL(
         "", "<mass value=\"0\"/>",
         "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")
               JOINT("i", "fixed", "a", "arm", "")),
     NOTED, 3, "no-inertial", "link 'arm': no mass, on a fixed joint: kept as a frame"},
    {"no inertial, moving joint", TWO("continuous", ""), LOADS},
    {"flat plate, rounded",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"0.0333333\" ixy=\"0\" ixz=\"0\" iyy=\"0.0333333\" iyz=\"0\" "
         "izz=\"0.0666666\"/>")),
     LOADS},
    {"triangle, a little",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.21\"/>")),
     WARNED, 2, "triangle",
     "link 'arm': its largest principal moment of inertia is 5 % larger than the other two "
     "together, which no body has; correct <inertia>"},
    {"empty inertial", ROBOT("<link name=\"arm\"><inertial/></link>\n"), REFUSED, 2,
     "missing-element",
     "link 'arm': <inertial> has no <mass>; add it\nlink 'arm': <inertial> has no <inertia>; add "
     "it"},
    {"mass without value", ROBOT(LINK_WITH_INERTIAL("", "<mass/>", INERTIA)), REFUSED, 4,
     "missing-attribute", "link 'arm': <mass> has no value; add value=\"...\""},
    {"two inertias", ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"1\"/>", INERTIA INERTIA)), REFUSED,
     5, "duplicate-element", "link 'arm': a second <inertia>, the first is on line 5; remove one"},
    {"two origins",
     ROBOT(LINK_WITH_INERTIAL("<origin/>\n<origin/>", "<mass value=\"1\"/>", INERTIA)), REFUSED, 4,
     "duplicate-element", "link 'arm': a second <origin>, the first is on line 3; remove one"},
    {0},
};
