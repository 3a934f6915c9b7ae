/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Changes robots element by element, so that most of what comes out is still nearly a robot.
 */
#include "generate.hpp"
#include "tree.hpp"
#include "urdf/urdf.h"

#include <cstring>
#include <vector>

namespace
{
using elements = std::vector<TiXmlElement *>;
/* TinyXML must not see what the guard has not: it reads beyond cut sequences. */
bool read(const std::string &text, TiXmlDocument &document)
{
    tfa_urdf_log log = {};
    std::string clean(text.size() + 1, '\0');
    if (tfa_urdf_check_xml(text.c_str(), text.size(), &clean[0], &log) != TFA_OK)
        return false;
    document.Parse(clean.c_str(), nullptr, TIXML_ENCODING_UTF8);
    return !document.Error() && document.RootElement();
}

std::string print(const TiXmlDocument &document)
{
    TiXmlPrinter printer;
    printer.SetIndent("");
    document.Accept(&printer);
    return printer.Str();
}

void collect(TiXmlElement *element, elements &all)
{
    all.push_back(element);
    for (TiXmlElement *e = element->FirstChildElement(); e; e = e->NextSiblingElement())
        collect(e, all);
}

bool contains(const TiXmlNode *above, const TiXmlNode *node)
{
    while (node && node != above)
        node = node->Parent();
    return node == above;
}

TiXmlElement *any(const elements &all, struct random_source &c)
{
    return all[random_below(&c, all.size())];
}

/* A random element of that name, or nullptr. */
TiXmlElement *any_named(const elements &all, const char *name, struct random_source &c)
{
    size_t start = random_below(&c, all.size());
    for (size_t i = 0; i < all.size(); i++)
        if (all[(start + i) % all.size()]->ValueStr() == name)
            return all[(start + i) % all.size()];
    return nullptr;
}

TiXmlAttribute *any_attribute(TiXmlElement *element, struct random_source &c)
{
    size_t count = 0;
    for (TiXmlAttribute *a = element->FirstAttribute(); a; a = a->Next())
        count++;
    TiXmlAttribute *a = element->FirstAttribute();
    for (size_t i = random_below(&c, count); a && i > 0; i--)
        a = a->Next();
    return a;
}

void swap(TiXmlElement *a, TiXmlElement *b)
{
    if (contains(a, b) || contains(b, a))
        return;
    TiXmlElement copy(*a);
    a->Parent()->ReplaceChild(a, *b);
    b->Parent()->ReplaceChild(b, copy);
}

void move(TiXmlElement *element, TiXmlElement *to)
{
    if (contains(element, to))
        return;
    to->InsertEndChild(*element);
    element->Parent()->RemoveChild(element);
}

/* The link of a joint's end, or nullptr. */
const char *end_of(TiXmlElement *joint, const char *end)
{
    TiXmlElement *e = joint->FirstChildElement(end);
    return e ? e->Attribute("link") : nullptr;
}

/* A joint and the link that it carries: what hung from that link then hangs from the parent. */
void remove_joint(TiXmlElement *joint, const elements &all)
{
    const char *parent = end_of(joint, "parent");
    const char *child = end_of(joint, "child");
    if (!parent || !child)
        return;
    std::string kept = parent;
    std::string gone = child;
    for (TiXmlElement *e : all)
        if (e->ValueStr() == "parent" && e->Attribute("link") && gone == e->Attribute("link"))
            e->SetAttribute("link", kept);
    for (TiXmlElement *e : all)
        if (e->ValueStr() == "link" && e->Attribute("name") && gone == e->Attribute("name") &&
            !contains(e, joint) && !contains(joint, e)) {
            e->Parent()->RemoveChild(e);
            break;
        }
    joint->Parent()->RemoveChild(joint);
}

void change_joint(TiXmlElement *joint, const elements &all, struct random_source &c)
{
    static const char *const types[] = {"revolute", "continuous", "prismatic",
                                        "fixed",    "planar",     "floating"};
    TiXmlElement *link = any_named(all, "link", c);
    TiXmlElement *other = any_named(all, "joint", c);
    TiXmlElement mimic("mimic");
    switch (random_below(&c, 4)) {
    case 0:
        joint->SetAttribute("type", types[random_below(&c, 6)]);
        break;
    case 1: {
        TiXmlElement *parent = joint->FirstChildElement("parent");
        if (parent && link && link->Attribute("name"))
            parent->SetAttribute("link", link->Attribute("name"));
        break;
    }
    case 2:
        if (other && other->Attribute("name"))
            mimic.SetAttribute("joint", other->Attribute("name"));
        mimic.SetAttribute("multiplier", plain_number(c));
        if (!joint->FirstChildElement("mimic"))
            joint->InsertEndChild(mimic);
        break;
    default:
        remove_joint(joint, all);
    }
}

void change_link(TiXmlElement *link, struct random_source &c)
{
    TiXmlElement *inertial = link->FirstChildElement("inertial");
    if (!inertial)
        return;
    TiXmlElement *mass = inertial->FirstChildElement("mass");
    TiXmlElement *inertia = inertial->FirstChildElement("inertia");
    size_t what = random_below(&c, 4);
    if (what == 0)
        link->RemoveChild(inertial);
    else if (what == 1 && mass)
        mass->SetAttribute("value", plain_number(c));
    else if (mass && inertia) { /* a frame or a point */
        if (what == 2)
            mass->SetAttribute("value", "0");
        for (TiXmlAttribute *a = inertia->FirstAttribute(); a; a = a->Next())
            a->SetValue("0");
    }
}

void change_attribute(TiXmlElement *element, const elements &all, struct random_source &c)
{
    TiXmlAttribute *a = any_attribute(element, c);
    if (!a)
        return;
    TiXmlElement *like = any_named(all, element->Value(), c);
    const char *other = like ? like->Attribute(a->Name()) : nullptr;
    switch (random_below(&c, 6)) {
    case 0:
        a->SetValue(hostile_value(c));
        break;
    case 1:
        a->SetValue(strchr(a->Value(), ' ') ? plain_vector(c) : plain_number(c));
        break;
    case 2:
        element->RemoveAttribute(a->Name());
        break;
    default:
        if (other)
            a->SetValue(std::string(other));
    }
}

void change_element(TiXmlElement *element, TiXmlElement *other, struct random_source &c)
{
    static const char *const names[] = {
        "link",   "joint", "inertial", "mass",     "inertia",
        "origin", "axis",  "mimic",    "dynamics", "limit",
        "visual", "child", "parent",   "xacro:if", "drake:gear_ratio"};
    switch (random_below(&c, 5)) {
    case 0:
        element->Parent()->RemoveChild(element);
        break;
    case 1:
        element->Parent()->InsertAfterChild(element, *element);
        break;
    case 2:
        swap(element, other);
        break;
    case 3:
        move(element, other);
        break;
    default:
        element->SetValue(names[random_below(&c, sizeof names / sizeof *names)]);
    }
}

void change_once(TiXmlElement *root, struct random_source &c)
{
    elements all;
    collect(root, all);
    TiXmlElement *element = any(all, c);
    TiXmlElement *joint = any_named(all, "joint", c);
    TiXmlElement *link = any_named(all, "link", c);
    size_t what = random_below(&c, 10);
    if (what < 4 && joint && joint->Parent() == root)
        change_joint(joint, all, c);
    else if (what < 6 && link && link->Parent() == root)
        change_link(link, c);
    else if (what < 9)
        change_attribute(element, all, c);
    else if (element != root)
        change_element(element, any(all, c), c);
}

} // namespace

std::string change_robot(const std::string &text, struct random_source &c)
{
    TiXmlDocument document;
    if (!read(text, document))
        return "";
    for (size_t i = 1 + random_below(&c, 4); i > 0 && document.RootElement(); i--)
        change_once(document.RootElement(), c);
    if (document.RootElement() && random_percent(&c, 75))
        repair_robot(document.RootElement(), c);
    return print(document);
}

std::string cross_robots(const std::string &first, const std::string &second,
                         struct random_source &c)
{
    TiXmlDocument to;
    TiXmlDocument from;
    if (!read(first, to) || !read(second, from))
        return "";
    for (TiXmlElement *e = from.RootElement()->FirstChildElement(); e; e = e->NextSiblingElement())
        if (random_percent(&c, 20))
            to.RootElement()->InsertEndChild(*e);
    if (random_percent(&c, 90))
        repair_robot(to.RootElement(), c);
    return print(to);
}
