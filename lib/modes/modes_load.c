/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the YAML of a side file to tfa_link_modes.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/modes.h>

#include "modes/side_file.h"

/* Names are compared with all before them, hence the bounds of links and child joints. */
enum { LINKS_MAX = 4096, JOINTS_MAX = 256, PATH = 256 };

enum { KEY_MOMENTUM, KEY_MASS, KEY_STIFFNESS, KEY_DAMPING, KEY_LIMIT, KEY_SHAPE, MODE_KEYS };
static const char *const top_keys[] = {"links"}, *const link_keys[] = {"modes"};
static const char *const mode_keys[] = {"momentum", "mass",  "stiffness",
                                        "damping",  "limit", "shape"};

/* Row `k` of a matrix, or its diagonal */
static void read_row(tfa_side_file *r, const yaml_node_t *node, const char *path, size_t n,
                     size_t k, double *matrix)
{
    if (node->type == YAML_SEQUENCE_NODE)
        tfa_side_numbers(r, node, path, n, "a row, one for each mode of the link; or one number",
                         matrix + k * n);
    else
        matrix[k * n + k] = tfa_side_number(r, node, path);
}

/* ---- modes ---- */

/* Arrays of one link while it is read: tfa_link_modes has them constant. */
typedef struct arrays {
    double *momentum, *mass, *stiffness, *damping, *limit, *shape;
} arrays;

static size_t find_joint(const tfa_link_modes *link, const char *name, size_t count)
{
    size_t j = 0;
    while (j < count && strcmp(link->shapes[j].joint, name) != 0)
        j++;
    return j;
}

/* Each mode moves the joints that the first one names, each once. */
static void read_shape(tfa_side_file *r, const yaml_node_t *node, const char *path, size_t k,
                       const tfa_link_modes *link, const arrays *a)
{
    const size_t n = link->mode_count, count = link->shape_count;
    bool seen[JOINTS_MAX] = {0};
    if (!tfa_side_is_mapping(r, node, path, "'JOINT: [dx, dy, dz, tx, ty, tz]'"))
        return;
    for (size_t i = 0; i < pairs_of(node); i++) {
        const char *name = key_of(r, node, i);
        const size_t j = name ? find_joint(link, name, count) : count;
        const yaml_node_t *value = value_of(r, node, i);
        if (j == count)
            FAULT(r, key_at(r, node, i), path,
                  "joint '%.80s' is not in the shape of the first mode; all modes "
                  "of a link have the shape at all of its child joints",
                  name ? name : "?");
        else if (seen[j])
            FAULT(r, key_at(r, node, i), path, "joint '%.80s' is there twice", name);
        else
            tfa_side_numbers(r, value, path, 6, "[dx, dy, dz, tx, ty, tz]",
                             a->shape + (j * n + k) * 6);
        if (j < count)
            seen[j] = true;
    }
    for (size_t j = 0; j < count; j++)
        if (!seen[j])
            FAULT(r, node, path,
                  "joint '%.80s' of the first mode is missing; write zeros if the "
                  "mode leaves it at rest",
                  link->shapes[j].joint);
}

static void read_mode(tfa_side_file *r, const yaml_node_t *node, const char *link_path, size_t k,
                      const tfa_link_modes *link, const arrays *a)
{
    static const char form[] = "'momentum', 'mass', 'stiffness', 'shape'; if wanted 'damping', "
                               "'limit'";
    const yaml_node_t *values[MODE_KEYS] = {NULL};
    double *const matrices[MODE_KEYS] = {
        [KEY_MASS] = a->mass, [KEY_STIFFNESS] = a->stiffness, [KEY_DAMPING] = a->damping};
    char path[PATH + 24], key_path[PATH + 40];
    snprintf(path, sizeof path, "%s[%zu]", link_path, k);
    a->limit[k] = INFINITY;
    tfa_side_keys(r, node, path, mode_keys, MODE_KEYS, form, values);
    for (size_t key = 0; key < MODE_KEYS; key++) {
        snprintf(key_path, sizeof key_path, "%s.%s", path, mode_keys[key]);
        if (!values[key]) {
            if (key != KEY_DAMPING && key != KEY_LIMIT && node->type == YAML_MAPPING_NODE)
                FAULT(r, node, path, "the key '%s' is missing; write %s", mode_keys[key], form);
        } else if (key == KEY_MOMENTUM) {
            tfa_side_numbers(r, values[key], key_path, 6, "[lx, ly, lz, ax, ay, az]",
                             a->momentum + 6 * k);
        } else if (key == KEY_LIMIT) {
            a->limit[k] = tfa_side_number(r, values[key], key_path);
        } else if (key == KEY_SHAPE) {
            read_shape(r, values[key], key_path, k, link, a);
        } else {
            read_row(r, values[key], key_path, link->mode_count, k, matrices[key]);
        }
    }
}

/* The shape of the first mode, which names the child joints; NULL: there is none. */
static const yaml_node_t *first_shape(tfa_side_file *r, const yaml_node_t *modes)
{
    const yaml_node_t *first = item(r, modes, 0);
    for (size_t i = 0; first->type == YAML_MAPPING_NODE && i < pairs_of(first); i++) {
        const char *key = key_of(r, first, i);
        const yaml_node_t *value = value_of(r, first, i);
        if (key && strcmp(key, "shape") == 0 && value->type == YAML_MAPPING_NODE)
            return value;
    }
    return NULL;
}

/* One block with the arrays and names of a link; its start is `momentum`. NULL without memory. */
static double *allocate_link(tfa_side_file *r, const char *name, const yaml_node_t *shape, size_t n,
                             tfa_link_modes *link, arrays *a)
{
    const size_t joints = shape ? pairs_of(shape) : 0;
    const size_t numbers = n * (6 + 3 * n + 1 + 6 * joints);
    size_t bytes = strlen(name) + 1;
    for (size_t j = 0; j < joints; j++)
        bytes += 1 + (key_of(r, shape, j) ? strlen(key_of(r, shape, j)) : 0);
    double *block = calloc(1, numbers * sizeof(double) + joints * sizeof(tfa_mode_shape) + bytes);
    if (!block)
        return NULL;
    *a = (arrays){.momentum = block, .mass = block + 6 * n};
    a->stiffness = a->mass + n * n;
    a->damping = a->stiffness + n * n;
    a->limit = a->damping + n * n;
    a->shape = a->limit + n;
    tfa_mode_shape *shapes = (tfa_mode_shape *)(void *)(block + numbers);
    char *text = (char *)(shapes + joints);
    *link = (tfa_link_modes){text,       n,        a->momentum, a->mass, a->stiffness,
                             a->damping, a->limit, shapes,      0};
    text = stpcpy(text, name) + 1;
    for (size_t j = 0; j < joints; j++) {
        const char *joint = key_of(r, shape, j);
        if (!joint || find_joint(link, joint, link->shape_count) < link->shape_count)
            continue; /* read_shape refuses it */
        shapes[link->shape_count] = (tfa_mode_shape){text, a->shape + link->shape_count * n * 6};
        link->shape_count++;
        text = stpcpy(text, joint) + 1;
    }
    return block;
}

/* @return TFA_OK, errors or not; TFA_E_MEMORY */
static int read_link(tfa_side_file *r, const char *name, const yaml_node_t *node, tfa_modes *modes)
{
    static const char form[] = "'modes: [{momentum: ..}, ..]'";
    char path[PATH];
    const yaml_node_t *list = NULL;
    arrays a;
    snprintf(path, sizeof path, "links.%.160s", name);
    tfa_side_keys(r, node, path, link_keys, 1, form, &list);
    const size_t n = list && list->type == YAML_SEQUENCE_NODE ? items_of(list) : 0;
    if (n < 1 || n > TFA_MAX_LINK_MODES) {
        FAULT(r, list ? list : node, path, "%zu modes; a list of 1 to %d is expected: %s", n,
              TFA_MAX_LINK_MODES, form);
        return TFA_OK;
    }
    const yaml_node_t *shape = first_shape(r, list);
    if (shape && pairs_of(shape) > JOINTS_MAX) {
        FAULT(r, shape, path, "%zu child joints; a flexible link has at most %d", pairs_of(shape),
              JOINTS_MAX);
        return TFA_OK;
    }
    if (!allocate_link(r, name, shape, n, &modes->links[modes->count], &a))
        return TFA_E_MEMORY;
    modes->count++;
    strcat(path, ".modes");
    for (size_t k = 0; k < n; k++)
        read_mode(r, item(r, list, k), path, k, &modes->links[modes->count - 1], &a);
    return TFA_OK;
}

static int read_links(tfa_side_file *r, const yaml_node_t *node, tfa_modes *modes)
{
    const size_t count = pairs_of(node), first = modes->count;
    int status = TFA_OK;
    if (count > LINKS_MAX) {
        FAULT(r, node, "links", "%zu links; a file has at most %d", count, LINKS_MAX);
        return TFA_OK;
    }
    tfa_link_modes *grown = reallocarray(modes->links, first + count + 1, sizeof *grown);
    if (!grown)
        return TFA_E_MEMORY;
    modes->links = grown;
    for (size_t i = 0; i < count && status == TFA_OK; i++) {
        const char *name = key_of(r, node, i);
        const yaml_node_t *value = value_of(r, node, i);
        size_t k = first;
        while (name && k < modes->count && strcmp(modes->links[k].link, name) != 0)
            k++;
        if (!name || k < modes->count)
            FAULT(r, key_at(r, node, i), "links", "link '%.80s' %s", name ? name : "?",
                  name ? "is there twice" : "is no text");
        else
            status = read_link(r, name, value, modes);
    }
    return status;
}

static void drop_links(tfa_modes *modes, size_t count)
{
    while (modes->count > count)
        free((void *)(uintptr_t)modes->links[--modes->count].momentum);
}

static int read_document(tfa_side_file *r, void *out)
{
    static const char form[] = "'links: {LINK: {modes: [..]}}'";
    const yaml_node_t *root = yaml_document_get_root_node(&r->document), *links = NULL;
    tfa_modes *modes = out;
    const size_t before = modes->count;
    int status = TFA_OK;
    tfa_side_keys(r, root, "", top_keys, 1, form, &links);
    if (!links && root->type == YAML_MAPPING_NODE)
        FAULT(r, root, "", "the key 'links' is missing; write %s", form);
    else if (links && tfa_side_is_mapping(r, links, "links", "'LINK: {modes: [..]}'"))
        status = read_links(r, links, modes);
    if (status != TFA_OK || r->errors)
        drop_links(modes, before);
    return status;
}

static const tfa_side_form side_form = {"modes", "modes", TFA_MODES_MAX_BYTES, read_document};

int tfa_modes_parse(const char *text, size_t length, const char *name, tfa_modes *modes,
                    tfa_report *report)
{
    return tfa_side_parse(&side_form, text, length, name, modes, report);
}

int tfa_modes_load(const char *path, tfa_modes *modes, tfa_report *report)
{
    return tfa_side_load(&side_form, path, modes, report);
}

void tfa_modes_free(tfa_modes *modes)
{
    if (!modes)
        return;
    drop_links(modes, 0);
    free(modes->links);
    *modes = (tfa_modes){0};
}
