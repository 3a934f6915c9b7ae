/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "small_robot.h"

#include "test.h"

void small_robot_begin(small_robot *r)
{
    memset(r, 0, sizeof *r);
    r->d = (tfa_description){
        .name = "robot", .links = r->link, .link_count = 1, .joints = r->joint, .joint_count = 0};
    r->link[0] = (tfa_link){.name = "root", .quat = {0, 0, 0, 1}};
}

tfa_joint *small_robot_add(small_robot *r, uint32_t parent, tfa_joint_type type, double x, double y,
                           double z)
{
    const uint32_t j = (uint32_t)r->d.joint_count++, k = (uint32_t)r->d.link_count++;
    assert_true(k < SMALL_ROBOT_LINKS);
    snprintf(r->names[k], sizeof *r->names, "l%u", (unsigned)k);
    snprintf(r->names[SMALL_ROBOT_LINKS + j], sizeof *r->names, "j%u", (unsigned)j);
    r->link[k] = (tfa_link){.name = r->names[k], .quat = {0, 0, 0, 1}};
    r->joint[j] = (tfa_joint){.name = r->names[SMALL_ROBOT_LINKS + j],
                              .type = type,
                              .parent = parent,
                              .child = k,
                              .quat = {0, 0, 0, 1},
                              .axis = {x, y, z},
                              .mimic = -1};
    return &r->joint[j];
}

void small_robot_load(small_robot *r, uint32_t link, double mass, double xx, double yy, double zz)
{
    r->link[link].mass = mass;
    r->link[link].inertia[0] = xx;
    r->link[link].inertia[3] = yy;
    r->link[link].inertia[5] = zz;
}
