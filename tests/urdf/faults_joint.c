/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows about joints: axis, limit, dynamics, rotors, mimics.
 */
#include "faults.h"

#define FOLLOW(joint) "<mimic joint=\"" joint "\"/>"

const urdf_fault urdf_joint_faults[] = {
    {"joint origin", TWO("fixed", "<origin xyz=\"0 0 x\"/>"), REFUSED, 4, BAD,
     "joint 'j': xyz=\"0 0 x\" of <origin>: \"x\" " NOT_A_NUMBER},
    {"zero axis, moving", TWO("revolute", LIMIT "<axis xyz=\"0 0 0\"/>"), REFUSED, 4, "zero-axis",
     "joint 'j': axis 0 0 0 has no direction; give it a unit vector"},
    {"zero axis, planar", TWO("planar", "<axis xyz=\"0 -0 0\"/>"), REFUSED, 4, "zero-axis",
     "joint 'j': axis 0 0 0 has no direction; give it a unit vector"},
    {"zero axis, fixed", JOINED("fixed", "<axis xyz=\"0 0 0\"/>"), LOADS},
    {"axis of length 2", TWO("continuous", "<axis xyz=\"0 2 0\"/>"), WARNED, 4, "axis-length",
     "joint 'j': axis has the length 2 and is normalised; write a unit vector"},
    {"axis a little long", TWO("continuous", "<axis xyz=\"0 1.0009 0\"/>"), LOADS},
    {"axis without xyz", TWO("continuous", "<axis/>"), REFUSED, 4, "missing-attribute",
     "joint 'j': <axis> has no xyz; add xyz=\"...\""},
    {"revolute without limit", TWO("revolute", ""), WARNED, 4, "no-limit",
     "joint 'j': no <limit>; dynamics needs none, but other programs refuse the file: add it"},
    {"prismatic without limit", TWO("prismatic", ""), WARNED, 4, "no-limit",
     "joint 'j': no <limit>; dynamics needs none, but other programs refuse the file: add it"},
    {"limit without effort", TWO("revolute", "<limit/>"), LOADS},
    {"malformed limit", TWO("revolute", "<limit lower=\"-1,57\"/>"), WARNED, 4, "bad-limit",
     "joint 'j': lower=\"-1,57\" of <limit> " NOT_A_NUMBER},
    {"empty dynamics", TWO("continuous", "<dynamics/>"), WARNED, 4, "empty-dynamics",
     "joint 'j': <dynamics> has neither damping nor friction; remove it or add them"},
    {"malformed damping", TWO("continuous", "<dynamics damping=\"1,0\"/>"), REFUSED, 4, BAD,
     "joint 'j': damping=\"1,0\" of <dynamics> " NOT_A_NUMBER},
    {"negative damping", TWO("continuous", "<dynamics damping=\"-1\"/>"), WARNED, 4,
     "negative-damping", "joint 'j': damping -1 is negative and adds energy; correct it"},
    {"negative friction", TWO("continuous", "<dynamics friction=\"-2\"/>"), WARNED, 4,
     "negative-friction", "joint 'j': friction -2 is negative and adds energy; correct it"},
    {"friction", TWO("continuous", "<dynamics friction=\"1\"/>"), LOADS},
    {"reduction that is no number",
     ROBOT(LINK("a") "<transmission><joint name=\"x\"/><actuator><mechanicalReduction>1:50"
                     "</mechanicalReduction></actuator></transmission>"),
     WARNED, 3, "bad-reduction",
     "joint 'x': <mechanicalReduction> \"1:50\" is not a number other than 0 and does not count; "
     "correct it"},
    {"reduction of nobody",
     ROBOT(LINK("a") "<transmission><joint name=\"x\"/><actuator><mechanicalReduction>50"
                     "</mechanicalReduction></actuator></transmission>"),
     LOADS},
    {"negative rotor inertia", TWO("continuous", "<drake:rotor_inertia value=\"-1\"/>"), REFUSED, 4,
     "bad-armature",
     "joint 'j': rotor inertia -1 kg m^2 and gear ratio 1 give no finite armature; correct them"},
    {"rotor of nobody",
     ROBOT(LINK("a") "<transmission><joint name=\"x\"/><actuator><drake:rotor_inertia "
                     "value=\"1\"/></actuator></transmission>"),
     REFUSED, 3, "unknown-joint",
     "joint 'x': a <transmission> has a rotor for it, but it does not exist; correct the name"},
    {"mimic of a missing joint", TWO("continuous", FOLLOW("x")), WARNED, 4, "mimic-unknown",
     "joint 'j': mimics joint 'x', which does not exist, and moves on its own; correct the name"},
    {"mimic of a link", TWO("prismatic", LIMIT FOLLOW("a")), WARNED, 4, "mimic-unknown",
     "joint 'j': mimics joint 'a', which does not exist, and moves on its own; correct the name"},
    {"origin in degrees", TWO("continuous", "<origin rpy=\"90 0 -45\"/>"), WARNED, 4, "odd-angle",
     "joint 'j': rpy=\"90 0 -45\" of <origin>: 90 rad are 14.3 turns; is it in degrees? rpy is in "
     "rad: multiply by pi/180"},
    {"half a turn in degrees", JOINED("fixed", "<origin rpy=\"0 0 -180\"/>"), WARNED, 4,
     "odd-angle",
     "joint 'j': rpy=\"0 0 -180\" of <origin>: -180 rad are -28.6 turns; is it in degrees? rpy is "
     "in "
     "rad: multiply by pi/180"},
    {"a whole turn, rounded", TWO("continuous", "<origin rpy=\"0 -6.2832 6.28319\"/>"), LOADS},
    {"origin in millimetres", TWO("continuous", "<origin xyz=\"0 0 250\"/>"), WARNED, 4,
     "odd-origin",
     "joint 'j': its origin is 250 m from that of link 'a'; is it in millimetres? xyz is in "
     "metres"},
    {"oblique origin in millimetres", JOINED("fixed", "<origin xyz=\"-15 15 0\"/>"), WARNED, 4,
     "odd-origin",
     "joint 'j': its origin is 21.2132 m from that of link 'a'; is it in millimetres? xyz is in "
     "metres"},
    {"a crane", TWO("continuous", "<origin xyz=\"0 0 19.9\"/>"), LOADS},
    {"far from the origin of the world",
     ROBOT(LINK("world") MASSIVE("a")
               JOINT("j", "fixed", "world", "a", "<origin xyz=\"300 -40 0\"/>")),
     LOADS},
    {"mimic of itself", TWO("continuous", FOLLOW("j")), REFUSED, 4, "mimic-self",
     "joint 'j': mimics itself; name another joint or remove <mimic>"},
    {"mimic without a joint", TWO("continuous", "<mimic/>"), REFUSED, 4, "missing-attribute",
     "joint 'j': <mimic> has no joint; add joint=\"...\""},
    {"malformed multiplier",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "continuous", "b", "c", "<mimic joint=\"i\" multiplier=\"2x\"/>")),
     REFUSED, 6, BAD, "joint 'j': multiplier=\"2x\" of <mimic> " NOT_A_NUMBER},
    {"mimic in a circle",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "continuous", "a", "b", FOLLOW("j"))
               JOINT("j", "continuous", "b", "c", FOLLOW("i"))),
     REFUSED, 5, "mimic-loop",
     "joint 'i': mimics joint 'j', which in the end mimics it; let one of them move by itself"},
    {"mimic of a fixed joint",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "fixed", "a", "b", "")
               JOINT("j", "continuous", "b", "c", FOLLOW("i"))),
     REFUSED, 6, "mimic-type",
     "joint 'j': mimics joint 'i', which has no single coordinate; follow a revolute, continuous "
     "or prismatic joint"},
    {"mimic by a floating joint",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "floating", "b", "c", FOLLOW("i"))),
     REFUSED, 6, "mimic-type",
     "joint 'j': only a joint with one freedom can follow another; remove <mimic>"},
    {"mimic by a fixed joint", JOINED("fixed", FOLLOW("x")), WARNED, 4, "mimic-fixed",
     "joint 'j': a fixed joint has a <mimic>, which is ignored; remove it"},
    {"mimic in a chain",
     ROBOT(LINK("a") LINK("b") LINK("c") LINK("d") JOINT("i", "continuous", "a", "b", FOLLOW("j"))
               JOINT("j", "prismatic", "b", "c", LIMIT FOLLOW("k"))
                   JOINT("k", "continuous", "c", "d", "")),
     LOADS},
    {"mimic that leads into a circle",
     ROBOT(LINK("a") LINK("b") LINK("c") LINK("d") JOINT("i", "continuous", "a", "b", FOLLOW("j"))
               JOINT("j", "continuous", "b", "c", FOLLOW("k"))
                   JOINT("k", "continuous", "c", "d", FOLLOW("j"))),
     REFUSED, 7, "mimic-loop",
     "joint 'j': mimics joint 'k', which in the end mimics it; let one of them move by itself"},
    {"two mimics",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "continuous", "b", "c", FOLLOW("i") FOLLOW("i"))),
     REFUSED, 6, "duplicate-element",
     "joint 'j': a second <mimic>, the first is on line 6; remove one"},
    {"malformed offset",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "continuous", "b", "c", "<mimic joint=\"i\" offset=\"0,1\"/>")),
     REFUSED, 6, BAD, "joint 'j': offset=\"0,1\" of <mimic> " NOT_A_NUMBER},
    {"zero axis, prismatic", TWO("prismatic", LIMIT "<axis xyz=\"0 0 0\"/>"), REFUSED, 4,
     "zero-axis", "joint 'j': axis 0 0 0 has no direction; give it a unit vector"},
    {"zero axis, continuous", TWO("continuous", "<axis xyz=\"0 0 0\"/>"), REFUSED, 4, "zero-axis",
     "joint 'j': axis 0 0 0 has no direction; give it a unit vector"},
    {"zero axis, floating", TWO("floating", "<axis xyz=\"0 0 0\"/>"), LOADS},
    {"malformed axis, fixed", JOINED("fixed", "<axis xyz=\"none\"/>"), LOADS},
    {"malformed axis, moving", TWO("continuous", "<axis xyz=\"1 0\"/>"), REFUSED, 4, "bad-vector",
     "joint 'j': xyz=\"1 0\" of <axis> has 2 numbers; write three with blanks between them"},
    {"axis a little too long", TWO("continuous", "<axis xyz=\"0 1.0011 0\"/>"), WARNED, 4,
     "axis-length", "joint 'j': axis has the length 1.0011 and is normalised; write a unit vector"},
    {"axis too short", TWO("continuous", "<axis xyz=\"0 0 0.5\"/>"), WARNED, 4, "axis-length",
     "joint 'j': axis has the length 0.5 and is normalised; write a unit vector"},
    {"two axes", TWO("continuous", "<axis xyz=\"0 0 1\"/><axis xyz=\"0 1 0\"/>"), REFUSED, 4,
     "duplicate-element", "joint 'j': a second <axis>, the first is on line 4; remove one"},
    {"continuous without limit", TWO("continuous", ""), LOADS},
    {"planar and floating",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "planar", "a", "b", "<axis xyz=\"0 0 1\"/>")
               JOINT("j", "floating", "b", "c", "")),
     LOADS},
    {"equal limits",
     TWO("prismatic", "<limit lower=\"0.0\" upper=\"0\" effort=\"1\" velocity=\"1\"/>"), NOTED, 4,
     "equal-limits",
     "joint 'j': lower and upper limit are both 0, but dynamics lets it move; make it fixed if it "
     "cannot"},
    {"damping", TWO("continuous", "<dynamics damping=\"0.7\"/>"), LOADS},
    {"friction of two joints",
     ROBOT(LINK("a") LINK("b") LINK("c") LINK("d") JOINT("i", "continuous", "a", "b",
                                                         "<dynamics friction=\"1e-3\"/>")
               JOINT("j", "continuous", "b", "c", "<dynamics damping=\"1\" friction=\"0.0\"/>")
                   JOINT("k", "continuous", "c", "d", "<dynamics damping=\"1\" friction=\"5\"/>")),
     LOADS},
    {"malformed friction", TWO("continuous", "<dynamics friction=\"1.\t0\"/>"), REFUSED, 4, BAD,
     "joint 'j': friction=\"1.\\t0\" of <dynamics> " NOT_A_NUMBER},
    {"friction and a tab", TWO("continuous", "<dynamics friction=\"1.\t\"/>"), WARNED, 4,
     "white-space", "joint 'j': friction=\"1.\\t\" of <dynamics> " STRIPPED "1"},
    {"limit and a blank",
     TWO("revolute", "<limit lower=\" -1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"), WARNED, 4,
     "white-space", "joint 'j': lower=\" -1\" of <limit> " STRIPPED "1"},
    {"malformed rotor inertia", TWO("continuous", "<drake:rotor_inertia value=\"1e-4kgm2\"/>"),
     REFUSED, 4, BAD, "joint 'j': value=\"1e-4kgm2\" of <drake:rotor_inertia> " NOT_A_NUMBER},
    {"two rotors of nobody",
     ROBOT(LINK("a") "<transmission><actuator><drake:rotor_inertia "
                     "value=\"1\"/></actuator><actuator><drake:rotor_inertia "
                     "value=\"1\"/></actuator></transmission>"),
     REFUSED, 3, "missing-element", "robot: <transmission> has no <joint>; add it"},
    {0},
};
