/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Schedule of bodies to lanes as C tables. Everything else follows from it and the constants of the
 * bodies when specialised.c is compiled.
 */
#include "layout/schedule_body_lanes.h"
#include "specialised/specialised_internal.h"

/* Cost of a step, in bodies of a specialised kernel without lanes. Humanoid of 30 bodies: 1000 ns
 * without, 368 with four lanes, 408 with eight (clang 14, AVX-512, Zen 5). */
static double step_cost(uint32_t lanes)
{
    return lanes > 4 ? 1.5 : 1.3;
}

/* The fastest schedule; no steps if one body after the other is faster. */
static struct tfa_lane_schedule choose_schedule(const tfa_model *m, uint32_t lanes_max,
                                                int32_t *table)
{
    uint32_t best = 0;
    double least = m->bodies;
    for (uint32_t lanes = 2; lanes <= lanes_max; lanes *= 2) {
        const struct tfa_lane_schedule p = tfa_schedule_body_lanes(m, lanes, table);
        if (!p.steps || p.steps * step_cost(lanes) >= least)
            continue;
        least = p.steps * step_cost(lanes);
        best = lanes;
    }
    return best ? tfa_schedule_body_lanes(m, best, table) : (struct tfa_lane_schedule){0};
}

int specialised_has_body_lanes(const tfa_model *m)
{
    int32_t table[TFA_SPECIALISED_BODIES_MAX * TFA_BODY_LANES_MAX];
    return choose_schedule(m, specialised_lanes(), table).steps != 0;
}

/* One step: a body for each lane, repeated bodies in idle lanes included */
struct step {
    int32_t body[TFA_BODY_LANES_MAX];
    uint32_t lane_mask;
    int32_t parent;
    int leaf;
};

/* Body for an idle lane: preferably one whose parent the lane had in the step before, so that
 * nothing moves. */
static int32_t repeated_body(const tfa_model *m, const int32_t *row, uint32_t lanes, int32_t before)
{
    int32_t any = -1;
    for (uint32_t e = 0; e < lanes; e++) {
        if (row[e] < 0)
            continue;
        if (m->body[row[e]].parent >= 0 && m->body[row[e]].parent == before)
            return row[e];
        any = any < 0 ? row[e] : any;
    }
    return any;
}

static struct step step_of(const tfa_model *m, const struct tfa_lane_schedule *p, uint32_t k,
                           const struct step *before, const uint32_t *steps)
{
    const int32_t *row = p->body + (size_t)k * p->lanes;
    struct step x = {.parent = -1, .leaf = 1};
    for (uint32_t l = 0; l < p->lanes; l++) {
        x.body[l] = row[l] >= 0 ? row[l] : repeated_body(m, row, p->lanes, before->body[l]);
        if (row[l] < 0)
            continue;
        const struct tfa_body *b = &m->body[row[l]];
        x.lane_mask |= 1u << l;
        x.leaf &= b->leaf;
        if (b->parent >= 0 && x.parent < 0)
            x.parent = (int32_t)steps[b->parent];
    }
    return x;
}

static void write_step(struct text_buffer *t, const tfa_model *m, const struct tfa_lane_schedule *p,
                       const struct step *x, uint32_t v)
{
    const struct tfa_body *b = &m->body[x->body[0]];
    text_append(t, "    {.body = {");
    for (uint32_t l = 0; l < p->lanes; l++)
        text_append(t, "%s%d", l ? ", " : "", x->body[l]);
    text_append(
        t, "}, .lane_mask = %u, .parent = %d, .joint_nd = %d, .q = %u, .v = %u, .freedom = %u,",
        x->lane_mask, x->parent, b->joint_nd, b->base ? 0 : v - m->base_freedoms, v, b->v);
    text_append(
        t, " .kind = %u, .n = %u, .base = %u, .leaf = %d, .axial = %u, .has_armature = %d}, \\\n",
        b->kind, b->n, b->base, x->leaf, b->axial, b->armature > 0);
}

static void write_steps(struct text_buffer *t, const tfa_model *m,
                        const struct tfa_lane_schedule *p, const uint32_t *steps)
{
    struct step before = {.body = {-1, -1, -1, -1, -1, -1, -1, -1}};
    uint32_t v = 0;
    text_append(t, "#define ROBOT_STEP_TABLE \\\n");
    for (uint32_t k = 0; k < p->steps; k++) {
        before = step_of(m, p, k, &before, steps);
        write_step(t, m, p, &before, v);
        v += m->body[before.body[0]].n;
    }
    text_append(t, "\n#define ROBOT_STEP_FREEDOMS %u\n", v);
}

static void write_list(struct text_buffer *t, const char *name, const uint32_t *x, uint32_t n)
{
    text_append(t, "#define %s ", name);
    for (uint32_t k = 0; k < n; k++)
        text_append(t, "%s%u", k ? ", " : "", x[k]);
    text_append(t, "\n");
}

/* Writes the children of every body, the last one first, and DO(0) DO(1) .. up to the largest
 * number. */
static void write_children(struct text_buffer *t, const tfa_model *m)
{
    uint32_t most = 1;
    for (uint32_t i = 0; i < m->bodies; i++) {
        uint32_t count = 0;
        for (uint32_t k = 0; k < m->bodies; k++)
            count += m->body[k].parent == (int32_t)i;
        most = count > most ? count : most;
    }
    write_sequence(t, "ROBOT_CHILD_RANKS", most, 0);
    text_append(t, "static const int32_t robot_child[ROBOT_BODIES][%u] = {\n", most);
    for (uint32_t i = 0; i < m->bodies; i++) {
        uint32_t count = 0;
        text_append(t, "    {");
        for (uint32_t k = m->bodies; k-- > 0;)
            if (m->body[k].parent == (int32_t)i)
                text_append(t, "%s%u", count++ ? ", " : "", k);
        for (; count < most; count++)
            text_append(t, "%s-1", count ? ", " : "");
        text_append(t, "},\n");
    }
    text_append(t, "};\n");
}

void write_body_lane_tables(struct text_buffer *t, const tfa_model *m, uint32_t lanes_max)
{
    int32_t table[TFA_SPECIALISED_BODIES_MAX * TFA_BODY_LANES_MAX];
    uint32_t steps[TFA_SPECIALISED_BODIES_MAX], lanes[TFA_SPECIALISED_BODIES_MAX];
    const struct tfa_lane_schedule p = choose_schedule(m, lanes_max, table);
    if (!p.steps)
        return;
    for (uint32_t k = 0; k < p.steps * p.lanes; k++)
        if (p.body[k] >= 0) {
            steps[p.body[k]] = k / p.lanes;
            lanes[p.body[k]] = k % p.lanes;
        }
    text_append(
        t,
        "\n/* Bodies in lanes: in step k lane l holds body robot_step[k].body[l], if bit l of "
        ".lane_mask is set. Where\n * each body stands, and its children, the last one first. */\n"
        "#define ROBOT_BODY_LANES %u\n#define ROBOT_STEPS %u\n",
        p.lanes, p.steps);
    write_sequence(t, "ROBOT_STEPS_OUTWARD", p.steps, 0);
    write_sequence(t, "ROBOT_STEPS_INWARD", p.steps, 1);
    write_steps(t, m, &p, steps);
    write_list(t, "ROBOT_STEP_OF", steps, m->bodies);
    write_list(t, "ROBOT_LANE_OF", lanes, m->bodies);
    write_children(t, m);
}
