/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lint pass: collects links and joints in document order, resolves names to indices.
 */
#ifndef TFA_URDF_LINT_HPP
#define TFA_URDF_LINT_HPP

#include "urdf/element.hpp"

#include <string>
#include <unordered_map>
#include <vector>

namespace tfa
{

struct link_source {
    std::string name;
    uint32_t line;
    bool inertial;         /* it has an <inertial> */
    tfa_rotation rotation; /* of the inertial frame */
    double last_digit;     /* of its inertia */
};

struct joint_source {
    std::string name;
    uint32_t line;
    tfa_joint_type type;
    tfa_rotation rotation;
    double axis[3]; /* unit: axis + axis_low */
    double axis_low[3];
    std::string parent; /* names, resolved to the indices below */
    std::string child;
    std::string mimic; /* empty: none */
    uint32_t mimic_line;
    double rotor;     /* inertia as seen by the joint */
    double armature;  /* of MJCF, where it always counts */
    double reduction; /* 0: none */
    uint32_t parent_index;
    uint32_t child_index;
    int32_t mimic_index;
};

/* A <loop_joint> */
struct loop_source {
    std::string name;
    uint32_t line;
    uint32_t rows;       /* as in tfa_constraint */
    std::string link[2]; /* names, resolved to the indices below */
    double xyz[2][3];
    tfa_rotation rotation[2];
    bool aligned;     /* the second frame has the axes of the first with all joints at 0 */
    int32_t index[2]; /* -1: the world */
};

/* Of a joint by a <transmission>: the rotor's inertia as seen by the joint, or a reduction */
struct transmission_source {
    std::string joint;
    uint32_t line;
    double value;
};

/* "%g" */
std::string text_of(double number);

/* "drake:rotor_inertia" and "drake:gear_ratio" below `element`: rotor inertia seen by the joint. */
double reflected_inertia(const checked_element &checked, const TiXmlElement &element);

/* Reports "FIRST what: COUNT" if there are any. */
void report_tally(tfa_urdf_log *log, tfa_severity severity, const char *code, const tally &t,
                  const std::string &what);

/* Copies a text to `at`, which moves behind it. */
const char *append_string(char *&at, const std::string &text);

/* Warns of elements that would make another robot and are not read: joints and inertials in a wrong
 * place, closed loops, included files. */
void lint_lost_elements(const TiXmlElement &robot, tfa_urdf_log *log, file_findings *found);

class linter
{
  public:
    explicit linter(tfa_urdf_log *log) : log_(log), robot_(log, &found_, "robot") {}

    void robot(const TiXmlElement &element);

    /* Returns skeleton and canonical text if all names are resolved, even if numbers are invalid
     * (log->errors), so that the tree is checked in the same run. */
    int finish(tfa_description **skeleton, char **canonical) const;

  private:
    using index = std::unordered_map<std::string, uint32_t>;

    void mujoco(const TiXmlElement &element);
    void attributes(const TiXmlElement &element);
    void children(const TiXmlElement &element);
    void report_tallies() const;
    void link(const TiXmlElement &element);
    void joint(const TiXmlElement &element);
    void find_macros(const std::string &link, const TiXmlElement &element);
    void transmission(const TiXmlElement &element);
    void read_reductions(const TiXmlElement &element);
    void loop_joint(const TiXmlElement &element);

    void resolve();
    void add_world();
    template <class source> index index_names(const std::vector<source> &sources, const char *kind);
    uint32_t resolve_end(const joint_source &joint, const char *end, const std::string &link,
                         const index &links);
    void resolve_mimic(joint_source &joint, const index &joints);
    void resolve_rotors(const index &joints);
    void resolve_reductions(const index &joints);
    void resolve_loops(const index &links);
    size_t text_size() const;
    void append_unused(tfa_unused *unused, char *&strings) const;
    void append_loops(tfa_description &description, char *&strings) const;

    tfa_urdf_log *log_;
    file_findings found_;
    checked_element robot_;
    std::string name_;
    std::string out_; /* canonical elements inside <robot> */
    std::vector<link_source> links_;
    std::vector<joint_source> joints_;
    std::vector<transmission_source> rotors_;
    std::vector<transmission_source> reductions_;
    std::vector<loop_source> loops_;
    bool broken_ = false;   /* a link or joint is missing */
    bool resolved_ = false; /* all names have indices */
    bool root_is_free_ = false;
};

} // namespace tfa
#endif
