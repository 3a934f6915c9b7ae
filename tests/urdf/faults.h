/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of URDF snippets and of what the loader must say about each.
 */
#ifndef TESTS_URDF_FAULTS_H
#define TESTS_URDF_FAULTS_H

#include <totalforce/report.h>

typedef struct urdf_fault {
    const char *name;
    const char *text;
    int status;
    int severity; /* -1: loads without a word; else the report holds this and nothing else */
    uint32_t line;
    const char *code;
    const char *message; /* texts, one a line */
} urdf_fault;

extern const urdf_fault urdf_number_faults[];
extern const urdf_fault urdf_inertial_faults[];
extern const urdf_fault urdf_joint_faults[];
extern const urdf_fault urdf_tree_faults[];
extern const urdf_fault urdf_xml_faults[];

/* Status and severity; all that is there of a row without a word */
#define REFUSED TFA_E_PARSE, TFA_ERROR
#define WARNED TFA_OK, TFA_WARNING
#define NOTED TFA_OK, TFA_NOTE
#define LOADS TFA_OK, -1, 0, "", ""

/* The first element stands on line 2. */
#define ROBOT(body) "<robot name=\"r\">\n" body "</robot>\n"
#define LINK(name) "<link name=\"" name "\"/>\n"
#define JOINT(name, type, parent, child, rest)                                                     \
    "<joint name=\"" name "\" type=\"" type "\"><parent link=\"" parent "\"/><child link=\"" child \
    "\"/>" rest "</joint>\n"
#define LIMIT "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"
#define INERTIA "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/>"
/* A link with an inertial: <origin> on line 3, <mass> on line 4, <inertia> on line 5. */
#define LINK_WITH_INERTIAL(origin, mass, inertia)                                                  \
    "<link name=\"arm\"><inertial>\n" origin "\n" mass "\n" inertia "\n</inertial></link>\n"
#define MASS(text) ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"" text "\"/>", INERTIA))
#define COM(text)                                                                                  \
    ROBOT(LINK_WITH_INERTIAL("<origin xyz=\"" text "\"/>", "<mass value=\"1\"/>", INERTIA))
#define IXX(text)                                                                                  \
    ROBOT(LINK_WITH_INERTIAL("", "<mass value=\"1\"/>",                                            \
                             "<inertia ixx=\"" text                                                \
                             "\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"))
#define TWO(type, rest) ROBOT(LINK("a") LINK("b") JOINT("j", type, "a", "b", rest))

/* As TWO, but both links have mass. */
#define MASSIVE(name)                                                                              \
    "<link name=\"" name "\"><inertial><mass value=\"1\"/>" INERTIA "</inertial></link>\n"
#define JOINED(type, rest) ROBOT(MASSIVE("a") MASSIVE("b") JOINT("j", type, "a", "b", rest))

/* Codes and sentences that many rows share. */
#define BAD "bad-number"
#define NOT_A_NUMBER                                                                               \
    "is not a number; write digits, point and exponent without blanks or units, such as 1.5e-3"
#define STRIPPED                                                                                   \
    "has white space that other programs refuse and that is left out; remove it; attributes like " \
    "it: "

#endif
