/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce-sweep`: `totalforce sweep` as one rank of an MPI job, and the only program that is
 * linked with MPI.
 */
#include "common/commands.h"
#include "sweep.h"

#include <errno.h>
#include <mpi.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

/* Message sizes are int. */
enum { PIECE = 1 << 30 };

static MPI_File files[SWEEP_FILES] = {MPI_FILE_NULL, MPI_FILE_NULL};
/* Threads take turns (MPI_THREAD_SERIALIZED): every MPI library has that, and a block is written in
 * pieces of hundreds of kilobytes. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void start(sweep_ranks *ranks)
{
    int provided, size;
    MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &ranks->rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    ranks->size = size;
    if (size == 1 && sweep_launched_ranks() > 1) {
        fprintf(
            stderr,
            "totalforce sweep: %d processes were started, and MPI knows of one only: start them "
            "with mpirun or srun --mpi=pmix, or use --part I/N\n",
            sweep_launched_ranks());
        MPI_Finalize();
        exit(EXIT_FAILED);
    }
    if (provided < MPI_THREAD_SERIALIZED) {
        fprintf(stderr, "totalforce sweep: this MPI library does not support threads\n");
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    }
}

static void broadcast(void *data, size_t size)
{
    for (char *at = data; size > 0;) {
        const int piece = size < PIECE ? (int)size : PIECE;
        MPI_Bcast(at, piece, MPI_BYTE, 0, MPI_COMM_WORLD);
        at += piece;
        size -= (size_t)piece;
    }
}

static int agree(int good)
{
    int all = 0;
    good = good != 0;
    MPI_Allreduce(&good, &all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    return all;
}

static void merge_operation(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const statistics *from = in;
    statistics *into = inout;
    (void)type;
    for (int k = 0; k < *count; k++)
        statistics_merge(&into[k], &from[k]);
}

static void merge_statistics(statistics *s)
{
    static statistics all;
    int rank;
    MPI_Datatype type;
    MPI_Op operation;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Type_contiguous(sizeof all, MPI_BYTE, &type);
    MPI_Type_commit(&type);
    MPI_Op_create(merge_operation, 1, &operation);
    MPI_Reduce(s, &all, 1, type, operation, 0, MPI_COMM_WORLD);
    MPI_Op_free(&operation);
    MPI_Type_free(&type);
    if (rank == 0)
        *s = all;
}

/* The result replaces the input of rank 0. */
static void reduce(void *data, int count, MPI_Datatype type, MPI_Op operation)
{
    int rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Reduce(rank == 0 ? MPI_IN_PLACE : data, data, count, type, operation, 0, MPI_COMM_WORLD);
}

static void merge_doubles(double *values, int count)
{
    reduce(values, count, MPI_DOUBLE, MPI_SUM);
}

static void merge_bits(uint8_t *bits, size_t bytes)
{
    reduce(bits, (int)bytes, MPI_BYTE, MPI_BOR);
}

/* MPI's errors have no errno; EIO stands for those without a better one. */
static int errno_of(int error)
{
    int class = MPI_SUCCESS;
    if (error == MPI_SUCCESS)
        return 0;
    MPI_Error_class(error, &class);
    return class == MPI_ERR_NO_SUCH_FILE ? ENOENT
           : class == MPI_ERR_ACCESS     ? EACCES
           : class == MPI_ERR_NO_SPACE   ? ENOSPC
           : class == MPI_ERR_READ_ONLY  ? EROFS
                                         : EIO;
}

static int open_file(int file, const char *path, uint64_t size)
{
    int error = MPI_File_open(MPI_COMM_WORLD, path, MPI_MODE_WRONLY | MPI_MODE_CREATE,
                              MPI_INFO_NULL, &files[file]);
    if (error == MPI_SUCCESS)
        error = MPI_File_set_size(files[file], (MPI_Offset)size);
    return errno_of(error);
}

static int write_file(int file, uint64_t offset, const void *data, size_t size)
{
    MPI_Status status;
    pthread_mutex_lock(&lock);
    const int error =
        MPI_File_write_at(files[file], (MPI_Offset)offset, data, (int)size, MPI_BYTE, &status);
    pthread_mutex_unlock(&lock);
    return errno_of(error);
}

static int close_file(int file)
{
    return files[file] == MPI_FILE_NULL ? 0 : errno_of(MPI_File_close(&files[file]));
}

static void finish(void)
{
    MPI_Finalize();
}

int main(int argc, char **argv)
{
    static sweep_ranks ranks = {.size = 1,
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
    argp_err_exit_status = EXIT_USAGE;
    signal(SIGPIPE, SIG_IGN);
    ranks.rank = sweep_launched_rank();
    return sweep_main(argc, argv, &ranks);
}
