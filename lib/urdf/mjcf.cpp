/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bodies of MJCF become links. A body keeps its frame: where its joints are elsewhere or several,
 * links without inertia lie between, which the model fuses.
 */
#include "urdf/mjcf.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iterator>

namespace tfa
{

constexpr unsigned long most_rows = TFA_URDF_MAX_BYTES;

uint32_t mjcf_reader::main_line(uint32_t row) const
{
    char unused[300];
    return tfa_urdf_place(log_, row, unused, sizeof unused);
}

/* The rows of included texts, and <include>s that nothing has replaced */
void mjcf_reader::find_includes(const TiXmlElement &root)
{
    for (const TiXmlElement *e = &root; e; e = next_element(*e, root)) {
        if (e->ValueStr() != "include")
            continue;
        const char *file = e->Attribute("file");
        const char *rows = e->Attribute("lines");
        if (!e->FirstChildElement() || !file || !rows || spans_.size() > 1000)
            robot_.report(TFA_ERROR, *e, "bad-include",
                          "<include> in a text in memory is not followed; load the file by name");
        else
            spans_.push_back(
                {line_of(*e),
                 static_cast<uint32_t>(std::min(strtoul(rows, nullptr, 10), most_rows)), file});
    }
    log_->spans = spans_.data();
    log_->span_count = spans_.size();
}

/* The element's name, or another if it has none; "": reported */
std::string mjcf_reader::name_of(const TiXmlElement &element, const std::string &otherwise)
{
    const std::string *stated = element.Attribute("name") ? robot_.name(element, "name") : nullptr;
    broken |= !stated && element.Attribute("name");
    return stated ? *stated : element.Attribute("name") ? "" : otherwise;
}

const std::string &mjcf_reader::class_of(const checked_element &checked,
                                         const TiXmlElement &element, const std::string &childclass,
                                         const char *attribute)
{
    const std::string *stated = element.Attribute(std::string(attribute));
    if (!stated)
        return childclass;
    if (!defaults_.has(*stated))
        checked.report(TFA_ERROR, element, "bad-class",
                       std::string(attribute) + "=" + quoted(*stated) + " of <" + element.Value() +
                           "> is no class of <default>; add it or correct the name");
    return *stated;
}

/* --- links --------------------------------------------------------------------------------- */

static std::string numbers(std::initializer_list<std::pair<const char *, double>> values)
{
    std::string out;
    char text[32];
    for (const auto &[name, value] : values) {
        snprintf(text, sizeof text, "%.17g", value);
        write_attribute(out, name, text);
    }
    return out;
}

static std::string origin(const double xyz[3])
{
    char text[96];
    snprintf(text, sizeof text, "<origin xyz=\"%.17g %.17g %.17g\"/>", xyz[0], xyz[1], xyz[2]);
    return text;
}

void mjcf_reader::add_link(const std::string &name, const TiXmlElement &at, const std::string &text)
{
    if (name.size() > TFA_URDF_MAX_NAME)
        robot_.report(TFA_ERROR, at, "long-name", "the name " + quoted(name) + " is too long");
    links_text += "<link";
    write_attribute(links_text, "name", name);
    links_text += ">" + text + "</link>\n";
    links.push_back({name, main_line(line_of(at)), !text.empty(), {{0, 0, 0, 1}, {}}, 1});
}

void mjcf_reader::inertial(const mjcf_body &body)
{
    const checked_element checked(log_, found_, "link", body.name);
    const TiXmlElement *element = nullptr;
    const TiXmlElement *geom = nullptr; /* that gives mass */
    std::string unused;
    for (const TiXmlElement *e : children_of(*body.element)) {
        if (e->ValueStr() == "inertial" && element)
            checked.report(TFA_ERROR, *e, "duplicate-inertial", "a second <inertial>; remove one");
        if (e->ValueStr() == "inertial")
            element = e;
        if (e->ValueStr() != "geom" || geom)
            continue;
        double mass = 1;
        const std::string &class_name = class_of(checked, *e, body.childclass);
        for (const char *attribute : {"density", "mass"})
            if (const TiXmlElement *in = defaults_.find(*e, attribute, class_name))
                checked.number(*in, attribute, unused, &mass);
        geom = mass > 0 ? e : nullptr;
    }
    if (!element) {
        if (geom && compiler_.infers_inertia && !body.is_static)
            checked.report_grouped(TFA_ERROR, *geom, "geom-inertia",
                                   std::string("<body> has no <inertial>, and inertias of geoms "
                                               "are not computed here") +
                                       mjcf_save);
        add_link(body.name, *body.element);
        return;
    }
    const mjcf_pose pose = compiler_.pose(checked, *element);
    double mass = 0;
    double m[6] = {};
    if (checked.required_number(*element, "mass", unused, &mass) && mass < 0)
        checked.report(TFA_ERROR, *element, "negative-mass",
                       "mass " + text_of(mass) + " kg is negative; correct it");
    const bool full = element->Attribute("fullinertia");
    if (!full && !element->Attribute("diaginertia"))
        checked.missing(*element, "diaginertia");
    checked.vector(*element, full ? "fullinertia" : "diaginertia", unused, m, full ? 6 : 3);
    checked.unknown_attributes(*element, {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler",
                                          "mass", "diaginertia", "fullinertia"});
    add_link(body.name, *body.element,
             "<inertial>" + origin(pose.xyz) + "<mass" + numbers({{"value", mass}}) + "/><inertia" +
                 numbers({{"ixx", m[0]},
                          {"iyy", m[1]},
                          {"izz", m[2]},
                          {"ixy", m[3]},
                          {"ixz", m[4]},
                          {"iyz", m[5]}}) +
                 "/></inertial>");
    links.back().rotation = pose.rotation;
}

/* --- bodies -------------------------------------------------------------------------------- */

static void unknown_children(const checked_element &checked, const TiXmlElement &in,
                             std::initializer_list<const char *> known)
{
    checked.unknown_children(in, known, {"include"});
    for (const TiXmlElement *e = in.FirstChildElement("include"); e;
         e = e->NextSiblingElement("include"))
        for (const TiXmlElement *root = e->FirstChildElement(); root;
             root = root->NextSiblingElement())
            unknown_children(checked, *root, known);
}

/* Elements that place or make bodies */
static void refuse_makers(const checked_element &checked, const TiXmlElement &in)
{
    for (const TiXmlElement *e : children_of(in))
        for (const char *maker : {"frame", "replicate", "composite", "flexcomp", "attach"})
            if (e->ValueStr() == maker)
                checked.report(TFA_ERROR, *e, "unsupported-element",
                               std::string("<") + maker + "> is not read" + mjcf_save);
}

void mjcf_reader::body(mjcf_body &body)
{
    const TiXmlElement &element = *body.element;
    const checked_element checked(log_, found_, "link", body.name);
    body.childclass = class_of(checked, element, body.childclass, "childclass");
    body.pose = compiler_.pose(checked, element);
    body.world = body.world * body.pose;
    poses_.emplace(body.name, body.world);
    checked.unknown_attributes(element,
                               {"name", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler",
                                "childclass", "mocap", "gravcomp", "user", "sleep"});
    for (const char *attribute : {"mocap", "gravcomp"})
        if (element.Attribute(attribute))
            checked.not_used(std::string(attribute) + " of <body>", element);
    unknown_children(checked, element, {"body", "inertial", "joint", "freejoint"});
    refuse_makers(checked, element);
    body_joints(body);
    inertial(body);
}

/* It or a body that it carries has a joint. */
static bool moves(const TiXmlElement &body)
{
    std::vector<const TiXmlElement *> open = {&body};
    while (!open.empty()) {
        const TiXmlElement &in = *open.back();
        open.pop_back();
        for (const TiXmlElement *e : children_of(in)) {
            if (e->ValueStr() == "joint" || e->ValueStr() == "freejoint")
                return true;
            if (e->ValueStr() == "body")
                open.push_back(e);
        }
    }
    return false;
}

/* The only body of the world that moves, on a free joint, is the root of a floating base; others,
 * as the ground, are of no use to it. */
void mjcf_reader::find_floating_base(std::vector<mjcf_body> &bodies)
{
    std::vector<mjcf_body> moving, fixed;
    std::partition_copy(bodies.begin(), bodies.end(), std::back_inserter(moving),
                        std::back_inserter(fixed),
                        [](const mjcf_body &b) { return moves(*b.element); });
    if (moving.size() == 1)
        for (const TiXmlElement *e : children_of(*moving[0].element))
            floats |= is_free(*e);
    if (!floats)
        return;
    for (const mjcf_body &b : fixed)
        robot_.not_used("bodies fixed to the world", *b.element);
    bodies = moving;
}

void mjcf_reader::worldbody(const std::vector<const TiXmlElement *> &sections)
{
    std::vector<mjcf_body> open; /* bodies to be read, the next one last */
    size_t number = 0;
    const auto add = [&](const TiXmlElement &in, const mjcf_body &parent) {
        const std::vector<const TiXmlElement *> children = children_of(in);
        for (auto e = children.rbegin(); e != children.rend(); ++e)
            if ((*e)->ValueStr() == "body")
                open.push_back(
                    {*e, "", parent.name, parent.childclass, {}, parent.world, parent.is_static});
    };
    for (auto section = sections.rbegin(); section != sections.rend(); ++section) {
        const checked_element checked(log_, found_, "link", "world");
        mjcf_body world{*section, "world", "", "main", {}, {}, true};
        world.childclass = class_of(checked, **section, "main", "childclass");
        unknown_children(checked, **section, {"body"});
        refuse_makers(checked, **section);
        add(**section, world);
    }
    if (open.empty())
        return;
    find_floating_base(open);
    if (!floats)
        add_link("world", *sections[0]);
    while (!open.empty()) {
        mjcf_body next = open.back();
        open.pop_back();
        next.name = name_of(*next.element, "body" + std::to_string(++number));
        if (next.name.empty())
            return; /* reported */
        body(next);
        add(*next.element, next);
    }
}

void mjcf_reader::read(const TiXmlElement &root)
{
    find_includes(root);
    unknown_children(robot_, root, {"compiler", "default", "worldbody", "equality"});
    if (const char *stated = root.Attribute("model"))
        model = *stated && is_printable(stated) ? stated : "robot";
    std::vector<const TiXmlElement *> worlds;
    const std::vector<const TiXmlElement *> sections = children_of(root);
    for (const TiXmlElement *e : sections) {
        if (e->ValueStr() == "compiler")
            compiler_.read(robot_, *e);
        else if (e->ValueStr() == "default")
            defaults_.add(robot_, *e);
        else if (e->ValueStr() == "worldbody")
            worlds.push_back(e);
    }
    worldbody(worlds);
    for (const TiXmlElement *e : sections)
        if (e->ValueStr() == "equality" && !broken)
            equality(*e);
    /* from here on lines of the main file */
    for (unused_items::entry &entry : found_->unused.entries())
        entry.line = main_line(entry.line);
    for (tally *t : {&found_->loops, &found_->blanks})
        t->line = main_line(t->line);
}

std::string mjcf_reader::joints_text() const
{
    std::string out;
    for (const mjcf_joint &j : joints) {
        out += "<joint";
        write_attribute(out, "name", j.source.name);
        write_attribute(out, "type", tfa_joint_type_describe(j.source.type).name);
        out += ">" + origin(j.xyz) + "<parent";
        write_attribute(out, "link", j.source.parent);
        out += "/><child";
        write_attribute(out, "link", j.source.child);
        out += R"(/><limit effort="0" velocity="0"/>)"; /* urdfdom wants one of some types */
        if (j.damping != 0 || j.friction != 0)
            out += "<dynamics" + numbers({{"damping", j.damping}, {"friction", j.friction}}) + "/>";
        if (!j.source.mimic.empty()) {
            out += "<mimic";
            write_attribute(out, "joint", j.source.mimic);
            out += numbers({{"multiplier", j.multiplier}, {"offset", j.offset}}) + "/>";
        }
        out += "</joint>\n";
    }
    return out;
}

void linter::mujoco(const TiXmlElement &element)
{
    mjcf_reader reader(log_, &found_);
    reader.read(element);
    name_ = reader.model;
    out_ = reader.links_text + reader.joints_text();
    links_ = reader.links;
    loops_ = reader.loops;
    for (const mjcf_joint &joint : reader.joints)
        joints_.push_back(joint.source);
    broken_ = reader.broken;
    root_is_free_ = reader.floats;
}

} // namespace tfa
