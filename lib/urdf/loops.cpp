/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * <loop_joint>, no element of URDF: joints that close loops of the tree, as Drake, Isaac Sim and
 * exporters of CAD programs write them. Each becomes a constraint.
 */
#include "urdf/lint.hpp"

#include <cstring>

namespace tfa
{

static const struct {
    const char *word;
    uint32_t rows; /* that stay, with z along the axis */
    bool has_axis;
} types[] = {
    {"fixed", TFA_CONSTRAINT_WELD, false},      {"revolute", TFA_CONSTRAINT_HINGE, true},
    {"continuous", TFA_CONSTRAINT_HINGE, true}, {"prismatic", TFA_CONSTRAINT_WELD & ~4U, true},
    {"spherical", TFA_CONSTRAINT_POINT, false}, {"ball", TFA_CONSTRAINT_POINT, false},
};

static void not_read(const checked_element &checked, const TiXmlElement &element,
                     const std::string &why)
{
    checked.report(TFA_WARNING, element, "unsupported-element",
                   "<loop_joint> closes a loop and is not read, " + why +
                       ": the robot is open there, with other freedoms and forces");
}

/* The elements that name the links. False: reported. */
static bool find_ends(const checked_element &checked, const TiXmlElement &element,
                      const TiXmlElement *end[2])
{
    const bool numbered = element.FirstChildElement("link1") || element.FirstChildElement("link2");
    const bool named = element.FirstChildElement("parent") || element.FirstChildElement("child");
    if (!numbered && !named) {
        not_read(checked, element, "it has neither <link1> and <link2> nor <parent> and <child>");
        return false;
    }
    end[0] = element.FirstChildElement("link1");
    end[1] = end[0] ? end[0]->NextSiblingElement("link1") : nullptr; /* so in Isaac Sim's manual */
    if (!end[1] || element.FirstChildElement("link2")) {
        end[0] = checked.required(element, numbered ? "link1" : "parent");
        end[1] = checked.required(element, numbered ? "link2" : "child");
    }
    return end[0] && end[1];
}

/* The element with xyz and rpy of a side: <parent_origin>, <origin>, or the one that names the
 * link */
static const TiXmlElement &origin_of(const checked_element &checked, const TiXmlElement &element,
                                     const TiXmlElement &end, int side)
{
    const TiXmlElement *origin = nullptr;
    if (end.ValueStr() == "parent" || end.ValueStr() == "child")
        origin = checked.only_child(element, side == 0 ? "parent_origin" : "child_origin");
    if (!origin && end.ValueStr() == "parent")
        origin = checked.only_child(element, "origin");
    return origin ? *origin : end;
}

static bool read_frame(const checked_element &checked, const TiXmlElement &element,
                       const TiXmlElement &end, int side, loop_source &loop)
{
    const std::string *link = checked.name(end, "link");
    const TiXmlElement &origin = origin_of(checked, element, end, side);
    std::string unused;
    checked.vector(origin, "xyz", unused, loop.xyz[side]);
    loop.rotation[side] = checked.rotation(origin);
    checked.unknown_attributes(origin, {"link", "xyz", "rpy", "quat_xyzw"});
    if (side == 1)
        loop.aligned = origin.ValueStr() == "child_origin" && !origin.Attribute("rpy") &&
                       !origin.Attribute("quat_xyzw");
    if (link)
        loop.link[side] = *link;
    return link != nullptr;
}

/* Turns both frames so that their z is the axis. False: reported. */
static bool read_axis(const checked_element &checked, const TiXmlElement &element,
                      loop_source &loop)
{
    double axis[3] = {1, 0, 0}; /* URDF's default */
    double low[3] = {};
    std::string unused;
    tfa_rotation turn{};
    const TiXmlElement *stated = checked.only_child(element, "axis");
    const char *frame = stated ? stated->Attribute("frame") : nullptr;
    if (frame && strcmp(frame, "parent") != 0) {
        not_read(checked, element,
                 "its axis is along axes of " + quoted(frame) + "; write frame=\"parent\"");
        return false;
    }
    if (stated && !stated->Attribute("xyz"))
        checked.missing(*stated, "xyz");
    else if (stated && checked.vector(*stated, "xyz", unused, axis) &&
             tfa_axis_normalise(axis, low) == 0)
        checked.report(TFA_ERROR, *stated, "zero-axis",
                       "axis 0 0 0 has no direction; give it a unit vector");
    if (stated)
        checked.unknown_attributes(*stated, {"xyz", "frame"});
    if (frame)
        tfa_rotate_back(&loop.rotation[0], axis);
    tfa_rotation_from_z(axis, &turn);
    for (tfa_rotation &rotation : loop.rotation) {
        const tfa_rotation before = rotation;
        tfa_rotation_product(&before, &turn, &rotation);
    }
    return true;
}

void linter::loop_joint(const TiXmlElement &element)
{
    const std::string *name = robot_.name(element, "name");
    if (!name)
        return;
    const checked_element checked(log_, &found_, "constraint", *name);
    loop_source loop{};
    loop.name = *name;
    loop.line = line_of(element);
    const TiXmlElement *end[2] = {};
    const std::string *type =
        find_ends(checked, element, end) ? checked.name(element, "type") : nullptr;
    if (!type)
        return;
    std::string words;
    const auto *known = std::begin(types);
    for (; known != std::end(types) && *type != known->word; known++)
        words += (words.empty() ? "" : ", ") + std::string(known->word);
    if (known == std::end(types)) {
        not_read(checked, element, "type " + quoted(*type) + " is none of " + words);
        return;
    }
    checked.unknown_children(element, {"link1", "link2", "parent", "child", "parent_origin",
                                       "child_origin", "origin", "axis"});
    checked.unknown_attributes(element, {"name", "type"});
    loop.rows = known->rows;
    bool good = true;
    for (int side = 0; side < 2; side++)
        good &= read_frame(checked, element, *end[side], side, loop);
    if (!good || (known->has_axis && !read_axis(checked, element, loop)))
        return;
    checked.count(found_.loops, element, "<loop_joint> closes a loop");
    loops_.push_back(loop);
}

/* ---- names become indices -------------------------------------------------------------------- */

static tfa_rotation rotation_at_zero(const std::vector<joint_source> &joints,
                                     const std::vector<int32_t> &above, int32_t link)
{
    tfa_rotation rotation{{0, 0, 0, 1}, {}};
    for (size_t steps = 0; link >= 0 && steps <= joints.size(); steps++) { /* it may be no tree */
        const int32_t j = above[static_cast<size_t>(link)];
        if (j < 0)
            break;
        const joint_source &joint = joints[static_cast<size_t>(j)];
        const tfa_rotation before = rotation;
        tfa_rotation_product(&joint.rotation, &before, &rotation);
        link = static_cast<int32_t>(joint.parent_index);
    }
    return rotation;
}

/* Gives the second frame the axes that the first one has with all joints at 0. */
static void align(loop_source &loop, const std::vector<joint_source> &joints,
                  const std::vector<int32_t> &above)
{
    const tfa_rotation first = rotation_at_zero(joints, above, loop.index[0]);
    const tfa_rotation second = rotation_at_zero(joints, above, loop.index[1]);
    tfa_rotation back{};
    tfa_rotation between{};
    tfa_rotation_inverse(&second, &back);
    tfa_rotation_product(&back, &first, &between);
    tfa_rotation_product(&between, &loop.rotation[0], &loop.rotation[1]);
}

void linter::resolve_loops(const index &links)
{
    if (loops_.size() > TFA_MAX_CONSTRAINTS) {
        tfa_urdf_report(log_, TFA_ERROR, loops_[TFA_MAX_CONSTRAINTS].line, "too-large",
                        "robot: %zu loop joints; at most %d are supported", loops_.size(),
                        TFA_MAX_CONSTRAINTS);
        return;
    }
    std::vector<int32_t> above(loops_.empty() ? 0 : links_.size(), -1);
    for (size_t j = 0; j < joints_.size() && !above.empty(); j++)
        above[joints_[j].child_index] = static_cast<int32_t>(j);
    for (loop_source &loop : loops_) {
        for (int side = 0; side < 2; side++) {
            auto at = links.find(loop.link[side]);
            loop.index[side] = at == links.end() ? -1 : static_cast<int32_t>(at->second);
            if (at != links.end() || loop.link[side] == "world")
                continue;
            resolved_ = false;
            tfa_urdf_report(log_, TFA_ERROR, loop.line, "unknown-link",
                            "constraint '%s': link '%s' does not exist; declare it or correct the "
                            "name",
                            loop.name.c_str(), loop.link[side].c_str());
        }
        if (loop.aligned && resolved_)
            align(loop, joints_, above);
    }
}

void linter::append_loops(tfa_description &description, char *&strings) const
{
    tfa_constraint *to = description.constraints;
    for (const loop_source &loop : loops_) {
        to->name = append_string(strings, loop.name);
        to->line = loop.line;
        to->rows = loop.rows;
        for (int side = 0; side < 2; side++) {
            if (loop.index[side] >= 0)
                to->link[side] = description.links[loop.index[side]].name;
            memcpy(to->pose[side], loop.xyz[side], sizeof loop.xyz[side]);
            memcpy(to->pose[side] + 3, loop.rotation[side].quat, sizeof loop.rotation[side].quat);
        }
        to++;
    }
}

} // namespace tfa
