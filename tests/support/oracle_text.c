/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A reader of URDF text for the oracle: elements by their depth, attributes by their name.
 */
#include "oracle_text.h"

#include "oracle_motion.h"
#include "test.h"

enum { TAG = 4096, DEPTH = 64, NAME = 32 };

/* Where the reader is */
struct reader {
    const char *at;
    char tag[TAG]; /* "link name='a'": the element without its brackets */
    char path[DEPTH][NAME];
    int depth; /* of the element: 0 for <robot> */
    int open;  /* elements that are open */
    size_t link, joint;
};

/* Copies the next start tag to r->tag. 0 at the end of the text. */
static int next_element(struct reader *r)
{
    while ((r->at = strchr(r->at, '<'))) {
        if (strncmp(r->at, "<!--", 4) == 0) {
            r->at = strstr(r->at, "-->");
            assert_non_null(r->at);
            continue;
        }
        const char *start = r->at + 1, *end = start;
        for (char quote = 0; *end && (quote || *end != '>'); end++)
            if (quote ? *end == quote : *end == '"' || *end == '\'')
                quote = quote ? 0 : *end;
        r->at = end;
        if (*start == '?' || *start == '!')
            continue;
        if (*start == '/') {
            r->open--;
            continue;
        }
        const int empty = end[-1] == '/';
        const size_t length = (size_t)(end - start) - (size_t)empty;
        assert_true(length < TAG && r->open < DEPTH);
        memcpy(r->tag, start, length);
        r->tag[length] = '\0';
        r->depth = r->open;
        snprintf(r->path[r->depth], NAME, "%.*s", (int)strcspn(r->tag, " \t\r\n"), r->tag);
        r->open += !empty;
        return 1;
    }
    return 0;
}

/* The value of an attribute up to its quote; NULL: the element has none */
static const char *attribute(const char *tag, const char *name, size_t *length)
{
    const size_t size = strlen(name);
    for (const char *p = tag; (p = strstr(p, name)); p += size) {
        const char *q = p + size + strspn(p + size, " \t\r\n");
        if (p == tag || !strchr(" \t\r\n", p[-1]) || *q != '=')
            continue;
        q += 1 + strspn(q + 1, " \t\r\n");
        *length = strcspn(q + 1, *q == '"' ? "\"" : "'");
        return q + 1;
    }
    return NULL;
}

static int read_vector(const char *tag, const char *name, quad v[3])
{
    size_t length;
    const char *value = attribute(tag, name, &length);
    char *at = (char *)(uintptr_t)value;
    for (int k = 0; value && k < 3; k++)
        v[k] = strtod(at, &at);
    return value != NULL;
}

/* Rz(yaw) Ry(pitch) Rx(roll) */
static void read_turn(const char *tag, mat3 *turn)
{
    quad rpy[3];
    if (!read_vector(tag, "rpy", rpy))
        return;
    const mat3 x = mat_about_axis((vec3){{1, 0, 0}}, rpy[0]);
    const mat3 y = mat_about_axis((vec3){{0, 1, 0}}, rpy[1]);
    const mat3 z = mat_about_axis((vec3){{0, 0, 1}}, rpy[2]);
    const mat3 zy = mat_mul(&z, &y);
    *turn = mat_mul(&zy, &x);
}

/* The index of the name in a list of structs that begin with their name */
static size_t find(const char *tag, const void *list, size_t count, size_t stride)
{
    size_t length = 0, k = 0;
    const char *name = attribute(tag, "name", &length);
    assert_non_null(name);
    for (; k < count; k++) {
        const char *other = *(const char *const *)(const void *)((const char *)list + k * stride);
        if (strlen(other) == length && strncmp(other, name, length) == 0)
            break;
    }
    return k;
}

static int is_at(const struct reader *r, const char *parent, const char *element)
{
    return strcmp(r->path[1], parent) == 0 && strcmp(r->path[r->depth], element) == 0;
}

oracle_text *oracle_text_read(const char *text, const tfa_description *d)
{
    const size_t links = d->link_count, joints = d->joint_count;
    struct reader r = {.at = text};
    oracle_text *t = calloc(1, sizeof *t);
    assert_non_null(t);
    /* one more: what the description does not have is written there */
    t->link = calloc(links + 1, sizeof *t->link);
    t->joint = calloc(joints + 1, sizeof *t->joint);
    t->axis = calloc(joints + 1, sizeof *t->axis);
    assert_true(t->link && t->joint && t->axis);
    for (size_t k = 0; k < links; k++)
        t->link[k] = mat_identity();
    for (size_t k = 0; k < joints; k++) {
        t->joint[k] = mat_identity();
        t->axis[k] = (vec3){{1, 0, 0}};
    }
    while (next_element(&r)) {
        if (r.depth == 1 && is_at(&r, "link", "link"))
            r.link = find(r.tag, d->links, links, sizeof *d->links);
        else if (r.depth == 1 && is_at(&r, "joint", "joint"))
            r.joint = find(r.tag, d->joints, joints, sizeof *d->joints);
        else if (r.depth == 2 && is_at(&r, "joint", "origin"))
            read_turn(r.tag, &t->joint[r.joint]);
        else if (r.depth == 2 && is_at(&r, "joint", "axis"))
            (void)read_vector(r.tag, "xyz", t->axis[r.joint].x);
        else if (r.depth == 3 && is_at(&r, "link", "origin") && strcmp(r.path[2], "inertial") == 0)
            read_turn(r.tag, &t->link[r.link]);
    }
    return t;
}

oracle_text *oracle_text_load(const char *path, const tfa_description *description)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const size_t size = (size_t)ftell(file);
    rewind(file);
    char *text = calloc(size + 1, 1);
    assert_non_null(text);
    assert_int_equal(fread(text, 1, size, file), size);
    (void)fclose(file);
    oracle_text *t = oracle_text_read(text, description);
    free(text);
    return t;
}

void oracle_text_free(oracle_text *text)
{
    if (!text)
        return;
    free(text->link);
    free(text->joint);
    free(text->axis);
    free(text);
}

void oracle_use_text(oracle *o, const oracle_text *text)
{
    o->text = text;
}
