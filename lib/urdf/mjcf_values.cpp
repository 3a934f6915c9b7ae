/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Values of MJCF: included elements, classes of defaults, units, frames.
 */
#include "urdf/mjcf.hpp"

#include <cmath>
#include <cstring>

namespace tfa
{

const char mjcf_save[] = "; load the file in a current MuJoCo with <compiler "
                         "saveinertial=\"true\"/> and save it (mujoco.mj_saveLastXML)";

std::vector<const TiXmlElement *> children_of(const TiXmlElement &in)
{
    std::vector<const TiXmlElement *> children;
    const TiXmlElement *e = in.FirstChildElement();
    while (e) {
        const TiXmlElement *parent = e->Parent()->ToElement();
        const bool is_root = e->ValueStr() == "include" || parent->ValueStr() == "include";
        const TiXmlElement *inside = is_root ? e->FirstChildElement() : nullptr;
        if (!is_root)
            children.push_back(e);
        const TiXmlNode *at = e;
        for (e = inside; !e && at != &in; at = at->Parent())
            e = at->NextSiblingElement();
    }
    return children;
}

/* --- defaults ------------------------------------------------------------------------------ */

static std::string key_of(const std::string &class_name, const std::string &element,
                          const char *attribute)
{
    return class_name + '\n' + element + '\n' + attribute;
}

void mjcf_defaults::add(const checked_element &checked, const TiXmlElement &section)
{
    const char *top = section.Attribute("class");
    std::vector<std::pair<const TiXmlElement *, std::string>> open{{&section, "main"}};
    parents_.emplace("main", "");
    parents_.emplace(top ? top : "main", "main"); /* another name of the same class */
    while (!open.empty()) {
        const auto [in, class_name] = open.back();
        open.pop_back();
        for (const TiXmlElement *e : children_of(*in)) {
            if (e->ValueStr() != "default") {
                for (const TiXmlAttribute *a = e->FirstAttribute(); a; a = a->Next())
                    values_[key_of(class_name, e->ValueStr(), a->Name())] = e;
                continue;
            }
            const std::string *name = checked.name(*e, "class");
            if (!name)
                continue;
            if (parents_.emplace(*name, class_name).first->second == class_name)
                open.emplace_back(e, *name);
            else
                checked.report(TFA_ERROR, *e, "bad-class",
                               "class " + quoted(*name) + " stands twice; rename one");
        }
    }
}

const TiXmlElement *mjcf_defaults::find(const TiXmlElement &element, const char *attribute,
                                        const std::string &class_name) const
{
    if (element.Attribute(attribute))
        return &element;
    auto in = parents_.find(class_name);
    for (; in != parents_.end(); in = parents_.find(in->second)) {
        const auto at = values_.find(key_of(in->first, element.ValueStr(), attribute));
        if (at != values_.end())
            return at->second;
    }
    return nullptr;
}

/* --- frames -------------------------------------------------------------------------------- */

void rotate(const tfa_rotation &rotation, double x[3])
{
    tfa_rotation back{};
    tfa_rotation_inverse(&rotation, &back);
    tfa_rotate_back(&back, x);
}

tfa_rotation axis_rotation(const double axis[3], double angle)
{
    const double s = std::sin(angle / 2);
    const double xyzw[4] = {axis[0] * s, axis[1] * s, axis[2] * s, std::cos(angle / 2)};
    tfa_rotation rotation{};
    tfa_rotation_from_xyzw(xyzw, &rotation);
    return rotation;
}

mjcf_pose operator*(const mjcf_pose &a, const mjcf_pose &b)
{
    mjcf_pose out = b;
    rotate(a.rotation, out.xyz);
    for (int k = 0; k < 3; k++)
        out.xyz[k] += a.xyz[k];
    tfa_rotation_product(&a.rotation, &b.rotation, &out.rotation);
    return out;
}

mjcf_pose inverse(const mjcf_pose &pose)
{
    mjcf_pose out;
    for (int k = 0; k < 3; k++)
        out.xyz[k] = -pose.xyz[k];
    tfa_rotate_back(&pose.rotation, out.xyz);
    tfa_rotation_inverse(&pose.rotation, &out.rotation);
    return out;
}

static bool normalise(double x[3])
{
    double low[3];
    return tfa_axis_normalise(x, low) > 0;
}

/* Any rotation of z to x cross y, after one about z that takes x to its place */
static bool rotation_from_axes(double *x, const double *y, tfa_rotation &rotation)
{
    double z[3] = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
    if (!normalise(z))
        return false;
    tfa_rotation tilt{};
    tfa_rotation_from_z(z, &tilt);
    tfa_rotate_back(&tilt, x);
    const double about[3] = {0, 0, std::atan2(x[1], x[0])};
    tfa_rotation spin{};
    tfa_rotation_from_rpy(about, &spin);
    tfa_rotation_product(&tilt, &spin, &rotation);
    return true;
}

static tfa_rotation rotation_from_euler(const double *angle, const std::string &sequence)
{
    tfa_rotation rotation{{0, 0, 0, 1}, {}};
    for (size_t k = 0; k < 3; k++) {
        const bool moves = sequence[k] >= 'x'; /* small letters: axes that turn along */
        double rpy[3] = {};
        rpy[sequence[k] - (moves ? 'x' : 'X')] = angle[k];
        const tfa_rotation before = rotation;
        tfa_rotation next{};
        tfa_rotation_from_rpy(rpy, &next);
        tfa_rotation_product(moves ? &before : &next, moves ? &next : &before, &rotation);
    }
    return rotation;
}

/* False: a direction or quaternion of zeros */
bool mjcf_compiler::orientation(double v[6], const std::string &form, tfa_rotation &rotation) const
{
    if (form == "quat") {
        const double xyzw[4] = {v[1], v[2], v[3], v[0]};
        return tfa_rotation_from_xyzw(xyzw, &rotation) > 0;
    }
    if (form == "xyaxes")
        return rotation_from_axes(v, v + 3, rotation);
    if (form == "euler") {
        const double angles[3] = {v[0] * unit, v[1] * unit, v[2] * unit};
        rotation = rotation_from_euler(angles, euler);
        return true;
    }
    if (!normalise(v))
        return false;
    if (form == "axisangle") {
        rotation = axis_rotation(v, v[3] * unit);
        return true;
    }
    const double shortest[4] = {-v[1], v[0], 0, 1 + v[2]};
    const double opposite[4] = {1, 0, 0, 0};
    return tfa_rotation_from_xyzw(v[2] > -1 ? shortest : opposite, &rotation) > 0;
}

mjcf_pose mjcf_compiler::pose(const checked_element &checked, const TiXmlElement &element) const
{
    static const struct {
        const char *name;
        size_t length;
    } forms[] = {{"quat", 4}, {"axisangle", 4}, {"xyaxes", 6}, {"zaxis", 3}, {"euler", 3}};
    mjcf_pose pose;
    std::string unused;
    checked.vector(element, "pos", unused, pose.xyz);
    int stated = 0;
    for (const auto &form : forms) {
        double v[6] = {};
        if (!checked.vector(element, form.name, unused, v, form.length))
            continue;
        if (!orientation(v, form.name, pose.rotation) || ++stated > 1)
            checked.report(TFA_ERROR, element, "bad-quaternion",
                           std::string(form.name) + " of <" + element.Value() +
                               "> is zero, or a second orientation; correct it");
    }
    return pose;
}

/* --- compiler ------------------------------------------------------------------------------ */

void mjcf_compiler::read(const checked_element &checked, const TiXmlElement &element)
{
    static const struct {
        const char *name, *values; /* those that are read, with a blank before each */
    } attributes[] = {
        {"angle", " degree radian"}, {"inertiafromgeom", " auto false"},
        {"coordinate", " local"},    {"balanceinertia", " false"},
        {"alignfree", " false"},     {"boundmass", " 0"},
        {"boundinertia", " 0"},      {"settotalmass", " -1"},
    };
    const auto value = [&](const char *name) {
        const char *text = element.Attribute(name);
        return std::string(text ? text : "");
    };
    const auto refuse = [&](const char *name) {
        checked.report(TFA_ERROR, element, "bad-compiler",
                       std::string(name) + "=" + quoted(value(name)) +
                           " of <compiler> is not read" + mjcf_save);
    };
    for (const auto &a : attributes)
        if (element.Attribute(a.name) && !strstr(a.values, (" " + value(a.name)).c_str()))
            refuse(a.name);
    if (element.Attribute("angle"))
        unit = value("angle") == "radian" ? 1 : 0.017453292519943295;
    const std::string sequence = element.Attribute("eulerseq") ? value("eulerseq") : euler;
    if (sequence.size() == 3 && sequence.find_first_not_of("xyzXYZ") == std::string::npos)
        euler = sequence;
    else
        refuse("eulerseq");
    infers_inertia &= value("inertiafromgeom") != "false";
    limits_by_range &= value("autolimits") != "false";
}

} // namespace tfa
