/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints of MJCF. Those of a body act one after the other, each about an anchor in the body; the
 * coordinates are MuJoCo's, `ref` included.
 */
#include "urdf/mjcf.hpp"

#include <algorithm>
#include <cmath>

namespace tfa
{

bool is_free(const TiXmlElement &joint)
{
    const char *type = joint.ValueStr() == "joint" ? joint.Attribute("type") : nullptr;
    return joint.ValueStr() == "freejoint" || (type && std::string(type) == "free");
}

mjcf_joint &mjcf_reader::add_joint(const std::string &name, const TiXmlElement &at,
                                   const std::string &parent, const std::string &child,
                                   const mjcf_pose &pose)
{
    mjcf_joint joint;
    if (name.size() > TFA_URDF_MAX_NAME)
        robot_.report(TFA_ERROR, at, "long-name", "the name " + quoted(name) + " is too long");
    joint.source.name = name;
    joint.source.line = main_line(line_of(at));
    joint.source.axis[2] = 1;
    joint.source.rotation = pose.rotation;
    joint.source.parent = parent;
    joint.source.child = child;
    joint.limits.velocity = joint.limits.effort = INFINITY;
    std::copy(pose.xyz, pose.xyz + 3, joint.xyz);
    joint_index_.emplace(name, joints.size());
    joints.push_back(joint);
    return joints.back();
}

/* A free joint of the root is the floating base. Coordinates are the body's pose in the world: that
 * of the file is only where it starts. */
void mjcf_reader::free_joint(const TiXmlElement &element, mjcf_body &body, const std::string &name)
{
    const checked_element checked(log_, found_, "joint", name);
    if (body.parent != "world" || !body.is_static)
        checked.report(TFA_ERROR, element, "unknown-joint-type",
                       "only a body of <worldbody> with no other joint can have a free joint");
    body.is_static = false;
    mjcf_joint root;
    mjcf_joint &joint = floats ? root : add_joint(name, element, "world", body.name, {});
    axis_joint(checked, element, class_of(checked, element, body.childclass), joint);
    joint.source.type = TFA_JOINT_FLOATING;
    if (floats && (joint.source.armature != 0 || joint.damping != 0 || joint.friction != 0))
        checked.not_used("armature, damping and friction of the root's free joint", element);
}

/* Axis, armature, losses and range */
void mjcf_reader::axis_joint(const checked_element &checked, const TiXmlElement &element,
                             const std::string &class_name, mjcf_joint &joint)
{
    const double unit = joint.source.type == TFA_JOINT_PRISMATIC ? 1 : compiler_.unit;
    double range[2] = {};
    double force[2] = {};
    double stiffness = 0;
    const struct {
        const char *name;
        double *value;
        size_t length;
    } attributes[] = {{"axis", joint.source.axis, 3}, {"armature", &joint.source.armature, 1},
                      {"damping", &joint.damping, 1}, {"frictionloss", &joint.friction, 1},
                      {"ref", &joint.reference, 1},   {"stiffness", &stiffness, 1},
                      {"actuatorfrcrange", force, 2}, {"range", range, 2}};
    std::string unused;
    bool limited = false; /* by a range */
    joint.source.axis[2] = 1;
    for (const auto &a : attributes)
        if (const TiXmlElement *in = defaults_.find(element, a.name, class_name))
            limited |= checked.vector(*in, a.name, unused, a.value, a.length) && a.value == range;
    if (tfa_axis_normalise(joint.source.axis, joint.source.axis_low) == 0)
        checked.report(TFA_ERROR, element, "zero-axis",
                       "axis 0 0 0 has no direction; give it a unit vector");
    joint.reference *= unit;
    if (stiffness != 0)
        checked.not_used("stiffness of <joint>", element);
    const TiXmlElement *in = defaults_.find(element, "limited", class_name);
    const std::string word = in ? in->Attribute("limited") : "auto";
    if (word == "true" || (word == "auto" && limited && compiler_.limits_by_range)) {
        checked.not_used("position limits", element);
        if (joint.source.type == TFA_JOINT_CONTINUOUS)
            joint.source.type = TFA_JOINT_REVOLUTE;
        joint.limits.limited = range[0] < range[1];
        joint.limits.lower = joint.limits.limited ? range[0] * unit : 0;
        joint.limits.upper = joint.limits.limited ? range[1] * unit : 0;
    }
    if (force[0] < force[1])
        joint.limits.effort = std::min(std::fabs(force[0]), std::fabs(force[1]));
}

/* The joint moves by q - ref: turns or shifts its frame back by ref. */
static void apply_reference(mjcf_joint &joint)
{
    const tfa_rotation before = joint.source.rotation;
    double along[3] = {joint.source.axis[0], joint.source.axis[1], joint.source.axis[2]};
    const tfa_rotation back = axis_rotation(along, -joint.reference);
    if (joint.source.type != TFA_JOINT_PRISMATIC) {
        tfa_rotation_product(&before, &back, &joint.source.rotation);
        return;
    }
    rotate(before, along);
    for (int k = 0; k < 3; k++)
        joint.xyz[k] -= along[k] * joint.reference;
}

/* Reads a joint below `parent`, in whose frame the body's is `origin`; then in the one of the link
 * that the joint moves, which is returned: at its anchor. */
std::string mjcf_reader::joint(const TiXmlElement &element, const mjcf_body &body,
                               const std::string &name, const std::string &parent, bool is_last,
                               mjcf_pose &origin)
{
    const checked_element checked(log_, found_, "joint", name);
    const std::string &class_name = class_of(checked, element, body.childclass);
    const TiXmlElement *in = defaults_.find(element, "type", class_name);
    const std::string type = in ? in->Attribute("type") : "hinge";
    if (type != "hinge" && type != "slide")
        checked.report(TFA_ERROR, *in, "unknown-joint-type",
                       "type " + quoted(type) +
                           " is not read; use hinge, slide or free, and for a ball three hinges "
                           "about axes at right angles in its body");
    checked.unknown_attributes(element, {"name",
                                         "class",
                                         "type",
                                         "group",
                                         "pos",
                                         "axis",
                                         "springdamper",
                                         "limited",
                                         "actuatorfrclimited",
                                         "solreflimit",
                                         "solimplimit",
                                         "solreffriction",
                                         "solimpfriction",
                                         "stiffness",
                                         "range",
                                         "actuatorfrcrange",
                                         "actuatorgravcomp",
                                         "margin",
                                         "ref",
                                         "springref",
                                         "armature",
                                         "damping",
                                         "frictionloss",
                                         "user"});
    mjcf_pose anchor;
    std::string unused;
    if (const TiXmlElement *at = defaults_.find(element, "pos", class_name))
        checked.vector(*at, "pos", unused, anchor.xyz);
    const bool here = anchor.xyz[0] == 0 && anchor.xyz[1] == 0 && anchor.xyz[2] == 0;
    const std::string child = is_last && here ? body.name : body.name + "/" + name;
    mjcf_joint &made = add_joint(name, element, parent, child, origin * anchor);
    made.source.type = type == "slide" ? TFA_JOINT_PRISMATIC : TFA_JOINT_CONTINUOUS;
    axis_joint(checked, element, class_name, made);
    if (made.reference != 0)
        apply_reference(made);
    if (child != body.name) {
        add_link(child, element);
        links.back().inertial = true; /* zeros, as meant */
    }
    origin = inverse(anchor);
    return child;
}

void mjcf_reader::body_joints(mjcf_body &body)
{
    std::vector<const TiXmlElement *> elements;
    for (const TiXmlElement *e : children_of(*body.element))
        if (e->ValueStr() == "joint" || e->ValueStr() == "freejoint")
            elements.push_back(e);
    std::string parent = body.parent;
    mjcf_pose origin = body.pose; /* of the body, in the frame of `parent` */
    for (size_t k = 0; k < elements.size(); k++) {
        const TiXmlElement &element = *elements[k];
        const std::string name =
            name_of(element, body.name + "/joint" + (k > 0 ? std::to_string(k + 1) : ""));
        if (is_free(element)) {
            free_joint(element, body, name);
            parent = body.name;
        } else {
            parent = joint(element, body, name, parent, k + 1 == elements.size(), origin);
            body.is_static = false;
        }
    }
    if (parent != body.name)
        add_joint((elements.empty() ? body.name : parent) + "/fixed", *body.element, parent,
                  body.name, origin);
}

} // namespace tfa
