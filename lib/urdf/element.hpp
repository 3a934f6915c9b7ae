/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checked access to XML elements: a value is either valid and copied, or reported.
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

/* The value for a message: quoted, control characters escaped, shortened. */
std::string quoted(const std::string &value);

/* True if the value contains a xacro expression. */
bool has_xacro(const std::string &value);

/* Name of the file for a command line; "FILE" for standard input. */
std::string file_of(const tfa_urdf_log *log);

/* True without control characters. */
bool is_printable(const std::string &name);

/* "value="1,5" of <mass>" */
std::string describe(const TiXmlAttribute &attribute, const TiXmlElement &in);

/* The element after this one in document order, below `top`; nullptr at the end. No recursion. */
const TiXmlElement *next_element(const TiXmlElement &element, const TiXmlElement &top);

/* Appends ` name="value"` with the value escaped. */
void write_attribute(std::string &out, const char *name, const std::string &value);

/* Findings of one kind that become one message: the first, its line, and their number */
struct tally {
    std::string first;
    uint32_t line = 0;
    size_t count = 0;

    void add(const std::string &what, const TiXmlBase &at)
    {
        if (count++ > 0)
            return;
        first = what;
        line = line_of(at);
    }
};

/* Items of the file that dynamics does not use, in order of first occurrence */
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
    std::vector<entry> &entries()
    {
        return entries_;
    }

  private:
    static constexpr size_t most = 100; /* bound of the names, so that searching stays fast */
    std::vector<entry> entries_;
};

/* Of one file, shared by all its elements */
struct file_findings {
    unused_items unused;
    tally macros;             /* xacro expressions in <visual> or <collision> */
    tally blanks;             /* numbers with white space around them */
    tally twice;              /* inertias with all nine entries */
    tally loops;              /* <loop_joint>s that became constraints */
    bool quaternions = false; /* URDF 1.1 or later: <origin> may have quat_xyzw */
};

/* One link or joint (or the robot) while it is being checked. */
class checked_element
{
  public:
    checked_element(tfa_urdf_log *log, file_findings *found, const char *kind,
                    std::string name = "")
        : log_(log), found_(found), kind_(kind), name_(std::move(name))
    {
    }

    /* Reports "link 'NAME': TEXT". */
    void report(tfa_severity severity, const TiXmlBase &at, const char *code,
                const std::string &what) const;

    /* The same for messages that many links or joints have in common (tfa_report_add_grouped). */
    void report_grouped(tfa_severity severity, const TiXmlBase &at, const char *code,
                        const std::string &what) const;

    /* "link 'NAME'" */
    std::string entity() const;

    /* Counts a finding about this link or joint. */
    void count(tally &findings, const TiXmlBase &at, const std::string &what) const
    {
        findings.add(entity() + ": " + what, at);
    }

    /* "run xacro first: xacro FILE > FILE.urdf" */
    std::string run_xacro() const;

    /* Counts an unused item. */
    void not_used(const std::string &item, const TiXmlBase &at) const
    {
        found_->unused.add(item, line_of(at));
    }

    /* The first child of that name; a second one is reported. */
    const TiXmlElement *only_child(const TiXmlElement &in, const char *name,
                                   tfa_severity severity = TFA_ERROR,
                                   const char *code = "duplicate-element") const;

    /* As one(), but reports when there is none. */
    const TiXmlElement *required(const TiXmlElement &in, const char *name) const;

    /* Reports that the attribute is missing. */
    void missing(const TiXmlElement &in, const char *attribute) const;

    /* The attribute's value; nullptr if it is no name (1 to 255 bytes without control characters),
     * which is reported. */
    const std::string *name(const TiXmlElement &in, const char *attribute) const;

    /* Checks one number and appends the attribute to `out`, without the white space around it,
     * which is counted. False if absent or malformed. */
    bool number(const TiXmlElement &in, const char *attribute, std::string &out, double *value,
                tfa_severity severity = TFA_ERROR, const char *code = nullptr) const;

    /* As number(), but reports when there is none. */
    bool required_number(const TiXmlElement &in, const char *attribute, std::string &out,
                         double *value) const;

    /* Checks `length` numbers separated by white space (`least` > 0: or fewer) and appends the
     * attribute to `out`. False if absent or malformed. */
    bool vector(const TiXmlElement &in, const char *attribute, std::string &out, double *value,
                size_t length = 3, size_t least = 0) const;

    /* The rotation that an element states by rpy or quat_xyzw */
    tfa_rotation rotation(const TiXmlElement &in) const;

    /* Appends the position of <origin> if `in` has one. Returns its rotation. */
    tfa_rotation pose(const TiXmlElement &in, std::string &out) const;

    /* A child whose name is similar to a known one is an error (a misspelled <inertial> would be
     * lost); others count as unused, except `silent` ones. */
    void unknown_children(const TiXmlElement &in, std::initializer_list<const char *> known,
                          std::initializer_list<const char *> silent = {}) const;
    /* Attributes that dynamics does not use. */
    void unused_attributes(const TiXmlElement &in, std::initializer_list<const char *> known) const;
    void unknown_attributes(const TiXmlElement &in,
                            std::initializer_list<const char *> known) const;

  private:
    bool fault(const TiXmlAttribute &attribute, const TiXmlElement &in, const std::string &token,
               tfa_number_fault fault, tfa_severity severity, const char *code) const;
    void angles(const TiXmlElement &origin, tfa_rotation &rotation) const;
    void quaternion(const TiXmlElement &origin, tfa_rotation &rotation) const;

    tfa_urdf_log *log_;
    file_findings *found_;
    const char *kind_; /* "robot", "link", "joint" or "constraint" */
    std::string name_;
};

} // namespace tfa
#endif
