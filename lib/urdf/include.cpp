/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * <include> of MJCF: files become part of the text that is read, so that parsing opens none and a
 * recording of the text is complete.
 */
#include "urdf/element.hpp"

#include "model/report/report_messages.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <set>

namespace
{

struct refusal {
    uint32_t line; /* of the main file */
    std::string code, text;
};

using buffer = std::unique_ptr<char, decltype(&free)>;

/* The tags of a text; "" if it is not well-formed, with the first error. */
std::string tags_of(const char *text, size_t length, const std::string &name, refusal *error)
{
    tfa_report report{};
    tfa_urdf_log log{};
    log.report = &report;
    std::string clean(length + 1, ' ');
    const int status = tfa_urdf_check_xml(text, length, &clean[0], &log);
    if (status != TFA_OK && report.count > 0) {
        const tfa_message &m = report.messages[0];
        *error = {error->line, m.code, name + ":" + std::to_string(m.line) + ": " + m.text};
    }
    clean.resize(status == TFA_OK ? length : 0);
    tfa_report_free(&report);
    return clean;
}

size_t line_ends(const std::string &text)
{
    return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

class includer
{
  public:
    explicit includer(const std::string &path) : folder_(path.substr(0, path.rfind('/') + 1)) {}

    /* The tags of a text, with its <include>s replaced; `line`: of the main file, 0: this is it. */
    std::string expand(const std::string &clean, uint32_t line)
    {
        std::string out;
        size_t at = 0;
        for (size_t tag; (tag = clean.find("<include", at)) != std::string::npos;) {
            out.append(clean, at, tag - at);
            at = clean.find('>', tag) + 1;
            if (clean[at - 2] != '/') /* then </include> follows */
                at = std::min(clean.find('>', at), clean.size() - 1) + 1;
            const std::string element = clean.substr(tag, at - tag);
            const auto here = static_cast<uint32_t>(line_ends(clean.substr(0, tag)) + 1);
            out += included(element, line > 0 ? line : here);
            out.append(line_ends(element), '\n');
            if (out.size() > TFA_URDF_MAX_BYTES)
                throw refusal{line, "too-large", "robot: more than 64 MiB with its <include>s"};
        }
        return out + clean.substr(at);
    }

  private:
    std::string included(const std::string &element, uint32_t line)
    {
        TiXmlDocument parsed;
        parsed.Parse(element.c_str(), nullptr, TIXML_ENCODING_UTF8);
        const TiXmlElement *root = parsed.RootElement();
        const char *attribute = root ? root->Attribute("file") : nullptr;
        const std::string name = attribute ? attribute : "";
        refusal error{line, "bad-include", "robot: <include> of " + tfa::quoted(name)};
        if (name.empty() || name[0] == '/' || name.find_first_of(":$~\\") != std::string::npos ||
            ("/" + name + "/").find("/../") != std::string::npos)
            error.text += ": write the name of a file in the folder of the main file, or below it";
        else if (!seen_.insert(name).second || seen_.size() > 1000)
            error.text += " is a second one, or one of more than 1000; remove it";
        else
            return read(name, error);
        throw error;
    }

    std::string read(const std::string &name, refusal &error)
    {
        char *text = nullptr;
        size_t length = 0;
        char message[128];
        const int status = tfa_urdf_read_path((folder_ + name).c_str(), &text, &length);
        const buffer owner(text, &free);
        error.text += ": ";
        error.text +=
            status != TFA_OK ? strerror_r(errno, message, sizeof message) : "more than 64 MiB";
        if (status != TFA_OK || length > TFA_URDF_MAX_BYTES)
            throw error;
        const std::string clean = tags_of(text, length, name, &error);
        if (clean.empty())
            throw error;
        const std::string inside = expand(clean, error.line);
        std::string out = "<include";
        tfa::write_attribute(out, "file", name);
        tfa::write_attribute(out, "lines", std::to_string(line_ends(inside)));
        return out + ">" + inside + "</include>";
    }

    std::string folder_;
    std::set<std::string> seen_;
};

int include(const char *path, buffer &text, size_t *length, tfa_report *report)
try {
    if (*length > TFA_URDF_MAX_BYTES || !memmem(text.get(), *length, "<mujoco", 7) ||
        !memmem(text.get(), *length, "<include", 8))
        return TFA_OK;
    refusal unused{};
    const std::string clean = tags_of(text.get(), *length, "", &unused);
    const size_t root = clean.find('<');
    if (root == std::string::npos || clean.compare(root, 7, "<mujoco") != 0)
        return TFA_OK; /* another format, or an error that parsing reports */
    const std::string out = includer(path).expand(clean, 0);
    *length = out.size();
    text.reset(strdup(out.c_str()));
    return text ? TFA_OK : TFA_E_MEMORY;
} catch (const refusal &error) {
    tfa_report_begin(report);
    tfa_report_add(report, TFA_ERROR, error.line, error.code.c_str(), "%s", error.text.c_str());
    tfa_report_add_refused(report, nullptr);
    return TFA_E_PARSE;
} catch (const std::bad_alloc &) {
    return TFA_E_MEMORY;
} catch (const std::exception &) {
    return TFA_E_PARSE;
}

} // namespace

int tfa_mjcf_include(const char *path, char **text, size_t *length, tfa_report *report) noexcept
{
    buffer owner(*text, &free);
    const int status = include(path, owner, length, report);
    *text = status == TFA_OK ? owner.release() : nullptr;
    return status;
}
