/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of configuration keys, and how it is walked.
 */
#ifndef TFA_SERVICE_CONFIG_CONFIG_TABLE_H
#define TFA_SERVICE_CONFIG_CONFIG_TABLE_H

#include "config.h"

#define CONFIG_ROWS_MAX 32

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
    bool reloadable;          /* a reload may change it; of a GROUP or LIST with table: see there */
    uint32_t default_value;   /* the default of COUNT, BOOL and WORD; NUMBER: 0, which stands for
                                 none where it is not in the range */
    double low, high;         /* range of COUNT and NUMBER; entries of a LIST; WORD: low, the first
                                 index that may be chosen */
    const char *word;         /* of COUNT: it may stand in place of a number, and is the default;
                                 its value is UINT32_MAX */
    const char *const *words; /* of WORD, up to NULL: the value is the index */
    config_kind entry;        /* of a LIST without table: COUNT, NUMBER, TEXT or WORD */
    bool one;                 /* of a LIST without table: an entry may stand for a list of one */
    const struct config_table *table;
    const char *unit; /* of COUNT, NUMBER and entries of NUMBER; NULL: a pure number */
    const char *help;
} config_row;

typedef struct config_table {
    const config_row *rows; /* up to a row without key */
    size_t size;            /* of the struct */
} config_table;

extern const config_table config_top;

/** Bytes of an entry of a LIST in the configuration. */
size_t config_entry_size(const config_row *row);

#endif
