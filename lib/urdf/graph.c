/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checks that the skeleton of a robot is one tree and that every chain of mimics ends at an
 * independent joint.
 */
#include "urdf/urdf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NONE = -1 };

/* parent_of: joint above each link; -1 for roots */
static void find_parents(const tfa_description *d, int32_t *parent_of, tfa_urdf_log *log)
{
    for (size_t i = 0; i < d->link_count; i++)
        parent_of[i] = NONE;
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_joint *joint = &d->joints[j];
        int32_t *above = &parent_of[joint->child];
        if (joint->parent == joint->child)
            tfa_urdf_report(
                log, TFA_ERROR, joint->line, "loop",
                "joint '%s': link '%s' is its parent and its child; correct one of them",
                joint->name, d->links[joint->child].name);
        else if (*above != NONE)
            tfa_urdf_report(log, TFA_ERROR, joint->line, "two-parents",
                            "link '%s': child of joint '%s' (line %u) and of joint '%s'; a robot "
                            "is a tree: remove one",
                            d->links[joint->child].name, d->joints[*above].name,
                            d->joints[*above].line, joint->name);
        else
            *above = (int32_t)j;
    }
}

/* " with joint 'NAME'" for the first joint that hangs from a link, or "". */
static const char *name_first(const tfa_description *d, int32_t first, char text[300])
{
    text[0] = '\0';
    if (first != NONE)
        snprintf(text, 300, " with joint '%s'", d->joints[first].name);
    return text;
}

/* More than one root: islands. `first` is scratch for one joint below each link. */
static void check_roots(const tfa_description *d, const int32_t *parent_of, int32_t *first,
                        tfa_urdf_log *log)
{
    for (size_t i = 0; i < d->link_count; i++)
        first[i] = NONE;
    for (size_t j = d->joint_count; j-- > 0;)
        first[d->joints[j].parent] = (int32_t)j;
    int32_t root = NONE;
    char mine[300];
    char other[300];
    for (size_t i = 0; i < d->link_count; i++) {
        if (parent_of[i] != NONE)
            continue;
        if (root != NONE)
            tfa_urdf_report(log, TFA_ERROR, d->links[i].line, "two-roots",
                            "link '%s'%s: neither it nor link '%s'%s (line %u) is the child of a "
                            "joint; connect them or remove one",
                            d->links[i].name, name_first(d, first[i], mine), d->links[root].name,
                            name_first(d, first[root], other), d->links[root].line);
        else
            root = (int32_t)i;
    }
}

enum { NEW = 0, ON_PATH = 1, DONE = 2 };

/* Walks from `start` along next[] to a known node. Returns a node of the loop that it ends in, or
 * -1. All calls together walk each node once. */
static int32_t find_cycle(const int32_t *next, uint8_t *state, int32_t start)
{
    int32_t i = start;
    while (i != NONE && state[i] == NEW) {
        state[i] = ON_PATH;
        i = next[i];
    }
    int32_t loop = i != NONE && state[i] == ON_PATH ? i : NONE;
    for (i = start; i != NONE && state[i] == ON_PATH; i = next[i])
        state[i] = DONE;
    return loop;
}

/* Reports links that reach no root. */
static void check_loops(const tfa_description *d, const int32_t *parent_of, int32_t *next,
                        uint8_t *state, tfa_urdf_log *log)
{
    for (size_t i = 0; i < d->link_count; i++)
        next[i] = parent_of[i] == NONE ? NONE : (int32_t)d->joints[parent_of[i]].parent;
    memset(state, NEW, d->link_count);
    for (size_t i = 0; i < d->link_count; i++) {
        int32_t loop = find_cycle(next, state, (int32_t)i);
        if (loop == NONE)
            continue;
        const tfa_joint *in = &d->joints[parent_of[loop]];
        const tfa_joint *above = &d->joints[parent_of[in->parent]];
        tfa_urdf_report(log, TFA_ERROR, in->line, "loop",
                        "link '%s': hangs from itself, through joint '%s' and joint '%s' (line "
                        "%u); a robot is a tree: open the loop",
                        d->links[loop].name, in->name, above->name, above->line);
    }
}

static void check_mimics(const tfa_description *d, int32_t *next, uint8_t *state, tfa_urdf_log *log)
{
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_joint *joint = &d->joints[j];
        next[j] = joint->mimic >= 0 ? joint->mimic : NONE;
        if (next[j] != NONE && tfa_joint_type_describe(d->joints[joint->mimic].type).freedoms != 1)
            tfa_urdf_report(log, TFA_ERROR, joint->line, "mimic-type",
                            "joint '%s': mimics joint '%s', which has no single coordinate; follow "
                            "a revolute, continuous or prismatic joint",
                            joint->name, d->joints[joint->mimic].name);
    }
    memset(state, NEW, d->joint_count);
    for (size_t j = 0; j < d->joint_count; j++) {
        int32_t loop = find_cycle(next, state, (int32_t)j);
        if (loop == NONE)
            continue;
        tfa_urdf_report(log, TFA_ERROR, d->joints[loop].line, "mimic-loop",
                        "joint '%s': mimics joint '%s', which in the end mimics it; let one of "
                        "them move by itself",
                        d->joints[loop].name, d->joints[d->joints[loop].mimic].name);
    }
}

int tfa_urdf_graph(const tfa_description *description, tfa_urdf_log *log)
{
    const tfa_description *d = description;
    size_t n = d->link_count > d->joint_count ? d->link_count : d->joint_count;
    int32_t *parent_of = malloc(n * sizeof *parent_of);
    int32_t *next = malloc(n * sizeof *next);
    uint8_t *state = malloc(n);
    int status = TFA_E_MEMORY;
    if (parent_of && next && state) {
        size_t errors = log->errors;
        find_parents(d, parent_of, log);
        /* two parents make the walk ambiguous */
        if (log->errors == errors) {
            check_roots(d, parent_of, next, log);
            check_loops(d, parent_of, next, state, log);
        }
        check_mimics(d, next, state, log);
        status = log->errors == errors ? TFA_OK : TFA_E_PARSE;
    }
    free(parent_of);
    free(next);
    free(state);
    return status;
}
