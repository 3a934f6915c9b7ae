/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checked access to XML elements.
 */
#include "urdf/element.hpp"

#include "model/report/report_messages.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

namespace tfa
{

uint32_t line_of(const TiXmlBase &node)
{
    return static_cast<uint32_t>(std::max(node.Row(), 0));
}

std::string quoted(const std::string &value)
{
    constexpr size_t most = 60;
    std::string out = "\"";
    for (size_t i = 0; i < value.size() && i < most; i++) {
        unsigned char c = static_cast<unsigned char>(value[i]);
        char text[8];
        if (c == '\n')
            out += "\\n";
        else if (c == '\t')
            out += "\\t";
        else if (c < 0x20 || c == 0x7F) {
            snprintf(text, sizeof text, "\\x%02x", c);
            out += text;
        } else
            out += value[i];
    }
    return out + (value.size() > most ? "...\"" : "\"");
}

void write_attribute(std::string &out, const char *name, const std::string &value)
{
    out += ' ';
    out += name;
    out += "=\"";
    for (char c : value) {
        switch (c) {
        case '&':
            out += "&amp;";
            break;
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            out += c;
        }
    }
    out += '"';
}

static const TiXmlAttribute *find(const TiXmlElement &in, const char *name)
{
    for (const TiXmlAttribute *a = in.FirstAttribute(); a; a = a->Next())
        if (strcmp(a->Name(), name) == 0)
            return a;
    return nullptr;
}

bool has_xacro(const std::string &value)
{
    return value.find("${") != std::string::npos || value.find("$(") != std::string::npos;
}

std::string file_of(const tfa_urdf_log *log)
{
    const char *file = log->report->file;
    return file && file[0] != '\0' && file[0] != '(' ? file : "FILE";
}

bool is_printable(const std::string &name)
{
    return std::none_of(name.begin(), name.end(),
                        [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

static bool is_known(const char *name, std::initializer_list<const char *> known)
{
    return std::any_of(known.begin(), known.end(),
                       [name](const char *k) { return strcmp(k, name) == 0; });
}

std::string describe(const TiXmlAttribute &attribute, const TiXmlElement &in)
{
    return std::string(attribute.Name()) + "=" + quoted(attribute.ValueStr()) + " of <" +
           in.Value() + ">";
}

const TiXmlElement *next_element(const TiXmlElement &element, const TiXmlElement &top)
{
    if (const TiXmlElement *child = element.FirstChildElement())
        return child;
    for (const TiXmlNode *at = &element; at != &top; at = at->Parent())
        if (const TiXmlElement *next = at->NextSiblingElement())
            return next;
    return nullptr;
}

void unused_items::add(const std::string &item, uint32_t line)
{
    for (entry &e : entries_)
        if (e.item == item) {
            e.count++;
            return;
        }
    if (entries_.size() == most)
        entries_.push_back({"other elements", line, 0});
    if (entries_.size() > most)
        entries_.back().count++;
    else
        entries_.push_back({item, line, 1});
}

std::string checked_element::entity() const
{
    return name_.empty() ? kind_ : std::string(kind_) + " '" + name_ + "'";
}

void checked_element::report(tfa_severity severity, const TiXmlBase &at, const char *code,
                             const std::string &what) const
{
    tfa_urdf_report(log_, severity, line_of(at), code, "%s: %s", entity().c_str(), what.c_str());
}

void checked_element::report_grouped(tfa_severity severity, const TiXmlBase &at, const char *code,
                                     const std::string &what) const
{
    char prefix[300];
    log_->errors += severity == TFA_ERROR;
    const uint32_t line = tfa_urdf_place(log_, line_of(at), prefix, sizeof prefix);
    tfa_report_add_grouped(log_->report, severity, line, code, kind_[0] == 'l' ? "links" : "joints",
                           name_.c_str(), "%s%s: %s", prefix, entity().c_str(), what.c_str());
}

std::string checked_element::run_xacro() const
{
    const std::string file = file_of(log_);
    const std::string ending = ".xacro", urdf = ".urdf";
    std::string to = file;
    if (to.size() > ending.size() &&
        to.compare(to.size() - ending.size(), std::string::npos, ending) == 0)
        to.resize(to.size() - ending.size());
    if (to == file || to.size() < urdf.size() ||
        to.compare(to.size() - urdf.size(), std::string::npos, urdf) != 0)
        to += urdf;
    return "run xacro first: xacro " + file + " > " + to;
}

const TiXmlElement *checked_element::only_child(const TiXmlElement &in, const char *name,
                                                tfa_severity severity, const char *code) const
{
    const TiXmlElement *first = in.FirstChildElement(name);
    const TiXmlElement *second = first ? first->NextSiblingElement(name) : nullptr;
    if (second)
        report(severity, *second, code,
               std::string("a second <") + name + ">, the first is on line " +
                   std::to_string(line_of(*first)) +
                   (severity == TFA_ERROR ? "; remove one" : ", which counts; remove one"));
    return first;
}

const TiXmlElement *checked_element::required(const TiXmlElement &in, const char *name) const
{
    const TiXmlElement *element = only_child(in, name);
    if (!element)
        report(TFA_ERROR, in, "missing-element",
               std::string("<") + in.Value() + "> has no <" + name + ">; add it");
    return element;
}

void checked_element::missing(const TiXmlElement &in, const char *attribute) const
{
    report(TFA_ERROR, in, "missing-attribute",
           std::string("<") + in.Value() + "> has no " + attribute + "; add " + attribute +
               "=\"...\"");
}

const std::string *checked_element::name(const TiXmlElement &in, const char *attribute) const
{
    const TiXmlAttribute *a = find(in, attribute);
    if (!a) {
        missing(in, attribute);
        return nullptr;
    }
    if (a->ValueStr().empty()) {
        report(TFA_ERROR, *a, "empty-name", describe(*a, in) + " is empty; give it a name");
        return nullptr;
    }
    const std::string &value = a->ValueStr();
    if (has_xacro(value)) {
        report(TFA_ERROR, *a, "xacro",
               describe(*a, in) + " is an unexpanded xacro expression; " + run_xacro());
        return nullptr;
    }
    if (value.size() > TFA_URDF_MAX_NAME) {
        report(TFA_ERROR, *a, "long-name",
               describe(*a, in) + " has " + std::to_string(value.size()) + " bytes; use at most " +
                   std::to_string(TFA_URDF_MAX_NAME));
        return nullptr;
    }
    if (!is_printable(value)) {
        report(TFA_ERROR, *a, "bad-name",
               describe(*a, in) + " holds a control character; remove it");
        return nullptr;
    }
    return &value;
}

bool checked_element::fault(const TiXmlAttribute &a, const TiXmlElement &in,
                            const std::string &token, tfa_number_fault fault, tfa_severity severity,
                            const char *code) const
{
    const char *kind = "bad-number";
    const char *what =
        "is not a number; write digits, point and exponent without blanks or units, such as 1.5e-3";
    if (fault == TFA_NUMBER_OK)
        return true;
    if (fault == TFA_NUMBER_UNDERFLOW) {
        kind = "underflow";
        what = "is smaller than any number of double precision; write 0 if that is meant";
    } else if (fault == TFA_NUMBER_OVERFLOW) {
        kind = "overflow";
        what = "is larger than any number of double precision; correct it";
    }
    std::string which = token == a.ValueStr() ? " " : ": " + quoted(token) + " ";
    if (has_xacro(a.ValueStr()))
        report(severity, a, "xacro",
               describe(a, in) + " is an unexpanded xacro expression; " + run_xacro());
    else
        report(severity, a, code ? code : kind, describe(a, in) + which + what);
    return false;
}

bool checked_element::number(const TiXmlElement &in, const char *attribute, std::string &out,
                             double *value, tfa_severity severity, const char *code) const
{
    const TiXmlAttribute *a = find(in, attribute);
    if (!a)
        return false;
    size_t length = 0;
    const char *start = tfa_urdf_strip(a->Value(), &length);
    const std::string text(start, length);
    if (!fault(*a, in, text, tfa_number_read(text.c_str(), length, value), severity, code))
        return false;
    if (text != a->ValueStr())
        count(found_->blanks, *a, describe(*a, in));
    write_attribute(out, attribute, text);
    return true;
}

bool checked_element::required_number(const TiXmlElement &in, const char *attribute,
                                      std::string &out, double *value) const
{
    if (find(in, attribute))
        return number(in, attribute, out, value);
    missing(in, attribute);
    return false;
}

static std::vector<std::string> split(const std::string &text, size_t most)
{
    std::vector<std::string> tokens;
    for (size_t at = 0; at < text.size() && tokens.size() < most;) {
        size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
        if (end > at)
            tokens.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return tokens;
}

bool checked_element::vector(const TiXmlElement &in, const char *attribute, std::string &out,
                             double *value, size_t length, size_t least) const
{
    const TiXmlAttribute *a = find(in, attribute);
    if (!a)
        return false;
    std::vector<std::string> tokens = split(a->ValueStr(), length + 2);
    std::string text; /* for urdfdom a tab or a line end is part of a number */
    for (size_t i = 0; i < tokens.size(); i++) {
        double unused;
        double *to = i < length ? &value[i] : &unused;
        text += (i > 0 ? " " : "") + tokens[i];
        if (!fault(*a, in, tokens[i], tfa_number_read(tokens[i].c_str(), tokens[i].size(), to),
                   TFA_ERROR, nullptr))
            return false;
    }
    if (tokens.size() > length || tokens.size() < (least > 0 ? least : length)) {
        std::string many = tokens.size() > length + 1 ? "more than " + std::to_string(length + 1)
                                                      : std::to_string(tokens.size());
        report(TFA_ERROR, *a, "bad-vector",
               describe(*a, in) + " has " + many + " numbers; write " +
                   (length == 3   ? "three"
                    : length == 4 ? "four"
                                  : (least > 0 ? "at most " : "") + std::to_string(length)) +
                   " with blanks between them");
        return false;
    }
    if (a->ValueStr().find_first_of("\t\r\n") != std::string::npos)
        count(found_->blanks, *a, describe(*a, in));
    write_attribute(out, attribute, text);
    return true;
}

/* urdfdom's default; a negative zero is not */
static bool all_zero(const double value[3])
{
    static const double zero[3] = {0, 0, 0};
    return memcmp(value, zero, sizeof zero) == 0;
}

void checked_element::angles(const TiXmlElement &origin, tfa_rotation &rotation) const
{
    constexpr double turn = 6.2831853071795865, rounding = 1e-3;
    double rpy[3];
    std::string unused;
    if (!vector(origin, "rpy", unused, rpy))
        return;
    tfa_rotation_from_rpy(rpy, &rotation);
    const double *most = std::max_element(
        rpy, rpy + 3, [](double a, double b) { return std::fabs(a) < std::fabs(b); });
    if (std::fabs(*most) < turn + rounding)
        return;
    char text[128];
    snprintf(text, sizeof text,
             ": %g rad are %.1f turns; is it in degrees? rpy is in rad: multiply by pi/180", *most,
             *most / turn);
    report_grouped(TFA_WARNING, origin, "odd-angle", describe(*find(origin, "rpy"), origin) + text);
}

void checked_element::quaternion(const TiXmlElement &origin, tfa_rotation &rotation) const
{
    const TiXmlAttribute *a = find(origin, "quat_xyzw");
    double xyzw[4];
    std::string unused;
    if (!a)
        return;
    if (!found_->quaternions)
        report(TFA_ERROR, *a, "quaternion-origin",
               "<origin> has quat_xyzw, which URDF 1.0 does not know; write rpy instead, or "
               "version=\"1.1\" in <robot>");
    else if (find(origin, "rpy"))
        report(TFA_ERROR, *a, "quaternion-origin",
               "<origin> has rpy and quat_xyzw; remove one of them");
    else if (vector(origin, "quat_xyzw", unused, xyzw, 4) &&
             !(std::fabs(tfa_rotation_from_xyzw(xyzw, &rotation) - 1) <= 1e-3))
        report(TFA_ERROR, *a, "bad-quaternion",
               describe(*a, origin) + " is no rotation: its norm is not 1; correct it");
}

tfa_rotation checked_element::rotation(const TiXmlElement &in) const
{
    tfa_rotation rotation{{0, 0, 0, 1}, {}};
    angles(in, rotation);
    quaternion(in, rotation);
    return rotation;
}

/* Zeros are not written: urdfdom's conversion of numbers takes half the time of a load. */
tfa_rotation checked_element::pose(const TiXmlElement &in, std::string &out) const
{
    const TiXmlElement *origin = only_child(in, "origin");
    if (!origin)
        return {{0, 0, 0, 1}, {}};
    double xyz[3];
    std::string text;
    if (vector(*origin, "xyz", text, xyz) && !all_zero(xyz))
        out += "<origin" + text + "/>";
    unknown_attributes(*origin, {"xyz", "rpy", "quat_xyzw"});
    return rotation(*origin);
}

static const char *name_at(const void *list, size_t index)
{
    return static_cast<const char *const *>(list)[index];
}

void checked_element::unknown_children(const TiXmlElement &in,
                                       std::initializer_list<const char *> known,
                                       std::initializer_list<const char *> silent) const
{
    for (const TiXmlElement *e = in.FirstChildElement(); e; e = e->NextSiblingElement()) {
        const char *name = e->Value();
        if (is_known(name, known) || is_known(name, silent))
            continue;
        const char *meant = nullptr;
        if (!strchr(name, ':')) /* not a name space of another program */
            meant = tfa_misspelled(name, known.begin(), known.size(), name_at);
        if (meant)
            report(TFA_ERROR, *e, "misspelled-element",
                   std::string("<") + name + "> in <" + in.Value() + ">: did you mean <" + meant +
                       ">?");
        else
            not_used(std::string("<") + name + ">", *e);
    }
}

void checked_element::unused_attributes(const TiXmlElement &in,
                                        std::initializer_list<const char *> known) const
{
    for (const TiXmlAttribute *a = in.FirstAttribute(); a; a = a->Next())
        if (!is_known(a->Name(), known))
            not_used(std::string(a->Name()) + " of <" + in.Value() + ">", *a);
}

void checked_element::unknown_attributes(const TiXmlElement &in,
                                         std::initializer_list<const char *> known) const
{
    for (const TiXmlAttribute *a = in.FirstAttribute(); a; a = a->Next())
        if (!is_known(a->Name(), known) && !strchr(a->Name(), ':'))
            report(TFA_WARNING, *a, "unknown-attribute",
                   std::string(a->Name()) + " of <" + in.Value() +
                       "> is ignored; is it misspelled?");
}

} // namespace tfa
