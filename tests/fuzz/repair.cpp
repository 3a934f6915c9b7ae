/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Makes most of a broken robot whole again: without this, changes add up until nothing loads, and
 * the fuzzer sees little but the first check.
 */
#include "generate.hpp"
#include "tree.hpp"
#include "urdf/urdf.h"

#include <map>
#include <set>
#include <sstream>
#include <vector>

namespace
{
using elements = std::vector<TiXmlElement *>;
elements children(TiXmlElement *root, const char *name)
{
    elements found;
    for (TiXmlElement *e = root->FirstChildElement(name); e; e = e->NextSiblingElement(name))
        found.push_back(e);
    return found;
}

std::string value(const TiXmlElement *element, const char *attribute)
{
    const char *text = element ? element->Attribute(attribute) : nullptr;
    return text ? text : "";
}

/* Removes what has no name or one that was there before, and returns the names. */
std::set<std::string> unique_names(TiXmlElement *root, const char *kind)
{
    std::set<std::string> names;
    for (TiXmlElement *e : children(root, kind))
        if (value(e, "name").empty() || !names.insert(value(e, "name")).second)
            root->RemoveChild(e);
    return names;
}

/* The root of the tree that a link hangs in. */
std::string top_of(const std::map<std::string, std::string> &parent_of, std::string link)
{
    for (auto at = parent_of.find(link); at != parent_of.end(); at = parent_of.find(link))
        link = at->second;
    return link;
}

/* Keeps the joints that make a forest; fixes the other trees to the first. */
void repair_tree(TiXmlElement *root)
{
    std::set<std::string> links = unique_names(root, "link");
    unique_names(root, "joint");
    std::map<std::string, std::string> parent_of;
    for (TiXmlElement *joint : children(root, "joint")) {
        std::string parent = value(joint->FirstChildElement("parent"), "link");
        std::string child = value(joint->FirstChildElement("child"), "link");
        if (!links.count(parent) || !links.count(child) || parent_of.count(child) ||
            top_of(parent_of, parent) == child)
            root->RemoveChild(joint);
        else
            parent_of[child] = parent;
    }
    std::string first;
    for (const std::string &link : links) {
        if (parent_of.count(link))
            continue;
        if (!first.empty()) {
            TiXmlElement joint("joint");
            TiXmlElement parent("parent");
            TiXmlElement child("child");
            joint.SetAttribute("name", "mend_" + link);
            joint.SetAttribute("type", "fixed");
            parent.SetAttribute("link", first);
            child.SetAttribute("link", link);
            joint.InsertEndChild(parent);
            joint.InsertEndChild(child);
            root->InsertEndChild(joint);
        } else
            first = link;
    }
}

bool is_number(const std::string &text)
{
    double number;
    return tfa_number_read(text.c_str(), text.size(), &number) == TFA_NUMBER_OK;
}

bool is_vector(const std::string &text)
{
    std::istringstream in(text);
    std::string word;
    size_t count = 0;
    for (; in >> word && is_number(word);)
        count++;
    return count == 3 && in.eof() && text.find_first_of("\t\r\n") == std::string::npos;
}

void repair_numbers(TiXmlElement *element, struct random_source &c)
{
    static const std::set<std::string> scalars = {"value",    "ixx",        "ixy",   "ixz",
                                                  "iyy",      "iyz",        "izz",   "damping",
                                                  "friction", "multiplier", "offset"};
    for (TiXmlAttribute *a = element->FirstAttribute(); a; a = a->Next()) {
        std::string name = a->Name();
        if ((name == "xyz" || name == "rpy") && !is_vector(a->ValueStr()))
            a->SetValue(element->ValueStr() == "axis" ? "0 0 1" : plain_vector(c));
        else if (scalars.count(name) && !is_number(a->ValueStr()))
            a->SetValue(plain_number(c));
    }
    if (element->ValueStr() == "mass" && value(element, "value")[0] == '-')
        element->SetAttribute("value", "1");
    for (TiXmlElement *e = element->FirstChildElement(); e; e = e->NextSiblingElement())
        repair_numbers(e, c);
}

} // namespace

void repair_robot(TiXmlElement *root, struct random_source &c)
{
    repair_numbers(root, c);
    repair_tree(root);
}
