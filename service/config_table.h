/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of configuration keys, and how it is walked.
 */
#ifndef TFA_SERVICE_CONFIG_TABLE_H
#define TFA_SERVICE_CONFIG_TABLE_H

#include <cyaml/cyaml.h>

#include "config.h"

#define CONFIG_ROWS_MAX 24

typedef enum config_kind {
    CONFIG_COUNT,  /* uint32_t */
    CONFIG_BOOL,   /* bool */
    CONFIG_NUMBER, /* double */
    CONFIG_TEXT,   /* const char *; NULL when absent */
    CONFIG_WORD,   /* uint32_t, one of `words` */
    CONFIG_GROUP,  /* a nested struct: `table` */
    CONFIG_LIST,   /* pointer and size_t count: entries of `entry`, or structs of `table` */
} config_kind;

struct config_table;

typedef struct config_row {
    const char *key;
    config_kind kind;
    size_t at, count_at; /* offsets in the struct */
    bool required;
    bool live;                /* a reload may change it; of a GROUP or LIST with table: see there */
    uint32_t standard;        /* the default of COUNT, BOOL and WORD */
    double low, high;         /* range of COUNT and NUMBER; entries of a LIST */
    const char *const *words; /* of WORD, up to NULL: the value is the index */
    config_kind entry;        /* of a LIST without table: COUNT, NUMBER or TEXT */
    struct config_table *table;
    const char *help;
} config_row;

typedef struct config_table {
    const config_row *rows;                           /* up to a row without key */
    size_t size;                                      /* of the struct */
    cyaml_schema_field_t fields[CONFIG_ROWS_MAX + 1]; /* made from the rows */
    cyaml_schema_value_t value;                       /* of an entry that is this struct */
    cyaml_schema_value_t entries[CONFIG_ROWS_MAX];    /* of scalar entries of lists */
    cyaml_strval_t words[CONFIG_ROWS_MAX][8];
} config_table;

/** What libcyaml fills in for a row: a pointer, NULL where the key is absent. */
typedef struct config_raw {
    void *value;
    uint64_t count;
} config_raw;

extern config_table config_top;

/** Makes the libcyaml schema of a table and those below it. */
void config_build(config_table *table);

/** Bytes of an entry of a LIST in the configuration. */
size_t config_entry_size(const config_row *row);

/** Where the value of a path like "robots[1].urdf" stands in the file; 0, 0 when it is nowhere. */
void config_locate(const char *file, const char *path, size_t *line, size_t *column);

/** Where the first key of that name stands at or after a place, which is then updated: libcyaml
 *  knows only the place of the value before an offending key. */
void config_locate_key(const char *file, const char *key, size_t *line, size_t *column);

#endif
