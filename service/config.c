/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the configuration: libcyaml, then defaults, ranges and what only the whole can tell.
 */
#include "config.h"

#include <ctype.h>
#include <errno.h>
#include <libgen.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "client/hello.h"
#include "config_table.h"

/* Reads one file: where errors go and how many there were. */
typedef struct reader {
    const char *file;
    FILE *errors;
    unsigned count;
    char message[512];   /* of libcyaml: the cause, */
    size_t line, column; /* and the innermost place of its backtrace, */
    char field[64];      /* and the innermost key, with ": " */
} reader;

__attribute__((format(printf, 3, 4))) static void complain(reader *r, const char *path,
                                                           const char *format, ...)
{
    size_t line, column;
    va_list arguments;
    config_locate(r->file, path, &line, &column);
    fprintf(r->errors, "%s:%zu:%zu: %s: ", r->file, line, column, path);
    va_start(arguments, format);
    vfprintf(r->errors, format, arguments);
    va_end(arguments);
    fputc('\n', r->errors);
    r->count++;
}

/* ---- libcyaml ---- */

/* libcyaml says the cause first and then a backtrace from the inside out. */
static void on_cyaml(cyaml_log_t level, void *context, const char *format, va_list arguments)
{
    reader *r = context;
    char text[512];
    (void)level;
    vsnprintf(text, sizeof text, format, arguments);
    text[strcspn(text, "\n")] = 0;
    const char *place = strstr(text, "(line: ");
    if (place && r->line == 0)
        (void)sscanf(place, "(line: %zu, column: %zu)", &r->line, &r->column);
    char name[48];
    if (place && !r->field[0] && sscanf(text, " in mapping field '%47[^']'", name) == 1)
        snprintf(r->field, sizeof r->field, "%s: ", name);
    if (!place && r->message[0] == 0)
        snprintf(r->message, sizeof r->message, "%s",
                 strncmp(text, "Load: ", 6) == 0 ? text + 6 : text);
}

static void print_cyaml_error(reader *r, cyaml_err_t error)
{
    const char *hint = "", *key = strrchr(r->message, ' ');
    if (error == CYAML_ERR_INVALID_KEY)
        hint = "; totalforced --dump-config shows every key";
    if (strstr(r->message, "already seen"))
        hint = ": it is there twice";
    if (*hint || error == CYAML_ERR_MAPPING_FIELD_MISSING)
        r->field[0] = 0; /* it names the key before the offence */
    if (*hint && key)
        config_locate_key(r->file, key + 1, &r->line, &r->column);
    fprintf(r->errors, "%s:%zu:%zu: %s%s%s\n", r->file, r->line, r->column, r->field,
            r->message[0] ? r->message : cyaml_strerror(error), hint);
}

static cyaml_config_t cyaml_settings(reader *r)
{
    return (cyaml_config_t){
        .log_fn = on_cyaml, .log_ctx = r, .mem_fn = cyaml_mem, .log_level = CYAML_LOG_WARNING};
}

static cyaml_schema_value_t top_schema(void)
{
    cyaml_schema_value_t top = config_top.value;
    top.flags = CYAML_FLAG_POINTER;
    return top;
}

static int parse(reader *r, config_raw **raw)
{
    const cyaml_config_t settings = cyaml_settings(r);
    *raw = NULL;
    config_build(&config_top);
    const cyaml_schema_value_t top = top_schema();
    if (access(r->file, R_OK) != 0) {
        fprintf(r->errors, "%s:0:0: cannot be read: %s\n", r->file, strerror(errno));
        return TFA_E_FILE;
    }
    cyaml_err_t error =
        cyaml_load_file(r->file, &settings, &top, (cyaml_data_t **)(void *)raw, NULL);
    if (error != CYAML_OK) {
        print_cyaml_error(r, error);
        return error == CYAML_ERR_OOM ? TFA_E_MEMORY : TFA_E_PARSE;
    }
    if (!*raw) {
        fprintf(r->errors, "%s:1:1: no keys; at least `robots` is needed\n", r->file);
        return TFA_E_PARSE;
    }
    return TFA_OK;
}

/* ---- from what libcyaml read to the configuration ---- */

static int resolve(reader *r, const config_table *t, const config_raw *raw, const char *path,
                   char *out);

static void check_range(reader *r, const config_row *row, const char *path, double value)
{
    if (!(value >= row->low && value <= row->high))
        complain(r, path, "%.10g is out of range: %.10g to %.10g", value, row->low, row->high);
}

static void resolve_scalar(reader *r, const config_row *row, const void *value, const char *path,
                           void *out)
{
    switch (row->kind) {
    case CONFIG_COUNT:
    case CONFIG_WORD:
        *(uint32_t *)out = value ? *(const uint32_t *)value : row->standard;
        if (row->kind == CONFIG_COUNT)
            check_range(r, row, path, *(uint32_t *)out);
        break;
    case CONFIG_BOOL:
        *(bool *)out = (value ? *(const uint32_t *)value : row->standard) != 0;
        break;
    case CONFIG_NUMBER:
        *(double *)out = value ? *(const double *)value : 0;
        check_range(r, row, path, *(double *)out);
        break;
    default:
        *(const char **)out = value;
        break;
    }
}

static int resolve_list(reader *r, const config_row *row, const config_raw *raw, const char *path,
                        void **out, size_t *count)
{
    char entry_path[256];
    *count = raw->value ? (size_t)raw->count : 0;
    *out = row->table ? NULL : raw->value;
    if (!row->table || *count == 0)
        return TFA_OK;
    char *entries = calloc(*count, row->table->size);
    if (!entries)
        return TFA_E_MEMORY;
    *out = entries;
    for (size_t i = 0; i < *count; i++) {
        const char *from = (const char *)raw->value + i * row->table->value.data_size;
        snprintf(entry_path, sizeof entry_path, "%.200s[%zu]", path, i);
        int status = resolve(r, row->table, (const config_raw *)(const void *)from, entry_path,
                             entries + i * row->table->size);
        if (status != TFA_OK)
            return status;
    }
    return TFA_OK;
}

/* A group that the file leaves out has its defaults. */
static int resolve_group(reader *r, const config_row *row, const config_raw *raw, const char *path,
                         char *out)
{
    static const config_raw nothing[CONFIG_ROWS_MAX];
    return resolve(r, row->table, raw->value ? raw->value : nothing, path, out);
}

static int resolve(reader *r, const config_table *t, const config_raw *raw, const char *path,
                   char *out)
{
    char key_path[256];
    int status = TFA_OK;
    for (size_t i = 0; t->rows[i].key && status == TFA_OK; i++) {
        const config_row *row = &t->rows[i];
        snprintf(key_path, sizeof key_path, "%s%s%s", path, *path ? "." : "", row->key);
        if (row->kind == CONFIG_GROUP)
            status = resolve_group(r, row, &raw[i], key_path, out + row->at);
        else if (row->kind == CONFIG_LIST)
            status = resolve_list(r, row, &raw[i], key_path, (void **)(void *)(out + row->at),
                                  (size_t *)(void *)(out + row->count_at));
        else
            resolve_scalar(r, row, raw[i].value, key_path, out + row->at);
    }
    return status;
}

/* ---- what only the whole can tell ---- */

static bool is_name(const char *s)
{
    if (!*s || *s == '.' || strlen(s) > TFA_ROBOT_NAME_MAX)
        return false;
    for (; *s; s++)
        if (!isalnum((unsigned char)*s) && !strchr("-_.", *s))
            return false;
    return true;
}

/* No other robot and no scene of another may have the name that clients would ask for. */
static void check_unique(reader *r, const config *c, size_t i, const char *path, const char *name)
{
    char other[2 * TFA_ROBOT_NAME_MAX + 2];
    for (size_t k = 0; k < i; k++) {
        const config_robot *robot = &c->robots[k];
        if (strcmp(name, robot->name) == 0)
            complain(r, path, "'%s' is already the name of robots[%zu]", name, k);
        for (size_t s = 0; s < robot->scenes_count; s++) {
            snprintf(other, sizeof other, "%.63s.%.63s", robot->name, robot->scenes[s].name);
            if (strcmp(name, other) == 0)
                complain(r, path, "'%s' is already the name of robots[%zu].scenes[%zu]", name, k,
                         s);
        }
    }
}

static void check_lock(reader *r, const config_lock *lock, const char *path)
{
    if (lock->pose_count && lock->pose_count != 3 && lock->pose_count != 7)
        complain(r, path, "%zu numbers; planar joints take 3, floating joints 7", lock->pose_count);
}

static void check_scene(reader *r, const config *c, size_t i, size_t k)
{
    const config_robot *robot = &c->robots[i];
    const config_scene *scene = &robot->scenes[k];
    char path[96], name[2 * TFA_ROBOT_NAME_MAX + 2];
    snprintf(path, sizeof path, "robots[%zu].scenes[%zu].name", i, k);
    if (!is_name(scene->name) || strlen(robot->name) + 1 + strlen(scene->name) > TFA_ROBOT_NAME_MAX)
        complain(r, path, "'%s.%s' is not a name: 1 to %d letters, digits, '-', '_', '.'",
                 robot->name, scene->name, TFA_ROBOT_NAME_MAX);
    for (size_t s = 0; s < k; s++)
        if (strcmp(scene->name, robot->scenes[s].name) == 0)
            complain(r, path, "'%s' is already the name of robots[%zu].scenes[%zu]", scene->name, i,
                     s);
    snprintf(name, sizeof name, "%.63s.%.63s", robot->name, scene->name);
    check_unique(r, c, i, path, name);
    for (size_t j = 0; j < scene->locked_count; j++) {
        snprintf(path, sizeof path, "robots[%zu].scenes[%zu].locked[%zu].pose", i, k, j);
        check_lock(r, &scene->locked[j], path);
    }
}

static void check_robot(reader *r, const config *c, size_t i)
{
    const config_robot *robot = &c->robots[i];
    char path[64];
    snprintf(path, sizeof path, "robots[%zu].name", i);
    if (!is_name(robot->name))
        complain(r, path, "'%s' is not a name: 1 to %d letters, digits, '-', '_', '.'", robot->name,
                 TFA_ROBOT_NAME_MAX);
    check_unique(r, c, i, path, robot->name);
    snprintf(path, sizeof path, "robots[%zu].slots", i);
    if (robot->slots & (robot->slots - 1))
        complain(r, path, "%u is not a power of two", robot->slots);
    snprintf(path, sizeof path, "robots[%zu].wait", i);
    if (robot->wait == TFA_WAIT_DEFAULT)
        complain(r, path, "choose spin, hybrid or block");
    if (robot->wait == TFA_WAIT_SPIN && !c->allow_spin)
        complain(r, path, "spin, but allow_spin is no");
    for (size_t k = 0; k < robot->scenes_count; k++)
        check_scene(r, c, i, k);
}

static void check_file(reader *r, const config *c, size_t i)
{
    char path[64];
    char *urdf = config_file_path(c, c->robots[i].urdf);
    snprintf(path, sizeof path, "robots[%zu].urdf", i);
    if (urdf && access(urdf, R_OK) != 0)
        complain(r, path, "'%s' cannot be read: %s", urdf, strerror(errno));
    free(urdf);
}

/* Two FIFO spinners on one core: the second would never run. */
static void check_realtime(reader *r, const config *c)
{
    const config_realtime *rt = &c->realtime;
    const long processors = sysconf(_SC_NPROCESSORS_CONF);
    if (rt->affinity_count && rt->affinity_count != c->workers)
        complain(r, "realtime.affinity", "%zu processors for %u workers; name one for each",
                 rt->affinity_count, c->workers);
    /* with one processor nobody is granted spin: see grant_wait in session.c */
    if (rt->priority && c->allow_spin && processors > 1 && (long)c->workers >= processors)
        complain(r, "realtime.priority",
                 "%u workers of real-time priority may spin on all %ld processors and nothing else "
                 "would run; fewer workers, or allow_spin: no",
                 c->workers, processors);
    for (size_t i = 0; i < rt->affinity_count; i++) {
        if ((long)rt->affinity[i] >= processors)
            complain(r, "realtime.affinity", "no processor %u; there are 0 to %ld", rt->affinity[i],
                     processors - 1);
        for (size_t k = 0; k < i && rt->priority; k++)
            if (rt->affinity[i] == rt->affinity[k])
                complain(r, "realtime.affinity",
                         "two workers of priority %u on processor %u: one would never run",
                         rt->priority, rt->affinity[i]);
    }
}

static int set_runtime_dir(config *c)
{
    const char *given = getenv("TOTALFORCE_RUNTIME_DIR"), *xdg = getenv("XDG_RUNTIME_DIR");
    if (c->runtime_dir)
        return TFA_OK;
    int n = -1;
    if (given && *given)
        n = asprintf(&c->default_dir, "%s", given);
    else if (geteuid() != 0 && xdg && *xdg)
        n = asprintf(&c->default_dir, "%s/totalforce", xdg);
    else
        n = asprintf(&c->default_dir, "/run/totalforce");
    if (n < 0)
        c->default_dir = NULL;
    c->runtime_dir = c->default_dir;
    return c->default_dir ? TFA_OK : TFA_E_MEMORY;
}

static int read_crossovers(reader *r, config *c)
{
    char error[512];
    c->crossover = *tfa_crossovers_default();
    if (!c->crossovers)
        return TFA_OK;
    char *path = config_file_path(c, c->crossovers);
    if (!path)
        return TFA_E_MEMORY;
    if (tfa_crossovers_read(path, &c->crossover, error, sizeof error) != TFA_OK)
        complain(r, "crossovers", "%s", error);
    free(path);
    return TFA_OK;
}

static void check_specialise(reader *r, const config *c)
{
    if (c->specialise != CONFIG_SPECIALISE_OFF && !c->specialise_directory)
        complain(r, "specialise", "needs 'specialise_directory': where the kernels are");
}

static int finish(reader *r, config *c)
{
    int status = resolve(r, &config_top, c->raw, "", (char *)c);
    if (status == TFA_OK)
        status = set_runtime_dir(c);
    if (status == TFA_OK)
        status = read_crossovers(r, c);
    if (status != TFA_OK)
        return status;
    for (size_t i = 0; i < c->robots_count; i++) {
        check_robot(r, c, i);
        check_file(r, c, i);
    }
    check_realtime(r, c);
    check_specialise(r, c);
    return r->count ? TFA_E_PARSE : TFA_OK;
}

int config_load(const char *file, FILE *errors, config **out)
{
    reader r = {.file = file, .errors = errors};
    config_raw *raw;
    *out = NULL;
    int status = parse(&r, &raw);
    if (status != TFA_OK)
        return status;
    config *c = calloc(1, sizeof *c);
    if (!c) {
        const cyaml_config_t settings = cyaml_settings(&r);
        const cyaml_schema_value_t top = top_schema();
        (void)cyaml_free(&settings, &top, raw, 0);
        return TFA_E_MEMORY;
    }
    c->raw = raw;
    c->file = strdup(file);
    status = c->file ? finish(&r, c) : TFA_E_MEMORY;
    if (status != TFA_OK) {
        config_free(c);
        return status;
    }
    *out = c;
    return TFA_OK;
}

/* The lists of structs below a struct; those of scalars belong to libcyaml. */
static void free_lists(const config_table *t, char *in)
{
    for (const config_row *row = t->rows; row->key; row++) {
        if (row->kind == CONFIG_GROUP)
            free_lists(row->table, in + row->at);
        if (row->kind != CONFIG_LIST || !row->table)
            continue;
        char *entries = *(char **)(void *)(in + row->at);
        const size_t count = *(const size_t *)(const void *)(in + row->count_at);
        for (size_t i = 0; entries && i < count; i++)
            free_lists(row->table, entries + i * row->table->size);
        free(entries);
    }
}

void config_free(config *c)
{
    if (!c)
        return;
    reader nobody = {0};
    const cyaml_config_t settings = cyaml_settings(&nobody);
    const cyaml_schema_value_t top = top_schema();
    (void)cyaml_free(&settings, &top, c->raw, 0);
    free_lists(&config_top, (char *)c);
    free(c->default_dir);
    free(c->file);
    free(c);
}

void config_place(const config *c, const char *path, char *text, size_t size)
{
    size_t line, column;
    config_locate(c->file, path, &line, &column);
    snprintf(text, size, "%s:%zu:%zu", c->file, line, column);
}

char *config_file_path(const config *c, const char *name)
{
    char *path = NULL, *directory = strdup(c->file);
    int n = -1;
    if (name[0] == '/')
        n = asprintf(&path, "%s", name);
    else if (directory)
        n = asprintf(&path, "%s/%s", dirname(directory), name);
    free(directory);
    return n < 0 ? NULL : path;
}
