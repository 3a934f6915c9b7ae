/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The processes of a sweep: one alone, or the ranks of an MPI job. Only the program
 * `totalforce-sweep` is linked with MPI; `totalforce sweep` becomes that program under mpirun or
 * srun and is one rank elsewhere.
 */
#ifndef TOOLS_SWEEP_SWEEP_RANKS_H
#define TOOLS_SWEEP_SWEEP_RANKS_H

#include "statistics.h"

#include <stddef.h>
#include <stdint.h>

/* Files that all ranks write at offsets */
enum { SWEEP_FILE_ANSWERS, SWEEP_FILE_STATES, SWEEP_FILES };

/** Operations that all ranks call together return nothing: a job whose communication fails is ended
 *  by MPI. File operations return 0 or an errno. */
typedef struct sweep_ranks {
    int rank, size;
    void (*start)(struct sweep_ranks *ranks);
    /** Rank 0's bytes to all. */
    void (*broadcast)(void *data, size_t size);
    /** Whether `good` on every rank. */
    int (*agree)(int good);
    /** Sums over the ranks, on rank 0. */
    void (*merge_statistics)(statistics *s);
    void (*merge_doubles)(double *values, int count);
    /** Union of bit sets, on rank 0. */
    void (*merge_bits)(uint8_t *bits, size_t bytes);
    /** All ranks open together. An existing file keeps its contents within `size` bytes. */
    int (*open_file)(int file, const char *path, uint64_t size);
    /** By any thread of any rank. */
    int (*write_file)(int file, uint64_t offset, const void *data, size_t size);
    int (*close_file)(int file);
    void (*finish)(void);
} sweep_ranks;

/** One process alone. */
extern sweep_ranks sweep_ranks_single;

/** Number of processes that mpirun or srun started, by their environment; 1 without them. */
int sweep_launched_ranks(void);
/** This process's rank by the environment; 0 without one. */
int sweep_launched_rank(void);

#endif
