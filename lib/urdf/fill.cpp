/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The only file that uses urdfdom: parses the canonical text and copies the numbers.
 */
#include "urdf/urdf.h"

#include <console_bridge/console.h>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

namespace
{

/* Captures urdfdom's output during its lifetime. */
class log_capture : public console_bridge::OutputHandler
{
  public:
    log_capture()
        : previous_handler_(console_bridge::getOutputHandler()),
          level_(console_bridge::getLogLevel())
    {
        console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_WARN);
        console_bridge::useOutputHandler(this);
    }
    ~log_capture() override
    {
        console_bridge::useOutputHandler(previous_handler_);
        console_bridge::setLogLevel(level_);
    }
    log_capture(const log_capture &) = delete;
    log_capture &operator=(const log_capture &) = delete;

    void log(const std::string &text, console_bridge::LogLevel level, const char *, int) override
    {
        if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error.empty())
            first_error = text;
    }

    std::string first_error; /* empty: none */

  private:
    console_bridge::OutputHandler *previous_handler_;
    console_bridge::LogLevel level_;
};

/* Removes the pointers between links before the model is released: they own one another, and
 * releasing a chain of 100 000 links would recurse that deep. */
struct unlinked_model {
    urdf::ModelInterfaceSharedPtr model;
    explicit unlinked_model(urdf::ModelInterfaceSharedPtr m) : model(std::move(m)) {}
    ~unlinked_model()
    {
        if (!model)
            return;
        for (auto &entry : model->links_) {
            entry.second->child_links.clear();
            entry.second->child_joints.clear();
            entry.second->parent_joint.reset();
        }
    }
    unlinked_model(const unlinked_model &) = delete;
    unlinked_model &operator=(const unlinked_model &) = delete;
};

void copy(double to[3], const urdf::Vector3 &from)
{
    to[0] = from.x;
    to[1] = from.y;
    to[2] = from.z;
}

bool fill_link(tfa_link &to, const urdf::ModelInterface &model)
{
    urdf::LinkConstSharedPtr link = model.getLink(to.name);
    if (!link)
        return false;
    if (!link->inertial)
        return true;
    const urdf::Inertial &from = *link->inertial;
    to.mass = from.mass;
    copy(to.com, from.origin.position);
    const double inertia[6] = {from.ixx, from.ixy, from.ixz, from.iyy, from.iyz, from.izz};
    memcpy(to.inertia, inertia, sizeof inertia);
    return true;
}

bool fill_joint(tfa_joint &to, const urdf::ModelInterface &model)
{
    urdf::JointConstSharedPtr from = model.getJoint(to.name);
    if (!from)
        return false;
    copy(to.xyz, from->parent_to_joint_origin_transform.position);
    to.damping = from->dynamics ? from->dynamics->damping : 0;
    to.friction = from->dynamics ? from->dynamics->friction : 0;
    to.multiplier = from->mimic ? from->mimic->multiplier : 1;
    to.offset = from->mimic ? from->mimic->offset : 0;
    return true;
}

/* False if urdfdom's model is not the robot that the skeleton describes. */
bool fill(tfa_description &d, const urdf::ModelInterface &model)
{
    bool same = model.links_.size() == d.link_count && model.joints_.size() == d.joint_count;
    for (size_t i = 0; same && i < d.link_count; i++)
        same = fill_link(d.links[i], model);
    for (size_t j = 0; same && j < d.joint_count; j++)
        same = fill_joint(d.joints[j], model);
    return same;
}

} // namespace

int tfa_urdf_fill(const char *canonical, tfa_description *description, tfa_urdf_log *log) noexcept
try {
    log_capture capture;
    unlinked_model parsed(urdf::parseURDF(canonical));
    if (!parsed.model || !capture.first_error.empty()) {
        tfa_urdf_report(log, TFA_ERROR, 0, "urdfdom", "robot: urdfdom refuses it: %s",
                        capture.first_error.c_str());
        return TFA_E_PARSE;
    }
    if (!fill(*description, *parsed.model)) {
        tfa_urdf_report(log, TFA_ERROR, 0, "urdfdom",
                        "robot: urdfdom reads another robot than the file holds");
        return TFA_E_PARSE;
    }
    return TFA_OK;
} catch (const std::bad_alloc &) {
    return TFA_E_MEMORY;
} catch (const std::exception &e) {
    tfa_urdf_report(log, TFA_ERROR, 0, "urdfdom", "robot: urdfdom refuses it: %s", e.what());
    return TFA_E_PARSE;
}
