/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The subcommands of `totalforce` and their shared parts.
 */
#ifndef TOOLS_COMMON_COMMANDS_H
#define TOOLS_COMMON_COMMANDS_H

#include <argp.h>
#include <stdint.h>
#include <stdio.h>
#include <totalforce/text.h>

/** Exit statuses of every subcommand. */
enum {
    EXIT_GOOD = 0,
    EXIT_UNMET = 1,  /**< it ran, and an expectation did not hold */
    EXIT_FAILED = 2, /**< it could not do its work */
    EXIT_USAGE = 3,  /**< the command line is wrong */
};

/* Each takes its own command line, argv[0] being "totalforce NAME", and returns an exit status. */
int command_model(int argc, char **argv);
int command_solve(int argc, char **argv);
int command_call(int argc, char **argv);
int command_latency(int argc, char **argv);
int command_status(int argc, char **argv);
int command_list(int argc, char **argv);
int command_top(int argc, char **argv);
int command_reload(int argc, char **argv);
int command_stop(int argc, char **argv);
int command_methods(int argc, char **argv);
int command_chain(int argc, char **argv);
int command_specialise(int argc, char **argv);
int command_record(int argc, char **argv);
int command_replay(int argc, char **argv);

/* Option values. A bad one ends the program with usage (argp_error), naming the option. */

uint64_t option_unsigned(struct argp_state *state, const char *name, const char *text,
                         uint64_t lowest, uint64_t highest);
double option_double(struct argp_state *state, const char *name, const char *text);
/** Above 0 and at most `most`, which may be INFINITY. */
double option_positive(struct argp_state *state, const char *name, const char *text, double most);
/** "x,y,...": at most `most` finite numbers. @return how many */
uint32_t option_numbers(struct argp_state *state, const char *name, const char *text, double *out,
                        uint32_t most);
/** "x,y,z" */
void option_vector3(struct argp_state *state, const char *name, const char *text, double out[3]);
/** Value of a word of an enum; the error names the words. */
int option_enum(struct argp_state *state, const char *name, const char *text, tfa_words of);
/** The value of --method */
tfa_method option_method(struct argp_state *state, const char *text);
/** Index of `text` in a list of `count` words; the error names the words. */
int option_word(struct argp_state *state, const char *name, const char *text,
                const char *const *words, int count);
/** Takes one positional argument; a second one is a usage error. */
void option_argument(struct argp_state *state, const char **slot, const char *text);

/** Calls `take` for each word of "a,b,c", which is cut up in place. */
void for_each_word(struct argp_state *state, char *text,
                   void (*take)(struct argp_state *state, char *word));
/** The command line as it was typed, if no list was cut up yet; free() it. NULL: out of memory. */
char *join_arguments(int argc, char **argv);

#endif
