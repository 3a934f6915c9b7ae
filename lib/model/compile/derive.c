/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derived models: they share the tables of another model and differ in gravity or payloads. With
 * the same payloads they equal a compiled scene, to the bit and the hash.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/arena.h"
#include "model/compile/compile.h"
#include "model/hash.h"
#include "model/payload.h"

struct derived {
    struct tfa_model *model;
    struct tfa_body *body; /* payloads only, with the next four */
    struct tfa_body_quad *quad;
    tfa_body_info *info;
    struct tfa_link_mass *link;
    struct tfa_mass_properties *link_quad;
    size_t size;
};

static struct derived layout_of(const struct tfa_model *from, int with_bodies, void *memory)
{
    struct arena a = {memory, 0};
    struct derived l = {0};
    l.model = arena_alloc(&a, 1, sizeof *l.model);
    if (with_bodies) {
        l.body = arena_alloc(&a, from->bodies, sizeof *l.body);
        l.quad = arena_alloc(&a, from->bodies, sizeof *l.quad);
        l.info = arena_alloc(&a, from->bodies, sizeof *l.info);
        l.link = arena_alloc(&a, from->frames, sizeof *l.link);
        l.link_quad = arena_alloc(&a, from->frames, sizeof *l.link_quad);
    }
    l.size = a.used;
    return l;
}

static int refuse(int status, const char *code, const tfa_payload *payload, const char *what,
                  tfa_report *report)
{
    tfa_report_add(report, TFA_ERROR, 0, code, "link '%s': the payload %s",
                   payload->link ? payload->link : "(none)", what);
    return status;
}

static int check_payload(const struct tfa_model *m, const tfa_payload *p, tfa_report *report)
{
    const double numbers[10] = {p->mass,       p->com[0],     p->com[1],     p->com[2],
                                p->inertia[0], p->inertia[1], p->inertia[2], p->inertia[3],
                                p->inertia[4], p->inertia[5]};
    int status = TFA_E_MODEL;
    for (int k = 0; k < 10; k++)
        if (!isfinite(numbers[k]))
            status = TFA_E_VALUE;
    if (p->mass < 0)
        status = TFA_E_VALUE;
    const char *wrong = tfa_payload_error(p);
    if (wrong)
        return refuse(status, "payload", p, wrong, report);
    const int32_t frame = p->link ? tfa_model_find_frame(m, p->link) : -1;
    if (frame < 0)
        return refuse(TFA_E_LINK, "payload", p,
                      "is on a link that the model does not have; name one of its links", report);
    if (tfa_frame_is_flexible(m, (uint32_t)frame))
        return refuse(TFA_E_MODEL, "payload", p,
                      "is on a flexible link; give it in the scene, on a link behind a fixed joint",
                      report);
    if (m->frame[frame].part)
        return refuse(TFA_E_MODEL, "payload", p,
                      "is on a massless link that was fused with the next one; give the payload in "
                      "the scene, so that the robot is compiled with it",
                      report);
    return TFA_OK;
}

/* moves_mass[j]: freedom j or one of its followers moves mass or an armature. */
static void find_moving_mass(const struct tfa_model *m, const struct tfa_mass_scratch *mass_scratch,
                             uint8_t *moves_mass)
{
    for (uint32_t i = 0; i < m->bodies; i++)
        for (uint32_t k = m->body[i].v; k < m->body[i].v + m->body[i].n; k++)
            moves_mass[k] = mass_scratch[i].has_mass || m->armature[k] > 0;
    for (uint32_t k = 0; k < m->mimics; k++)
        moves_mass[m->mimic[k].leader] |= moves_mass[m->mimic[k].follower];
    for (uint32_t k = 0; k < m->mimics; k++)
        moves_mass[m->mimic[k].follower] = 1;
}

/* Checks that M is regular without the payloads of the original model. */
static int check_freedoms(const struct tfa_model *m, const struct tfa_mass_scratch *mass_scratch,
                          tfa_report *report)
{
    uint8_t *moves_mass = calloc(m->freedoms + 1u, 1);
    if (!moves_mass)
        return TFA_E_MEMORY;
    uint32_t massless_body = m->bodies;
    find_moving_mass(m, mass_scratch, moves_mass);
    for (uint32_t i = m->bodies; i-- > 0;)
        for (uint32_t k = m->body[i].v; k < m->body[i].v + m->body[i].n; k++)
            massless_body = moves_mass[k] ? massless_body : i;
    free(moves_mass);
    if (massless_body == m->bodies)
        return TFA_OK;
    return TFA_REFUSE(report, TFA_E_NO_MASS, 0, "massless-leaf",
                      "link '%s': without the payloads of the model that this one is derived from, "
                      "nothing with mass moves with it; keep them",
                      m->body_info[massless_body].name);
}

static int apply_payloads(const struct derived *l, const struct tfa_model *from,
                          const tfa_payload *payloads, size_t count, tfa_report *report)
{
    struct tfa_model *m = l->model;
    struct tfa_mass_scratch *mass_scratch = malloc((from->bodies + 1u) * sizeof *mass_scratch);
    if (!mass_scratch)
        return TFA_E_MEMORY;
    memcpy(l->body, from->body, from->bodies * sizeof *l->body);
    for (uint32_t i = 0; i < from->bodies; i++)
        l->quad[i] = *from->body[i].quad;
    memcpy(l->info, from->body_info, from->bodies * sizeof *l->info);
    memcpy(l->link, from->link, from->frames * sizeof *l->link);
    m->body = l->body;
    m->body_info = l->info;
    m->link = l->link;
    tfa_compute_mass_properties(m, l->body, l->quad, l->info, mass_scratch, payloads, count);
    tfa_compute_links(m, l->link, l->link_quad, payloads, count);
    int status = check_freedoms(m, mass_scratch, report);
    free(mass_scratch);
    return status;
}

static int check_inputs(const struct tfa_model *model, const double *gravity,
                        const tfa_payload *payloads, size_t count, tfa_report *report)
{
    int status = tfa_check_gravity(gravity, report);
    for (size_t k = 0; k < count && status == TFA_OK; k++)
        status = check_payload(model, &payloads[k], report);
    return status;
}

int tfa_model_derive(const tfa_model *model, const double *gravity, const tfa_payload *payloads,
                     size_t payload_count, tfa_report *report, tfa_model **derived)
{
    if (!derived)
        return TFA_E_ARGUMENT;
    *derived = NULL;
    if (!model || (payload_count && !payloads))
        return TFA_E_ARGUMENT;
    int status = check_inputs(model, gravity, payloads, payload_count, report);
    if (status != TFA_OK)
        return status;
    const int with_payloads = payload_count > 0;
    void *memory = aligned_alloc(TFA_ALIGNMENT, layout_of(model, with_payloads, NULL).size);
    if (!memory)
        return TFA_E_MEMORY;
    const struct derived l = layout_of(model, with_payloads, memory);
    *l.model = *model;
    if (gravity) {
        memcpy(l.model->gravity, gravity, sizeof l.model->gravity);
        memcpy(l.model->summary.gravity, gravity, sizeof l.model->summary.gravity);
    }
    if (with_payloads)
        status = apply_payloads(&l, model, payloads, payload_count, report);
    if (status != TFA_OK) {
        free(memory);
        return status;
    }
    tfa_hash_model(l.model);
    *derived = l.model;
    return TFA_OK;
}
