/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One process alone, and what the environment says about others.
 */
#include "sweep_ranks.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>
#include <unistd.h>

/* A whole number of the environment, or -1 */
static int number(const char *name)
{
    uint64_t value;
    const char *text = getenv(name);
    if (!text || tfa_whole_number_read(text, strlen(text), &value) != TFA_NUMBER_OK ||
        value > INT32_MAX)
        return -1;
    return (int)value;
}

/* Open MPI's mpirun, PMI launchers, and srun, which says how many tasks its step has: a batch
 * script has no step of its own. */
int sweep_launched_ranks(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (number(names[k]) > 0)
            return number(names[k]);
    return 1;
}

int sweep_launched_rank(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (number(names[k]) >= 0)
            return number(names[k]);
    return number("SLURM_STEP_NUM_TASKS") > 1 && number("SLURM_PROCID") > 0 ? number("SLURM_PROCID")
                                                                            : 0;
}

static int files[SWEEP_FILES] = {-1, -1};

static void start(sweep_ranks *ranks)
{
    (void)ranks;
}

static void broadcast(void *data, size_t size)
{
    (void)data;
    (void)size;
}

static int agree(int good)
{
    return good;
}

static void merge_statistics(statistics *s)
{
    (void)s;
}

static void merge_doubles(double *values, int count)
{
    (void)values;
    (void)count;
}

static void merge_bits(uint8_t *bits, size_t bytes)
{
    (void)bits;
    (void)bytes;
}

static int open_file(int file, const char *path, uint64_t size)
{
    files[file] = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    return files[file] < 0 || ftruncate(files[file], (off_t)size) != 0 ? errno : 0;
}

static int write_file(int file, uint64_t offset, const void *data, size_t size)
{
    for (const char *at = data; size > 0;) {
        const ssize_t put = pwrite(files[file], at, size, (off_t)offset);
        if (put < 0 && errno != EINTR)
            return errno;
        if (put <= 0)
            continue;
        at += put;
        offset += (uint64_t)put;
        size -= (size_t)put;
    }
    return 0;
}

static int close_file(int file)
{
    const int bad = files[file] >= 0 && close(files[file]) != 0;
    files[file] = -1;
    return bad ? errno : 0;
}

static void finish(void) {}

sweep_ranks sweep_ranks_single = {.rank = 0,
                                  .size = 1,
                                  .start = start,
                                  .broadcast = broadcast,
                                  .agree = agree,
                                  .merge_statistics = merge_statistics,
                                  .merge_doubles = merge_doubles,
                                  .merge_bits = merge_bits,
                                  .open_file = open_file,
                                  .write_file = write_file,
                                  .close_file = close_file,
                                  .finish = finish};
