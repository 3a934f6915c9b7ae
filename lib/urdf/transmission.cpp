/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transmissions: rotors of the file, and the reductions between joints and motors.
 */
#include "urdf/lint.hpp"

#include <cmath>

namespace tfa
{

double reflected_inertia(const checked_element &checked, const TiXmlElement &element)
{
    const TiXmlElement *rotor = checked.only_child(element, "drake:rotor_inertia");
    const TiXmlElement *gear = checked.only_child(element, "drake:gear_ratio");
    double inertia = 0;
    double ratio = 1;
    std::string unused;
    if (gear)
        checked.required_number(*gear, "value", unused, &ratio);
    if (!rotor || !checked.required_number(*rotor, "value", unused, &inertia))
        return 0;
    double reflected = inertia * ratio * ratio;
    if (!(reflected >= 0) || !std::isfinite(reflected)) {
        checked.report(TFA_ERROR, *rotor, "bad-armature",
                       "rotor inertia " + text_of(inertia) + " kg m^2 and gear ratio " +
                           text_of(ratio) + " give no finite armature; correct them");
        return 0;
    }
    return reflected;
}

/* <mechanicalReduction> below `in`; 0: none */
static double reduction_below(const checked_element &joint, const TiXmlElement &in)
{
    const TiXmlElement *e = in.FirstChildElement("mechanicalReduction");
    if (!e)
        return 0;
    double value = 0;
    size_t length = 0;
    const std::string text = e->GetText() ? e->GetText() : "";
    const char *start = tfa_urdf_strip(text.c_str(), &length);
    if (tfa_number_read(start, length, &value) == TFA_NUMBER_OK && value != 0)
        return value;
    joint.report_grouped(TFA_WARNING, *e, "bad-reduction",
                         "<mechanicalReduction> " + quoted(text) +
                             " is not a number other than 0 and does not count; correct it");
    return 0;
}

/* ROS files state it of the actuator or of the joint, the oldest of the transmission. Only with one
 * joint it is clear which one an actuator drives. */
void linter::read_reductions(const TiXmlElement &element)
{
    const TiXmlElement *only = element.FirstChildElement("joint");
    const bool is_one = only && !only->NextSiblingElement("joint");
    const auto read = [&](const TiXmlElement *joint, const TiXmlElement &in) {
        const std::string *name = joint ? joint->Attribute(std::string("name")) : nullptr;
        if (!name || !is_printable(*name))
            return;
        const double value = reduction_below(checked_element(log_, &found_, "joint", *name), in);
        if (value != 0)
            reductions_.push_back({*name, line_of(in), value});
    };
    for (const TiXmlElement *e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
        if (e->ValueStr() == "joint")
            read(e, *e);
        else if (e->ValueStr() == "actuator" && is_one)
            read(only, *e);
    }
    if (is_one)
        read(only, element);
}

void linter::transmission(const TiXmlElement &element)
{
    const std::string *name = nullptr;
    bool rotor = false;
    for (const TiXmlElement *a = element.FirstChildElement("actuator"); a;
         a = a->NextSiblingElement("actuator")) {
        if (!a->FirstChildElement("drake:rotor_inertia"))
            continue;
        const TiXmlElement *joint = name ? nullptr : robot_.required(element, "joint");
        name = joint ? robot_.name(*joint, "name") : name;
        if (!name)
            return; /* reported */
        rotor = true;
        rotors_.push_back({*name, line_of(*a),
                           reflected_inertia(checked_element(log_, &found_, "joint", *name), *a)});
    }
    read_reductions(element);
    if (!rotor) /* rotors are noted by the model, which uses them or not */
        robot_.not_used("<transmission>", element);
}

void linter::resolve_rotors(const index &joints)
{
    for (const transmission_source &rotor : rotors_) {
        auto at = joints.find(rotor.joint);
        if (at == joints.end())
            tfa_urdf_report(log_, TFA_ERROR, rotor.line, "unknown-joint",
                            "joint '%s': a <transmission> has a rotor for it, but it does not "
                            "exist; correct the name",
                            rotor.joint.c_str());
        else
            joints_[at->second].rotor += rotor.value;
    }
}

/* Of a joint that does not exist nothing reads it. */
void linter::resolve_reductions(const index &joints)
{
    for (const transmission_source &reduction : reductions_) {
        auto at = joints.find(reduction.joint);
        if (at == joints.end())
            continue;
        double &first = joints_[at->second].reduction;
        if (first == 0)
            first = reduction.value;
        else if (std::fabs(first) != std::fabs(reduction.value))
            tfa_urdf_report(log_, TFA_WARNING, reduction.line, "several-reductions",
                            "joint '%s': a reduction of %s besides the first one, %s, which "
                            "counts; remove one",
                            reduction.joint.c_str(), text_of(reduction.value).c_str(),
                            text_of(first).c_str());
    }
}

} // namespace tfa
