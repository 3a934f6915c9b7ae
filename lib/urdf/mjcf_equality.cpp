/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Equalities of MJCF: <connect> and <weld> become constraints, <joint> a mimic; ranges of joints.
 */
#include "urdf/mjcf.hpp"

#include <algorithm>
#include <cstring>

namespace tfa
{

/* Both frames coincide at the file's pose, unless relpose says otherwise. */
void mjcf_reader::loop(const checked_element &checked, const TiXmlElement &element,
                       const std::string &name)
{
    const bool weld = element.ValueStr() == "weld";
    loop_source loop{};
    double relative[7] = {};
    std::string unused;
    mjcf_pose frame[2];
    loop.name = name;
    loop.line = main_line(line_of(element));
    loop.rows = weld ? TFA_CONSTRAINT_WELD : TFA_CONSTRAINT_POINT;
    for (int side = 0; side < 2; side++) {
        const char *attribute = side == 0 ? "body1" : "body2";
        const bool stated = side == 0 || element.Attribute(attribute);
        const std::string *body = stated ? checked.name(element, attribute) : nullptr;
        if (stated && !body)
            return;
        loop.link[side] = body ? *body : "world";
    }
    const mjcf_pose between = inverse(poses_[loop.link[0]]) * poses_[loop.link[1]];
    checked.vector(element, "anchor", unused, frame[weld].xyz);
    checked.vector(element, "relpose", unused, relative, 7);
    const double xyzw[4] = {relative[4], relative[5], relative[6], relative[3]};
    mjcf_pose stated;
    std::copy(relative, relative + 3, stated.xyz);
    if (!weld)
        frame[1] = inverse(between) * frame[0];
    else if (tfa_rotation_from_xyzw(xyzw, &stated.rotation) > 0)
        frame[0] = stated * frame[1];
    else
        frame[0] = between * frame[1];
    for (int side = 0; side < 2; side++) {
        std::copy(frame[side].xyz, frame[side].xyz + 3, loop.xyz[side]);
        loop.rotation[side] = frame[side].rotation;
    }
    checked.count(found_->loops, element, "<" + element.ValueStr() + "> closes a loop");
    loops.push_back(loop);
}

static void not_read(const checked_element &checked, const TiXmlElement &element,
                     const std::string &why)
{
    checked.report(TFA_WARNING, element, "unsupported-element",
                   "<" + element.ValueStr() + "> of <equality> is not read, " + why +
                       ": the robot is free there, with other freedoms and forces");
}

/* joint1 - ref1 = a0 + a1 (joint2 - ref2) */
void mjcf_reader::coupling(const checked_element &checked, const TiXmlElement &element)
{
    double a[5] = {0, 1, 0, 0, 0};
    std::string unused;
    const std::string *names[2] = {checked.name(element, "joint1"), nullptr};
    if (element.Attribute("joint2"))
        names[1] = checked.name(element, "joint2");
    checked.vector(element, "polycoef", unused, a, 5, 1);
    if (!names[1] || a[2] != 0 || a[3] != 0 || a[4] != 0) {
        not_read(checked, element, names[1] ? "its polycoef is not linear" : "it has no joint2");
        return;
    }
    mjcf_joint *joint[2] = {};
    for (int k = 0; k < 2 && names[0]; k++) {
        const auto at = joint_index_.find(*names[k]);
        if (at != joint_index_.end())
            joint[k] = &joints[at->second];
        else
            checked.report(TFA_ERROR, element, "unknown-joint",
                           "joint " + quoted(*names[k]) + " does not exist; correct the name");
    }
    if (!joint[0] || !joint[1])
        return;
    if (!joint[0]->source.mimic.empty()) {
        not_read(checked, element, "joint " + quoted(*names[0]) + " follows another one already");
        return;
    }
    joint[0]->source.mimic = *names[1];
    joint[0]->source.mimic_line = main_line(line_of(element));
    joint[0]->multiplier = a[1];
    joint[0]->offset = joint[0]->reference + a[0] - a[1] * joint[1]->reference;
}

void mjcf_reader::equality(const TiXmlElement &element)
{
    for (const TiXmlElement *e : children_of(element)) {
        const std::string &kind = e->ValueStr();
        const std::string name = name_of(*e, kind + std::to_string(++equalities_));
        const checked_element checked(log_, found_, "constraint", name);
        const char *active = e->Attribute("active");
        if (active && strcmp(active, "false") == 0)
            checked.not_used("inactive <" + kind + ">", *e);
        else if (kind == "joint")
            coupling(checked, *e);
        else if ((kind == "connect" || kind == "weld") && e->Attribute("site1"))
            not_read(checked, *e, "it names sites; name bodies and an anchor");
        else if (kind == "connect" || kind == "weld")
            loop(checked, *e, name);
        else
            not_read(checked, *e, "only <connect>, <weld> and <joint> are");
    }
}

/* Limits of joints of a file with a root <mujoco> */
void mjcf_limits(const TiXmlElement &root, const char *const *names, size_t count,
                 tfa_joint_limits *limits)
{
    tfa_report report{};
    tfa_urdf_log log{};
    file_findings found;
    log.report = &report;
    {
        mjcf_reader reader(&log, &found);
        reader.read(root);
        std::unordered_map<std::string, const tfa_joint_limits *> index;
        for (const mjcf_joint &joint : reader.joints)
            index.emplace(joint.source.name, &joint.limits);
        for (size_t k = 0; k < count; k++) {
            const auto at = index.find(names[k]);
            if (at != index.end())
                limits[k] = *at->second;
        }
    }
    tfa_report_free(&report);
}

} // namespace tfa
