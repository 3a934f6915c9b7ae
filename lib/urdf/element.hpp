/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checked access to XML elements: what is asked for is right and copied, or a message says why not.
 */
#ifndef TFA_URDF_ELEMENT_HPP
#define TFA_URDF_ELEMENT_HPP

#include "urdf/urdf.h"

#include <initializer_list>
#include <string>
#include <tinyxml.h>
#include <vector>

namespace tfa
{

uint32_t line_of(const TiXmlBase &node);

/* The value as it may be printed: quoted, control characters escaped, not too long. */
std::string quoted(const std::string &value);

/* Does the value hold an expression that xacro would have replaced? */
bool has_xacro(const std::string &value);

/* The name of the file, for a command that reads it; "FILE" for standard input. */
std::string file_of(const tfa_urdf_log *log);

/* "value="1,5" of <mass>" */
std::string describe(const TiXmlAttribute &attribute, const TiXmlElement &in);

/* The element after this one in document order, below `top`; nullptr at the end. No recursion. */
const TiXmlElement *next_element(const TiXmlElement &element, const TiXmlElement &top);

/* Appends ` name="value"` with the value escaped. */
void write_attribute(std::string &out, const char *name, const std::string &value);

/* What the file says and dynamics does not use, by name, in order of first appearance. */
class unused_items
{
  public:
    struct entry {
        std::string item;
        uint32_t line;
        size_t count;
    };

    void add(const std::string &item, uint32_t line);
    const std::vector<entry> &entries() const
    {
        return entries_;
    }

  private:
    static constexpr size_t most = 100; /* names; a file with more is odd, and must not be slow */
    std::vector<entry> entries_;
};

/* One link or joint (or the robot) while it is being checked. */
class checked_element
{
  public:
    checked_element(tfa_urdf_log *log, unused_items *unused, const char *kind,
                    std::string name = "")
        : log_(log), unused_(unused), kind_(kind), name_(std::move(name))
    {
    }

    /* "link 'NAME': what" */
    void report(tfa_severity severity, uint32_t line, const char *code,
                const std::string &what) const;

    /* The same of a link or joint, for what many can have alike: one message for all of them. */
    void report_grouped(tfa_severity severity, uint32_t line, const char *code,
                        const std::string &what) const;

    /* "run xacro first: xacro FILE > FILE.urdf" */
    std::string run_xacro() const;

    /* The element, or something in it, is not used. */
    void not_used(const std::string &item, uint32_t line) const
    {
        unused_->add(item, line);
    }

    /* The first child of that name; a second one is reported. */
    const TiXmlElement *only_child(const TiXmlElement &in, const char *name,
                                   tfa_severity severity = TFA_ERROR,
                                   const char *code = "duplicate-element") const;

    /* As one(), but reports when there is none. */
    const TiXmlElement *required(const TiXmlElement &in, const char *name) const;

    /* Reports that the attribute is missing. */
    void missing(const TiXmlElement &in, const char *attribute) const;

    /* The attribute's value or nullptr, which is reported; a name has 1 to 255 plain bytes. */
    const std::string *name(const TiXmlElement &in, const char *attribute) const;

    /* Checks one number and appends the attribute to `out`. False if absent or malformed. */
    bool number(const TiXmlElement &in, const char *attribute, std::string &out, double *value,
                tfa_severity severity = TFA_ERROR, const char *code = nullptr) const;

    /* As number(), but reports when there is none. */
    bool required_number(const TiXmlElement &in, const char *attribute, std::string &out,
                         double *value) const;

    /* Checks three numbers separated by blanks and appends the attribute to `out`. */
    bool vector(const TiXmlElement &in, const char *attribute, std::string &out,
                double value[3]) const;

    /* Appends the position of <origin> if `in` has one. Returns its rotation. */
    tfa_rotation pose(const TiXmlElement &in, std::string &out) const;

    /* A child whose name is nearly a known one is an error: a misspelled <inertial> would be lost
     * without a trace. Others are counted as not used, but for `silent`. */
    void unknown_children(const TiXmlElement &in, std::initializer_list<const char *> known,
                          std::initializer_list<const char *> silent = {}) const;
    /* Attributes that dynamics does not use. */
    void unused_attributes(const TiXmlElement &in, std::initializer_list<const char *> known) const;
    void unknown_attributes(const TiXmlElement &in,
                            std::initializer_list<const char *> known) const;

  private:
    bool fault(const TiXmlAttribute &attribute, const TiXmlElement &in, const std::string &token,
               tfa_number_fault fault, tfa_severity severity, const char *code) const;

    tfa_urdf_log *log_;
    unused_items *unused_;
    const char *kind_; /* "robot", "link" or "joint" */
    std::string name_;
};

} // namespace tfa
#endif
