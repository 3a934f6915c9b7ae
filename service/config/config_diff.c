/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Keys that a reload may not change, from the table of keys.
 */
#include <string.h>

#include "config_table.h"

/* The first difference found: its path, and both values where they are short. */
typedef struct difference {
    const config *next;
    char *text;
    size_t size;
} difference;

static bool differ(const config_table *t, const char *now, const char *next, const char *path,
                   const difference *d);

static bool same_text(const char *a, const char *b)
{
    return a == b || (a && b && strcmp(a, b) == 0);
}

static bool same_scalar(config_kind kind, const void *a, const void *b)
{
    switch (kind) {
    case CONFIG_BOOL:
        return *(const bool *)a == *(const bool *)b;
    case CONFIG_NUMBER:
        return memcmp(a, b, sizeof(double)) == 0;
    case CONFIG_TEXT:
        return same_text(*(const char *const *)a, *(const char *const *)b);
    default:
        return *(const uint32_t *)a == *(const uint32_t *)b;
    }
}

/* @return true, for the caller to hand on */
static bool set_difference(const difference *d, const char *path, const char *what)
{
    char location[256];
    config_location(d->next, path, location, sizeof location);
    snprintf(d->text, d->size, "%s: %s %s", location, path, what);
    return true;
}

static bool lists_differ(const config_row *row, const char *now, const char *next, const char *path,
                         const difference *d)
{
    const char *a = *(const char *const *)(const void *)(now + row->at);
    const char *b = *(const char *const *)(const void *)(next + row->at);
    const size_t count = *(const size_t *)(const void *)(now + row->count_at);
    const size_t size = config_entry_size(row);
    char entry[256], what[64];
    snprintf(what, sizeof what, "has %zu entries, it had %zu",
             *(const size_t *)(const void *)(next + row->count_at), count);
    if (*(const size_t *)(const void *)(next + row->count_at) != count)
        return set_difference(d, path, what);
    for (size_t i = 0; i < count; i++) {
        snprintf(entry, sizeof entry, "%.200s[%zu]", path, i);
        if (row->table ? differ(row->table, a + i * size, b + i * size, entry, d)
                       : !same_scalar(row->entry, a + i * size, b + i * size) &&
                             set_difference(d, entry, "is another"))
            return true;
    }
    return false;
}

static bool differ(const config_table *t, const char *now, const char *next, const char *path,
                   const difference *d)
{
    char key[256];
    for (const config_row *row = t->rows; row->key; row++) {
        if (row->reloadable)
            continue;
        snprintf(key, sizeof key, "%.200s%s%s", path, *path ? "." : "", row->key);
        if (row->kind == CONFIG_GROUP) {
            if (differ(row->table, now + row->at, next + row->at, key, d))
                return true;
        } else if (row->kind == CONFIG_LIST) {
            if (lists_differ(row, now, next, key, d))
                return true;
        } else if (!same_scalar(row->kind, now + row->at, next + row->at)) {
            return set_difference(d, key, "is another");
        }
    }
    return false;
}

bool config_needs_restart(const config *now, const config *next, char *text, size_t size)
{
    const difference d = {next, text, size};
    return differ(&config_top, (const char *)now, (const char *)next, "", &d);
}
