/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots from files, and those that are written for the occasion, so that peers read them too.
 */
#include "bench.h"
#include "suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- made: humanoids as real ones are built, axes along the frames ---- */

/* A branch: so many joints on the link of another branch's end, or on the pelvis (-1). */
struct branch_of_links {
    const char *name, *axes; /* one letter for each joint */
    int on;
    double x, y, z;      /* its root there, m */
    double length, mass; /* of each link, at the first; both fall outward */
};

static const struct branch_of_links humanoid[] = {
    {"waist", "zyx", -1, 0, 0, 0.1, 0.1, 8},
    {"neck", "y", 0, 0, 0, 0.3, 0.1, 2},
    {"left_leg", "zxyyyx", -1, 0, 0.1, 0, -0.2, 4},
    {"right_leg", "zxyyyx", -1, 0, -0.1, 0, -0.2, 4},
    {"left_arm", "yxzyzyx", 0, 0, 0.2, 0.3, -0.15, 2.5},
    {"right_arm", "yxzyzyx", 0, 0, -0.2, 0.3, -0.15, 2.5},
};

/* Besides: a neck of three, and hands of thirteen, a thumb of four and three fingers of three */
static const struct branch_of_links hands[] = {
    {"head", "xz", 1, 0, 0, 0.1, 0.1, 1},
    {"left_thumb", "zyyy", 4, 0.03, 0, 0, -0.03, 0.05},
    {"left_index", "yyy", 4, 0.03, 0, -0.05, -0.03, 0.04},
    {"left_middle", "yyy", 4, 0, 0, -0.05, -0.03, 0.04},
    {"left_ring", "yyy", 4, -0.03, 0, -0.05, -0.03, 0.04},
    {"right_thumb", "zyyy", 5, 0.03, 0, 0, -0.03, 0.05},
    {"right_index", "yyy", 5, 0.03, 0, -0.05, -0.03, 0.04},
    {"right_middle", "yyy", 5, 0, 0, -0.05, -0.03, 0.04},
    {"right_ring", "yyy", 5, -0.03, 0, -0.05, -0.03, 0.04},
};

static void write_inertial(FILE *f, double mass, double length)
{
    const double radius = 0.3 * (length < 0 ? -length : length);
    const double along = mass * radius * radius / 2;
    const double across = mass * (3 * radius * radius + length * length) / 12;
    fprintf(f,
            "<inertial><origin xyz='0.01 0 %.17g'/><mass value='%.17g'/><inertia ixx='%.17g' "
            "ixy='0' ixz='0' iyy='%.17g' iyz='0' izz='%.17g'/></inertial>",
            length / 2, mass, across, across, along);
}

static void write_branch(FILE *f, const struct branch_of_links *branch_of_links,
                         const struct branch_of_links *on)
{
    double length = branch_of_links->length, mass = branch_of_links->mass, x = branch_of_links->x,
           y = branch_of_links->y, z = branch_of_links->z;
    char parent[64] = "pelvis";
    if (on)
        snprintf(parent, sizeof parent, "%s_%zu", on->name, strlen(on->axes));
    for (size_t k = 0; branch_of_links->axes[k]; k++) {
        const char axis = branch_of_links->axes[k];
        fprintf(f, "<link name='%s_%zu'>", branch_of_links->name, k + 1);
        write_inertial(f, mass, length);
        fprintf(f,
                "</link><joint name='%s_j%zu' type='continuous'><parent link='%s'/>"
                "<child link='%s_%zu'/><origin xyz='%.17g %.17g %.17g'/><axis xyz='%d %d %d'/>"
                "</joint>\n",
                branch_of_links->name, k + 1, parent, branch_of_links->name, k + 1, x, y, z,
                axis == 'x', axis == 'y', axis == 'z');
        snprintf(parent, sizeof parent, "%s_%zu", branch_of_links->name, k + 1);
        x = y = 0;
        z = length;
        length *= 0.9;
        mass *= 0.8;
    }
}

static int write_humanoid(const char *path, int with_hands)
{
    FILE *f = fopen(path, "w");
    if (!f)
        return -1;
    fprintf(f, "<robot name='humanoid%d'><link name='pelvis'>", with_hands ? 58 : 30);
    write_inertial(f, 10, 0.2);
    fputs("</link>\n", f);
    for (size_t k = 0; k < sizeof humanoid / sizeof *humanoid; k++)
        write_branch(f, &humanoid[k], humanoid[k].on < 0 ? NULL : &humanoid[humanoid[k].on]);
    for (size_t k = 0; with_hands && k < sizeof hands / sizeof *hands; k++)
        write_branch(f, &hands[k], &humanoid[hands[k].on]);
    fputs("</robot>\n", f);
    return fclose(f) ? -1 : 0;
}

/* @return 1: it was written; 0: there is none of that name; -1 after a message */
static int make(struct robot *r, const char *name)
{
    const char *folder = getenv("TMPDIR");
    const int chain = strncmp(name, "chain", 5) == 0 ? atoi(name + 5) : 0;
    const int with_hands = strcmp(name, "humanoid58") == 0;
    if (chain <= 0 && !with_hands && strcmp(name, "humanoid30") != 0)
        return 0;
    snprintf(r->path, sizeof r->path, "%s/tfa-suite-XXXXXX.urdf", folder ? folder : "/tmp");
    const int file = mkstemps(r->path, 5);
    if (file >= 0)
        close(file);
    r->written = file >= 0;
    const int bad =
        file < 0 || (chain ? chain_urdf(r->path, chain, 1) : write_humanoid(r->path, with_hands));
    if (bad)
        perror(r->path);
    return bad ? -1 : 1;
}

/* ---- what is known of them ---- */

static void look(struct robot *r)
{
    const tfa_description *d = r->description;
    r->chain = 1;
    for (size_t j = 0; j < d->joint_count; j++) {
        r->joints += d->joints[j].type != TFA_JOINT_FIXED;
        r->chain &= d->joints[j].child == d->joints[j].parent + 1;
        r->hands |= strcmp(d->joints[j].name, "left_thumb_1_joint") == 0;
    }
}

/* The joint that a link hangs from; NULL: the root */
static const tfa_joint *joint_of(const tfa_description *d, uint32_t link)
{
    for (size_t j = 0; j < d->joint_count; j++)
        if (d->joints[j].child == link)
            return &d->joints[j];
    return NULL;
}

/* Whether the link moves against the root */
static int moves(const tfa_description *d, uint32_t link)
{
    const tfa_joint *joint = joint_of(d, link);
    while (joint && joint->type == TFA_JOINT_FIXED)
        joint = joint_of(d, joint->parent);
    return joint != NULL;
}

/* Moving links from which nothing hangs, in order. @return how many */
static uint32_t candidates(const tfa_description *d, uint32_t *out)
{
    uint32_t count = 0;
    for (uint32_t link = 0; link < d->link_count; link++) {
        int parent = 0;
        for (size_t j = 0; j < d->joint_count; j++)
            parent |= d->joints[j].parent == link;
        if (!parent && moves(d, link))
            out[count++] = link;
    }
    return count;
}

uint32_t robot_deepest(const struct robot *r)
{
    const tfa_description *d = r->description;
    uint32_t deepest = 0, most = 0;
    for (uint32_t link = 0; link < d->link_count; link++) {
        uint32_t depth = 0;
        for (const tfa_joint *j = joint_of(d, link); j; j = joint_of(d, j->parent))
            depth += j->type != TFA_JOINT_FIXED;
        if (depth >= most)
            deepest = link;
        most = depth > most ? depth : most;
    }
    return deepest;
}

void robot_tips(struct robot *r, uint32_t count)
{
    uint32_t *link = calloc(r->description->link_count, sizeof *link);
    const uint32_t found = link ? candidates(r->description, link) : 0;
    for (uint32_t t = 0; t < count; t++)
        r->tips[t] = found ? link[found - 1 - t * found / count] : 0;
    free(link);
}

int robot_open(struct robot *r, const struct library *l, const char *name, tfa_base base)
{
    tfa_report report = {0};
    *r = (struct robot){.base = base};
    const int written = make(r, name);
    if (written == 0)
        snprintf(r->path, sizeof r->path, "%s", name);
    int status = written < 0 ? TFA_E_FILE : l->tfa_urdf_load(r->path, &r->description, &report);
    l->tfa_report_free(&report);
    if (status != TFA_OK) {
        fprintf(stderr, "bench_suite: %s: cannot be loaded\n", r->path);
        robot_close(r, l);
        return -1;
    }
    const char *file = strrchr(name, '/');
    snprintf(r->name, sizeof r->name, "%s", file ? file + 1 : name);
    if (strstr(r->name, ".urdf"))
        *strstr(r->name, ".urdf") = '\0';
    look(r);
    return 0;
}

void robot_close(struct robot *r, const struct library *l)
{
    l->tfa_description_free(r->description);
    if (r->written)
        unlink(r->path);
}
