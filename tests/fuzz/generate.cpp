/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots from scratch: random trees with every kind of joint and inertial, and a few mistakes.
 */
#include "generate.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace
{
template <size_t n> const char *any(struct random_source &c, const char *const (&list)[n])
{
    return list[random_below(&c, n)];
}

std::string attribute(const char *name, const std::string &value)
{
    return std::string(" ") + name + "=\"" + value + "\"";
}

std::string origin(struct random_source &c)
{
    std::string out = "<origin";
    if (random_percent(&c, 80))
        out += attribute("xyz", plain_vector(c));
    if (random_percent(&c, 50))
        out += attribute("rpy", plain_vector(c));
    return out + "/>";
}

/* A diagonal that a body can have, a rod, a point, or nonsense. */
std::string inertia(struct random_source &c)
{
    char text[256];
    double x = 0.1 + 0.09 * random_signed(&c);
    double y = 0.1 + 0.09 * random_signed(&c);
    double z = 0.1 + 0.09 * random_signed(&c);
    double off = 0;
    switch (random_below(&c, 12)) {
    case 0:
        x = y = z = 0;
        break;
    case 1:
        x = 0;
        break;
    case 2:
        x = -x;
        break;
    case 3:
        off = 0.2 * random_signed(&c);
        break;
    case 4:
        x *= 1e-12;
        y *= 1e-12;
        break;
    case 5:
        x = y = z = 1;
        break;
    default:
        y = x + z;
        off = 0.01 * random_signed(&c) * std::min(x, z);
        break;
    }
    snprintf(text, sizeof text,
             "<inertia ixx=\"%.9g\" ixy=\"%.9g\" ixz=\"0\" iyy=\"%.9g\" iyz=\"0\" izz=\"%.9g\"/>",
             x, off, y, z);
    return text;
}

std::string link(struct random_source &c, const std::string &name)
{
    static const char *const masses[] = {"0", "1e-5", "1e-300", "1e300", "-1"};
    std::string out = "<link" + attribute("name", name) + ">";
    if (random_percent(&c, 70)) {
        bool zero = random_percent(&c, 15);
        out += "<inertial>" + (random_percent(&c, 60) ? origin(c) : "");
        out += "<mass" + attribute("value", zero ? "0"
                                            : random_percent(&c, 4)
                                                ? any(c, masses)
                                                : std::to_string(1 + random_below(&c, 20)));
        out += "/>";
        out += zero ? "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>"
                    : inertia(c);
        out += "</inertial>";
    }
    if (random_percent(&c, 5))
        out += "<visual><origin xyz=\"${x}\"/><geometry><mesh filename=\"package://m\"/></geometry>"
               "</visual>";
    return out + "</link>\n";
}

std::string axis(struct random_source &c)
{
    static const char *const axes[] = {"1 0 0", "0 1 0", "0 0 1",    "0 0 -1",
                                       "1 1 0", "0 0 2", "0.1 0 -1", "0 0 0"};
    return "<axis" +
           attribute("xyz", random_percent(&c, 90) ? axes[random_below(&c, 7)] : any(c, axes)) +
           "/>";
}

std::string name_of(const char *kind, size_t i)
{
    return kind + std::to_string(i);
}

std::string joint(struct random_source &c, size_t i, size_t parent, size_t count)
{
    static const char *const types[] = {"revolute",   "revolute",  "continuous",
                                        "continuous", "prismatic", "fixed",
                                        "fixed",      "planar",    "floating"};
    std::string out = "<joint" + attribute("name", name_of("j", i)) +
                      attribute("type", any(c, types)) + ">" + origin(c) + "<parent" +
                      attribute("link", name_of("l", parent)) + "/><child" +
                      attribute("link", name_of("l", i)) + "/>" + axis(c);
    if (random_percent(&c, 50))
        out += "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
    if (random_percent(&c, 20) && count > 2)
        out += "<mimic" + attribute("joint", name_of("j", 1 + random_below(&c, count - 1))) +
               attribute("multiplier", plain_number(c)) + attribute("offset", plain_number(c)) +
               "/>";
    if (random_percent(&c, 30))
        out += "<dynamics" + attribute("damping", plain_number(c)) +
               attribute("friction", plain_number(c)) + "/>";
    if (random_percent(&c, 15))
        out += "<drake:rotor_inertia value=\"1e-4\"/><drake:gear_ratio" +
               attribute("value", plain_number(c)) + "/>";
    return out + "</joint>\n";
}

} // namespace

std::string hostile_value(struct random_source &c)
{
    static const char *const values[] = {
        "",
        "0",
        "-0",
        "nan",
        "inf",
        "1e308",
        "-1e308",
        "1e-308",
        "5e-324",
        "1e400",
        "1e-400",
        "0x1p3",
        "1,5",
        " 1",
        "1 ",
        "${x}",
        "a\nb",
        "0 0 0",
        "1e308 0 0",
        "1 0",
        "1e-200 0 0",
        "world",
        "fixed",
        "floating",
        "planar",
        "1e300 1 1e9",
        "-1",
        "1e-9",
        "l0",
        "l1",
        "j1",
        "j2",
        "1e16",
        "-1e-17",
        "3.14159265358979",
        "\xC3\xA9",
        "1e154 1e154 1e154",
        "1e-160 1e-160 0",
        "1 2 3 4",
        "1\t2\t3",
        "0e-999",
    };
    if (random_percent(&c, 3))
        return std::string(random_below(&c, 600), 'n');
    return any(c, values);
}

std::string plain_number(struct random_source &c)
{
    if (random_percent(&c, 2))
        return hostile_value(c);
    char text[32];
    snprintf(text, sizeof text, "%.*g", (int)(1 + random_below(&c, 17)), 2 * random_signed(&c));
    return random_percent(&c, 25) ? "0" : text;
}

std::string plain_vector(struct random_source &c)
{
    return plain_number(c) + " " + plain_number(c) + " " + plain_number(c);
}

std::string generate_robot(struct random_source &c)
{
    size_t count = 1 + random_below(&c, 16);
    bool chain = random_percent(&c, 40);
    std::vector<std::string> parts;
    for (size_t i = 0; i < count; i++)
        parts.push_back(link(c, name_of("l", i)));
    for (size_t i = 1; i < count; i++)
        parts.push_back(joint(c, i, chain ? i - 1 : random_below(&c, i), count));
    if (random_percent(&c, 10))
        parts.push_back("<transmission><joint name=\"j1\"/><actuator name=\"m\">"
                        "<drake:rotor_inertia value=\"1e-5\"/></actuator></transmission>");
    if (random_percent(&c, 10) && count > 1)
        parts.push_back("<loop_joint name=\"loop\" type=\"revolute\"><link1 link=\"l0\" xyz=\"" +
                        plain_vector(c) + "\"/><link2 link=\"" + name_of("l", count - 1) +
                        "\"/><axis xyz=\"0 0.6 -0.8\"/></loop_joint>");
    if (random_percent(&c, 30))
        for (size_t i = parts.size(); i > 1; i--)
            std::swap(parts[i - 1], parts[random_below(&c, i)]);
    std::string out = "<robot name=\"r\">\n";
    for (const std::string &part : parts)
        out += part;
    return out + "</robot>\n";
}
