/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows about names and the tree.
 */
#include "faults.h"

/* Two links and a joint between them; loop joints on line 5 */
#define LOOPED(loops) ROBOT(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b", "") loops "\n")

const urdf_fault urdf_tree_faults[] = {
    {"one link", ROBOT(LINK("a")), LOADS},
    {"joint of itself",
     ROBOT(LINK("a") LINK("b") JOINT("i", "fixed", "a", "b", "") JOINT("j", "fixed", "b", "b", "")),
     REFUSED, 5, "loop", "joint 'j': link 'b' is its parent and its child; correct one of them"},
    {"two parents",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "fixed", "a", "b", "")
               JOINT("j", "fixed", "a", "c", "") JOINT("k", "fixed", "b", "c", "")),
     REFUSED, 7, "two-parents",
     "link 'c': child of joint 'j' (line 6) and of joint 'k'; a robot is a tree: remove one"},
    {"detached cycle",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("i", "fixed", "b", "c", "")
               JOINT("j", "fixed", "c", "b", "")),
     REFUSED, 6, "loop",
     "link 'b': hangs from itself, through joint 'j' and joint 'i' (line 5); a robot is a tree: "
     "open the loop"},
    {"nothing but a cycle",
     ROBOT(LINK("a") LINK("b") JOINT("i", "fixed", "a", "b", "") JOINT("j", "fixed", "b", "a", "")),
     REFUSED, 5, "loop",
     "link 'a': hangs from itself, through joint 'j' and joint 'i' (line 4); a robot is a tree: "
     "open the loop"},
    {"two roots", ROBOT(LINK("a") LINK("b")), REFUSED, 3, "two-roots",
     "link 'b': neither it nor link 'a' (line 2) is the child of a joint; connect them or remove "
     "one"},
    {"world", ROBOT(LINK("a") JOINT("j", "floating", "world", "a", "")), NOTED, 3, "world-added",
     "link 'world': not declared but a joint's parent; it becomes the root"},
    {"world declared", ROBOT(LINK("a") LINK("world") JOINT("j", "floating", "world", "a", "")),
     LOADS},
    {"unknown parent", ROBOT(LINK("a") JOINT("j", "fixed", "x", "a", "")), REFUSED, 3,
     "unknown-link", "joint 'j': parent link 'x' does not exist; declare it or correct the name"},
    {"unknown child", ROBOT(LINK("a") JOINT("j", "fixed", "a", "world", "")), REFUSED, 3,
     "unknown-link",
     "joint 'j': child link 'world' does not exist; declare it or correct the name"},
    {"no parent", ROBOT(LINK("a") "<joint name=\"j\" type=\"fixed\"><child link=\"a\"/></joint>"),
     REFUSED, 3, "missing-element", "joint 'j': <joint> has no <parent>; add it"},
    {"two children",
     ROBOT(LINK("a") LINK("b") JOINT("j", "fixed", "a", "b", "<child link=\"a\"/>")), REFUSED, 4,
     "duplicate-element", "joint 'j': a second <child>, the first is on line 4; remove one"},
    {"child without link",
     ROBOT(LINK("a") "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child/></joint>"),
     REFUSED, 3, "missing-attribute", "joint 'j': <child> has no link; add link=\"...\""},
    {"two links of one name", ROBOT(LINK("a") LINK("b") LINK("b")), REFUSED, 4, "duplicate-link",
     "link 'b': declared before on line 3; rename one"},
    {"two joints of one name",
     ROBOT(LINK("a") LINK("b") LINK("c") JOINT("j", "fixed", "a", "b", "")
               JOINT("j", "fixed", "a", "c", "")),
     REFUSED, 6, "duplicate-joint", "joint 'j': declared before on line 5; rename one"},
    {"unknown type", TWO("hinge", ""), REFUSED, 4, "unknown-joint-type",
     "joint 'j': type \"hinge\" does not exist; use fixed, revolute, continuous, prismatic, planar "
     "or floating"},
    {"type in capitals", TWO("Revolute", ""), REFUSED, 4, "unknown-joint-type",
     "joint 'j': type \"Revolute\" does not exist; use fixed, revolute, continuous, prismatic, "
     "planar or floating"},
    {"no type",
     ROBOT(LINK("a") LINK("b") "<joint name=\"j\"><parent link=\"a\"/><child link=\"b\"/></joint>"),
     REFUSED, 4, "missing-attribute", "joint 'j': <joint> has no type; add type=\"...\""},
    {"link without name", ROBOT(LINK("a") "<link/>"), REFUSED, 3, "missing-attribute",
     "robot: <link> has no name; add name=\"...\""},
    {"link with an empty name", ROBOT(LINK("")), REFUSED, 2, "empty-name",
     "robot: name=\"\" of <link> is empty; give it a name"},
    {"robot without name", "<robot>\n" LINK("a") "</robot>", WARNED, 1, "no-name",
     "robot: <robot> has no name, other programs refuse the file; called \"robot\" here: add "
     "name=\"...\""},
    {"robot with an empty name", "<robot name=\"\">\n" LINK("a") "</robot>", WARNED, 1, "no-name",
     "robot: <robot> has no name, other programs refuse the file; called \"robot\" here: add "
     "name=\"...\""},
    {"name with a line end", ROBOT(LINK("a\n")), REFUSED, 2, "bad-name",
     "robot: name=\"a\\n\" of <link> holds a control character; remove it"},
    {"name with a control character", ROBOT(LINK("a&#7;")), REFUSED, 2, "bad-name",
     "robot: name=\"a\\x07\" of <link> holds a control character; remove it"},
    {"name with everything that is allowed",
     ROBOT(LINK("a &lt;&amp;&quot;'&gt; &#xE9; \xC3\xA9/[]")), LOADS},
    {"no links", ROBOT(""), REFUSED, 1, "no-links", "robot: the robot has no links; add one"},
    {"version 1.1", "<robot name=\"r\" version=\"1.1\">\n" LINK("a") "</robot>", LOADS},
    {"version 1.2", "<robot name=\"r\" version=\"1.2\">\n" LINK("a") "</robot>", LOADS},
    {"version in words", "<robot name=\"r\" version=\"one\">\n" LINK("a") "</robot>", NOTED, 1,
     "version", "robot: version=\"one\" is read as 1.0"},
    {"version 1.0", "<robot name=\"r\" version=\"1.0\">\n" LINK("a") "</robot>", LOADS},
    {"misspelled link", ROBOT(LINK("a") "<lnik name=\"b\"/>"), REFUSED, 3, "misspelled-element",
     "robot: <lnik> in <robot>: did you mean <link>?"},
    {"things of others", ROBOT(LINK("a") "<gazebo/><transmission/><material/><drake:x/>"), LOADS},
    {"islands",
     ROBOT(LINK("a") LINK("b") JOINT("i", "fixed", "a", "b", "") LINK("c") LINK("d") LINK("e")
               JOINT("j", "fixed", "c", "d", "") JOINT("k", "fixed", "c", "e", "")),
     REFUSED, 5, "two-roots",
     "link 'c' with joint 'j': neither it nor link 'a' with joint 'i' (line 2) is the child of a "
     "joint; connect them or remove one"},
    {"long cycle beside the robot",
     ROBOT(LINK("a") LINK("b") LINK("c") LINK("d") JOINT("i", "fixed", "b", "c", "")
               JOINT("j", "fixed", "c", "d", "") JOINT("k", "fixed", "d", "b", "")),
     REFUSED, 8, "loop",
     "link 'b': hangs from itself, through joint 'k' and joint 'j' (line 7); a robot is a tree: "
     "open the loop"},
    {"closed chain",
     ROBOT(LINK("a") LINK("b") LINK("c") LINK("d") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "continuous", "a", "c", "") JOINT("k", "continuous", "b", "d", "")
                   JOINT("l", "continuous", "c", "d", "")),
     REFUSED, 9, "two-parents",
     "link 'd': child of joint 'k' (line 8) and of joint 'l'; a robot is a tree: remove one"},
    {"children before parents",
     ROBOT(JOINT("j", "continuous", "b", "c", "") JOINT("i", "continuous", "a", "b", "") LINK("c")
               LINK("b") LINK("a")),
     LOADS},
    {"version 2.0", "<robot name=\"r\" version=\"2.0\">\n" LINK("a") "</robot>", NOTED, 1,
     "version", "robot: version=\"2.0\" is read as 1.2"},
    {"ball joint", TWO("ball", ""), REFUSED, 4, "unknown-joint-type",
     "joint 'j': type \"ball\" does not exist; write three revolute joints about axes at right "
     "angles with links without <inertial> between them, which become one joint here"},
    {"spherical joint", TWO("spherical", LIMIT), REFUSED, 4, "unknown-joint-type",
     "joint 'j': type \"spherical\" does not exist; write three revolute joints about axes at "
     "right "
     "angles with links without <inertial> between them, which become one joint here"},
    {"universal joint", TWO("universal", ""), REFUSED, 4, "unknown-joint-type",
     "joint 'j': type \"universal\" does not exist; write two revolute joints about axes at right "
     "angles with links without <inertial> between them, which become one joint here"},
    {"joint inside a group",
     ROBOT(LINK("a") LINK("b") JOINT("i", "floating", "a", "b",
                                     "") "<group>\n" JOINT("j", "fixed", "a", "b", "") "</group>"),
     WARNED, 6, "misplaced-element",
     "robot: <joint> \"j\" inside <group> is not read: move it into <robot>"},
    {"joint inside a link", ROBOT("<link name=\"a\">" JOINT("j", "fixed", "a", "b", "") "</link>"),
     WARNED, 2, "misplaced-element",
     "link 'a': <joint> \"j\" inside <link> is not read: move it into <robot>"},
    {"joint of a simulator",
     ROBOT(LINK("a") "<gazebo>" JOINT("screw", "screw", "a", "b",
                                      "<axis xyz=\"0 0 1\"/>") "</gazebo>"),
     WARNED, 3, "misplaced-element",
     "robot: <joint> \"screw\" inside <gazebo> is not read: the robot has no such joint; joints "
     "like it: 1"},
    {"joints that are only named",
     ROBOT(LINK("a") "<gazebo><plugin><joint>j</joint><mass>1</mass></plugin></gazebo>"
                     "<transmission><joint name=\"j\"/></transmission>"
                     "<ros2_control><joint name=\"j\"/></ros2_control>"),
     LOADS},
    {"axis and mimic in wrong places",
     ROBOT(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b",
                                     "<limit><axis xyz=\"0 0 1\"/></limit>"
                                     "<origin><mimic joint=\"i\"/></origin>")),
     WARNED, 4, "misplaced-element",
     "joint 'j': <axis> inside <limit> is not read: move it into <joint>\n"
     "joint 'j': <mimic> inside <origin> is not read: move it into <joint>"},
    {"loop joint",
     LOOPED("<loop_joint name=\"l\" type=\"revolute\"><link1 link=\"a\"/><link2 link=\"b\"/><axis "
            "xyz=\"0 0 1\"/></loop_joint>"),
     WARNED, 5, "loop-joint",
     "constraint 'l': <loop_joint> closes a loop; forward_dynamics and other ops answer the open "
     "tree, constrained_dynamics, impact and constrained_inverse_dynamics apply it; loop joints: "
     "1"},
    {"loop joint, link1 twice",
     LOOPED("<loop_joint name=\"l\" type=\"spherical\"><link1 link=\"a\"/><link1 "
            "link=\"b\"/></loop_joint>"),
     WARNED, 5, "loop-joint",
     "constraint 'l': <loop_joint> closes a loop; forward_dynamics and other ops answer the open "
     "tree, constrained_dynamics, impact and constrained_inverse_dynamics apply it; loop joints: "
     "1"},
    {"loop joint to the world",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><link1 link=\"world\"/><link2 "
            "link=\"b\"/></loop_joint>"),
     WARNED, 5, "loop-joint",
     "constraint 'l': <loop_joint> closes a loop; forward_dynamics and other ops answer the open "
     "tree, constrained_dynamics, impact and constrained_inverse_dynamics apply it; loop joints: "
     "1"},
    {"loop joint of parent and child",
     LOOPED("<loop_joint name=\"l\" type=\"continuous\"><parent link=\"a\"/><child "
            "link=\"b\"/><origin xyz=\"0 0 1\"/></loop_joint>"),
     WARNED, 5, "loop-joint",
     "constraint 'l': <loop_joint> closes a loop; forward_dynamics and other ops answer the open "
     "tree, constrained_dynamics, impact and constrained_inverse_dynamics apply it; loop joints: "
     "1"},
    {"loop joint without links",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\" link1=\"a\" link2=\"b\"/>"), WARNED, 5,
     "unsupported-element",
     "constraint 'l': <loop_joint> closes a loop and is not read, it has neither <link1> and "
     "<link2> nor <parent> and <child>: the robot is open there, with other freedoms and forces"},
    {"loop joint of another type",
     LOOPED(
         "<loop_joint name=\"l\" type=\"3D\"><link1 link=\"a\"/><link2 link=\"b\"/></loop_joint>"),
     WARNED, 5, "unsupported-element",
     "constraint 'l': <loop_joint> closes a loop and is not read, type \"3D\" is none of fixed, "
     "revolute, continuous, prismatic, spherical, ball: the robot is open there, with other "
     "freedoms and forces"},
    {"loop joint with the axis of the child",
     LOOPED("<loop_joint name=\"l\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><axis "
            "xyz=\"0 0 1\" frame=\"child\"/></loop_joint>"),
     WARNED, 5, "unsupported-element",
     "constraint 'l': <loop_joint> closes a loop and is not read, its axis is along axes of "
     "\"child\"; write frame=\"parent\": the robot is open there, with other freedoms and forces"},
    {"loop joint without a name",
     LOOPED("<loop_joint type=\"fixed\"><link1 link=\"a\"/><link2 link=\"b\"/></loop_joint>"),
     REFUSED, 5, "missing-attribute", "robot: <loop_joint> has no name; add name=\"...\""},
    {"loop joint without a type",
     LOOPED("<loop_joint name=\"l\"><link1 link=\"a\"/><link2 link=\"b\"/></loop_joint>"), REFUSED,
     5, "missing-attribute", "constraint 'l': <loop_joint> has no type; add type=\"...\""},
    {"loop joint with one link",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><link1 link=\"a\"/></loop_joint>"), REFUSED, 5,
     "missing-element", "constraint 'l': <loop_joint> has no <link2>; add it"},
    {"loop joint without a child",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><parent link=\"a\"/></loop_joint>"), REFUSED, 5,
     "missing-element", "constraint 'l': <loop_joint> has no <child>; add it"},
    {"loop joint with a nameless link",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><link1/><link2 link=\"b\"/></loop_joint>"),
     REFUSED, 5, "missing-attribute", "constraint 'l': <link1> has no link; add link=\"...\""},
    {"loop joint to nowhere",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><link1 link=\"a\"/><link2 "
            "link=\"c\"/></loop_joint>"),
     REFUSED, 5, "unknown-link",
     "constraint 'l': link 'c' does not exist; declare it or correct the name"},
    {"loop joint with a bad origin",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><link1 link=\"a\"/><link2 link=\"b\" xyz=\"0 "
            "0\"/></loop_joint>"),
     REFUSED, 5, "bad-vector",
     "constraint 'l': xyz=\"0 0\" of <link2> has 2 numbers; write three with blanks between them"},
    {"loop joint with a bad number",
     LOOPED("<loop_joint name=\"l\" type=\"fixed\"><link1 link=\"a\"/><link2 link=\"b\" rpy=\"0 0 "
            "x\"/></loop_joint>"),
     REFUSED, 5, "bad-number",
     "constraint 'l': rpy=\"0 0 x\" of <link2>: \"x\" is not a number; write digits, point and "
     "exponent without blanks or units, such as 1.5e-3"},
    {"loop joint without an axis",
     LOOPED("<loop_joint name=\"l\" type=\"revolute\"><link1 link=\"a\"/><link2 link=\"b\"/><axis "
            "xyz=\"0 0 0\"/></loop_joint>"),
     REFUSED, 5, "zero-axis", "constraint 'l': axis 0 0 0 has no direction; give it a unit vector"},
    {"loop joint, misspelled",
     LOOPED("<loop_joint name=\"l\" type=\"revolute\"><link1 link=\"a\"/><link2 link=\"b\"/><axes "
            "xyz=\"0 0 1\"/></loop_joint>"),
     REFUSED, 5, "misspelled-element",
     "constraint 'l': <axes> in <loop_joint>: did you mean <axis>?"},
    {"two loop joints of one name",
     LOOPED("<loop_joint name=\"l\" type=\"ball\"><link1 link=\"a\"/><link2 "
            "link=\"b\"/></loop_joint>\n<loop_joint name=\"l\" type=\"ball\"><link1 "
            "link=\"a\"/><link2 link=\"b\"/></loop_joint>"),
     REFUSED, 6, "duplicate-joint", "constraint 'l': declared before on line 5; rename one"},
    {"loop joint in a plugin",
     ROBOT(LINK("a") "<gazebo><plugin><loop_joint name=\"l\"/></plugin></gazebo>"), WARNED, 3,
     "unsupported-element",
     "robot: <loop_joint> closes a loop and is not read there: the robot is open, with other "
     "freedoms and forces; move it into <robot>; elements like it: 1"},
    {"included file",
     "<robot name=\"r\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n" LINK(
         "a") "<xi:include href=\"arm.urdf\"/></robot>",
     WARNED, 3, "unsupported-element",
     "robot: <xi:include> is not followed, what it includes is missing; expand it first: xmllint "
     "--xinclude; elements like it: 1"},
    {"two loop joints without links", LOOPED("<loop_joint name=\"l\"/><loop_joint name=\"m\"/>"),
     WARNED, 5, "unsupported-element",
     "constraint 'l': <loop_joint> closes a loop and is not read, it has neither <link1> and "
     "<link2> nor <parent> and <child>: the robot is open there, with other freedoms and forces\n"
     "constraint 'm': <loop_joint> closes a loop and is not read, it has neither <link1> and "
     "<link2> nor <parent> and <child>: the robot is open there, with other freedoms and forces"},
    {"included file, deep",
     ROBOT("<link name=\"a\"><inertial><xi:include href=\"mass.xml\"/><mass value=\"1\"/>" INERTIA
           "</inertial></link>"),
     WARNED, 2, "unsupported-element",
     "link 'a': <xi:include> is not followed, what it includes is missing; expand it first: "
     "xmllint "
     "--xinclude; elements like it: 1"},
    {"joint of Drake",
     ROBOT(LINK("a") "<drake:joint name=\"j\" type=\"ball\"><parent link=\"a\"/><child "
                     "link=\"b\"/></drake:joint>"),
     WARNED, 3, "unsupported-element",
     "robot: <drake:joint> is a joint that URDF does not have, and is not read; elements like it: "
     "1"},
    {"link in another case", ROBOT(LINK("a") LINK("A") JOINT("j", "floating", "a", "A", "")),
     LOADS},
    {"two joints between the same links",
     ROBOT(LINK("a") LINK("b") JOINT("i", "continuous", "a", "b", "")
               JOINT("j", "fixed", "a", "b", "")),
     REFUSED, 5, "two-parents",
     "link 'b': child of joint 'i' (line 4) and of joint 'j'; a robot is a tree: remove one"},
    {0},
};
