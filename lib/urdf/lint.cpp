/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checks every element of a URDF file that decides the robot, reports errors with their lines, and
 * writes the canonical text for urdfdom: checked elements only, numbers spelled as in the file.
 */
#include "urdf/lint.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>

namespace tfa
{

static std::string text_of(double number)
{
    char text[32];
    snprintf(text, sizeof text, "%g", number);
    return text;
}

/* --- links --------------------------------------------------------------------------------- */

/* Returns the rotation of the inertial frame. */
static tfa_rotation lint_inertial(const checked_element &checked, const TiXmlElement &inertial,
                                  std::string &out)
{
    checked.unknown_children(inertial, {"origin", "mass", "inertia"});
    double value = 0;
    out += "<inertial>";
    const tfa_rotation rotation = checked.pose(inertial, out);
    if (const TiXmlElement *mass = checked.required(inertial, "mass")) {
        out += "<mass";
        if (checked.required_number(*mass, "value", out, &value) && value < 0)
            checked.report(TFA_ERROR, *mass, "negative-mass",
                           "mass " + text_of(value) + " kg is negative; correct it");
        checked.unknown_attributes(*mass, {"value"});
        out += "/>";
    }
    if (const TiXmlElement *inertia = checked.required(inertial, "inertia")) {
        out += "<inertia";
        for (const char *name : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"})
            checked.required_number(*inertia, name, out, &value);
        checked.unknown_attributes(*inertia, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"});
        out += "/>";
    }
    out += "</inertial>";
    return rotation;
}

/* Finds xacro expressions in elements that dynamics does not use. */
void linter::find_macros(const std::string &link, const TiXmlElement &element)
{
    for (const TiXmlElement *e = &element; e; e = next_element(*e, element))
        for (const TiXmlAttribute *a = e->FirstAttribute(); a; a = a->Next()) {
            if (!has_xacro(a->ValueStr()))
                continue;
            if (macro_count_++ > 0)
                continue;
            macros_ = "link '" + link + "': " + describe(*a, *e);
            macro_line_ = line_of(*a);
        }
}

void linter::link(const TiXmlElement &element)
{
    const std::string *name = robot_.name(element, "name");
    if (!name) {
        broken_ = true;
        return;
    }
    checked_element checked(log_, &unused_, "link", *name);
    checked.unknown_children(element, {"inertial"}, {"visual", "collision", "material"});
    out_ += "<link";
    write_attribute(out_, "name", *name);
    out_ += ">";
    const TiXmlElement *inertial =
        checked.only_child(element, "inertial", TFA_ERROR, "duplicate-inertial");
    tfa_rotation rotation{{0, 0, 0, 1}, {}};
    if (inertial)
        rotation = lint_inertial(checked, *inertial, out_);
    for (const char *unused : {"visual", "collision"})
        for (const TiXmlElement *e = element.FirstChildElement(unused); e;
             e = e->NextSiblingElement(unused))
            find_macros(*name, *e);
    out_ += "</link>\n";
    links_.push_back({*name, line_of(element), inertial != nullptr, rotation});
}

/* --- joints -------------------------------------------------------------------------------- */

static bool joint_type(const checked_element &checked, const TiXmlElement &element,
                       tfa_joint_type &type)
{
    static const struct {
        const char *name;
        tfa_joint_type type;
    } types[] = {
        {"fixed", TFA_JOINT_FIXED},           {"revolute", TFA_JOINT_REVOLUTE},
        {"continuous", TFA_JOINT_CONTINUOUS}, {"prismatic", TFA_JOINT_PRISMATIC},
        {"planar", TFA_JOINT_PLANAR},         {"floating", TFA_JOINT_FLOATING},
    };
    const std::string *text = checked.name(element, "type");
    if (!text)
        return false;
    for (const auto &t : types) {
        type = t.type;
        if (*text == t.name)
            return true;
    }
    checked.report(
        TFA_ERROR, element, "unknown-joint-type",
        "type " + quoted(*text) +
            " does not exist; use fixed, revolute, continuous, prismatic, planar or floating");
    return false;
}

static void lint_axis(const checked_element &checked, const TiXmlElement &element,
                      joint_source &joint)
{
    joint.axis[0] = 1; /* URDF's default */
    const TiXmlElement *axis = checked.only_child(element, "axis");
    if (!axis || joint.type == TFA_JOINT_FIXED || joint.type == TFA_JOINT_FLOATING)
        return;
    std::string unused;
    if (!axis->Attribute("xyz"))
        checked.missing(*axis, "xyz");
    else if (checked.vector(*axis, "xyz", unused, joint.axis)) {
        double length = tfa_axis_normalise(joint.axis, joint.axis_low);
        if (length == 0)
            checked.report(TFA_ERROR, *axis, "zero-axis",
                           "axis 0 0 0 has no direction; give it a unit vector");
        else if (std::fabs(length - 1) > 1e-3)
            checked.report_grouped(TFA_WARNING, *axis, "axis-length",
                                   "axis has the length " + text_of(length) +
                                       " and is normalised; write a unit vector");
    }
    checked.unknown_attributes(*axis, {"xyz"});
}

static void lint_limit(const checked_element &checked, const TiXmlElement &element,
                       tfa_joint_type type)
{
    const TiXmlElement *limit = checked.only_child(element, "limit", TFA_WARNING);
    if (!limit && (type == TFA_JOINT_REVOLUTE || type == TFA_JOINT_PRISMATIC))
        checked.report_grouped(
            TFA_WARNING, element, "no-limit",
            "no <limit>; dynamics needs none, but other programs refuse the file: add it");
    if (!limit)
        return;
    std::string unused;
    double number;
    double lower = 0;
    double upper = 0;
    bool has_lower = checked.number(*limit, "lower", unused, &lower, TFA_WARNING, "bad-limit");
    bool has_upper = checked.number(*limit, "upper", unused, &upper, TFA_WARNING, "bad-limit");
    if (has_lower || has_upper)
        checked.not_used("position limits", *limit);
    for (const char *name : {"effort", "velocity"})
        if (checked.number(*limit, name, unused, &number, TFA_WARNING, "bad-limit"))
            checked.not_used(std::string(name) + " limits", *limit);
    checked.unused_attributes(*limit, {"lower", "upper", "effort", "velocity"});
    bool limited = type == TFA_JOINT_REVOLUTE || type == TFA_JOINT_PRISMATIC;
    if (limited && has_lower && has_upper && lower == upper)
        checked.report_grouped(TFA_NOTE, *limit, "equal-limits",
                               "lower and upper limit are both " + text_of(lower) +
                                   ", but dynamics lets it move; make it fixed if it cannot");
}

static void lint_mimic(const checked_element &checked, const TiXmlElement &element,
                       joint_source &joint, std::string &out)
{
    const TiXmlElement *mimic = checked.only_child(element, "mimic");
    if (!mimic)
        return;
    if (joint.type == TFA_JOINT_FIXED) {
        checked.report_grouped(TFA_WARNING, *mimic, "mimic-fixed",
                               "a fixed joint has a <mimic>, which is ignored; remove it");
        return;
    }
    if (joint.type == TFA_JOINT_PLANAR || joint.type == TFA_JOINT_FLOATING) {
        checked.report(TFA_ERROR, *mimic, "mimic-type",
                       "only a joint with one freedom can follow another; remove <mimic>");
        return;
    }
    const std::string *followed = checked.name(*mimic, "joint");
    if (!followed)
        return;
    double unused;
    joint.mimic = *followed;
    joint.mimic_line = line_of(*mimic);
    out += "<mimic";
    write_attribute(out, "joint", *followed);
    checked.number(*mimic, "multiplier", out, &unused);
    checked.number(*mimic, "offset", out, &unused);
    checked.unknown_attributes(*mimic, {"joint", "multiplier", "offset"});
    out += "/>";
}

static void lint_dynamics(const checked_element &checked, const TiXmlElement &element,
                          std::string &out)
{
    const TiXmlElement *dynamics = checked.only_child(element, "dynamics", TFA_WARNING);
    if (!dynamics)
        return;
    double damping = 0;
    double friction = 0;
    std::string text;
    checked.number(*dynamics, "damping", text, &damping);
    checked.number(*dynamics, "friction", text, &friction);
    checked.unused_attributes(*dynamics, {"damping", "friction"});
    if (!text.empty())
        out += "<dynamics" + text + "/>";
    if (damping < 0)
        checked.report_grouped(TFA_WARNING, *dynamics, "negative-damping",
                               "damping " + text_of(damping) +
                                   " is negative and adds energy; correct it");
    if (!dynamics->Attribute("damping") && !dynamics->Attribute("friction"))
        checked.report_grouped(
            TFA_WARNING, *dynamics, "empty-dynamics",
            "<dynamics> has neither damping nor friction; remove it or add them");
}

/* "drake:rotor_inertia" and "drake:gear_ratio" below `element`: rotor inertia seen by the joint. */
static double reflected_inertia(const checked_element &checked, const TiXmlElement &element)
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

static bool joint_end(const checked_element &checked, const TiXmlElement &element, const char *end,
                      std::string &link, std::string &out)
{
    const TiXmlElement *child = checked.required(element, end);
    const std::string *name = child ? checked.name(*child, "link") : nullptr;
    if (!name)
        return false;
    link = *name;
    out += std::string("<") + end;
    write_attribute(out, "link", link);
    out += "/>";
    return true;
}

void linter::joint(const TiXmlElement &element)
{
    joint_source joint{};
    const std::string *name = robot_.name(element, "name");
    if (!name) {
        broken_ = true;
        return;
    }
    checked_element checked(log_, &unused_, "joint", *name);
    checked.unknown_children(element,
                             {"origin", "parent", "child", "axis", "limit", "mimic", "dynamics"},
                             {"drake:rotor_inertia", "drake:gear_ratio"});
    joint.name = *name;
    joint.line = line_of(element);
    if (!joint_type(checked, element, joint.type)) {
        broken_ = true;
        return;
    }
    out_ += "<joint";
    write_attribute(out_, "name", *name);
    write_attribute(out_, "type", element.Attribute("type"));
    out_ += ">";
    joint.rotation = checked.pose(element, out_);
    broken_ |= !joint_end(checked, element, "parent", joint.parent, out_);
    broken_ |= !joint_end(checked, element, "child", joint.child, out_);
    lint_axis(checked, element, joint);
    lint_limit(checked, element, joint.type);
    if (joint.type == TFA_JOINT_REVOLUTE || joint.type == TFA_JOINT_PRISMATIC)
        out_ += R"(<limit effort="0" velocity="0"/>)"; /* urdfdom wants one */
    lint_mimic(checked, element, joint, out_);
    lint_dynamics(checked, element, out_);
    joint.armature = reflected_inertia(checked, element);
    out_ += "</joint>\n";
    joints_.push_back(joint);
}

/* --- robot --------------------------------------------------------------------------------- */

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
                           reflected_inertia(checked_element(log_, &unused_, "joint", *name), *a)});
    }
    if (!rotor) /* rotors are noted by the model, which uses them or not */
        robot_.not_used("<transmission>", element);
}

/* Reports the first unexpanded macro: the others have the same cause. */
static bool report_xacro(const checked_element &checked, const TiXmlElement &robot)
{
    for (const TiXmlElement *e = &robot; e; e = next_element(*e, robot)) {
        bool old_style =
            e->Parent() == &robot &&
            (e->ValueStr() == "macro" || e->ValueStr() == "property" || e->ValueStr() == "include");
        if (!old_style && e->ValueStr().compare(0, 6, "xacro:") != 0)
            continue;
        checked.report(TFA_ERROR, *e, "xacro",
                       std::string("<") + e->Value() + "> is not expanded; " + checked.run_xacro());
        return true;
    }
    return false;
}

void linter::children(const TiXmlElement &element)
{
    robot_.unknown_children(element, {"link", "joint", "transmission"}, {"material"});
    for (const TiXmlElement *e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
        if (e->ValueStr() == "link")
            link(*e);
        else if (e->ValueStr() == "joint")
            joint(*e);
        else if (e->ValueStr() == "transmission")
            transmission(*e);
    }
}

/* Command that converts another format to URDF, for a message */
static std::string conversion(const std::string &root, const std::string &file)
{
    if (root == "sdf" || root == "gazebo")
        return "this is SDF, not URDF; convert it: rosrun pysdf sdf2urdf.py " + file + " " + file +
               ".urdf (gz sdf converts the other way only)";
    if (root == "mujoco")
        return "this is MJCF, not URDF; convert it: python3 -c \"from mjcf_urdf_simple_converter "
               "import convert; convert('" +
               file + "', '" + file + ".urdf')\" (pip install mjcf-urdf-simple-converter)";
    return "a URDF file has <robot>; export URDF from the program that wrote the file";
}

void linter::robot(const TiXmlElement &element)
{
    if (element.ValueStr() != "robot") {
        robot_.report(TFA_ERROR, element, "not-urdf",
                      std::string("the root element is <") + element.Value() + ">; " +
                          conversion(element.ValueStr(), file_of(log_)));
        return;
    }
    if (report_xacro(robot_, element))
        return;
    if (const std::string *name = robot_.name(element, "name"))
        name_ = *name;
    const char *version = element.Attribute("version");
    if (version && strcmp(version, "1.0") != 0)
        robot_.report(TFA_NOTE, element, "version",
                      "version=" + quoted(version) + " is read as 1.0");
    children(element);
    if (links_.empty() && !broken_)
        robot_.report(TFA_ERROR, element, "no-links", "the robot has no links; add one");
    if (links_.size() > TFA_URDF_MAX_LINKS)
        robot_.report(TFA_ERROR, element, "too-large",
                      "the robot has " + std::to_string(links_.size()) + " links; at most " +
                          std::to_string(TFA_URDF_MAX_LINKS) + " are supported");
    else if (!links_.empty() && !name_.empty())
        resolve();
    if (macro_count_ > 0)
        tfa_urdf_report(log_, TFA_WARNING, macro_line_, "xacro",
                        "%s is an unexpanded xacro expression, harmless in <visual> and "
                        "<collision>; %s; expressions like it: %zu",
                        macros_.c_str(), robot_.run_xacro().c_str(), macro_count_);
}

} // namespace tfa

int tfa_urdf_lint(const char *clean, tfa_urdf_log *log, tfa_description **skeleton,
                  char **canonical) noexcept
try {
    TiXmlDocument document;
    document.Parse(clean, nullptr, TIXML_ENCODING_UTF8);
    const TiXmlElement *root = document.RootElement();
    if (document.Error() || !root) {
        tfa_urdf_report(log, TFA_ERROR, static_cast<uint32_t>(document.ErrorRow()), "bad-xml",
                        "xml: TinyXML cannot read it: %s", document.ErrorDesc());
        return TFA_E_PARSE;
    }
    tfa::linter linter(log);
    linter.robot(*root);
    return linter.finish(skeleton, canonical);
} catch (const std::bad_alloc &) {
    return TFA_E_MEMORY;
} catch (const std::exception &e) {
    tfa_urdf_report(log, TFA_ERROR, 0, "internal", "robot: %s", e.what());
    return TFA_E_PARSE;
}
