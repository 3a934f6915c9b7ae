/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Options that `solve` and `call` have in common, and the run from requests to replies.
 */
#ifndef TOOLS_JSONL_JSONL_OPTIONS_H
#define TOOLS_JSONL_JSONL_OPTIONS_H

#include "jsonl_serve.h"

#include <argp.h>

typedef struct jsonl_options {
    jsonl_defaults defaults;
    int strict;       /**< an error reply makes the exit status 1 */
    const char *file; /**< of requests; NULL or "-": standard input */
} jsonl_options;

#define JSONL_OPTIONS_DEFAULT                                                                      \
    {                                                                                              \
        .defaults = JSONL_DEFAULTS                                                                 \
    }

/** --method, --refine, --estimate, --strict; its input is a jsonl_options. */
extern const struct argp jsonl_argp;

/** Keys of a line, for --help */
#define JSONL_HELP                                                                                 \
    "A request is {\"id\":1,\"op\":OP,\"q\":[...],...}. OP and its keys:\n"                        \
    "  forward_dynamics     q, v, tau, wrench, tips -> qdd, lambda_inv\n"                          \
    "  inverse_dynamics     q, v, qdd, wrench -> tau\n"                                            \
    "  operational_inertia  q, tips -> lambda_inv, rank, eig_min, eig_max\n"                       \
    "  mass_matrix          q -> M\n"                                                              \
    "q, v, tau, qdd are arrays in joint order (`totalforce model --json` prints it) or objects "   \
    "{joint: value}. A floating base has base_pose, base_twist, base_wrench, base_acceleration. "  \
    "Optional: method, refine, estimate, gravity, frame (world, local, local_world_aligned), "     \
    "poses (true: those of the tips), payload ({link, mass, com, inertia} or a list of such), "    \
    "locked ([joint,...]: they do not move). "                                                     \
    "A line that cannot be answered gets {\"id\":..,\"status\":\"error\",\"error\":..,"            \
    "\"code\":..} and the next line is answered all the same."

/** Serves the requests to standard output. @return an exit status of commands.h. */
int jsonl_run(const char *command, const jsonl_options *options, const jsonl_backend *backend);

#endif
