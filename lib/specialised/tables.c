/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constants of a model as C tables, the input of lib/dynamics/specialised/specialised.c. Doubles
 * are hexadecimal, exact to the bit, with a decimal comment.
 */
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/dynamics.h>
#include <totalforce/version.h>

#include "model/hash.h"
#include "model/model.h"
#include "specialised/specialised_internal.h"

static void write_doubles(struct text_buffer *t, const double *x, uint32_t n)
{
    text_append(t, "{");
    for (uint32_t k = 0; k < n; k++)
        text_append(t, "%s%a /* %.9g */", k ? ", " : "", x[k], x[k]);
    text_append(t, "}");
}

static void write_array(struct text_buffer *t, const char *name, const double *x, uint32_t n)
{
    static const double none[1];
    text_append(t, "static const double %s[%u] = ", name, n ? n : 1);
    write_doubles(t, n ? x : none, n ? n : 1);
    text_append(t, ";\n");
}

static void write_header(struct text_buffer *t, const tfa_model *m)
{
    text_append(t, "/* The constants of one robot, written by totalforce " TFA_VERSION ": ");
    text_append_name(t, m->name);
    text_append(t, ", %u bodies.\n", m->bodies);
    text_append(
        t,
        " * Data for dynamics/specialised/specialised.c, where the algorithm is. SI units: m, kg, "
        "rad, s; inertias in kg m^2. Names\n"
        " * of the URDF stand in comments only, with _ for all but letters, digits, . _ and -. */\n"
        "#ifndef ROBOT_TABLES_H\n#define ROBOT_TABLES_H\n#include \"model/model.h\"\n\n");
}

void write_sequence(struct text_buffer *t, const char *name, uint32_t n, int reverse)
{
    text_append(t, "#define %s(DO)", name);
    for (uint32_t k = 0; k < n; k++)
        text_append(t, " DO(%u)", reverse ? n - 1 - k : k);
    text_append(t, "\n");
}

static void write_order(struct text_buffer *t, const tfa_model *m)
{
    uint8_t hash[32];
    tfa_hash_without_gravity(m, hash);
    write_sequence(t, "ROBOT_OUTWARD", m->bodies, 0);
    write_sequence(t, "ROBOT_INWARD", m->bodies, 1);
    text_append(t, "#define ROBOT_HASH {");
    for (int k = 0; k < 32; k++)
        text_append(t, "%s0x%02x", k ? ", " : "", hash[k]);
    text_append(t, "}\n\n");
}

static void write_sizes(struct text_buffer *t, const tfa_model *m)
{
    uint32_t paths = 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        for (int32_t k = (int32_t)i; k >= 0; k = m->body[k].parent)
            paths++;
    const struct {
        const char *name, *text;
        uint32_t value;
    } sizes[] = {
        {"BODIES", "the floating base included", m->bodies},
        {"COORDINATES", "inner, the base's excluded", m->inner_q},
        {"FREEDOMS", "inner, the base's included", m->freedoms},
        {"BASE", "freedoms of the floating base", m->base_freedoms},
        {"Q_COUNT", "of a request", m->q_count},
        {"V_COUNT", "of a request", m->v_count},
        {"FRAMES", "of the model", m->frames},
        {"PATHS", "bodies between each and the world, both included", paths},
        {"DAMPED", "1: damping acts", m->damping != NULL},
        {"HAS_FRICTION", "1: friction acts", m->friction != NULL},
    };
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        text_append(t, "#define ROBOT_%s %u /* %s */\n", sizes[k].name, sizes[k].value,
                    sizes[k].text);
}

/* ---- bodies ---- */

static const char *joint_of(const tfa_model *m, uint32_t body)
{
    for (uint32_t j = 0; j < m->joints; j++)
        if (m->joint[j].body == body)
            return m->joint[j].name;
    return "floating-base";
}

static void write_body_comment(struct text_buffer *t, const tfa_model *m, uint32_t i)
{
    const struct tfa_body *b = &m->body[i];
    text_append(t, "    /* body %u, ", i);
    text_append_name(t, m->body_info[i].name);
    text_append(t, ": %s joint ", joint_types[b->kind].name);
    text_append_name(t, joint_of(m, i));
    if (b->parent < 0) {
        text_append(t, ", on the world */\n");
        return;
    }
    text_append(t, ", on body %d, ", b->parent);
    text_append_name(t, m->body_info[b->parent].name);
    text_append(t, " */\n");
}

static void write_integers(struct text_buffer *t, const struct tfa_body *b)
{
    text_append(t, "     .parent = %d, .link = %u, .q = %u, .v = %u, .kind = %u, .n = %u,\n",
                b->parent, b->link, b->q, b->v, b->kind, b->n);
    text_append(t, "     .regular = %u, .base = %u, .leaf = %u, .last = %u, .axial = %u,\n",
                b->regular, b->base, b->leaf, b->last, b->axial);
    text_append(t, "     .joint_nd = %d, .part = %u, .tree = %d, .depth = %u},\n", b->joint_nd,
                b->part, b->tree, b->depth);
}

static void write_body(struct text_buffer *t, const tfa_model *m, uint32_t i)
{
    const struct tfa_body *b = &m->body[i];
    const struct {
        const char *name;
        const double *x;
        uint32_t n;
    } arrays[] = {{"E", b->E, 9},
                  {"r", b->r, 3},
                  {"h", b->h, 3},
                  {"I", b->I, 6},
                  {"outboard", b->outboard, 2}};
    write_body_comment(t, m, i);
    text_append(t, "    {");
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        text_append(t, "%s.%s = ", k ? "     " : "", arrays[k].name);
        write_doubles(t, arrays[k].x, arrays[k].n);
        text_append(t, ",\n");
    }
    text_append(t, "     .mass = %a /* %.9g */, .armature = %a /* %.9g */, .d = %a /* %.9g */,\n",
                b->mass, b->mass, b->armature, b->armature, b->d, b->d);
    write_integers(t, b);
}

static void write_bodies(struct text_buffer *t, const tfa_model *m)
{
    text_append(t, "\n/* E, r: of the joint's frame in the parent's, m; h: mass times centre of "
                   "mass, kg m; I: xx xy xz yy\n * yz zz about the frame's origin, kg m^2; mass, "
                   "kg; armature, kg m^2 or kg; outboard, kg m^2 and kg: of the sentinel */\n"
                   "static const struct tfa_body robot_body[ROBOT_BODIES] = {\n");
    for (uint32_t i = 0; i < m->bodies; i++)
        write_body(t, m, i);
    text_append(t, "};\n\n");
}

/* Bit i of entry k: body i is on the path from body k to the world. */
static void write_paths(struct text_buffer *t, const tfa_model *m)
{
    text_append(t, "/* bodies on the path from each to the world, as bits */\n"
                   "static const uint64_t robot_path[ROBOT_BODIES][2] = {\n");
    for (uint32_t i = 0; i < m->bodies; i++) {
        uint64_t path[2] = {0};
        for (int32_t k = (int32_t)i; k >= 0; k = m->body[k].parent)
            path[k / 64] |= UINT64_C(1) << (k % 64);
        text_append(t, "    {0x%llx, 0x%llx},\n", (unsigned long long)path[0],
                    (unsigned long long)path[1]);
    }
    text_append(t, "};\n");
}

/* ---- where coordinates and freedoms come from ---- */

static void write_maps(struct text_buffer *t, const tfa_model *m)
{
    const uint32_t freedoms = m->freedoms - m->base_freedoms;
    text_append(t,
                "/* inner coordinate k = multiplier q[from] + offset */\n"
                "static const struct tfa_coordinate robot_coordinate[%u] = {\n",
                m->inner_q ? m->inner_q : 1);
    for (uint32_t k = 0; k < m->inner_q; k++)
        text_append(t, "    {%u, %a, %a},\n", m->coordinate[k].from, m->coordinate[k].multiplier,
                    m->coordinate[k].offset);
    text_append(t, m->inner_q ? "};\n" : "    {0}};\n");
    text_append(t,
                "/* inner freedom k = multiplier v[from] */\n"
                "static const struct tfa_freedom robot_freedom[%u] = {\n",
                freedoms ? freedoms : 1);
    for (uint32_t k = 0; k < freedoms; k++)
        text_append(t, "    {%u, %a},\n", m->freedom[k].from, m->freedom[k].multiplier);
    text_append(t, freedoms ? "};\n" : "    {0}};\n");
}

static void write_forces(struct text_buffer *t, const tfa_model *m)
{
    text_append(t, "/* armature, damping and friction of each inner freedom */\n");
    write_array(t, "robot_armature", m->armature, m->freedoms);
    write_array(t, "robot_damping", m->damping, m->damping ? m->freedoms : 0);
    write_array(t, "robot_friction", m->friction, m->friction ? m->freedoms : 0);
    text_append(t, "static const double robot_friction_velocity = %a;\n", m->friction_velocity);
}

/* Doubles in a vector of this machine */
uint32_t specialised_lanes(void)
{
    return strcmp(tfa_isa_name(), "avx512") == 0 ? 8 : strcmp(tfa_isa_name(), "avx2") == 0 ? 4 : 2;
}

int tfa_specialised_tables(const tfa_model *model, char **text)
{
    struct text_buffer t = {0};
    if (!model || !text)
        return TFA_E_ARGUMENT;
    *text = NULL;
    const int status = tfa_specialised_check(model, NULL, 0);
    if (status != TFA_OK)
        return status;
    /* numbers with a point in every locale; the C locale is static in glibc, so this cannot fail */
    const locale_t previous = uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
    write_header(&t, model);
    write_sizes(&t, model);
    write_order(&t, model);
    write_bodies(&t, model);
    write_paths(&t, model);
    write_maps(&t, model);
    write_forces(&t, model);
    write_body_lane_tables(&t, model, specialised_lanes());
    text_append(&t, "#endif\n");
    uselocale(previous);
    if (t.failed) {
        free(t.text);
        return TFA_E_MEMORY;
    }
    *text = t.text;
    return TFA_OK;
}
