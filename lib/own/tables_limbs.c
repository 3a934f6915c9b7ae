/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Independent limbs side by side, as tables of C: which bodies share the lanes of which step. All else
 * follows from these and the constants of the bodies while own.c is compiled.
 */
#include "own/own.h"
#include "plan/limbs.h"

/* Time for a step of the packing, in bodies that go one by one in a kernel of the robot's own. Humanoid of 30
 * bodies: 1000 ns one by one, 368 with four lanes, 408 with eight; of 47: 2050, 1310, 790; quadruped: 241, 105
 * with four (clang 14, AVX-512, AMD EPYC Zen 5 VM, 2026-11-22). */
static double step_cost(uint32_t lanes)
{
    return lanes > 4 ? 1.5 : 1.3;
}

/* The packing that takes the least time; no steps where one body after the other takes less. */
static struct tfa_packing choose(const tfa_model *m, uint32_t lanes_max, int32_t *table)
{
    uint32_t best = 0;
    double least = m->bodies;
    for (uint32_t lanes = 2; lanes <= lanes_max; lanes *= 2) {
        const struct tfa_packing p = tfa_limbs_pack(m, lanes, table);
        if (!p.steps || p.steps * step_cost(lanes) >= least)
            continue;
        least = p.steps * step_cost(lanes);
        best = lanes;
    }
    return best ? tfa_limbs_pack(m, best, table) : (struct tfa_packing){0};
}

/* What is said of one step: a body for each lane, those of lanes without one included */
struct step {
    int32_t body[TFA_LIMBS_LANES_MAX];
    uint32_t held;
    int32_t parent;
    int leaf;
};

/* A lane without a body repeats one whose parent the lane before it had, so that nothing moves. */
static int32_t repeated(const tfa_model *m, const int32_t *row, uint32_t lanes, int32_t before)
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

static struct step step_of(const tfa_model *m, const struct tfa_packing *p, uint32_t k,
                           const struct step *before, const uint32_t *steps)
{
    const int32_t *row = p->body + (size_t)k * p->lanes;
    struct step x = {.parent = -1, .leaf = 1};
    for (uint32_t l = 0; l < p->lanes; l++) {
        x.body[l] = row[l] >= 0 ? row[l] : repeated(m, row, p->lanes, before->body[l]);
        if (row[l] < 0)
            continue;
        const struct tfa_body *b = &m->body[row[l]];
        x.held |= 1u << l;
        x.leaf &= b->leaf;
        if (b->parent >= 0 && x.parent < 0)
            x.parent = (int32_t)steps[b->parent];
    }
    return x;
}

static void say_step(struct own_text *t, const tfa_model *m, const struct tfa_packing *p,
                     const struct step *x, uint32_t v)
{
    const struct tfa_body *b = &m->body[x->body[0]];
    own_say(t, "    {.body = {");
    for (uint32_t l = 0; l < p->lanes; l++)
        own_say(t, "%s%d", l ? ", " : "", x->body[l]);
    own_say(t, "}, .held = %u, .parent = %d, .multi = %d, .q = %u, .v = %u, .freedom = %u,",
            x->held, x->parent, b->multi, b->base ? 0 : v - m->base_freedoms, v, b->v);
    own_say(t, " .kind = %u, .n = %u, .base = %u, .leaf = %d, .axial = %u, .geared = %d}, \\\n",
            b->kind, b->n, b->base, x->leaf, b->axial, b->armature > 0);
}

static void say_steps(struct own_text *t, const tfa_model *m, const struct tfa_packing *p,
                      const uint32_t *steps)
{
    struct step before = {.body = {-1, -1, -1, -1, -1, -1, -1, -1}};
    uint32_t v = 0;
    own_say(t, "#define OWN_STEP_TABLE \\\n");
    for (uint32_t k = 0; k < p->steps; k++) {
        before = step_of(m, p, k, &before, steps);
        say_step(t, m, p, &before, v);
        v += m->body[before.body[0]].n;
    }
    own_say(t, "\n#define OWN_STEP_FREEDOMS %u\n", v);
}

static void say_list(struct own_text *t, const char *name, const uint32_t *x, uint32_t n)
{
    own_say(t, "#define %s ", name);
    for (uint32_t k = 0; k < n; k++)
        own_say(t, "%s%u", k ? ", " : "", x[k]);
    own_say(t, "\n");
}

static void say_walk(struct own_text *t, uint32_t steps)
{
    own_say(t, "#define OWN_STEPS_OUTWARD(DO)");
    for (uint32_t k = 0; k < steps; k++)
        own_say(t, " DO(%u)", k);
    own_say(t, "\n#define OWN_STEPS_INWARD(DO)");
    for (uint32_t k = steps; k-- > 0;)
        own_say(t, " DO(%u)", k);
    own_say(t, "\n");
}

/* The children of every body, the last one first; and DO(0) DO(1) .. for as many as one body has */
static void say_children(struct own_text *t, const tfa_model *m)
{
    uint32_t most = 1;
    for (uint32_t i = 0; i < m->bodies; i++) {
        uint32_t count = 0;
        for (uint32_t k = 0; k < m->bodies; k++)
            count += m->body[k].parent == (int32_t)i;
        most = count > most ? count : most;
    }
    own_say(t, "#define OWN_RANKS(DO)");
    for (uint32_t k = 0; k < most; k++)
        own_say(t, " DO(%u)", k);
    own_say(t, "\nstatic const int32_t own_child[OWN_BODIES][%u] = {\n", most);
    for (uint32_t i = 0; i < m->bodies; i++) {
        uint32_t count = 0;
        own_say(t, "    {");
        for (uint32_t k = m->bodies; k-- > 0;)
            if (m->body[k].parent == (int32_t)i)
                own_say(t, "%s%u", count++ ? ", " : "", k);
        for (; count < most; count++)
            own_say(t, "%s-1", count ? ", " : "");
        own_say(t, "},\n");
    }
    own_say(t, "};\n");
}

void own_say_limbs(struct own_text *t, const tfa_model *m, uint32_t lanes_max)
{
    int32_t table[TFA_SPECIALISED_BODIES_MAX * TFA_LIMBS_LANES_MAX];
    uint32_t steps[TFA_SPECIALISED_BODIES_MAX], lanes[TFA_SPECIALISED_BODIES_MAX];
    const struct tfa_packing p = choose(m, lanes_max, table);
    if (!p.steps)
        return;
    for (uint32_t k = 0; k < p.steps * p.lanes; k++)
        if (p.body[k] >= 0) {
            steps[p.body[k]] = k / p.lanes;
            lanes[p.body[k]] = k % p.lanes;
        }
    own_say(t,
            "\n/* Limbs side by side: in step k lane l holds body own_step[k].body[l], if bit l of "
            ".held is set. Where\n * each body stands, and its children, the last one first. */\n"
            "#define OWN_LIMB_LANES %u\n#define OWN_STEPS %u\n",
            p.lanes, p.steps);
    say_walk(t, p.steps);
    say_steps(t, m, &p, steps);
    say_list(t, "OWN_STEP_OF", steps, m->bodies);
    say_list(t, "OWN_LANE_OF", lanes, m->bodies);
    say_children(t, m);
}
