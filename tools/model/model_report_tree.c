/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The robot as a tree of bodies. A body that is its parent's only child stands below it, several
 * children branch off: a long chain stays narrow.
 */
#include "model_report.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEP = 4, DEEPEST = 40 }; /* columns of a branch; branches that are indented */

#define NONE UINT32_MAX

/* Lists of indices, chained through one array: the children of a body, the joints that move it.
 * List number `bodies` is that of the world. */
typedef struct chains {
    uint32_t *first, *next;
} chains;

typedef struct drawing {
    const model_report *report;
    chains children, joints;
    char prefix[STEP * DEEPEST + 1];
} drawing;

static int make_chains(chains *c, uint32_t lists, uint32_t entries)
{
    c->first = malloc(((size_t)lists + 1) * sizeof *c->first);
    c->next = malloc(((size_t)entries + 1) * sizeof *c->next);
    if (!c->first || !c->next)
        return TFA_E_MEMORY;
    memset(c->first, 0xff, ((size_t)lists + 1) * sizeof *c->first);
    return TFA_OK;
}

static void free_chains(chains *c)
{
    free(c->first);
    free(c->next);
}

static void put_first(chains *c, uint32_t list, uint32_t entry)
{
    c->next[entry] = c->first[list];
    c->first[list] = entry;
}

static int moves(tfa_fate fate)
{
    return fate == TFA_FATE_MOVES || fate == TFA_FATE_FUSED || fate == TFA_FATE_FOLLOWS;
}

/* From the last to the first, so that lists are in order. */
static int fill(drawing *d)
{
    const tfa_model *model = d->report->model;
    const uint32_t bodies = d->report->bodies, joints = tfa_model_declared_count(model);
    if (make_chains(&d->children, bodies, bodies) != TFA_OK ||
        make_chains(&d->joints, bodies, joints) != TFA_OK)
        return TFA_E_MEMORY;
    for (uint32_t b = bodies; b-- > 0;) {
        const int32_t parent = tfa_model_body_parent(model, b);
        put_first(&d->children, parent < 0 ? bodies : (uint32_t)parent, b);
    }
    for (uint32_t j = joints; j-- > 0;) {
        const tfa_declared_joint joint = tfa_model_declared(model, j);
        if (moves(joint.fate) && joint.body >= 0)
            put_first(&d->joints, (uint32_t)joint.body, j);
    }
    return TFA_OK;
}

static void print_joints(const drawing *d, uint32_t body)
{
    const tfa_model *model = d->report->model;
    const char *before = "";
    if (tfa_model_body_parent(model, body) < 0 && tfa_model_base_freedoms(model))
        printf("floating base");
    for (uint32_t j = d->joints.first[body]; j != NONE; j = d->joints.next[j]) {
        const tfa_declared_joint joint = tfa_model_declared(model, j);
        printf("%s%s %s", before, joint.name, tfa_joint_type_describe(joint.type).name);
        if (joint.fate == TFA_FATE_FOLLOWS && joint.leader >= 0)
            printf(" that follows %s", tfa_model_joint(model, (uint32_t)joint.leader).name);
        before = " + ";
    }
}

/* The links that are fixed to it, but for the one that names it. */
static void print_merged(const model_report *r, uint32_t body, const char *name)
{
    const char *before = "  [";
    for (uint32_t i = r->first_link[body]; i < r->first_link[body + 1]; i++) {
        if (strcmp(r->link_names[i], name) == 0)
            continue;
        printf("%s%s", before, r->link_names[i]);
        before = ", ";
    }
    puts(before[0] == ',' ? "]" : "");
}

static void print_body(const drawing *d, uint32_t body)
{
    const tfa_body_info info = tfa_model_body(d->report->model, body);
    printf("%s  (", info.name);
    print_joints(d, body);
    printf(")  %.6g kg", info.mass);
    print_merged(d->report, body, info.name);
}

static void print_children(drawing *d, uint32_t list, unsigned depth);

/* A body and its subtree, children below each other */
static void print_branch(drawing *d, uint32_t body, unsigned depth)
{
    for (;;) {
        const uint32_t child = d->children.first[body];
        print_body(d, body);
        if (child == NONE)
            return;
        if (d->children.next[child] != NONE)
            break;
        printf("%s", d->prefix);
        body = child;
    }
    print_children(d, body, depth + 1);
}

static void print_children(drawing *d, uint32_t list, unsigned depth)
{
    const size_t length = strlen(d->prefix);
    const int indented = depth <= DEEPEST;
    for (uint32_t child = d->children.first[list]; child != NONE; child = d->children.next[child]) {
        const int last = d->children.next[child] == NONE;
        printf("%s%s", d->prefix, !indented ? "" : last ? "`-- " : "|-- ");
        if (indented)
            strcpy(d->prefix + length, last ? "    " : "|   ");
        print_branch(d, child, depth);
        d->prefix[length] = '\0';
    }
}

int model_report_print_tree(const model_report *r)
{
    drawing d = {.report = r};
    const int status = fill(&d);
    if (status == TFA_OK) {
        printf("%s  (%s base)", tfa_model_name(r->model),
               tfa_word(TFA_WORDS_BASE, tfa_model_summarise(r->model).base));
        print_merged(r, r->bodies, "");
        print_children(&d, r->bodies, 1);
    }
    free_chains(&d.children);
    free_chains(&d.joints);
    return status != TFA_OK || ferror(stdout);
}
