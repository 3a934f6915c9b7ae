/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a draft to the compiled model: one block of memory, constants rounded to double, the
 * tree of freedoms, the plan's main chains, the hash.
 */
#include "model/compile.h"

#include <math.h>
#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/arena.h"
#include "model/draft.h"

/* A main-chain body whose inertia, scaled to unit diagonal, has a pivot below this cannot be
 * inverted with more than about two good digits in double: TFA refuses it. */
#define REGULAR_PIVOT 1e-13

/* Every array of the model, walked once to count and once to place. */
struct layout {
    struct tfa_model *model;
    struct tfa_body *body;
    struct tfa_frame *frame;
    struct tfa_chain *chain;
    uint32_t *chain_body;
    tfa_joint_info *joint;
    tfa_body_info *body_info;
    struct tfa_coordinate *coordinate;
    struct tfa_freedom *freedom;
    double *armature;
    int32_t *dof_parent;
    uint32_t *dof_depth;
    size_t *dof_row;
    char *text;
    size_t size;
};

static size_t text_size(const tfa_description *s)
{
    size_t n = strlen(s->name ? s->name : "") + 1;
    for (size_t k = 0; k < s->link_count; k++)
        n += strlen(s->links[k].name) + 1;
    for (size_t k = 0; k < s->joint_count; k++)
        n += strlen(s->joints[k].name) + 1;
    return n;
}

static uint32_t count_freedoms(const struct draft *d)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < d->bodies; i++)
        n += d->body[i].n;
    return n;
}

static struct layout lay_out(const struct draft *d, void *memory)
{
    struct arena a = {memory, 0};
    struct layout l;
    uint32_t freedoms = count_freedoms(d);
    l.model = arena_take(&a, 1, sizeof *l.model);
    l.body = arena_take(&a, d->bodies, sizeof *l.body);
    l.frame = arena_take(&a, d->description->link_count, sizeof *l.frame);
    l.chain = arena_take(&a, d->bodies, sizeof *l.chain);
    l.chain_body = arena_take(&a, d->bodies, sizeof *l.chain_body);
    l.joint = arena_take(&a, d->movable, sizeof *l.joint);
    l.body_info = arena_take(&a, d->bodies, sizeof *l.body_info);
    l.coordinate = arena_take(&a, (size_t)d->bodies * 7, sizeof *l.coordinate);
    l.freedom = arena_take(&a, freedoms, sizeof *l.freedom);
    l.armature = arena_take(&a, freedoms, sizeof *l.armature);
    l.dof_parent = arena_take(&a, freedoms, sizeof *l.dof_parent);
    l.dof_depth = arena_take(&a, freedoms, sizeof *l.dof_depth);
    l.dof_row = arena_take(&a, freedoms, sizeof *l.dof_row);
    l.text = arena_take(&a, text_size(d->description), 1);
    l.size = a.used;
    return l;
}

static const char *keep_text(char **at, const char *text)
{
    char *start = *at;
    size_t n = strlen(text) + 1;
    memcpy(start, text, n);
    *at += n;
    return start;
}

/* Pivots of LDL^T of the 6 x 6 inertia scaled to unit diagonal: all above REGULAR_PIVOT? */
static uint8_t is_regular(const struct draft_body *b)
{
    const ext *I = b->I, *h = b->h, m = b->mass;
    ext a[6][6] = {{I[0], I[1], I[2], 0, -h[2], h[1]}, {I[1], I[3], I[4], h[2], 0, -h[0]},
                   {I[2], I[4], I[5], -h[1], h[0], 0}, {0, h[2], -h[1], m, 0, 0},
                   {-h[2], 0, h[0], 0, m, 0},          {h[1], -h[0], 0, 0, 0, m}};
    ext s[6];
    for (int i = 0; i < 6; i++) {
        if (!(a[i][i] > 0))
            return 0;
        s[i] = 1 / sqrtl(a[i][i]);
    }
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            a[i][j] *= s[i] * s[j];
    for (int k = 0; k < 6; k++) {
        if (!(a[k][k] > REGULAR_PIVOT))
            return 0;
        for (int i = k + 1; i < 6; i++)
            for (int j = k + 1; j < 6; j++)
                a[i][j] -= a[i][k] * a[k][j] / a[k][k];
    }
    return 1;
}

static void round_body(struct tfa_body *o, const struct draft_body *b)
{
    for (int k = 0; k < 9; k++)
        o->E[k] = (double)b->E[k];
    for (int k = 0; k < 3; k++) {
        o->r[k] = (double)b->r[k];
        o->h[k] = (double)b->h[k];
    }
    for (int k = 0; k < 6; k++)
        o->I[k] = (double)b->I[k];
    o->mass = (double)b->mass;
    o->armature = b->armature;
    o->parent = b->parent;
    o->kind = b->kind;
    o->n = b->n;
    o->base = b->base;
    o->link = b->link;
    o->regular = is_regular(b);
}

/* Bodies with their places in q and v, depths and trees. */
static void place_bodies(struct tfa_model *m, struct layout *l, const struct draft *d)
{
    static const uint8_t coordinates[] = {1, 1, 3, 7};
    uint32_t q = 0, v = 0;
    for (uint32_t i = 0; i < d->bodies; i++) {
        struct tfa_body *b = &l->body[i];
        round_body(b, &d->body[i]);
        b->q = q;
        b->v = v;
        q += b->base ? 0 : coordinates[b->kind];
        v += b->n;
        b->multi = b->n > 1 ? (int32_t)m->multis++ : -1;
        b->tree = b->parent < 0 ? (int32_t)i : l->body[b->parent].tree;
        b->depth = b->parent < 0 ? 1 : l->body[b->parent].depth + 1;
        m->depth = b->depth > m->depth ? b->depth : m->depth;
        m->trees += b->parent < 0;
        m->base_freedoms = b->base ? 6 : m->base_freedoms;
    }
    for (uint32_t i = 0; i < d->bodies; i++)
        l->body[i].leaf = 1;
    for (uint32_t i = d->bodies; i-- > 0;) {
        struct tfa_body *b = &l->body[i];
        if (b->parent < 0)
            continue;
        b->last = l->body[b->parent].leaf;
        l->body[b->parent].leaf = 0;
    }
    m->q_count = m->inner_q = q;
    m->freedoms = v;
    m->v_count = v - m->base_freedoms;
    for (uint32_t k = 0; k < q; k++)
        l->coordinate[k] = (struct tfa_coordinate){k, 1, 0};
    for (uint32_t k = 0; k < m->v_count; k++)
        l->freedom[k] = (struct tfa_freedom){k, 1};
    for (uint32_t i = 0; i < d->bodies; i++)
        for (uint32_t k = 0; k < l->body[i].n; k++)
            l->armature[l->body[i].v + k] = l->body[i].armature;
}

/* Expanded tree of freedoms: a joint with n freedoms is a path of n nodes. */
static void place_freedoms(struct tfa_model *m, struct layout *l)
{
    size_t row = 0;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &l->body[i];
        for (uint32_t k = 0; k < b->n; k++) {
            uint32_t j = b->v + k;
            int32_t up = -1;
            if (k > 0)
                up = (int32_t)(j - 1);
            else if (b->parent >= 0)
                up = (int32_t)(l->body[b->parent].v + l->body[b->parent].n - 1u);
            l->dof_parent[j] = up;
            l->dof_depth[j] = up < 0 ? 0 : l->dof_depth[up] + 1;
            l->dof_row[j] = row;
            row += l->dof_depth[j] + 1;
            if (l->dof_depth[j] + 1 > m->depth_freedoms)
                m->depth_freedoms = l->dof_depth[j] + 1;
        }
    }
    m->mass_entries = row;
}

/* The main chain of each tree: the path to its deepest body, the first one where several are. */
static void plan_chains(struct tfa_model *m, struct layout *l)
{
    uint32_t trees = 0;
    uint32_t *at = l->chain_body;
    for (uint32_t root = 0; root < m->bodies; root++) {
        if (l->body[root].parent >= 0)
            continue;
        uint32_t tip = root;
        for (uint32_t i = root; i < m->bodies; i++)
            if (l->body[i].tree == (int32_t)root && l->body[i].depth > l->body[tip].depth)
                tip = i;
        struct tfa_chain *c = &l->chain[trees++];
        c->length = l->body[tip].depth;
        c->body = at;
        for (int32_t i = (int32_t)tip; i >= 0; i = l->body[i].parent)
            at[l->body[i].depth - 1] = (uint32_t)i;
        at += c->length;
    }
}

static void place_frames(struct layout *l, const struct draft *d, char **text)
{
    for (size_t k = 0; k < d->description->link_count; k++) {
        struct tfa_frame *f = &l->frame[k];
        f->body = d->frame[k].body;
        for (int e = 0; e < 9; e++)
            f->R[e] = (double)d->frame[k].R[e];
        for (int e = 0; e < 3; e++)
            f->p[e] = (double)d->frame[k].p[e];
        f->name = keep_text(text, d->description->links[k].name);
    }
}

static void place_joints(struct tfa_model *m, struct layout *l, const struct draft *d, char **text)
{
    static const uint32_t coordinates[] = {1, 1, 3, 7};
    for (size_t k = 0; k < d->description->joint_count; k++) {
        uint32_t j = d->order[k];
        const tfa_joint *joint = &d->description->joints[j];
        if (joint->type == TFA_JOINT_FIXED)
            continue;
        const struct tfa_body *b = &l->body[d->joint_body[j]];
        l->joint[m->joints++] = (tfa_joint_info){
            .name = keep_text(text, joint->name),
            .type = joint->type,
            .q_index = b->q,
            .q_count = coordinates[b->kind],
            .v_index = b->v - m->base_freedoms,
            .v_count = b->n,
            .body = d->joint_body[j],
            .armature = b->armature,
        };
    }
}

static void summarise(struct tfa_model *m, const struct layout *l, const struct draft *d)
{
    tfa_model_summary *s = &m->summary;
    s->links = (uint32_t)d->description->link_count;
    s->joints = (uint32_t)d->description->joint_count;
    s->bodies = m->bodies;
    s->q_count = m->q_count;
    s->v_count = m->freedoms - m->base_freedoms;
    s->depth = m->depth;
    s->base = m->base;
    memcpy(s->gravity, m->gravity, sizeof s->gravity);
    for (size_t k = 0; k < d->description->link_count; k++)
        s->total_mass += d->description->links[k].mass;
    for (uint32_t i = 0; i < m->bodies; i++)
        s->moving_mass += l->body[i].mass;
    s->singular_body = -1;
    for (uint32_t t = m->trees; t-- > 0;) {
        const struct tfa_chain *c = &l->chain[t];
        s->main_chain = c->length > s->main_chain ? c->length : s->main_chain;
        for (uint32_t k = c->length; k-- > 0;)
            if (!l->body[c->body[k]].regular)
                s->singular_body = (int32_t)c->body[k];
    }
}

/* Everything that decides the answers, and the names in their order: clients map by them. */
static void hash_model(struct tfa_model *m)
{
    SHA2_CTX c;
    SHA256Init(&c);
    static const char version[] = "totalforce model 1";
    SHA256Update(&c, (const uint8_t *)version, sizeof version);
    SHA256Update(&c, (const uint8_t *)m->gravity, sizeof m->gravity);
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &m->body[i];
        const uint8_t small[4] = {b->kind, b->n, b->base, 0};
        SHA256Update(&c, (const uint8_t *)b->E, offsetof(struct tfa_body, parent));
        SHA256Update(&c, (const uint8_t *)&b->parent, sizeof b->parent);
        SHA256Update(&c, small, sizeof small);
    }
    for (uint32_t k = 0; k < m->frames; k++) {
        const struct tfa_frame *f = &m->frame[k];
        SHA256Update(&c, (const uint8_t *)f->R, sizeof f->R + sizeof f->p);
        SHA256Update(&c, (const uint8_t *)&f->body, sizeof f->body);
        SHA256Update(&c, (const uint8_t *)f->name, strlen(f->name) + 1);
    }
    for (uint32_t k = 0; k < m->joints; k++)
        SHA256Update(&c, (const uint8_t *)m->joint[k].name, strlen(m->joint[k].name) + 1);
    SHA256Final(m->hash, &c);
    for (int k = 0; k < 32; k++)
        snprintf(m->hash_text + 2 * k, 3, "%02x", m->hash[k]);
}

size_t tfa_compiled_size(const struct draft *d)
{
    return lay_out(d, NULL).size;
}

const struct tfa_model *tfa_compile(const struct draft *d, const tfa_model_options *options,
                                    void *memory)
{
    struct layout l = lay_out(d, memory);
    struct tfa_model *m = l.model;
    memset(memory, 0, l.size);
    char *text = l.text;
    const double standard[3] = {0, 0, -9.80665};
    memcpy(m->gravity, options && options->gravity ? options->gravity : standard, sizeof standard);
    m->base = options ? options->base : TFA_BASE_FIXED;
    m->bodies = d->bodies;
    m->frames = (uint32_t)d->description->link_count;
    m->body = l.body;
    m->frame = l.frame;
    m->chain = l.chain;
    m->joint = l.joint;
    m->body_info = l.body_info;
    m->coordinate = l.coordinate;
    m->freedom = l.freedom;
    m->armature = l.armature;
    m->dof_parent = l.dof_parent;
    m->dof_depth = l.dof_depth;
    m->dof_row = l.dof_row;
    place_bodies(m, &l, d);
    place_freedoms(m, &l);
    plan_chains(m, &l);
    m->name = keep_text(&text, d->description->name ? d->description->name : "");
    place_frames(&l, d, &text);
    place_joints(m, &l, d, &text);
    for (uint32_t i = 0; i < m->bodies; i++)
        l.body_info[i].name = l.frame[d->body[i].link].name;
    summarise(m, &l, d);
    hash_model(m);
    return m;
}
