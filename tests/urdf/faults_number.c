/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows about numbers and vectors.
 */
#include "faults.h"

const urdf_fault urdf_number_faults[] = {
    {"plain", MASS("1.5"), LOADS},
    {"exponent", MASS("+.15E+1"), LOADS},
    {"comma", MASS("1,5"), REFUSED, 4, BAD, "link 'arm': value=\"1,5\" of <mass> " NOT_A_NUMBER},
    {"trailing blank", MASS("1.5 "), WARNED, 4, "white-space",
     "link 'arm': value=\"1.5 \" of <mass> " STRIPPED "1"},
    {"leading blank", MASS(" 1.5"), WARNED, 4, "white-space",
     "link 'arm': value=\" 1.5\" of <mass> " STRIPPED "1"},
    {"only a blank", MASS(" "), REFUSED, 4, BAD,
     "link 'arm': value=\" \" of <mass>: \"\" " NOT_A_NUMBER},
    {"blanks in two attributes",
     ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"1\n\"/>",
                              "<inertia ixx=\" 1\" ixy=\"0\" ixz=\"0\" iyy=\"0.9\" iyz=\"0\" "
                              "izz=\"1\"/>")),
     WARNED, 4, "white-space", "link 'arm': value=\"1\\n\" of <mass> " STRIPPED "2"},
    {"nan", MASS("nan"), REFUSED, 4, BAD, "link 'arm': value=\"nan\" of <mass> " NOT_A_NUMBER},
    {"inf", MASS("inf"), REFUSED, 4, BAD, "link 'arm': value=\"inf\" of <mass> " NOT_A_NUMBER},
    {"hexadecimal", MASS("0x1p3"), REFUSED, 4, BAD,
     "link 'arm': value=\"0x1p3\" of <mass> " NOT_A_NUMBER},
    {"unit", MASS("1.5kg"), REFUSED, 4, BAD, "link 'arm': value=\"1.5kg\" of <mass> " NOT_A_NUMBER},
    {"empty number", MASS(""), REFUSED, 4, BAD, "link 'arm': value=\"\" of <mass> " NOT_A_NUMBER},
    {"no exponent digits", MASS("1e"), REFUSED, 4, BAD,
     "link 'arm': value=\"1e\" of <mass> " NOT_A_NUMBER},
    {"only a point", MASS("."), REFUSED, 4, BAD, "link 'arm': value=\".\" of <mass> " NOT_A_NUMBER},
    {"two signs", MASS("--1"), REFUSED, 4, BAD,
     "link 'arm': value=\"--1\" of <mass> " NOT_A_NUMBER},
    {"xacro expression", MASS("${m}"), REFUSED, 4, "xacro",
     "link 'arm': value=\"${m}\" of <mass> is an unexpanded xacro expression; run xacro first: "
     "xacro f.urdf > f.urdf.urdf"},
    {"newline in a number", MASS("1.\n5"), REFUSED, 4, BAD,
     "link 'arm': value=\"1.\\n5\" of <mass> " NOT_A_NUMBER},
    {"underflow", MASS("1e-400"), REFUSED, 4, "underflow",
     "link 'arm': value=\"1e-400\" of <mass> is smaller than any number of double precision; write "
     "0 if that is meant"},
    {"overflow", MASS("1e400"), REFUSED, 4, "overflow",
     "link 'arm': value=\"1e400\" of <mass> is larger than any number of double precision; correct "
     "it"},
    {"zero written long", COM("0e-999 0.000 -0"), LOADS},
    {"vector of 2", COM("1 2"), REFUSED, 3, "bad-vector",
     "link 'arm': xyz=\"1 2\" of <origin> has 2 numbers; write three with blanks between them"},
    {"vector of 4", COM("1 2 3 4"), REFUSED, 3, "bad-vector",
     "link 'arm': xyz=\"1 2 3 4\" of <origin> has 4 numbers; write three with blanks between them"},
    {"vector of 6", COM("1 2 3 4 5 6"), REFUSED, 3, "bad-vector",
     "link 'arm': xyz=\"1 2 3 4 5 6\" of <origin> has more than 4 numbers; write three with blanks "
     "between them"},
    {"empty vector", COM(""), REFUSED, 3, "bad-vector",
     "link 'arm': xyz=\"\" of <origin> has 0 numbers; write three with blanks between them"},
    {"tab in a vector", COM("1\t2 3"), WARNED, 3, "white-space",
     "link 'arm': xyz=\"1\\t2 3\" of <origin> " STRIPPED "1"},
    {"newline in a vector", COM("1 2\n3"), WARNED, 3, "white-space",
     "link 'arm': xyz=\"1 2\\n3\" of <origin> " STRIPPED "1"},
    {"newline in a number of a vector", COM("1 2.\n5 3"), REFUSED, 3, "bad-vector",
     "link 'arm': xyz=\"1 2.\\n5 3\" of <origin> has 4 numbers; write three with blanks between "
     "them"},
    {"blanks around a vector", COM("  1  2 3 "), LOADS},
    {"comma in a vector", COM("0 0,5 0"), REFUSED, 3, BAD,
     "link 'arm': xyz=\"0 0,5 0\" of <origin>: \"0,5\" " NOT_A_NUMBER},
    {"tab in an inertia", IXX("0.9\t"), WARNED, 5, "white-space",
     "link 'arm': ixx=\"0.9\\t\" of <inertia> " STRIPPED "1"},
    {"attribute on a line of its own",
     ROBOT(LINK_WITH_INERTIAL(
         "", "<mass value=\"1\"/>",
         "<inertia ixx=\"1\"\n ixy=\"x\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>")),
     REFUSED, 6, BAD, "link 'arm': ixy=\"x\" of <inertia> " NOT_A_NUMBER},
    {"CRLF and CR count as one line end",
     "<robot name=\"r\">\r\n\r\n<link name=\"a\">\r<inertial>\n<mass value=\"x\"/>" INERTIA
     "</inertial></link></robot>",
     REFUSED, 5, BAD, "link 'a': value=\"x\" of <mass> " NOT_A_NUMBER},
    {"rpy with units",
     ROBOT(LINK_WITH_INERTIAL("<origin rpy=\"0 0 90deg\"/>", "<mass value=\"1\"/>", INERTIA)),
     REFUSED, 3, BAD, "link 'arm': rpy=\"0 0 90deg\" of <origin>: \"90deg\" " NOT_A_NUMBER},
    {"underflow in a vector", COM("0 -1e-400 0"), REFUSED, 3, "underflow",
     "link 'arm': xyz=\"0 -1e-400 0\" of <origin>: \"-1e-400\" is smaller than any number of "
     "double precision; write 0 if that is meant"},
    {"smallest number", COM("0 5e-324 0"), LOADS},
    {"xacro in a vector", COM("0 ${x} 0"), REFUSED, 3, "xacro",
     "link 'arm': xyz=\"0 ${x} 0\" of <origin> is an unexpanded xacro expression; run xacro first: "
     "xacro f.urdf > f.urdf.urdf"},
    {"xacro argument", MASS("$(arg m)"), REFUSED, 4, "xacro",
     "link 'arm': value=\"$(arg m)\" of <mass> is an unexpanded xacro expression; run xacro first: "
     "xacro f.urdf > f.urdf.urdf"},
    {"newline as a character number", MASS("1&#10;5"), REFUSED, 4, BAD,
     "link 'arm': value=\"1\\n5\" of <mass> " NOT_A_NUMBER},
    {"digits as character numbers", MASS("&#49;.&#x35;"), LOADS},
    {"a very long value", MASS("1.1111111111222222222233333333334444444444555555555566666666667"),
     LOADS},
    {"CRLF",
     "<robot name=\"r\">\r\n<link name=\"arm\">\r\n<inertial>\r\n<mass\r\n value=\"1 \"/>" INERTIA
     "</inertial></link>\r\n</robot>\r\n",
     WARNED, 5, "white-space", "link 'arm': value=\"1 \" of <mass> " STRIPPED "1"},
    {0},
};
