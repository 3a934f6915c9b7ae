/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Elements that nothing reads although the file means another robot with them.
 */
#include "urdf/lint.hpp"

#include <cstring>
#include <iterator>

namespace tfa
{

static const struct {
    const char *name, *what;
} unsupported[] = {
    {"loop_joint",
     "closes a loop and is not read there: the robot is open, with other freedoms and forces; move "
     "it into <robot>"},
    {"xi:include", "is not followed, what it includes is missing; expand it first: xmllint "
                   "--xinclude"},
    {"drake:joint", "is a joint that URDF does not have, and is not read"},
};

/* Elements that count in one place only */
static const struct {
    const char *name, *parent;
} places[] = {
    {"joint", "robot"},      {"inertial", "link"}, {"mass", "inertial"},
    {"inertia", "inertial"}, {"axis", "joint"},    {"mimic", "joint"},
};

static bool is(const TiXmlNode &element, const char *name)
{
    return strcmp(element.Value(), name) == 0;
}

/* A joint of the robot; in transmissions and plugins a <joint> only names one. */
static bool defines_joint(const TiXmlElement &element)
{
    return element.FirstChildElement("parent") && element.FirstChildElement("child");
}

/* Words of other programs: they have elements of the same names. */
static bool is_foreign(const TiXmlElement &element)
{
    return is(element, "transmission") || is(element, "loop_joint") || is(element, "gazebo") ||
           is(element, "ros2_control") || strchr(element.Value(), ':');
}

static void lint_place(const TiXmlElement &element, const TiXmlElement &top,
                       const checked_element &owner, tally &simulated)
{
    for (const auto &place : places) {
        const TiXmlNode &parent = *element.Parent();
        if (!is(element, place.name) || is(parent, place.parent) ||
            (is(element, "joint") ? !defines_joint(element) : is_foreign(top)))
            continue;
        const char *name = is(element, "joint") ? element.Attribute("name") : nullptr;
        const std::string what = std::string("<") + place.name + ">" +
                                 (name ? " " + quoted(name) + " inside <" : " inside <") +
                                 parent.Value() + "> is not read";
        if (is(top, "gazebo"))
            owner.count(simulated, element, what);
        else
            owner.report(TFA_WARNING, element, "misplaced-element",
                         what + ": move it into <" + place.parent + ">");
    }
}

void lint_lost_elements(const TiXmlElement &robot, tfa_urdf_log *log, file_findings *found)
{
    tally simulated; /* joints inside <gazebo> */
    tally lost[std::size(unsupported)];
    for (const TiXmlElement *top = robot.FirstChildElement(); top;
         top = top->NextSiblingElement()) {
        const char *name = top->Attribute("name");
        const bool owns = name && strlen(name) <= TFA_URDF_MAX_NAME && is_printable(name) &&
                          (is(*top, "link") || is(*top, "joint"));
        const checked_element owner(log, found, owns ? top->Value() : "robot", owns ? name : "");
        for (const TiXmlElement *e = top; e; e = next_element(*e, *top)) {
            for (size_t k = 0; k < std::size(unsupported); k++)
                if (is(*e, unsupported[k].name) && !(e == top && is(*e, "loop_joint")))
                    owner.count(lost[k], *e, std::string("<") + e->Value() + ">");
            lint_place(*e, *top, owner, simulated);
        }
    }
    report_tally(log, TFA_WARNING, "misplaced-element", simulated,
                 ": the robot has no such joint; joints like it");
    for (size_t k = 0; k < std::size(unsupported); k++)
        report_tally(log, TFA_WARNING, "unsupported-element", lost[k],
                     std::string(" ") + unsupported[k].what + "; elements like it");
}

} // namespace tfa
