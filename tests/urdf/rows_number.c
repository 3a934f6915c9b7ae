/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows about numbers, inertials and what a joint holds.
 */
#include "rows.h"

#define BAD "bad-number"

const urdf_row urdf_number_rows[] = {
    {"plain", MASS("1.5"), TFA_OK, -1, 0, "", ""},
    {"exponent", MASS("+.15E+1"), TFA_OK, -1, 0, "", ""},
    {"comma", MASS("1,5"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"1,5\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"trailing blank", MASS("1.5 "), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"1.5 \" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"leading blank", MASS(" 1.5"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\" 1.5\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"nan", MASS("nan"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"nan\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"inf", MASS("inf"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"inf\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"hexadecimal", MASS("0x1p3"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"0x1p3\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"unit", MASS("1.5kg"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"1.5kg\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"empty number", MASS(""), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link \'arm\': value=\"\" of <mass> is not a number; write digits, point and exponent without "
     "blanks or units, such as 1.5e-3"},
    {"no exponent digits", MASS("1e"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"1e\" of <mass> is not a number; write digits, point and exponent without "
     "blanks or units, such as 1.5e-3"},
    {"only a point", MASS("."), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\".\" of <mass> is not a number; write digits, point and exponent without "
     "blanks or units, such as 1.5e-3"},
    {"two signs", MASS("--1"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"--1\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"xacro expression", MASS("${m}"), TFA_E_PARSE, TFA_ERROR, 4, "xacro",
     "link 'arm': value=\"${m}\" of <mass> is an unexpanded xacro expression; run xacro first"},
    {"newline in a number", MASS("1.\n5"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "link 'arm': value=\"1.\\n5\" of <mass> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"underflow", MASS("1e-400"), TFA_E_PARSE, TFA_ERROR, 4, "underflow",
     "link 'arm': value=\"1e-400\" of <mass> is smaller than any number of double precision; write "
     "0 if that is meant"},
    {"overflow", MASS("1e400"), TFA_E_PARSE, TFA_ERROR, 4, "overflow",
     "link 'arm': value=\"1e400\" of <mass> is larger than any number of double precision; correct "
     "it"},
    {"zero written long", COM("0e-999 0.000 -0"), TFA_OK, -1, 0, "", ""},
    {"negative mass", MASS("-1"), TFA_E_PARSE, TFA_ERROR, 4, "negative-mass",
     "link 'arm': mass -1 kg is negative; correct it"},
    {"small mass",
     ROBOT(
         HEAVY("", "<mass value=\"1e-5\"/>",
               "<inertia ixx=\"1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"1e-9\" iyz=\"0\" izz=\"1e-9\"/>")),
     TFA_OK, TFA_WARNING, 2, "small-mass",
     "link 'arm': mass 1e-05 kg is below 1e-4 kg; give it the mass of the real part, or 0 if it is "
     "only a frame"},
    {"small gyration",
     ROBOT(
         HEAVY("", "<mass value=\"1\"/>",
               "<inertia ixx=\"1e-8\" ixy=\"0\" ixz=\"0\" iyy=\"1e-8\" iyz=\"0\" izz=\"1e-8\"/>")),
     TFA_OK, TFA_WARNING, 2, "odd-gyration",
     "link 'arm': gyration radii 0.0001 to 0.0001 m, condition number 1; real parts have 1 mm to 2 "
     "m: check the units of <mass> and <inertia>"},
    {"large gyration", MASS("0.2"), TFA_OK, TFA_WARNING, 2, "odd-gyration",
     "link 'arm': gyration radii 2.23607 to 2.23607 m, condition number 1; real parts have 1 mm to "
     "2 m: check the units of <mass> and <inertia>"},
    {"triangle", IXX("3"), TFA_OK, TFA_WARNING, 2, "triangle",
     "link 'arm': its largest principal moment of inertia is 50 % larger than the other two "
     "together, which no body has; correct <inertia>"},
    {"triangle, rotated",
     ROBOT(HEAVY("<origin rpy=\"0.3 0.2 0.1\"/>", "<mass value=\"1\"/>",
                 "<inertia ixx=\"2\" ixy=\"0.4\" ixz=\"0\" iyy=\"2\" iyz=\"0\" izz=\"1\"/>")),
     TFA_OK, -1, 0, "", ""},
    {"triangle, off the axes",
     ROBOT(HEAVY("", "<mass value=\"1\"/>",
                 "<inertia ixx=\"2\" ixy=\"1.5\" ixz=\"0\" iyy=\"2\" iyz=\"0\" izz=\"1\"/>")),
     TFA_OK, TFA_WARNING, 2, "triangle",
     "link 'arm': its largest principal moment of inertia is 133 % larger than the other two "
     "together, which no body has; correct <inertia>"},
    {"negative inertia", IXX("-0.01"), TFA_OK, -1, 0, "", ""}, /* refused by the model compiler */
    {"only one moment",
     ROBOT(HEAVY("", "<mass value=\"1\"/>",
                 "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0.1\"/>")),
     TFA_OK, TFA_WARNING, 2, "odd-gyration", NULL},
    {"point mass",
     ROBOT(HEAVY("", "<mass value=\"1\"/>",
                 "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")),
     TFA_OK, -1, 0, "", ""},

    {"vector of 2", COM("1 2"), TFA_E_PARSE, TFA_ERROR, 3, "bad-vector",
     "link 'arm': xyz=\"1 2\" of <origin> has 2 numbers; write three with blanks between them"},
    {"vector of 4", COM("1 2 3 4"), TFA_E_PARSE, TFA_ERROR, 3, "bad-vector",
     "link 'arm': xyz=\"1 2 3 4\" of <origin> has 4 numbers; write three with blanks between them"},
    {"vector of 6", COM("1 2 3 4 5 6"), TFA_E_PARSE, TFA_ERROR, 3, "bad-vector",
     "link 'arm': xyz=\"1 2 3 4 5 6\" of <origin> has more than 4 numbers; write three with blanks "
     "between them"},
    {"empty vector", COM(""), TFA_E_PARSE, TFA_ERROR, 3, "bad-vector",
     "link 'arm': xyz=\"\" of <origin> has 0 numbers; write three with blanks between them"},
    {"tab in a vector", COM("1\t2 3"), TFA_E_PARSE, TFA_ERROR, 3, BAD,
     "link 'arm': xyz=\"1\\t2 3\" of <origin>: \"1\\t2\" is not a number; write digits, point and "
     "exponent without blanks or units, such as 1.5e-3"},
    {"newline in a vector", COM("1 2\n3"), TFA_E_PARSE, TFA_ERROR, 3, BAD,
     "link 'arm': xyz=\"1 2\\n3\" of <origin>: \"2\\n3\" is not a number; write digits, point and "
     "exponent without blanks or units, such as 1.5e-3"},
    {"blanks around a vector", COM("  1  2 3 "), TFA_OK, -1, 0, "", ""},
    {"comma in a vector", COM("0 0,5 0"), TFA_E_PARSE, TFA_ERROR, 3, BAD,
     "link 'arm': xyz=\"0 0,5 0\" of <origin>: \"0,5\" is not a number; write digits, point and "
     "exponent without blanks or units, such as 1.5e-3"},
    {"quaternion origin",
     ROBOT(HEAVY("<origin quat_xyzw=\"0 0 0 1\"/>", "<mass value=\"1\"/>", INERTIA)), TFA_E_PARSE,
     TFA_ERROR, 3, "quaternion-origin",
     "link 'arm': <origin> has quat_xyzw, which URDF 1.0 does not know; write rpy instead"},
    {"misspelled rpy", ROBOT(HEAVY("<origin ryp=\"0 0 1\"/>", "<mass value=\"1\"/>", INERTIA)),
     TFA_OK, TFA_WARNING, 3, "unknown-attribute",
     "link 'arm': ryp of <origin> is ignored; is it misspelled?"},
    {"tab in an inertia", IXX("1\t"), TFA_E_PARSE, TFA_ERROR, 5, BAD,
     "link 'arm': ixx=\"1\\t\" of <inertia> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"inertia attribute missing",
     ROBOT(HEAVY("", "<mass value=\"1\"/>",
                 "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\"/>")),
     TFA_E_PARSE, TFA_ERROR, 5, "missing-attribute",
     "link 'arm': <inertia> has no izz; add izz=\"...\""},
    {"attribute on a line of its own",
     ROBOT(HEAVY("", "<mass value=\"1\"/>",
                 "<inertia ixx=\"1\"\n ixy=\"x\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>")),
     TFA_E_PARSE, TFA_ERROR, 6, BAD,
     "link 'arm': ixy=\"x\" of <inertia> is not a number; write digits, point and exponent without "
     "blanks or units, such as 1.5e-3"},
    {"CRLF and CR count as one line end",
     "<robot name=\"r\">\r\n\r\n<link name=\"a\">\r<inertial>\n<mass value=\"x\"/>" INERTIA
     "</inertial></link></robot>",
     TFA_E_PARSE, TFA_ERROR, 5, BAD,
     "link 'a': value=\"x\" of <mass> is not a number; write digits, point and exponent without "
     "blanks or units, such as 1.5e-3"},
    {"no mass", ROBOT(HEAVY("", "", INERTIA)), TFA_E_PARSE, TFA_ERROR, 2, "missing-element",
     "link 'arm': <inertial> has no <mass>; add it"},
    {"no inertia", ROBOT(HEAVY("", "<mass value=\"1\"/>", "")), TFA_E_PARSE, TFA_ERROR, 2,
     "missing-element", "link 'arm': <inertial> has no <inertia>; add it"},
    {"two inertials",
     ROBOT("<link name=\"arm\"><inertial><mass value=\"1\"/>" INERTIA
           "</inertial>\n<inertial><mass value=\"2\"/>" INERTIA "</inertial></link>\n"),
     TFA_E_PARSE, TFA_ERROR, 3, "duplicate-inertial",
     "link 'arm': a second <inertial>, the first is on line 2; remove one"},
    {"two masses", ROBOT(HEAVY("", "<mass value=\"1\"/><mass value=\"2\"/>", INERTIA)), TFA_E_PARSE,
     TFA_ERROR, 4, "duplicate-element",
     "link 'arm': a second <mass>, the first is on line 4; remove one"},
    {"misspelled inertial", ROBOT("<link name=\"arm\">\n<inertail/></link>\n"), TFA_OK, TFA_WARNING,
     3, "unknown-element", "link 'arm': <inertail> in <link> is ignored; is it misspelled?"},

    {"joint origin", TWO("fixed", "<origin xyz=\"0 0 x\"/>"), TFA_E_PARSE, TFA_ERROR, 4, BAD,
     "joint 'j': xyz=\"0 0 x\" of <origin>: \"x\" is not a number; write digits, point and "
     "exponent without blanks or units, such as 1.5e-3"},
    {"zero axis, moving", TWO("revolute", LIMIT "<axis xyz=\"0 0 0\"/>"), TFA_E_PARSE, TFA_ERROR, 4,
     "zero-axis", "joint 'j': axis 0 0 0 has no direction; give it a unit vector"},
    {"zero axis, planar", TWO("planar", "<axis xyz=\"0 -0 0\"/>"), TFA_E_PARSE, TFA_ERROR, 4,
     "zero-axis", "joint 'j': axis 0 0 0 has no direction; give it a unit vector"},
    {"zero axis, fixed", TWO("fixed", "<axis xyz=\"0 0 0\"/>"), TFA_OK, -1, 0, "", ""},
    {"axis of length 2", TWO("continuous", "<axis xyz=\"0 2 0\"/>"), TFA_OK, TFA_WARNING, 4,
     "axis-length", "joint 'j': axis has the length 2 and is normalised; write a unit vector"},
    {"axis a little long", TWO("continuous", "<axis xyz=\"0 1.0009 0\"/>"), TFA_OK, -1, 0, "", ""},
    {"axis without xyz", TWO("continuous", "<axis/>"), TFA_E_PARSE, TFA_ERROR, 4,
     "missing-attribute", "joint 'j': <axis> has no xyz; add xyz=\"...\""},
    {"revolute without limit", TWO("revolute", ""), TFA_OK, TFA_WARNING, 4, "no-limit",
     "joint 'j': no <limit>; dynamics needs none, but other programs refuse the file: add it"},
    {"prismatic without limit", TWO("prismatic", ""), TFA_OK, TFA_WARNING, 4, "no-limit",
     "joint 'j': no <limit>; dynamics needs none, but other programs refuse the file: add it"},
    {"limit without effort", TWO("revolute", "<limit/>"), TFA_OK, -1, 0, "", ""},
    {"malformed limit", TWO("revolute", "<limit lower=\"-1,57\"/>"), TFA_OK, TFA_WARNING, 4,
     "bad-limit",
     "joint 'j': lower=\"-1,57\" of <limit> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"empty dynamics", TWO("continuous", "<dynamics/>"), TFA_OK, TFA_WARNING, 4, "empty-dynamics",
     "joint 'j': <dynamics> has neither damping nor friction; remove it or add them"},
    {"malformed damping", TWO("continuous", "<dynamics damping=\"1,0\"/>"), TFA_E_PARSE, TFA_ERROR,
     4, BAD,
     "joint 'j': damping=\"1,0\" of <dynamics> is not a number; write digits, point and exponent "
     "without blanks or units, such as 1.5e-3"},
    {"negative damping", TWO("continuous", "<dynamics damping=\"-1\"/>"), TFA_OK, TFA_WARNING, 4,
     "negative-damping", "joint 'j': damping -1 is negative and adds energy; correct it"},
    {"friction", TWO("continuous", "<dynamics friction=\"1\"/>"), TFA_OK, TFA_NOTE, 0, "friction",
     "robot: friction of <dynamics> is ignored; joints that have it: 1"},
    {"negative rotor inertia", TWO("continuous", "<drake:rotor_inertia value=\"-1\"/>"),
     TFA_E_PARSE, TFA_ERROR, 4, "bad-armature",
     "joint 'j': rotor inertia -1 kg m^2 and gear ratio 1 give no finite armature; correct them"},
    {"rotor of nobody",
     ROBOT(LINK("a") "<transmission><joint name=\"x\"/><actuator><drake:rotor_inertia "
                     "value=\"1\"/></actuator></transmission>"),
     TFA_E_PARSE, TFA_ERROR, 3, "unknown-joint",
     "joint 'x': a <transmission> has a rotor for it, but it does not exist; correct the name"},
    {"meshes are never looked at",
     ROBOT("<link name=\"a\"><visual><origin xyz=\"x\"/><geometry><mesh "
           "filename=\"package://none\"/></geometry></visual><collision/></link>"),
     TFA_OK, -1, 0, "", ""},
    {0},
};
