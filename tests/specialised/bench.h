/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A scratch folder with sources in which fake_kernel.c takes the place of
 * dynamics/specialised/specialised.c, and what is built of them.
 */
#ifndef TESTS_SPECIALISED_BENCH_H
#define TESTS_SPECIALISED_BENCH_H

#include <totalforce/totalforce.h>

typedef struct bench {
    char folder[64];   /* of its own, mode 0700 */
    char sources[128]; /* in it: with dynamics/specialised/specialised.c */
    char kernels[128]; /* in it: where kernels are looked for */
    tfa_model *arm;
    char error_text[1024]; /* of the last refusal */
} bench;

void bench_open(bench *b);
void bench_close(bench *b);

/** A model of config/robots. */
tfa_model *bench_robot(const char *file, tfa_base base);

/** Path of a file in the scratch folder. */
const char *bench_path(const bench *b, const char *name, char path[256]);

/** Compiles fake_kernel.c with that fault for a model into `path`; must go well. */
void bench_build(bench *b, const tfa_model *model, const char *fault, const char *path);
/** Loads `path` for the arm. @return as tfa_specialised_load; what was loaded is freed again. */
int bench_load(bench *b, const char *path);
/** Fails unless the last reason holds `text`. */
void bench_assert_error_text(const bench *b, const char *text);

/** Some number in -1 .. 1 for each index; floats hold it. */
double bench_number(size_t k);
/** Some pose for each index. */
void bench_pose(size_t k, double pose[7]);

/** All of a file, malloc; and back. */
char *bench_read(const char *path, size_t *size);
void bench_write(const char *path, const void *bytes, size_t size);

#endif
