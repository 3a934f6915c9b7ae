/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constants of a model as C: what lib/kernel/own.c is compiled with. Doubles are hexadecimal, so
 * that each comes back to the bit, with a decimal for people.
 */
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/dynamics.h>
#include <totalforce/version.h>

#include "model/hash.h"
#include "model/model.h"
#include "own/own.h"

static void say_doubles(struct own_text *t, const double *x, uint32_t n)
{
    own_say(t, "{");
    for (uint32_t k = 0; k < n; k++)
        own_say(t, "%s%a /* %.9g */", k ? ", " : "", x[k], x[k]);
    own_say(t, "}");
}

static void say_array(struct own_text *t, const char *name, const double *x, uint32_t n)
{
    static const double none[1];
    own_say(t, "static const double %s[%u] = ", name, n ? n : 1);
    say_doubles(t, n ? x : none, n ? n : 1);
    own_say(t, ";\n");
}

static void say_head(struct own_text *t, const tfa_model *m)
{
    own_say(t, "/* The constants of one robot, written by totalforce " TFA_VERSION ": ");
    own_say_name(t, m->name);
    own_say(t, ", %u bodies.\n", m->bodies);
    own_say(
        t, " * Data for kernel/own.c, where the algorithm is. SI units: m, kg, rad, s; inertias in "
           "kg m^2. Names\n"
           " * of the URDF stand in comments only, with _ for all but letters, digits, . _ and "
           "-. */\n"
           "#ifndef OWN_TABLES_H\n#define OWN_TABLES_H\n#include \"model/model.h\"\n\n");
}

static void say_order(struct own_text *t, const tfa_model *m)
{
    uint8_t hash[32];
    tfa_hash_without_gravity(m, hash);
    own_say(t, "#define OWN_OUTWARD(DO)");
    for (uint32_t i = 0; i < m->bodies; i++)
        own_say(t, " DO(%u)", i);
    own_say(t, "\n#define OWN_INWARD(DO)");
    for (uint32_t i = m->bodies; i-- > 0;)
        own_say(t, " DO(%u)", i);
    own_say(t, "\n#define OWN_HASH {");
    for (int k = 0; k < 32; k++)
        own_say(t, "%s0x%02x", k ? ", " : "", hash[k]);
    own_say(t, "}\n\n");
}

static void say_sizes(struct own_text *t, const tfa_model *m)
{
    const struct {
        const char *name, *what;
        uint32_t value;
    } sizes[] = {
        {"BODIES", "the floating base included", m->bodies},
        {"COORDINATES", "inner, the base's excluded", m->inner_q},
        {"FREEDOMS", "inner, the base's included", m->freedoms},
        {"BASE", "freedoms of the floating base", m->base_freedoms},
        {"Q_COUNT", "of a request", m->q_count},
        {"V_COUNT", "of a request", m->v_count},
        {"FRAMES", "of the model", m->frames},
        {"DAMPED", "1: damping acts", m->damping != NULL},
    };
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        own_say(t, "#define OWN_%s %u /* %s */\n", sizes[k].name, sizes[k].value, sizes[k].what);
}

/* ---- bodies ---- */

static const char *joint_of(const tfa_model *m, uint32_t body)
{
    for (uint32_t j = 0; j < m->joints; j++)
        if (m->joint[j].body == body)
            return m->joint[j].name;
    return "floating-base";
}

static void say_title(struct own_text *t, const tfa_model *m, uint32_t i)
{
    static const char *const kinds[] = {"revolute", "prismatic", "planar", "free", "fused"};
    const struct tfa_body *b = &m->body[i];
    own_say(t, "    /* body %u, ", i);
    own_say_name(t, m->body_info[i].name);
    own_say(t, ": %s joint ", kinds[b->kind]);
    own_say_name(t, joint_of(m, i));
    if (b->parent < 0) {
        own_say(t, ", on the world */\n");
        return;
    }
    own_say(t, ", on body %d, ", b->parent);
    own_say_name(t, m->body_info[b->parent].name);
    own_say(t, " */\n");
}

static void say_whole_numbers(struct own_text *t, const struct tfa_body *b)
{
    own_say(t, "     .parent = %d, .link = %u, .q = %u, .v = %u, .kind = %u, .n = %u,\n", b->parent,
            b->link, b->q, b->v, b->kind, b->n);
    own_say(t, "     .regular = %u, .base = %u, .leaf = %u, .last = %u, .axial = %u,\n", b->regular,
            b->base, b->leaf, b->last, b->axial);
    own_say(t, "     .multi = %d, .part = %u, .tree = %d, .depth = %u},\n", b->multi, b->part,
            b->tree, b->depth);
}

static void say_body(struct own_text *t, const tfa_model *m, uint32_t i)
{
    const struct tfa_body *b = &m->body[i];
    const struct {
        const char *name;
        const double *x;
        uint32_t n;
    } arrays[] = {
        {"E", b->E, 9}, {"r", b->r, 3}, {"h", b->h, 3}, {"I", b->I, 6}, {"bound", b->bound, b->n}};
    say_title(t, m, i);
    own_say(t, "    {");
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        own_say(t, "%s.%s = ", k ? "     " : "", arrays[k].name);
        say_doubles(t, arrays[k].x, arrays[k].n);
        own_say(t, ",\n");
    }
    own_say(t, "     .mass = %a /* %.9g */, .armature = %a /* %.9g */, .d = %a /* %.9g */,\n",
            b->mass, b->mass, b->armature, b->armature, b->d, b->d);
    say_whole_numbers(t, b);
}

static void say_bodies(struct own_text *t, const tfa_model *m)
{
    own_say(
        t,
        "\n/* E, r: of the joint's frame in the parent's, m; h: mass times centre of mass, kg m; "
        "I: xx xy xz yy\n * yz zz about the frame's origin, kg m^2; mass, kg; armature, kg m^2 "
        "or kg; bound: largest inertia that a freedom may move */\n"
        "static const struct tfa_body own_body[OWN_BODIES] = {\n");
    for (uint32_t i = 0; i < m->bodies; i++)
        say_body(t, m, i);
    own_say(t, "};\n\n");
}

/* ---- where coordinates and freedoms come from ---- */

static void say_maps(struct own_text *t, const tfa_model *m)
{
    const uint32_t freedoms = m->freedoms - m->base_freedoms;
    own_say(t,
            "/* inner coordinate k = multiplier q[from] + offset */\n"
            "static const struct tfa_coordinate own_coordinate[%u] = {\n",
            m->inner_q ? m->inner_q : 1);
    for (uint32_t k = 0; k < m->inner_q; k++)
        own_say(t, "    {%u, %a, %a},\n", m->coordinate[k].from, m->coordinate[k].multiplier,
                m->coordinate[k].offset);
    own_say(t, m->inner_q ? "};\n" : "    {0}};\n");
    own_say(t,
            "/* inner freedom k = multiplier v[from] */\n"
            "static const struct tfa_freedom own_freedom[%u] = {\n",
            freedoms ? freedoms : 1);
    for (uint32_t k = 0; k < freedoms; k++)
        own_say(t, "    {%u, %a},\n", m->freedom[k].from, m->freedom[k].multiplier);
    own_say(t, freedoms ? "};\n" : "    {0}};\n");
}

static void say_forces(struct own_text *t, const tfa_model *m)
{
    own_say(t, "/* armature and damping of each inner freedom */\n");
    say_array(t, "own_armature", m->armature, m->freedoms);
    say_array(t, "own_damping", m->damping, m->damping ? m->freedoms : 0);
}

/* Of doubles, in a vector of this machine */
static uint32_t lanes_here(void)
{
    return strcmp(tfa_isa_name(), "avx512") == 0 ? 8 : strcmp(tfa_isa_name(), "avx2") == 0 ? 4 : 2;
}

int tfa_specialised_tables(const tfa_model *model, char **text)
{
    struct own_text t = {0};
    if (!model || !text)
        return TFA_E_ARGUMENT;
    *text = NULL;
    const int status = tfa_specialised_check(model, NULL, 0);
    if (status != TFA_OK)
        return status;
    /* numbers with a point in every locale; the C locale is static in glibc, so this cannot fail */
    const locale_t former = uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
    say_head(&t, model);
    say_sizes(&t, model);
    say_order(&t, model);
    say_bodies(&t, model);
    say_maps(&t, model);
    say_forces(&t, model);
    own_say_limbs(&t, model, lanes_here());
    own_say(&t, "#endif\n");
    uselocale(former);
    if (t.failed) {
        free(t.text);
        return TFA_E_MEMORY;
    }
    *text = t.text;
    return TFA_OK;
}
