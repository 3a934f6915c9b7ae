/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checks every element of a URDF file that decides the robot, reports errors with their lines, and
 * writes the canonical text for urdfdom: checked elements only, numbers spelled as in the file.
 */
#include "urdf/lint.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace tfa
{

std::string text_of(double number)
{
    char text[32];
    snprintf(text, sizeof text, "%g", number);
    return text;
}

/* --- links --------------------------------------------------------------------------------- */

/* Unit of the last printed decimal of a number, 1 for a whole number */
static double last_digit(const char *text)
{
    const char *exponent = strpbrk(text, "eE");
    const char *point = strchr(text, '.');
    const size_t length = exponent ? static_cast<size_t>(exponent - text) : strlen(text);
    const long decimals = point ? static_cast<long>(text + length - point) - 1 : 0;
    return std::pow(10.0, (exponent ? strtod(exponent + 1, nullptr) : 0.0) -
                              static_cast<double>(decimals));
}

/* iyx, izx and izy, which some writers add, must be ixy, ixz and iyz. */
static void lint_lower_entries(const checked_element &checked, const TiXmlElement &inertia,
                               const double upper[6], file_findings &found)
{
    static const struct {
        const char *lower, *upper;
        int entry;
    } pairs[] = {{"iyx", "ixy", 1}, {"izx", "ixz", 2}, {"izy", "iyz", 4}};
    const double rounding =
        1e-6 * (std::fabs(upper[0]) + std::fabs(upper[3]) + std::fabs(upper[5]));
    bool twice = false;
    bool symmetric = true;
    for (const auto &pair : pairs) {
        double lower = 0;
        std::string unused;
        if (!checked.number(inertia, pair.lower, unused, &lower))
            continue;
        twice = true;
        if (std::fabs(lower - upper[pair.entry]) <= rounding)
            continue;
        symmetric = false;
        checked.report(TFA_ERROR, inertia, "asymmetric-inertia",
                       std::string(pair.lower) + "=" + text_of(lower) + " of <inertia>, but " +
                           pair.upper + "=" + text_of(upper[pair.entry]) +
                           "; a tensor of inertia is symmetric: correct one of them");
    }
    if (twice && symmetric)
        checked.count(found.twice, inertia,
                      "iyx, izx and izy of <inertia> say again what ixy, ixz and iyz say");
}

static void lint_inertia(const checked_element &checked, const TiXmlElement &inertia,
                         link_source &link, file_findings &found, std::string &out)
{
    static const char *const names[] = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
    double value[6] = {};
    bool all = true;
    out += "<inertia";
    link.last_digit = 1;
    for (int k = 0; k < 6; k++) {
        all &= checked.required_number(inertia, names[k], out, &value[k]);
        if (all)
            link.last_digit = std::fmin(link.last_digit, last_digit(inertia.Attribute(names[k])));
    }
    if (all)
        lint_lower_entries(checked, inertia, value, found);
    checked.unknown_attributes(inertia,
                               {"ixx", "ixy", "ixz", "iyy", "iyz", "izz", "iyx", "izx", "izy"});
    out += "/>";
}

static void lint_inertial(const checked_element &checked, const TiXmlElement &inertial,
                          link_source &link, file_findings &found, std::string &out)
{
    checked.unknown_children(inertial, {"origin", "mass", "inertia"});
    double value = 0;
    out += "<inertial>";
    link.rotation = checked.pose(inertial, out);
    if (const TiXmlElement *mass = checked.required(inertial, "mass")) {
        out += "<mass";
        if (checked.required_number(*mass, "value", out, &value) && value < 0)
            checked.report(TFA_ERROR, *mass, "negative-mass",
                           "mass " + text_of(value) + " kg is negative; correct it");
        checked.unknown_attributes(*mass, {"value"});
        out += "/>";
    }
    if (const TiXmlElement *inertia = checked.required(inertial, "inertia"))
        lint_inertia(checked, *inertia, link, found, out);
    out += "</inertial>";
}

/* Finds xacro expressions in elements that dynamics does not use. */
void linter::find_macros(const std::string &link, const TiXmlElement &element)
{
    for (const TiXmlElement *e = &element; e; e = next_element(*e, element))
        for (const TiXmlAttribute *a = e->FirstAttribute(); a; a = a->Next())
            if (has_xacro(a->ValueStr()))
                found_.macros.add("link '" + link + "': " + describe(*a, *e), *a);
}

void linter::link(const TiXmlElement &element)
{
    const std::string *name = robot_.name(element, "name");
    if (!name) {
        broken_ = true;
        return;
    }
    checked_element checked(log_, &found_, "link", *name);
    checked.unknown_children(element, {"inertial"}, {"visual", "collision", "material"});
    out_ += "<link";
    write_attribute(out_, "name", *name);
    out_ += ">";
    const TiXmlElement *inertial =
        checked.only_child(element, "inertial", TFA_ERROR, "duplicate-inertial");
    link_source link{*name, line_of(element), inertial != nullptr, {{0, 0, 0, 1}, {}}, 1};
    if (inertial)
        lint_inertial(checked, *inertial, link, found_, out_);
    for (const char *unused : {"visual", "collision"})
        for (const TiXmlElement *e = element.FirstChildElement(unused); e;
             e = e->NextSiblingElement(unused))
            find_macros(*name, *e);
    out_ += "</link>\n";
    links_.push_back(link);
}

/* --- joints -------------------------------------------------------------------------------- */

static bool joint_type(const checked_element &checked, const TiXmlElement &element,
                       tfa_joint_type &type)
{
#define ROW(type, word) {word, type},
    static const struct {
        const char *name;
        tfa_joint_type type;
    } types[] = {TFA_JOINT_TYPE_WORDS(ROW)};
    static const char three[] = "three revolute joints about axes at right angles";
    static const struct {
        const char *name, *how;
    } written_out[] = {
        {"ball", three},
        {"spherical", three},
        {"universal", "two revolute joints about axes at right angles"},
        {"cylindrical", "a revolute and a prismatic joint along one axis"},
    };
    const std::string *text = checked.name(element, "type");
    if (!text)
        return false;
    std::string how;
    for (const auto &t : types) {
        type = t.type;
        if (*text == t.name)
            return true;
        how += how.empty() ? "use " : &t + 1 == std::end(types) ? " or " : ", ";
        how += t.name;
    }
    for (const auto &known : written_out)
        if (*text == known.name)
            how = std::string("write ") + known.how +
                  " with links without <inertial> between them, which become one joint here";
    checked.report(TFA_ERROR, element, "unknown-joint-type",
                   "type " + quoted(*text) + " does not exist; " + how);
    return false;
}

static void lint_axis(const checked_element &checked, const TiXmlElement &element,
                      joint_source &joint)
{
    joint.axis[0] = 1; /* URDF's default */
    const TiXmlElement *axis = checked.only_child(element, "axis");
    if (!axis || joint.type == TFA_JOINT_FIXED ||
        tfa_joint_type_describe(joint.type).quaternion >= 0)
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
    if (tfa_joint_type_describe(joint.type).freedoms != 1) {
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
    static const char *const numbers[][2] = {{"damping", "negative-damping"},
                                             {"friction", "negative-friction"}};
    std::string text;
    for (const auto &[name, code] : numbers) {
        double value = 0;
        checked.number(*dynamics, name, text, &value);
        if (value < 0)
            checked.report_grouped(TFA_WARNING, *dynamics, code,
                                   std::string(name) + " " + text_of(value) +
                                       " is negative and adds energy; correct it");
    }
    checked.unused_attributes(*dynamics, {"damping", "friction"});
    if (!text.empty())
        out += "<dynamics" + text + "/>";
    if (!dynamics->Attribute("damping") && !dynamics->Attribute("friction"))
        checked.report_grouped(
            TFA_WARNING, *dynamics, "empty-dynamics",
            "<dynamics> has neither damping nor friction; remove it or add them");
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
    checked_element checked(log_, &found_, "joint", *name);
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
    joint.rotor = reflected_inertia(checked, element);
    out_ += "</joint>\n";
    joints_.push_back(joint);
}

/* --- robot --------------------------------------------------------------------------------- */

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
    robot_.unknown_children(element, {"link", "joint", "transmission"},
                            {"material", "loop_joint", "xi:include", "drake:joint"});
    for (const TiXmlElement *e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
        if (e->ValueStr() == "link")
            link(*e);
        else if (e->ValueStr() == "joint")
            joint(*e);
        else if (e->ValueStr() == "transmission")
            transmission(*e);
        else if (e->ValueStr() == "loop_joint")
            loop_joint(*e);
    }
}

/* Command that converts another format to URDF, for a message */
static std::string conversion(const std::string &root, const std::string &file)
{
    if (root == "sdf" || root == "gazebo")
        return "this is SDF, not URDF; convert it: rosrun pysdf sdf2urdf.py " + file + " " + file +
               ".urdf (gz sdf converts the other way only)";
    return "a URDF file has <robot>, MJCF <mujoco>; export URDF from the program that wrote the "
           "file";
}

void linter::attributes(const TiXmlElement &robot)
{
    const char *name = robot.Attribute("name");
    if (!name || !*name) {
        name_ = "robot";
        robot_.report(TFA_WARNING, robot, "no-name",
                      "<robot> has no name, other programs refuse the file; called \"robot\" here: "
                      "add name=\"...\"");
    } else if (robot_.name(robot, "name"))
        name_ = name;
    const char *version = robot.Attribute("version");
    double number = 1;
    if (version && tfa_number_read(version, strlen(version), &number) != TFA_NUMBER_OK)
        number = 0;
    found_.quaternions = number >= 1.1;
    if (number < 1 || number > 1.2)
        robot_.report(TFA_NOTE, robot, "version",
                      "version=" + quoted(version) + " is read as " + (number > 1 ? "1.2" : "1.0"));
}

void report_tally(tfa_urdf_log *log, tfa_severity severity, const char *code, const tally &t,
                  const std::string &what)
{
    if (t.count > 0)
        tfa_urdf_report(log, severity, t.line, code, "%s%s: %zu", t.first.c_str(), what.c_str(),
                        t.count);
}

void linter::report_tallies() const
{
    report_tally(log_, TFA_WARNING, "xacro", found_.macros,
                 " is an unexpanded xacro expression, harmless in <visual> and <collision>; " +
                     robot_.run_xacro() + "; expressions like it");
    report_tally(log_, TFA_WARNING, "white-space", found_.blanks,
                 " has white space that other programs refuse and that is left out; remove it; "
                 "attributes like it");
    report_tally(log_, TFA_NOTE, "nine-entries", found_.twice, "; links like it");
    if (log_->errors == 0)
        report_tally(log_, TFA_WARNING, "loop-joint", found_.loops,
                     "; forward_dynamics and other ops answer the open tree, constrained_dynamics, "
                     "impact and constrained_inverse_dynamics apply it; loop joints");
}

void linter::robot(const TiXmlElement &element)
{
    const bool is_mjcf = element.ValueStr() == "mujoco";
    if (!is_mjcf && element.ValueStr() != "robot") {
        robot_.report(TFA_ERROR, element, "not-urdf",
                      std::string("the root element is <") + element.Value() + ">; " +
                          conversion(element.ValueStr(), file_of(log_)));
        return;
    }
    if (!is_mjcf && report_xacro(robot_, element))
        return;
    if (is_mjcf)
        mujoco(element);
    else {
        attributes(element);
        lint_lost_elements(element, log_, &found_);
        children(element);
    }
    if (links_.empty() && !broken_)
        robot_.report(TFA_ERROR, element, "no-links", "the robot has no links; add one");
    if (links_.size() > TFA_URDF_MAX_LINKS)
        robot_.report(TFA_ERROR, element, "too-large",
                      "the robot has " + std::to_string(links_.size()) + " links; at most " +
                          std::to_string(TFA_URDF_MAX_LINKS) + " are supported");
    else if (!links_.empty() && !name_.empty())
        resolve();
    report_tallies();
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
