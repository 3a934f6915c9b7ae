/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A random chain of uniform rods, written as URDF so that every contestant reads the same file.
 */
#include <stdio.h>

#include "bench.h"

/* splitmix64, uniform in [-1, 1) */
static double uniform(unsigned long long *state)
{
    unsigned long long z = (*state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
}

static void write_link(FILE *f, int i)
{
    const double length = 1, radius = 0.1, mass = 1;
    const double along = mass * radius * radius / 2;
    const double across = mass * (3 * radius * radius + length * length) / 12;
    fprintf(f,
            "  <link name='l%d'><inertial><origin xyz='%.17g 0 0'/><mass value='%.17g'/>"
            "<inertia ixx='%.17g' ixy='0' ixz='0' iyy='%.17g' iyz='0' izz='%.17g'/></inertial>"
            "</link>\n",
            i, length / 2, mass, along, across, across);
}

int chain_urdf(const char *path, int links, unsigned seed)
{
    static const char *const axes[] = {"1 0 0", "0 1 0", "0 0 1"};
    unsigned long long state = seed;
    FILE *f = fopen(path, "w");
    if (!f)
        return -1;
    fprintf(f, "<robot name='chain%d'>\n", links);
    write_link(f, 0);
    for (int i = 1; i <= links; i++) {
        write_link(f, i);
        double r = uniform(&state), p = uniform(&state), y = uniform(&state);
        int axis = (int)(1.5 * (uniform(&state) + 1));
        fprintf(f,
                "  <joint name='j%d' type='continuous'><parent link='l%d'/><child link='l%d'/>"
                "<origin xyz='%d 0 0' rpy='%.17g %.17g %.17g'/><axis xyz='%s'/></joint>\n",
                i, i - 1, i, i > 1, r, p, y, axes[axis > 2 ? 2 : axis]);
    }
    fputs("</robot>\n", f);
    return fclose(f) ? -1 : 0;
}
