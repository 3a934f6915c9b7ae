/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the YAML of a side file to tfa_link_modes.
 */
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/description.h>
#include <totalforce/modes.h>
#include <totalforce/text.h>

#include "model/report/report_messages.h"
#include "text/yaml_document.h"

/* Names are compared with all before them, hence the bounds of links and child joints. */
enum { DEPTH_MAX = 8, LINKS_MAX = 4096, JOINTS_MAX = 256, ERRORS_LISTED = 100, PATH = 256 };

enum { KEY_MOMENTUM, KEY_MASS, KEY_STIFFNESS, KEY_DAMPING, KEY_LIMIT, KEY_SHAPE, MODE_KEYS };
static const char *const top_keys[] = {"links"}, *const link_keys[] = {"modes"};
static const char *const mode_keys[] = {"momentum", "mass",  "stiffness",
                                        "damping",  "limit", "shape"};

typedef struct reader {
    yaml_document_t document;
    tfa_report *report;
    size_t errors;
} reader;

/* ---- nodes ---- */

__attribute__((format(printf, 4, 5))) static void
report_fault(reader *r, const yaml_mark_t *mark, const char *path, const char *format, ...)
{
    char text[600];
    va_list arguments;
    if (++r->errors > ERRORS_LISTED)
        return;
    va_start(arguments, format);
    if (tfa_report_print(text, sizeof text, format, arguments) < 0)
        *text = '\0';
    va_end(arguments);
    for (char *at = text; *at; at++) /* of values and names; a message is one line */
        if ((unsigned char)*at < ' ' || *at == 0x7f)
            *at = '?';
    tfa_report_add(r->report, TFA_ERROR, (uint32_t)mark->line + 1, "modes", "column %zu: %s%s%s",
                   mark->column + 1, path, *path ? ": " : "", text);
}

#define FAULT(r, node, path, ...) report_fault(r, &(node)->start_mark, path, __VA_ARGS__)

static size_t items_of(const yaml_node_t *node)
{
    return (size_t)(node->data.sequence.items.top - node->data.sequence.items.start);
}

static size_t pairs_of(const yaml_node_t *node)
{
    return (size_t)(node->data.mapping.pairs.top - node->data.mapping.pairs.start);
}

static const yaml_node_t *item(reader *r, const yaml_node_t *node, size_t k)
{
    return yaml_document_get_node(&r->document, node->data.sequence.items.start[k]);
}

static const yaml_node_t *value_of(reader *r, const yaml_node_t *node, size_t k)
{
    return yaml_document_get_node(&r->document, node->data.mapping.pairs.start[k].value);
}

static const yaml_node_t *key_at(reader *r, const yaml_node_t *node, size_t k)
{
    return yaml_document_get_node(&r->document, node->data.mapping.pairs.start[k].key);
}

/* The text of a key; NULL: it is none, or has a NUL character. */
static const char *key_of(reader *r, const yaml_node_t *node, size_t k)
{
    const yaml_node_t *key = key_at(r, node, k);
    if (key->type != YAML_SCALAR_NODE ||
        strlen((const char *)key->data.scalar.value) != key->data.scalar.length)
        return NULL;
    return (const char *)key->data.scalar.value;
}

static bool is_mapping(reader *r, const yaml_node_t *node, const char *path, const char *form)
{
    if (node->type == YAML_MAPPING_NODE)
        return true;
    FAULT(r, node, path, "keys are expected here: %s", form);
    return false;
}

/* The values of known keys; NULL where there is none. `form` shows them. */
static void read_keys(reader *r, const yaml_node_t *node, const char *path,
                      const char *const *names, size_t count, const char *form,
                      const yaml_node_t **values)
{
    if (!is_mapping(r, node, path, form))
        return;
    for (size_t i = 0; i < pairs_of(node); i++) {
        const char *key = key_of(r, node, i);
        const yaml_node_t *value = value_of(r, node, i);
        size_t k = 0;
        while (key && k < count && strcmp(names[k], key) != 0)
            k++;
        if (!key || k == count)
            FAULT(r, key_at(r, node, i), path, "there is no key '%.80s'; write %s", key ? key : "?",
                  form);
        else if (values[k])
            FAULT(r, key_at(r, node, i), path, "%s: it is there twice, first in line %zu", key,
                  values[k]->start_mark.line + 1);
        else
            values[k] = value;
    }
}

/* ---- numbers ---- */

static double read_number(reader *r, const yaml_node_t *node, const char *path)
{
    const char *text =
        node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : NULL;
    double value = 0;
    if (!text || tfa_number_read(text, node->data.scalar.length, &value) != TFA_NUMBER_OK)
        FAULT(r, node, path, "'%.80s' is not a finite number; write it like 2.5 or -1e-3",
              text                               ? text
              : node->type == YAML_SEQUENCE_NODE ? "[..]"
                                                 : "{..}");
    return value;
}

static void read_list(reader *r, const yaml_node_t *node, const char *path, size_t count,
                      const char *what, double *numbers)
{
    const size_t given = node->type == YAML_SEQUENCE_NODE ? items_of(node) : 0;
    if (given != count)
        FAULT(r, node, path, "%zu numbers where %zu are expected: %s", given, count, what);
    else
        for (size_t k = 0; k < count; k++)
            numbers[k] = read_number(r, item(r, node, k), path);
}

/* Row `k` of a matrix, or its diagonal */
static void read_row(reader *r, const yaml_node_t *node, const char *path, size_t n, size_t k,
                     double *matrix)
{
    if (node->type == YAML_SEQUENCE_NODE)
        read_list(r, node, path, n, "a row, one for each mode of the link; or one number",
                  matrix + k * n);
    else
        matrix[k * n + k] = read_number(r, node, path);
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
static void read_shape(reader *r, const yaml_node_t *node, const char *path, size_t k,
                       const tfa_link_modes *link, const arrays *a)
{
    const size_t n = link->mode_count, count = link->shape_count;
    bool seen[JOINTS_MAX] = {0};
    if (!is_mapping(r, node, path, "'JOINT: [dx, dy, dz, tx, ty, tz]'"))
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
            read_list(r, value, path, 6, "[dx, dy, dz, tx, ty, tz]", a->shape + (j * n + k) * 6);
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

static void read_mode(reader *r, const yaml_node_t *node, const char *link_path, size_t k,
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
    read_keys(r, node, path, mode_keys, MODE_KEYS, form, values);
    for (size_t key = 0; key < MODE_KEYS; key++) {
        snprintf(key_path, sizeof key_path, "%s.%s", path, mode_keys[key]);
        if (!values[key]) {
            if (key != KEY_DAMPING && key != KEY_LIMIT && node->type == YAML_MAPPING_NODE)
                FAULT(r, node, path, "the key '%s' is missing; write %s", mode_keys[key], form);
        } else if (key == KEY_MOMENTUM) {
            read_list(r, values[key], key_path, 6, "[lx, ly, lz, ax, ay, az]", a->momentum + 6 * k);
        } else if (key == KEY_LIMIT) {
            a->limit[k] = read_number(r, values[key], key_path);
        } else if (key == KEY_SHAPE) {
            read_shape(r, values[key], key_path, k, link, a);
        } else {
            read_row(r, values[key], key_path, link->mode_count, k, matrices[key]);
        }
    }
}

/* The shape of the first mode, which names the child joints; NULL: there is none. */
static const yaml_node_t *first_shape(reader *r, const yaml_node_t *modes)
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
static double *allocate_link(reader *r, const char *name, const yaml_node_t *shape, size_t n,
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
static int read_link(reader *r, const char *name, const yaml_node_t *node, tfa_modes *modes)
{
    static const char form[] = "'modes: [{momentum: ..}, ..]'";
    char path[PATH];
    const yaml_node_t *list = NULL;
    arrays a;
    snprintf(path, sizeof path, "links.%.160s", name);
    read_keys(r, node, path, link_keys, 1, form, &list);
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

static int read_links(reader *r, const yaml_node_t *node, tfa_modes *modes)
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

static int read_document(reader *r, tfa_modes *modes)
{
    static const char form[] = "'links: {LINK: {modes: [..]}}'";
    const yaml_node_t *root = yaml_document_get_root_node(&r->document), *links = NULL;
    int status = TFA_OK;
    read_keys(r, root, "", top_keys, 1, form, &links);
    if (!links && root->type == YAML_MAPPING_NODE)
        FAULT(r, root, "", "the key 'links' is missing; write %s", form);
    else if (links && is_mapping(r, links, "links", "'LINK: {modes: [..]}'"))
        status = read_links(r, links, modes);
    return status == TFA_OK && r->errors ? TFA_E_PARSE : status;
}

static int parse(const char *text, size_t length, tfa_modes *modes, tfa_report *report)
{
    reader r = {.report = report};
    tfa_yaml_fault fault;
    const size_t before = modes->count;
    if (length > TFA_MODES_MAX_BYTES)
        return TFA_REFUSE(report, TFA_E_FILE, 0, "too-large",
                          "file: more than %d MiB; it is no file of modes",
                          TFA_MODES_MAX_BYTES >> 20);
    FILE *stream = fmemopen((void *)(uintptr_t)(length ? text : "\n"), length ? length : 1, "r");
    if (!stream)
        return TFA_E_MEMORY;
    int status = tfa_yaml_read(stream, DEPTH_MAX, false, &r.document, &fault);
    fclose(stream);
    if (status == TFA_E_PARSE)
        report_fault(&r, &fault.mark, "", "%s", fault.text);
    if (status != TFA_OK)
        return status;
    status = read_document(&r, modes);
    yaml_document_delete(&r.document);
    if (status != TFA_OK)
        drop_links(modes, before);
    return status;
}

/* The report's file is that of the modes if they are refused. */
static int finish(int status, tfa_report *report, char *file_before)
{
    const int error = errno;
    if (status != TFA_OK) {
        free(file_before);
    } else {
        free(report->file);
        report->file = file_before;
    }
    errno = error;
    return status;
}

int tfa_modes_parse(const char *text, size_t length, const char *name, tfa_modes *modes,
                    tfa_report *report)
{
    if (!modes || !report || (!text && length > 0))
        return TFA_E_ARGUMENT;
    char *file_before = report->file;
    report->file = NULL;
    tfa_report_set_file(report, name);
    return finish(parse(text, length, modes, report), report, file_before);
}

int tfa_modes_load(const char *path, tfa_modes *modes, tfa_report *report)
{
    char *text, *file_before;
    size_t length;
    if (!path || !modes || !report)
        return TFA_E_ARGUMENT;
    file_before = report->file;
    report->file = NULL;
    int status = tfa_urdf_read(path, &text, &length, report);
    if (status == TFA_OK) {
        status = parse(text, length, modes, report);
        free(text);
    }
    return finish(status, report, file_before);
}

void tfa_modes_free(tfa_modes *modes)
{
    if (!modes)
        return;
    drop_links(modes, 0);
    free(modes->links);
    *modes = (tfa_modes){0};
}
