/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the YAML of a side file to tfa_constraints.
 */
#include <stdlib.h>
#include <string.h>
#include <totalforce/constraints.h>
#include <totalforce/text.h>

#include "modes/side_file.h"

enum { ENTRIES_MAX = 10000, PATH = 96 };
enum { KEY_CONSTRAINTS, KEY_ACTUATED, TOP_KEYS };
enum { KEY_NAME, KEY_FIRST, KEY_SECOND, KEY_HOLD, KEY_UNILATERAL, CONSTRAINT_KEYS };
enum { KEY_LINK, KEY_XYZ, KEY_RPY, FRAME_KEYS };
static const char *const top_keys[] = {"constraints", "actuated"};
static const char *const constraint_keys[] = {"name", "first", "second", "hold", "unilateral"};
static const char *const frame_keys[] = {"link", "xyz", "rpy"};
static const char top_form[] = "'constraints: [{name: ..}, ..]', 'actuated: [JOINT, ..]'";
static const char constraint_form[] =
    "'name', 'second', 'hold'; if wanted 'first' (else the world), 'unilateral'";
static const char frame_form[] = "'link: LINK', 'xyz: [x, y, z]', 'rpy: [r, p, y]'";

#define WORD(rows, word) {word, rows},
static const struct {
    const char *word;
    uint32_t rows;
} holds[] = {TFA_CONSTRAINT_WORDS(WORD)};
#undef WORD

/* A name, NULL after a fault or without memory, which `status` says */
static char *read_name(tfa_side_file *r, const yaml_node_t *node, const char *path, int *status)
{
    const char *text = tfa_side_text(node);
    if (!text || !*text) {
        FAULT(r, node, path, "a name is expected here");
        return NULL;
    }
    char *copy = strdup(text);
    if (!copy)
        *status = TFA_E_MEMORY;
    return copy;
}

static uint32_t read_word(tfa_side_file *r, const yaml_node_t *node, const char *path)
{
    const char *text = tfa_side_text(node);
    for (size_t k = 0; text && k < sizeof holds / sizeof *holds; k++)
        if (strcmp(holds[k].word, text) == 0)
            return holds[k].rows;
    FAULT(r, node, path, "'%.80s' is not one of point, hinge, weld, x, y, z, rx, ry, rz",
          text ? text : "..");
    return 0;
}

static uint32_t read_hold(tfa_side_file *r, const yaml_node_t *node, const char *path)
{
    uint32_t rows = 0;
    if (node->type != YAML_SEQUENCE_NODE)
        return read_word(r, node, path);
    if (items_of(node) == 0)
        FAULT(r, node, path, "it holds nothing; write point, hinge, weld, or some of x to rz");
    for (size_t k = 0; k < items_of(node); k++)
        rows |= read_word(r, item(r, node, k), path);
    return rows;
}

static uint32_t read_flag(tfa_side_file *r, const yaml_node_t *node, const char *path)
{
    const char *text = tfa_side_text(node);
    if (text && strcmp(text, "true") == 0)
        return 1;
    if (!text || strcmp(text, "false") != 0)
        FAULT(r, node, path, "'%.80s' is not one of true, false", text ? text : "..");
    return 0;
}

/* One side; without a node: the world */
static int read_frame(tfa_side_file *r, const yaml_node_t *node, const char *path,
                      tfa_constraint *c, int side)
{
    const yaml_node_t *values[FRAME_KEYS] = {NULL};
    double xyz[3] = {0}, rpy[3] = {0};
    char key_path[PATH + 16];
    char *link = NULL;
    int status = TFA_OK;
    if (node)
        tfa_side_keys(r, node, path, frame_keys, FRAME_KEYS, frame_form, values);
    for (int key = KEY_LINK; key < FRAME_KEYS; key++) {
        snprintf(key_path, sizeof key_path, "%s.%s", path, frame_keys[key]);
        if (!values[key])
            continue;
        if (key == KEY_LINK)
            link = read_name(r, values[key], key_path, &status);
        else
            tfa_side_numbers(r, values[key], key_path, 3, key == KEY_XYZ ? "m" : "rad",
                             key == KEY_XYZ ? xyz : rpy);
    }
    if (link && strcmp(link, "world") == 0) {
        free(link);
        link = NULL;
    }
    c->link[side] = link;
    tfa_constraint_set_pose(c->pose[side], xyz, rpy);
    return status;
}

static int read_constraint(tfa_side_file *r, const yaml_node_t *node, size_t k, tfa_constraint *c)
{
    const yaml_node_t *values[CONSTRAINT_KEYS] = {NULL};
    char path[40], key_path[PATH];
    int status = TFA_OK;
    snprintf(path, sizeof path, "constraints[%zu]", k);
    tfa_side_keys(r, node, path, constraint_keys, CONSTRAINT_KEYS, constraint_form, values);
    for (int key = KEY_NAME; key < CONSTRAINT_KEYS && status == TFA_OK; key++) {
        const yaml_node_t *value = values[key];
        snprintf(key_path, sizeof key_path, "%s.%s", path, constraint_keys[key]);
        if (key == KEY_FIRST || (key == KEY_SECOND && value))
            status = read_frame(r, value, key_path, c, key - KEY_FIRST);
        else if (!value && key != KEY_UNILATERAL && node->type == YAML_MAPPING_NODE)
            FAULT(r, node, path, "the key '%s' is missing; write %s", constraint_keys[key],
                  constraint_form);
        else if (value && key == KEY_NAME)
            c->name = read_name(r, value, key_path, &status);
        else if (value && key == KEY_HOLD)
            c->rows = read_hold(r, value, key_path);
        else if (value)
            c->unilateral = read_flag(r, value, key_path);
    }
    return status;
}

/* A list and its length; 0 after a fault */
static size_t length_of(tfa_side_file *r, const yaml_node_t *node, const char *path)
{
    const size_t count = node && node->type == YAML_SEQUENCE_NODE ? items_of(node) : 0;
    if (node && node->type != YAML_SEQUENCE_NODE)
        FAULT(r, node, path, "a list is expected here; write %s", top_form);
    if (count > ENTRIES_MAX)
        FAULT(r, node, path, "%zu entries; a file has at most %d", count, ENTRIES_MAX);
    return count > ENTRIES_MAX ? 0 : count;
}

static int read_constraints(tfa_side_file *r, const yaml_node_t *list, tfa_constraints *out)
{
    const size_t count = length_of(r, list, "constraints");
    tfa_constraint *grown = reallocarray(out->list, out->count + count + 1, sizeof *grown);
    int status = grown ? TFA_OK : TFA_E_MEMORY;
    out->list = grown ? grown : out->list;
    for (size_t k = 0; k < count && status == TFA_OK; k++) {
        tfa_constraint *c = &out->list[out->count++];
        *c = (tfa_constraint){0};
        status = read_constraint(r, item(r, list, k), k, c);
    }
    return status;
}

static int read_actuated(tfa_side_file *r, const yaml_node_t *list, tfa_constraints *out)
{
    const size_t count = length_of(r, list, "actuated");
    const char **grown =
        reallocarray(out->actuated, out->actuated_count + count + 1, sizeof *grown);
    int status = grown ? TFA_OK : TFA_E_MEMORY;
    out->actuated = grown ? grown : out->actuated;
    for (size_t k = 0; k < count && status == TFA_OK; k++)
        out->actuated[out->actuated_count++] = read_name(r, item(r, list, k), "actuated", &status);
    return status;
}

static void drop(tfa_constraints *c, size_t count, size_t actuated_count)
{
    while (c->count > count) {
        const tfa_constraint *last = &c->list[--c->count];
        free((void *)(uintptr_t)last->name);
        free((void *)(uintptr_t)last->link[0]);
        free((void *)(uintptr_t)last->link[1]);
    }
    while (c->actuated_count > actuated_count)
        free((void *)(uintptr_t)c->actuated[--c->actuated_count]);
}

static int read_document(tfa_side_file *r, void *out)
{
    const yaml_node_t *root = yaml_document_get_root_node(&r->document);
    const yaml_node_t *values[TOP_KEYS] = {NULL};
    tfa_constraints *c = out;
    const size_t count = c->count, actuated_count = c->actuated_count;
    tfa_side_keys(r, root, "", top_keys, TOP_KEYS, top_form, values);
    int status = read_constraints(r, values[KEY_CONSTRAINTS], c);
    if (status == TFA_OK)
        status = read_actuated(r, values[KEY_ACTUATED], c);
    if (status != TFA_OK || r->errors)
        drop(c, count, actuated_count);
    return status;
}

static const tfa_side_form side_form = {"constraints", "constraints", TFA_CONSTRAINTS_MAX_BYTES,
                                        read_document};

int tfa_constraints_parse(const char *text, size_t length, const char *name,
                          tfa_constraints *constraints, tfa_report *report)
{
    return tfa_side_parse(&side_form, text, length, name, constraints, report);
}

int tfa_constraints_load(const char *path, tfa_constraints *constraints, tfa_report *report)
{
    return tfa_side_load(&side_form, path, constraints, report);
}

void tfa_constraints_free(tfa_constraints *constraints)
{
    if (!constraints)
        return;
    drop(constraints, 0, 0);
    free(constraints->list);
    free(constraints->actuated);
    *constraints = (tfa_constraints){0};
}
