/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Results of a measuring subcommand: a file of rows in a folder, its head, and pictures.
 */
#ifndef TOOLS_COMMON_RESULTS_H
#define TOOLS_COMMON_RESULTS_H

#include <jansson.h>
#include <stdio.h>
#include <sys/types.h>

/** Opens NAME.csv or NAME.jsonl in the folder, which is made; standard output without a folder.
 * @return NULL after a message that begins with "totalforce NAME" */
FILE *results_open(const char *name, const char *folder, int json);

/** Flushes, so that a run ends where its rows can no longer be written.
 * @return 0, or the errno of the first write that failed */
int results_flush(FILE *out);

/** Flushes, and closes a file that is not standard output. @return an exit status; the reason
 * stands on stderr */
int results_close(const char *name, FILE *out);

/** Comment lines: command line, date, processor, kernels, version. */
void results_print_head(FILE *out, const char *command);

/** Nothing where there is no finite number. */
void results_print_number(FILE *out, const char *format, double value);

/** A word of CSV: in quotes where it has commas, quotes or control characters (blanks, then). */
void results_print_text(FILE *out, const char *text);

/** A number in JSON: null where there is no finite number. */
void results_set_number(json_t *object, const char *key, double value);

/** gnuplot, fed through its standard input, with our scripts. */
typedef struct gnuplot_pipe {
    const char *name; /**< of the subcommand: its scripts are in NAME.d */
    FILE *in;
    pid_t pid;
    char scripts[4096];
} gnuplot_pipe;

/** Starts gnuplot and tells it the folders of scripts and pictures.
 * @param scripts NULL: beside the program, as installed and as built
 * @return 0, or -1 after a message; gnuplot_finish is due in both cases */
int gnuplot_start(gnuplot_pipe *g, const char *name, const char *scripts, const char *folder);

/** @return an exit status; the reason stands on stderr */
int gnuplot_finish(gnuplot_pipe *g);

/** name = "text", of one or more lines */
void gnuplot_string(FILE *in, const char *name, const char *text);

#endif
