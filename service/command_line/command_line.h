/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Command lines of the daemon and the tools: parsed by argp's tables, which are also printed for
 * the programs that write man pages and shell completion (tools/manual).
 */
#ifndef TFA_SERVICE_COMMAND_LINE_COMMAND_LINE_H
#define TFA_SERVICE_COMMAND_LINE_COMMAND_LINE_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/** The words that stand for the name of an argument, such as METHOD. */
typedef struct command_line_values {
    const char *name;                  /**< NULL ends an array of these */
    const char *(*word)(size_t index); /**< NULL after the last */
} command_line_values;

/** argp_parse without flags. If --print-options is all that argv says, prints the tables and ends
 *  the program. `values` may be NULL. */
error_t command_line_parse(const struct argp *argp, const command_line_values *values, int argc,
                           char **argv, void *input);

/** True if argv is the program and that one option. */
bool command_line_asks(int argc, char **argv, const char *option);

/**
 * One fact a line, fields with tabs between; newline and backslash are written \n and \\ :
 *
 *     about  TEXT            before and after the list of options
 *     after  TEXT
 *     arguments  TEXT
 *     group  TEXT            of the options that follow
 *     option  LONG  SHORT  ARGUMENT  TEXT
 *     values  NAME  WORD...
 */
void command_line_print(const struct argp *argp, const command_line_values *values, FILE *out);

/** A field: a tab before it, special characters escaped; NULL is empty. */
void command_line_print_field(const char *text, FILE *out);

#endif
