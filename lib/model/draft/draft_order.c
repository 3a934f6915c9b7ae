/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Order of the joints: document order, parents first.
 */
#include <stdlib.h>

#include "model/draft/draft.h"

/* joint_of[link]: joint whose child it is, or -1. Two are an error. */
static int find_parents(const struct draft *d, int32_t *joint_of, tfa_report *report)
{
    const tfa_description *s = d->description;
    for (size_t k = 0; k < s->link_count; k++)
        joint_of[k] = -1;
    for (size_t j = 0; j < s->joint_count; j++) {
        const tfa_joint *joint = &s->joints[j];
        if (joint->parent >= s->link_count || joint->child >= s->link_count)
            return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "unknown-link",
                              "joint '%s': parent or child link does not exist", joint->name);
        if (joint_of[joint->child] >= 0)
            return TFA_REFUSE(
                report, TFA_E_MODEL, joint->line, "two-parents",
                "link '%s': child of joint '%s' and of joint '%s'; a robot is a tree: remove one",
                s->links[joint->child].name, s->joints[joint_of[joint->child]].name, joint->name);
        joint_of[joint->child] = (int32_t)j;
    }
    return TFA_OK;
}

static int find_root(struct draft *d, const int32_t *joint_of, tfa_report *report)
{
    const tfa_description *s = d->description;
    size_t roots = 0;
    for (size_t k = 0; k < s->link_count; k++) {
        if (joint_of[k] >= 0)
            continue;
        if (roots++ == 0)
            d->root = (uint32_t)k;
        else
            tfa_report_add(report, TFA_ERROR, s->links[k].line, "two-roots",
                           "link '%s': neither it nor link '%s' is the child of a joint; connect "
                           "them or remove one",
                           s->links[k].name, s->links[d->root].name);
    }
    if (roots == 0)
        tfa_report_add(report, TFA_ERROR, 0, "no-root",
                       "every link is the child of a joint: the joints form a loop; remove one");
    return roots == 1 ? TFA_OK : TFA_E_MODEL;
}

/* Appends joint j after its ancestors. `path` is scratch. Returns SIZE_MAX on a loop. */
static size_t append_path(struct draft *d, size_t done, uint32_t j, const int32_t *joint_of,
                          uint8_t *visited, uint32_t *path)
{
    const tfa_description *s = d->description;
    size_t length = 0;
    for (int32_t k = (int32_t)j; k >= 0 && !visited[k]; k = joint_of[s->joints[k].parent]) {
        if (length == s->joint_count)
            return SIZE_MAX;
        path[length++] = (uint32_t)k;
    }
    while (length > 0) {
        uint32_t k = path[--length];
        d->order[done++] = k;
        visited[k] = 1;
    }
    return done;
}

/* A joint of the loop above joint j: after as many steps up as there are joints, the walk is in the
 * loop. */
static const tfa_joint *joint_in_loop(const tfa_description *s, uint32_t j, const int32_t *joint_of)
{
    for (size_t step = 0; step < s->joint_count; step++)
        j = (uint32_t)joint_of[s->joints[j].parent];
    return &s->joints[j];
}

static int append_all(struct draft *d, const int32_t *joint_of, uint8_t *visited, uint32_t *path,
                      tfa_report *report)
{
    const tfa_description *s = d->description;
    size_t done = 0;
    for (uint32_t j = 0; j < s->joint_count; j++) {
        done = append_path(d, done, j, joint_of, visited, path);
        if (done == SIZE_MAX) {
            const tfa_joint *joint = joint_in_loop(s, j, joint_of);
            return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "loop",
                              "joint '%s': its parent link '%s' hangs from itself; a robot is a "
                              "tree: open the loop",
                              joint->name, s->links[joint->parent].name);
        }
    }
    return TFA_OK;
}

int tfa_draft_order(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    if (s->link_count == 0)
        return TFA_REFUSE(report, TFA_E_MODEL, 0, "no-links", "the robot has no links");
    int32_t *joint_of = malloc(s->link_count * sizeof *joint_of);
    uint8_t *visited = calloc(s->joint_count + 1, 1);
    uint32_t *path = malloc((s->joint_count + 1) * sizeof *path);
    int status = TFA_E_MEMORY;
    if (joint_of && visited && path) {
        status = find_parents(d, joint_of, report);
        if (status == TFA_OK)
            status = find_root(d, joint_of, report);
        if (status == TFA_OK)
            status = append_all(d, joint_of, visited, path, report);
    }
    free(path);
    free(visited);
    free(joint_of);
    return status;
}
