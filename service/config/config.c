/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loads a configuration, and checks conditions between keys.
 */
#include "config.h"

#include <ctype.h>
#include <errno.h>
#include <libgen.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <totalforce/description.h>
#include <unistd.h>

#include "config_read.h"
#include "ipc/handshake.h"

/* ---- conditions between keys ---- */

static bool is_name(const char *s)
{
    if (!*s || *s == '.' || strlen(s) > TFA_ROBOT_NAME_MAX)
        return false;
    for (; *s; s++)
        if (!isalnum((unsigned char)*s) && !strchr("-_.", *s))
            return false;
    return true;
}

/* Names that could not be read are NULL. */
static bool same_name(const char *a, const char *b)
{
    return a && b && strcmp(a, b) == 0;
}

/* No other robot and no scene of another may have the name that clients would ask for. */
static void check_unique(config_reader *r, const config *c, size_t i, const char *path,
                         const char *name)
{
    char other[2 * TFA_ROBOT_NAME_MAX + 2];
    for (size_t k = 0; k < i; k++) {
        const config_robot *robot = &c->robots[k];
        if (same_name(name, robot->name))
            config_error(r, path, "'%s' is already the name of robots[%zu]", name, k);
        for (size_t s = 0; robot->name && s < robot->scenes_count; s++) {
            if (!robot->scenes[s].name)
                continue;
            snprintf(other, sizeof other, "%.63s.%.63s", robot->name, robot->scenes[s].name);
            if (strcmp(name, other) == 0)
                config_error(r, path, "'%s' is already the name of robots[%zu].scenes[%zu]", name,
                             k, s);
        }
    }
}

static void check_lock(config_reader *r, const config_lock *lock, const char *path)
{
    if (lock->pose_count && lock->pose_count != 3 && lock->pose_count != 7)
        config_error(r, path, "%zu numbers; planar joints take 3, floating joints 7",
                     lock->pose_count);
}

static void check_scene_name(config_reader *r, const config *c, size_t i, size_t k)
{
    const config_robot *robot = &c->robots[i];
    const config_scene *scene = &robot->scenes[k];
    char path[96], name[2 * TFA_ROBOT_NAME_MAX + 2];
    snprintf(path, sizeof path, "robots[%zu].scenes[%zu].name", i, k);
    if (!is_name(scene->name) || strlen(robot->name) + 1 + strlen(scene->name) > TFA_ROBOT_NAME_MAX)
        config_error(r, path, "'%s.%s' is not a name: 1 to %d letters, digits, '-', '_', '.'",
                     robot->name, scene->name, TFA_ROBOT_NAME_MAX);
    for (size_t s = 0; s < k; s++)
        if (same_name(scene->name, robot->scenes[s].name))
            config_error(r, path, "'%s' is already the name of robots[%zu].scenes[%zu]",
                         scene->name, i, s);
    snprintf(name, sizeof name, "%.63s.%.63s", robot->name, scene->name);
    check_unique(r, c, i, path, name);
}

static void check_scene(config_reader *r, const config *c, size_t i, size_t k)
{
    const config_scene *scene = &c->robots[i].scenes[k];
    char path[96];
    for (size_t j = 0; j < scene->locked_count; j++) {
        snprintf(path, sizeof path, "robots[%zu].scenes[%zu].locked[%zu].pose", i, k, j);
        check_lock(r, &scene->locked[j], path);
    }
}

static int refusal_of(const char *word)
{
    static const char *const words[] = {
#define WORD(name, word) word,
        CONFIG_REFUSE_LIST(WORD)
#undef WORD
    };
    for (int k = 0; k < CONFIG_REFUSALS; k++)
        if (word && strcmp(word, words[k]) == 0)
            return k;
    return -1;
}

uint32_t config_refusals(const config_robot *robot)
{
    uint32_t bits = 0;
    for (size_t k = 0; k < robot->refuse_count; k++)
        bits |= 1u << refusal_of(robot->refuse[k]);
    return bits;
}

uint32_t config_constraint_rows(const config_constraint *constraint)
{
#define ROWS(rows, word) rows,
    static const uint32_t rows_of[] = {TFA_CONSTRAINT_WORDS(ROWS)};
#undef ROWS
    uint32_t rows = 0;
    for (size_t k = 0; k < constraint->hold_count; k++)
        rows |= rows_of[constraint->hold[k]];
    return rows;
}

static void check_refusals(config_reader *r, const config_robot *robot, size_t i)
{
    char path[64];
    for (size_t k = 0; k < robot->refuse_count; k++) {
        snprintf(path, sizeof path, "robots[%zu].refuse[%zu]", i, k);
        if (robot->refuse[k] && refusal_of(robot->refuse[k]) < 0)
            config_error(r, path,
                         "'%s' is no kind of request; there are several-tips, spectrum, "
                         "mass-matrix, methods, estimates, batches",
                         robot->refuse[k]);
    }
}

static void check_robot(config_reader *r, const config *c, size_t i)
{
    const config_robot *robot = &c->robots[i];
    char path[64];
    snprintf(path, sizeof path, "robots[%zu].name", i);
    if (robot->name && !is_name(robot->name))
        config_error(r, path, "'%s' is not a name: 1 to %d letters, digits, '-', '_', '.'",
                     robot->name, TFA_ROBOT_NAME_MAX);
    if (robot->name)
        check_unique(r, c, i, path, robot->name);
    snprintf(path, sizeof path, "robots[%zu].slots", i);
    if (robot->slots & (robot->slots - 1))
        config_error(r, path, "%u is not a power of two", robot->slots);
    snprintf(path, sizeof path, "robots[%zu].wait", i);
    if (robot->wait == TFA_WAIT_SPIN && !c->allow_spin)
        config_error(r, path, "spin, but allow_spin is no");
    check_refusals(r, robot, i);
    for (size_t k = 0; k < robot->scenes_count; k++) {
        if (robot->name && robot->scenes[k].name)
            check_scene_name(r, c, i, k);
        check_scene(r, c, i, k);
    }
}

/* A directory opens like a file: only its reading fails. @return false, with errno */
static bool is_readable(const char *path)
{
    struct stat info;
    if (access(path, R_OK) != 0 || stat(path, &info) != 0)
        return false;
    if (S_ISDIR(info.st_mode))
        errno = EISDIR;
    return !S_ISDIR(info.st_mode);
}

static void check_file(config_reader *r, const config *c, size_t i)
{
    char path[64];
    if (!c->robots[i].urdf)
        return;
    char *urdf = config_file_path(c, c->robots[i].urdf), found[TFA_URDF_PATH_MAX];
    snprintf(path, sizeof path, "robots[%zu].urdf", i);
    if (tfa_urdf_find(c->robots[i].urdf, found, sizeof found) != TFA_OK)
        config_error(r, path, "'%s': %s", c->robots[i].urdf, found);
    else if (urdf && !is_readable(urdf))
        config_error(r, path, "'%s' cannot be read: %s", urdf, strerror(errno));
    free(urdf);
}

/* Two FIFO spinners on one core: the second would never run. */
static void check_realtime(config_reader *r, const config *c)
{
    const config_realtime *rt = &c->realtime;
    const long processors = sysconf(_SC_NPROCESSORS_CONF);
    if (rt->affinity_count && rt->affinity_count != c->workers)
        config_error(r, "realtime.affinity", "%zu processors for %u workers; name one for each",
                     rt->affinity_count, c->workers);
    /* with one processor spin is granted to no client: see choose_wait_mode in session.c */
    if (rt->priority && c->allow_spin && processors > 1 && (long)c->workers >= processors)
        config_error(
            r, "realtime.priority",
            "%u workers of real-time priority may spin on all %ld processors and nothing else "
            "would run; fewer workers, or allow_spin: no",
            c->workers, processors);
    for (size_t i = 0; i < rt->affinity_count; i++) {
        if ((long)rt->affinity[i] >= processors)
            config_error(r, "realtime.affinity", "no processor %u; there are 0 to %ld",
                         rt->affinity[i], processors - 1);
        for (size_t k = 0; k < i && rt->priority; k++)
            if (rt->affinity[i] == rt->affinity[k])
                config_error(r, "realtime.affinity",
                             "two workers of priority %u on processor %u: one would never run",
                             rt->priority, rt->affinity[i]);
    }
}

static void check_specialise(config_reader *r, const config *c)
{
    if (c->specialise != CONFIG_SPECIALISE_OFF && !c->specialise_directory)
        config_error(r, "specialise", "needs 'specialise_directory': where the kernels are");
}

static int finish(config_reader *r, config *c)
{
    int status = config_read_table(r, &config_top, yaml_document_get_root_node(r->document), "", c);
    if (status == TFA_OK)
        status = config_set_runtime_dir(c);
    if (status != TFA_OK)
        return status;
    for (size_t i = 0; i < c->robots_count; i++) {
        check_robot(r, c, i);
        check_file(r, c, i);
    }
    config_check_runtime_dir(r, c);
    check_realtime(r, c);
    check_specialise(r, c);
    return r->count ? TFA_E_PARSE : TFA_OK;
}

static int read_file(config_reader *r, config *c)
{
    c->file = strdup(r->file);
    r->document = calloc(1, sizeof *r->document);
    if (!c->file || !r->document) {
        free(r->document);
        return TFA_E_MEMORY;
    }
    int status = config_read_document(r);
    if (status != TFA_OK) {
        free(r->document);
        return status;
    }
    c->document = r->document;
    return finish(r, c);
}

int config_load(const char *file, FILE *errors, config **out)
{
    config_reader r = {.file = file, .errors = errors};
    config *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!c)
        return TFA_E_MEMORY;
    int status = read_file(&r, c);
    if (status != TFA_OK) {
        config_free(c);
        return status;
    }
    *out = c;
    return TFA_OK;
}

/* The lists below a struct, and those below their entries. */
static void free_lists(const config_table *t, char *in)
{
    for (const config_row *row = t->rows; row->key; row++) {
        if (row->kind == CONFIG_GROUP)
            free_lists(row->table, in + row->at);
        if (row->kind != CONFIG_LIST)
            continue;
        char *entries = *(char **)(void *)(in + row->at);
        const size_t count = *(const size_t *)(const void *)(in + row->count_at);
        for (size_t i = 0; entries && row->table && i < count; i++)
            free_lists(row->table, entries + i * row->table->size);
        free(entries);
    }
}

void config_free(config *c)
{
    if (!c)
        return;
    free_lists(&config_top, (char *)c);
    if (c->document)
        yaml_document_delete(c->document);
    free(c->document);
    free(c->default_dir);
    free(c->file);
    free(c);
}

void config_location(const config *c, const char *path, char *text, size_t size)
{
    const yaml_mark_t at = config_follow(c->document, path)->start_mark;
    snprintf(text, size, "%s:%zu:%zu", c->file, at.line + 1, at.column + 1);
}

char *config_file_path(const config *c, const char *name)
{
    char found[TFA_URDF_PATH_MAX], *path = NULL, *directory = strdup(c->file);
    int n = -1;
    if (tfa_urdf_find(name, found, sizeof found) != TFA_OK)
        n = asprintf(&path, "%s", name);
    else if (found[0] == '/')
        n = asprintf(&path, "%s", found);
    else if (directory)
        n = asprintf(&path, "%s/%s", dirname(directory), found);
    free(directory);
    return n < 0 ? NULL : path;
}
