/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Building a kernel: tables, compiler, checksum trailer, rename to its place.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "model/hash.h"
#include "model/model.h"
#include "specialised/specialised_internal.h"

struct build {
    const tfa_model *model;
    tfa_specialise_options options;
    struct process_limits limits;
    const char *path;
    char folder[512], sources[600];
    int lock; /* descriptor of the folder */
    struct compiler_info compiler;
    struct build_commands commands;
    tfa_specialise_result result;
    struct error_text *err;
};

/* ---- files ---- */

static int write_all(int file, const void *bytes, size_t size)
{
    for (size_t done = 0; done < size;) {
        const ssize_t wrote = write(file, (const char *)bytes + done, size - done);
        if (wrote <= 0)
            return -1;
        done += (size_t)wrote;
    }
    return 0;
}

static int write_file(const char *path, const void *bytes, size_t size, mode_t mode)
{
    const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
    if (file < 0)
        return -1;
    const int failed = write_all(file, bytes, size) != 0 || fchmod(file, mode) != 0;
    return (close(file) != 0 || failed) ? -1 : 0;
}

static int write_tables(struct build *b)
{
    char *text, path[4096];
    int status = tfa_specialised_tables(b->model, &text);
    if (status != TFA_OK)
        return status;
    snprintf(path, sizeof path, "%s/robot_tables.h", b->folder);
    if (write_file(path, text, strlen(text), 0600) != 0)
        status = refuse(b->err, TFA_E_FILE, "'%s': %s", path, strerror(errno));
    const size_t path_length = strlen(b->path);
    const int suffixed = path_length > 3 && strcmp(b->path + path_length - 3, ".so") == 0;
    snprintf(path, sizeof path, "%.*s.h", (int)(suffixed ? path_length - 3 : path_length), b->path);
    if (status == TFA_OK && b->options.keep_tables &&
        ((unlink(path) != 0 && errno != ENOENT) || write_file(path, text, strlen(text), 0644) != 0))
        status = refuse(b->err, TFA_E_FILE, "'%s': %s", path, strerror(errno));
    free(text);
    return status;
}

/* Temporary folder beside the result: it needs the same permissions. */
static int make_folder(struct build *b)
{
    const int code = build_folder_make(b->path, b->folder, sizeof b->folder, &b->lock);
    if (code == 0)
        return TFA_OK;
    return refuse(b->err, TFA_E_FILE, "'%s' cannot be written: no folder beside it: %s", b->path,
                  code == ENAMETOOLONG ? "its name is too long" : strerror(code));
}

/* ---- the checksum trailer ---- */

static int sync_folder(const char *path)
{
    char folder[4096];
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    const int at = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const int failed = at < 0 || fsync(at) != 0;
    if (at >= 0)
        close(at);
    return failed;
}

/* Writes the bytes and their trailer to a temporary file, and renames it to `path` once it is on
 * disk. */
static int write_object(struct build *b, const void *bytes, size_t size)
{
    struct checksum_trailer trailer;
    uint8_t hash[32];
    char temporary[4096];
    const int fits =
        snprintf(temporary, sizeof temporary, "%s.XXXXXX", b->path) < (int)sizeof temporary;
    const int file = fits ? mkostemp(temporary, O_CLOEXEC) : -1;
    if (file < 0)
        return refuse(b->err, TFA_E_FILE, "'%s' cannot be written: %s", b->path,
                      fits ? strerror(errno) : "its name is too long");
    tfa_hash_without_gravity(b->model, hash);
    checksum_trailer_make(bytes, size, hash, &trailer);
    int failed = write_all(file, bytes, size) != 0 ||
                 write_all(file, &trailer, sizeof trailer) != 0 || fchmod(file, 0644) != 0 ||
                 fsync(file) != 0;
    failed |= close(file) != 0;
    if (!failed && rename(temporary, b->path) == 0 && !sync_folder(b->path)) {
        b->result.bytes = size + sizeof trailer;
        return TFA_OK;
    }
    refuse(b->err, TFA_E_FILE, "'%s' cannot be written: %s", b->path, strerror(errno));
    unlink(temporary);
    return TFA_E_FILE;
}

static int install_object(struct build *b)
{
    char object[sizeof b->folder + 16];
    struct stat s;
    int status = TFA_E_NOT_COMPUTED;
    snprintf(object, sizeof object, "%s/kernel.so", b->folder);
    const int file = open(object, O_RDONLY | O_CLOEXEC);
    void *bytes = MAP_FAILED;
    if (file >= 0 && fstat(file, &s) == 0 && s.st_size > 0)
        bytes = mmap(NULL, (size_t)s.st_size, PROT_READ, MAP_PRIVATE, file, 0);
    if (bytes == MAP_FAILED)
        refuse(b->err, status, "%s made no shared object", b->compiler.path);
    else if ((size_t)s.st_size > TFA_SPECIALISED_FILE_MAX - sizeof(struct checksum_trailer))
        refuse(b->err, status, "the kernel has %lld bytes, %zu are allowed", (long long)s.st_size,
               TFA_SPECIALISED_FILE_MAX);
    else
        status = write_object(b, bytes, (size_t)s.st_size);
    if (bytes != MAP_FAILED)
        munmap(bytes, (size_t)s.st_size);
    if (file >= 0)
        close(file);
    return status;
}

/* ---- the steps ---- */

/* Runs commands in parallel; the first failure stops the others. */
static int run_in_parallel(struct build *b, int runs)
{
    struct child_process child[BUILD_COMMANDS_MAX] = {0};
    int status = TFA_OK;
    for (int k = 0; status == TFA_OK && k < runs; k++)
        status =
            child_process_start(b->commands.argv[k], b->folder, k, &b->limits, &child[k], b->err);
    for (int k = 0; k < runs; k++) {
        if (status == TFA_OK)
            status = child_process_wait(&child[k], &b->limits, b->err);
        else
            child_process_stop(&child[k]);
    }
    return status;
}

/* Links a kernel with these choices from the objects that are there. */
static int link_kernel(struct build *b, const struct choices *choices)
{
    struct text_buffer t = {0};
    char path[sizeof b->folder + 32];
    snprintf(path, sizeof path, "%s/robot_choice.h", b->folder);
    specialised_choice_write(&t, b->model, choices);
    int status = t.failed ? TFA_E_MEMORY : TFA_OK;
    if (status == TFA_OK && ((unlink(path) != 0 && errno != ENOENT) ||
                             write_file(path, t.text, strlen(t.text), 0600) != 0))
        status = refuse(b->err, TFA_E_FILE, "'%s': %s", path, strerror(errno));
    free(t.text);
    for (int k = b->commands.runs - 2; status == TFA_OK && k < b->commands.runs; k++)
        status = child_process_run(b->commands.argv[k], b->folder, &b->limits, b->err);
    return status;
}

/* Links a kernel for each algorithm and times them, unless one is asked for. */
static int choose_algorithms(struct build *b, int algorithms, struct choices *choices)
{
    char kernel[sizeof b->folder + 16], path[ALGORITHMS][sizeof b->folder + 16];
    const char *paths[ALGORITHMS];
    struct choices uniform = {0};
    int status = TFA_OK;
    if (algorithms < ALGORITHMS)
        return TFA_OK;
    if (b->options.algorithm == TFA_SPECIALISE_CRBA) {
        memset(choices->algorithm, ALGORITHM_CRBA, CHOICES);
        return TFA_OK;
    }
    snprintf(kernel, sizeof kernel, "%s/kernel.so", b->folder);
    for (int a = 0; status == TFA_OK && a < ALGORITHMS; a++) {
        snprintf(path[a], sizeof path[a], "%s/%d.so", b->folder, a);
        paths[a] = path[a];
        memset(uniform.algorithm, a, CHOICES);
        status = link_kernel(b, &uniform);
        if (status == TFA_OK && rename(kernel, path[a]) != 0)
            status =
                refuse(b->err, TFA_E_NOT_COMPUTED, "%s made no shared object", b->compiler.path);
    }
    return status == TFA_OK ? specialised_choose(b->model, paths, choices) : status;
}

/* The kernel, its products fused with sums or not. All commands but the last two make the objects
 * of the algorithms. */
static int make_kernel(struct build *b, int fused)
{
    const int algorithms =
        b->options.algorithm == TFA_SPECIALISE_ABA ? 1 : specialised_algorithms(b->model);
    struct choices choices = {0}; /* ALGORITHM_ABA */
    int status = build_commands_write(&b->commands, &b->compiler, b->sources, b->folder,
                                      &b->options, algorithms, fused, b->err);
    if (status == TFA_OK)
        status = run_in_parallel(b, b->commands.runs - 2);
    if (status == TFA_OK)
        status = choose_algorithms(b, algorithms, &choices);
    return status == TFA_OK ? link_kernel(b, &choices) : status;
}

/* Fused products take 0.87 to 0.93 of the time in batches, 0.94 to 1 for one state (panda, ur5,
 * AVX-512, Intel Xeon VM, clang 14, 2026-11-27). Where factors and summand are constants clang
 * rounds once or twice, by what it sees first: a robot whose states in lanes get other bits (ur5,
 * Lambda^-1) is compiled again, doubles without. gcc before 14 fuses across expressions or not at
 * all. */
static int compile(struct build *b)
{
    char kernel[sizeof b->folder + 16];
    int status = find_compiler(b->options.compiler, b->folder, &b->limits, &b->compiler, b->err);
    const double start = seconds_now();
    snprintf(kernel, sizeof kernel, "%s/kernel.so", b->folder);
    if (status == TFA_OK)
        status = make_kernel(b, 1);
    if (status == TFA_OK && b->compiler.clang && !specialised_same_bits(b->model, kernel))
        status = make_kernel(b, 0);
    b->result.compile_s = seconds_now() - start;
    snprintf(b->result.compiler, sizeof b->result.compiler, "%s", b->compiler.version);
    return status;
}

static int build_kernel(struct build *b)
{
    int status = find_kernel_sources(b->options.sources, b->sources, sizeof b->sources, b->err);
    if (status != TFA_OK)
        return status;
    status = make_folder(b);
    if (status != TFA_OK)
        return status;
    status = write_tables(b);
    if (status == TFA_OK)
        status = compile(b);
    if (status == TFA_OK)
        status = install_object(b);
    build_folder_remove(b->folder, b->lock);
    return status;
}

static uint32_t value_or_default(uint32_t x, uint32_t standard)
{
    return x ? x : standard;
}

int tfa_specialised_build(const tfa_model *model, const tfa_specialise_options *options,
                          const char *path, tfa_specialise_result *result, char *error_text,
                          size_t size)
{
    struct error_text err = begin_error_text(error_text, size);
    if (!model || !path || (options && (uint32_t)options->algorithm > TFA_SPECIALISE_CRBA))
        return TFA_E_ARGUMENT;
    int status = tfa_specialised_check(model, error_text, size);
    if (status != TFA_OK)
        return status;
    struct build *b = calloc(1, sizeof *b);
    if (!b)
        return TFA_E_MEMORY;
    b->model = model;
    b->path = path;
    b->err = &err;
    if (options)
        b->options = *options;
    b->limits = (struct process_limits){
        value_or_default(b->options.seconds, 300), value_or_default(b->options.memory_mib, 4096),
        value_or_default(b->options.file_mib, 64), b->options.cancel};
    status = build_kernel(b);
    if (result)
        *result = b->result;
    free(b);
    return status;
}
