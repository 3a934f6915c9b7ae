/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * MJCF, the format of MuJoCo (https://mujoco.readthedocs.io/en/stable/XMLreference.html): bodies,
 * joints, inertials, defaults and equalities become links, joints and constraints as those of a
 * URDF file.
 */
#ifndef TFA_URDF_MJCF_HPP
#define TFA_URDF_MJCF_HPP

#include "urdf/lint.hpp"

#include <totalforce/limits.h>

namespace tfa
{

/* End of a message: the file as MuJoCo writes it, with bodies only and their inertials */
extern const char mjcf_save[];

/* Limits of named joints; one that is not there keeps its own. */
void mjcf_limits(const TiXmlElement &root, const char *const *names, size_t count,
                 tfa_joint_limits *limits);

/* Elements inside `in`, as if each <include> were replaced by what it includes */
std::vector<const TiXmlElement *> children_of(const TiXmlElement &in);

/* True for <freejoint> and <joint type="free"> */
bool is_free(const TiXmlElement &joint);

/* Classes of default attributes */
class mjcf_defaults
{
  public:
    /* Reads a <default> with those inside. */
    void add(const checked_element &checked, const TiXmlElement &section);

    bool has(const std::string &name) const
    {
        return name == "main" || parents_.count(name) > 0;
    }

    /* The element that states the attribute: this one or one of its class; nullptr: none */
    const TiXmlElement *find(const TiXmlElement &element, const char *attribute,
                             const std::string &class_name) const;

  private:
    std::unordered_map<std::string, std::string> parents_;
    std::unordered_map<std::string, const TiXmlElement *> values_;
};

/* A frame in another */
struct mjcf_pose {
    double xyz[3] = {};
    tfa_rotation rotation = {{0, 0, 0, 1}, {}};
};

/* x = R x */
void rotate(const tfa_rotation &rotation, double x[3]);
/* Rotation about a unit axis */
tfa_rotation axis_rotation(const double axis[3], double angle);
mjcf_pose operator*(const mjcf_pose &a, const mjcf_pose &b);
mjcf_pose inverse(const mjcf_pose &pose);

/* Of <compiler> */
struct mjcf_compiler {
    double unit = 0.017453292519943295; /* rad in a unit of the file's angles: degrees by default */
    std::string euler = "xyz";
    bool infers_inertia = true; /* of bodies without <inertial>, from their geoms */
    bool limits_by_range = true;

    void read(const checked_element &checked, const TiXmlElement &element);
    /* pos and the orientation of an element */
    mjcf_pose pose(const checked_element &checked, const TiXmlElement &element) const;

  private:
    bool orientation(double v[6], const std::string &form, tfa_rotation &rotation) const;
};

struct mjcf_joint {
    joint_source source{};
    double xyz[3] = {};
    double damping = 0, friction = 0;
    double reference = 0; /* coordinate at the file's pose */
    double multiplier = 1, offset = 0;
    tfa_joint_limits limits{};
};

struct mjcf_body {
    const TiXmlElement *element;
    std::string name;
    std::string parent; /* "world" or a body */
    std::string childclass;
    mjcf_pose pose;        /* in the parent */
    mjcf_pose world;       /* at the file's pose */
    bool is_static = true; /* no joint between it and the world */
};

class mjcf_reader
{
  public:
    mjcf_reader(tfa_urdf_log *log, file_findings *found)
        : log_(log), found_(found), robot_(log, found, "robot")
    {
    }
    ~mjcf_reader()
    {
        log_->span_count = 0;
    }
    mjcf_reader(const mjcf_reader &) = delete;
    mjcf_reader &operator=(const mjcf_reader &) = delete;

    void read(const TiXmlElement &root);

    /* Canonical text of the joints, once the equalities are read */
    std::string joints_text() const;

    std::string model = "robot"; /* its name */
    std::string links_text;
    std::vector<link_source> links;
    std::vector<mjcf_joint> joints;
    std::vector<loop_source> loops;
    bool broken = false; /* a link or joint is missing */
    bool floats = false; /* the only moving body of the world is on a free joint */

  private:
    void find_includes(const TiXmlElement &root);
    uint32_t main_line(uint32_t row) const;
    std::string name_of(const TiXmlElement &element, const std::string &otherwise);
    const std::string &class_of(const checked_element &checked, const TiXmlElement &element,
                                const std::string &childclass, const char *attribute = "class");
    void worldbody(const std::vector<const TiXmlElement *> &sections);
    void find_floating_base(std::vector<mjcf_body> &bodies);
    void body(mjcf_body &body);
    void inertial(const mjcf_body &body);
    void add_link(const std::string &name, const TiXmlElement &at, const std::string &text = "");
    mjcf_joint &add_joint(const std::string &name, const TiXmlElement &at,
                          const std::string &parent, const std::string &child,
                          const mjcf_pose &pose);
    void body_joints(mjcf_body &body);
    void free_joint(const TiXmlElement &element, mjcf_body &body, const std::string &name);
    std::string joint(const TiXmlElement &element, const mjcf_body &body, const std::string &name,
                      const std::string &parent, bool is_last, mjcf_pose &origin);
    void axis_joint(const checked_element &checked, const TiXmlElement &element,
                    const std::string &class_name, mjcf_joint &joint);
    void equality(const TiXmlElement &element);
    void loop(const checked_element &checked, const TiXmlElement &element, const std::string &name);
    void coupling(const checked_element &checked, const TiXmlElement &element);

    tfa_urdf_log *log_;
    file_findings *found_;
    checked_element robot_;
    std::vector<tfa_urdf_span> spans_;
    mjcf_compiler compiler_;
    mjcf_defaults defaults_;
    std::unordered_map<std::string, mjcf_pose> poses_; /* of bodies */
    std::unordered_map<std::string, size_t> joint_index_;
    size_t equalities_ = 0;
};

} // namespace tfa
#endif
