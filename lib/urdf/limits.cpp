/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Limits of named joints.
 */
#include "urdf/mjcf.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <tinyxml.h>
#include <totalforce/limits.h>
#include <unordered_map>

namespace
{

/* Returns whether the attribute is there and a number. */
bool number(const TiXmlElement &limit, const char *attribute, double *value)
{
    const char *text = limit.Attribute(attribute);
    size_t length = 0;
    const char *start = text ? tfa_urdf_strip(text, &length) : nullptr;
    return start && tfa_number_read(start, length, value) == TFA_NUMBER_OK;
}

constexpr tfa_joint_limits no_limits = {0, 0, 0, INFINITY, INFINITY};

/* A magnitude; infinite if it is not there or negative */
double bound(const TiXmlElement &limit, const char *attribute)
{
    double value = 0;
    return number(limit, attribute, &value) && value >= 0 ? value : INFINITY;
}

tfa_joint_limits limits_of(const TiXmlElement &joint)
{
    tfa_joint_limits limits = no_limits;
    const char *type = joint.Attribute("type");
    const TiXmlElement *limit = joint.FirstChildElement("limit");
    if (!limit || !type)
        return limits;
    limits.velocity = bound(*limit, "velocity");
    limits.effort = bound(*limit, "effort");
    if (strcmp(type, "revolute") != 0 && strcmp(type, "prismatic") != 0)
        return limits;
    double lower = 0;
    double upper = 0;
    const bool has_lower = number(*limit, "lower", &lower);
    const bool has_upper = number(*limit, "upper", &upper);
    if ((has_lower || has_upper) && lower < upper) {
        limits.limited = 1;
        limits.lower = lower;
        limits.upper = upper;
    }
    return limits;
}

void read_joints(const TiXmlElement &robot, const char *const *names, size_t count,
                 tfa_joint_limits *limits)
{
    std::unordered_map<std::string, size_t> index;
    for (size_t k = 0; k < count; k++) {
        index.emplace(names[k], k);
        limits[k] = no_limits;
    }
    if (robot.ValueStr() == "mujoco")
        tfa::mjcf_limits(robot, names, count, limits);
    for (const TiXmlElement *joint = robot.FirstChildElement("joint"); joint;
         joint = joint->NextSiblingElement("joint")) {
        const char *name = joint->Attribute("name");
        const auto found = name ? index.find(name) : index.end();
        if (found != index.end())
            limits[found->second] = limits_of(*joint);
    }
}

/* The tags of the text as TinyXML may read them: bounded in depth and number, nothing else. */
int clean_text(const char *text, size_t length, char *clean)
{
    tfa_report report{};
    tfa_urdf_log log{};
    log.report = &report;
    const int status = tfa_urdf_check_xml(text, length, clean, &log);
    tfa_report_free(&report);
    return status;
}

} // namespace

int tfa_urdf_limits(const char *text, size_t length, const char *const *names, size_t count,
                    tfa_joint_limits *limits)
try {
    if (!text || (count > 0 && (!names || !limits)))
        return TFA_E_ARGUMENT;
    if (length > TFA_URDF_MAX_BYTES)
        return TFA_E_FILE;
    std::unique_ptr<char, decltype(&free)> clean(static_cast<char *>(malloc(length + 1)), &free);
    if (!clean)
        return TFA_E_MEMORY;
    const int status = clean_text(text, length, clean.get());
    if (status != TFA_OK)
        return status;
    TiXmlDocument document;
    document.Parse(clean.get(), nullptr, TIXML_ENCODING_UTF8);
    const TiXmlElement *robot = document.RootElement();
    if (document.Error() || !robot)
        return TFA_E_PARSE;
    read_joints(*robot, names, count, limits);
    return TFA_OK;
} catch (const std::bad_alloc &) {
    return TFA_E_MEMORY;
} catch (const std::exception &) {
    return TFA_E_PARSE;
}
