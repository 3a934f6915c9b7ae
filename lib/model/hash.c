/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hash of a model: constants that decide answers, and the names in their order, by which clients
 * map joints and frames.
 */
#include "model/hash.h"

#include <sha256.h>
#include <stdio.h>
#include <string.h>

static void add(SHA2_CTX *c, const void *data, size_t size)
{
    SHA256Update(c, data, size);
}

static void add_bodies(SHA2_CTX *c, const struct tfa_model *m)
{
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &m->body[i];
        const uint8_t small[4] = {b->kind, b->n, b->base, 0};
        add(c, b->E, offsetof(struct tfa_body, parent));
        add(c, b->quad, sizeof *b->quad);
        add(c, &b->parent, sizeof b->parent);
        add(c, small, sizeof small);
    }
    for (uint32_t k = 0; k < m->parts; k++) {
        add(c, m->part[k].E, sizeof m->part[k].E + sizeof m->part[k].r);
        add(c, &m->part_quad[k], sizeof *m->part_quad);
        add(c, &m->part[k].kind, 1);
    }
}

static void add_maps(SHA2_CTX *c, const struct tfa_model *m)
{
    for (uint32_t k = 0; k < m->inner_q; k++) {
        const struct tfa_coordinate *q = &m->coordinate[k];
        const double numbers[2] = {q->multiplier, q->offset};
        add(c, &q->from, sizeof q->from);
        add(c, numbers, sizeof numbers);
    }
    for (uint32_t k = 0; k < m->freedoms - m->base_freedoms; k++) {
        add(c, &m->freedom[k].from, sizeof m->freedom[k].from);
        add(c, &m->freedom[k].multiplier, sizeof m->freedom[k].multiplier);
    }
    for (uint32_t k = 0; k < m->mimics; k++) {
        const uint32_t pair[2] = {m->mimic[k].follower, m->mimic[k].leader};
        add(c, pair, sizeof pair);
    }
    add(c, m->armature, m->freedoms * sizeof *m->armature);
    if (m->damping)
        add(c, m->damping, m->freedoms * sizeof *m->damping);
    if (m->friction) {
        add(c, m->friction, m->freedoms * sizeof *m->friction);
        add(c, &m->friction_velocity, sizeof m->friction_velocity);
    }
}

static void add_modes(SHA2_CTX *c, const struct tfa_model *m)
{
    for (uint32_t k = 0; k < m->flexible_bodies; k++) {
        const struct tfa_flexible *f = &m->flexible[k];
        const uint32_t small[3] = {f->body, f->frame, f->n};
        add(c, small, sizeof small);
        add(c, &f->mass, sizeof f->mass + sizeof f->c);
        add(c, f->B, (6 + 3 * f->n + 1) * f->n * sizeof *f->B); /* one after the other */
    }
    for (uint32_t k = 0; k < m->handles; k++) {
        const struct tfa_handle *h = &m->handle[k];
        add(c, &h->flexible, sizeof h->flexible);
        add(c, h->p, sizeof h->p);
        add(c, &h->mass, sizeof h->mass + sizeof h->h + sizeof h->I);
        add(c, h->shape, 6 * m->flexible[h->flexible].n * sizeof *h->shape);
    }
    for (uint32_t i = 0; m->modes && i < m->bodies; i++)
        add(c, &m->body[i].handle, sizeof m->body[i].handle);
    for (uint32_t k = 0; m->modes && k < m->frames; k++)
        add(c, &m->frame[k].handle, sizeof m->frame[k].handle);
}

static void add_constraints(SHA2_CTX *c, const struct tfa_model *m)
{
    for (uint32_t k = 0; k < m->constraints; k++) {
        const struct tfa_closure *x = &m->closure[k];
        add(c, x->frame, sizeof x->frame);
        add(c, &x->rows, sizeof x->rows + sizeof x->unilateral);
        add(c, x->R, sizeof x->R + sizeof x->p);
        add(c, x->name, strlen(x->name) + 1);
    }
}

/* Joints without a motor; nothing where all have one */
static void add_actuated(SHA2_CTX *c, const struct tfa_model *m)
{
    static const char label[] = "not actuated";
    for (uint32_t k = 0; k < m->joints; k++) {
        if (m->joint[k].actuated)
            continue;
        add(c, label, sizeof label);
        add(c, &k, sizeof k);
    }
}

static void add_names(SHA2_CTX *c, const struct tfa_model *m)
{
    for (uint32_t k = 0; k < m->frames; k++) {
        const struct tfa_frame *f = &m->frame[k];
        add(c, f->R, sizeof f->R + sizeof f->p);
        add(c, &m->frame_quad[k], sizeof *m->frame_quad);
        add(c, &f->body, sizeof f->body);
        add(c, &f->part, 1);
        add(c, m->link[k].quad, sizeof *m->link[k].quad);
        add(c, &m->link[k].parent, sizeof m->link[k].parent);
        add(c, f->name, strlen(f->name) + 1);
    }
    for (uint32_t k = 0; k < m->joints; k++)
        add(c, m->joint[k].name, strlen(m->joint[k].name) + 1);
}

static void hash_model(const struct tfa_model *m, int gravity, uint8_t hash[32])
{
    static const char version[] = "totalforce model 5";
    SHA2_CTX c;
    SHA256Init(&c);
    add(&c, version, sizeof version);
    if (gravity)
        add(&c, m->gravity, sizeof m->gravity);
    add_bodies(&c, m);
    add_maps(&c, m);
    add_modes(&c, m);
    add_names(&c, m);
    add_constraints(&c, m);
    add_actuated(&c, m);
    SHA256Final(hash, &c);
}

void tfa_hash_without_gravity(const struct tfa_model *m, uint8_t hash[32])
{
    hash_model(m, 0, hash);
}

void tfa_hash_model(struct tfa_model *m)
{
    hash_model(m, 1, m->hash);
    for (int k = 0; k < 32; k++)
        snprintf(m->hash_text + 2 * k, 3, "%02x", m->hash[k]);
}
