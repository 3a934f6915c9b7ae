/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * End of the lint pass: names become indices; skeleton description.
 */
#include "urdf/lint.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace tfa
{

/* Adds the link `world`, to which many files fix the robot without declaring it. */
void linter::add_world()
{
    for (const link_source &link : links_)
        if (link.name == "world")
            return;
    auto first = std::find_if(joints_.begin(), joints_.end(),
                              [](const joint_source &joint) { return joint.parent == "world"; });
    if (first == joints_.end())
        return;
    links_.insert(links_.begin(), {"world", 0, false, {{0, 0, 0, 1}, {}}, 1});
    out_ += "<link name=\"world\"/>\n";
    tfa_urdf_report(log_, TFA_NOTE, first->line, "world-added",
                    "link 'world': not declared but a joint's parent; it becomes the root");
}

template <class source>
linter::index linter::index_names(const std::vector<source> &sources, const char *kind)
{
    index names;
    names.reserve(sources.size());
    for (size_t i = 0; i < sources.size(); i++) {
        auto [at, added] = names.emplace(sources[i].name, static_cast<uint32_t>(i));
        if (added)
            continue;
        resolved_ = false;
        tfa_urdf_report(log_, TFA_ERROR, sources[i].line,
                        kind[0] == 'l' ? "duplicate-link" : "duplicate-joint",
                        "%s '%s': declared before on line %u; rename one", kind,
                        sources[i].name.c_str(), sources[at->second].line);
    }
    return names;
}

uint32_t linter::resolve_end(const joint_source &joint, const char *end, const std::string &link,
                             const index &links)
{
    auto at = links.find(link);
    if (at != links.end())
        return at->second;
    resolved_ = false;
    tfa_urdf_report(log_, TFA_ERROR, joint.line, "unknown-link",
                    "joint '%s': %s link '%s' does not exist; declare it or correct the name",
                    joint.name.c_str(), end, link.c_str());
    return 0;
}

void linter::resolve_mimic(joint_source &joint, const index &joints)
{
    joint.mimic_index = -1;
    if (joint.mimic.empty())
        return;
    auto at = joints.find(joint.mimic);
    if (at == joints.end()) {
        joint.mimic_index = TFA_MIMIC_UNKNOWN; /* the model refuses it where it has to follow */
        tfa_urdf_report(log_, TFA_WARNING, joint.mimic_line, "mimic-unknown",
                        "joint '%s': mimics joint '%s', which does not exist, and moves on its "
                        "own; correct the name",
                        joint.name.c_str(), joint.mimic.c_str());
    } else if (joint.mimic == joint.name)
        tfa_urdf_report(log_, TFA_ERROR, joint.mimic_line, "mimic-self",
                        "joint '%s': mimics itself; name another joint or remove <mimic>",
                        joint.name.c_str());
    else
        joint.mimic_index = static_cast<int32_t>(at->second);
}

void linter::resolve()
{
    resolved_ = !broken_;
    if (broken_)
        return; /* reported; unresolved names would follow */
    add_world();
    index links = index_names(links_, "link");
    index joints = index_names(joints_, "joint");
    for (joint_source &joint : joints_) {
        joint.parent_index = resolve_end(joint, "parent", joint.parent, links);
        joint.child_index = resolve_end(joint, "child", joint.child, links);
        resolve_mimic(joint, joints);
    }
    resolve_rotors(joints);
    resolve_reductions(joints);
    index_names(loops_, "constraint");
    resolve_loops(links);
}

size_t linter::text_size() const
{
    size_t size = name_.size() + 1;
    for (const link_source &link : links_)
        size += link.name.size() + 1;
    for (const joint_source &joint : joints_)
        size += joint.name.size() + 1;
    for (const unused_items::entry &entry : found_.unused.entries())
        size += entry.item.size() + 1;
    for (const loop_source &loop : loops_)
        size += loop.name.size() + 1;
    return size;
}

const char *append_string(char *&at, const std::string &text)
{
    char *start = at;
    memcpy(start, text.c_str(), text.size() + 1);
    at += text.size() + 1;
    return start;
}

void linter::append_unused(tfa_unused *unused, char *&strings) const
{
    for (const unused_items::entry &entry : found_.unused.entries()) {
        *unused++ = {append_string(strings, entry.item), entry.line, entry.count};
    }
}

/* of a link or a joint */
template <class part> static void set_rotation(part &to, const tfa_rotation &from)
{
    memcpy(to.quat, from.quat, sizeof to.quat);
    memcpy(to.quat_low, from.low, sizeof to.quat_low);
}

/* One block: description, links, joints, constraints, unused items, strings. */
int linter::finish(tfa_description **skeleton, char **canonical) const
{
    if (!resolved_)
        return TFA_E_PARSE;
    size_t unused_size = found_.unused.entries().size() * sizeof(tfa_unused);
    size_t fixed_size = sizeof(tfa_description) + links_.size() * sizeof(tfa_link) +
                        joints_.size() * sizeof(tfa_joint) +
                        loops_.size() * sizeof(tfa_constraint) + unused_size;
    char *block = static_cast<char *>(calloc(1, fixed_size + text_size()));
    std::string text = "<robot";
    write_attribute(text, "name", name_);
    text += ">\n" + out_ + "</robot>\n";
    *canonical = strdup(text.c_str());
    if (!block || !*canonical) {
        free(block);
        free(*canonical);
        *canonical = nullptr;
        return TFA_E_MEMORY;
    }
    char *strings = block + fixed_size;
    auto *d = reinterpret_cast<tfa_description *>(block);
    d->name = append_string(strings, name_);
    d->links = reinterpret_cast<tfa_link *>(d + 1);
    d->link_count = links_.size();
    d->joints = reinterpret_cast<tfa_joint *>(d->links + links_.size());
    d->joint_count = joints_.size();
    d->constraints = reinterpret_cast<tfa_constraint *>(d->joints + joints_.size());
    d->constraint_count = loops_.size();
    d->root_is_free = root_is_free_;
    auto *unused = reinterpret_cast<tfa_unused *>(block + fixed_size - unused_size);
    append_unused(unused, strings);
    d->unused = unused;
    d->unused_count = found_.unused.entries().size();
    for (size_t i = 0; i < links_.size(); i++) {
        d->links[i].name = append_string(strings, links_[i].name);
        d->links[i].line = links_[i].line;
        d->links[i].inertial = links_[i].inertial;
        set_rotation(d->links[i], links_[i].rotation);
        d->links[i].last_digit = links_[i].last_digit < 1 ? links_[i].last_digit : 0;
    }
    for (size_t j = 0; j < joints_.size(); j++) {
        const joint_source &s = joints_[j];
        tfa_joint &joint = d->joints[j];
        joint.name = append_string(strings, s.name);
        joint.line = s.line;
        joint.type = s.type;
        set_rotation(joint, s.rotation);
        memcpy(joint.axis, s.axis, sizeof joint.axis);
        memcpy(joint.axis_low, s.axis_low, sizeof joint.axis_low);
        joint.parent = s.parent_index;
        joint.child = s.child_index;
        joint.mimic = s.mimic_index;
        joint.rotor = s.rotor;
        joint.armature = s.armature;
        joint.reduction = s.reduction;
    }
    append_loops(*d, strings);
    *skeleton = d;
    return TFA_OK;
}

} // namespace tfa
