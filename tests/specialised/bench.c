/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scratch folders and stand-ins, see bench.h.
 */
#include "bench.h"

#include "models.h"
#include "support/wait.h"
#include "test.h"

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

static void link_to(const bench *b, const char *target, const char *name)
{
    char to[512], at[256];
    snprintf(to, sizeof to, TFA_SOURCE_DIR "/%s", target);
    assert_int_equal(symlink(to, bench_path(b, name, at)), 0);
}

static void make_folder(const bench *b, const char *name)
{
    char at[256];
    assert_int_equal(mkdir(bench_path(b, name, at), 0755), 0);
}

static void write_empty(const bench *b, const char *name)
{
    char path[256];
    bench_write(bench_path(b, name, path), "", 0);
}

void bench_open(bench *b)
{
    *b = (bench){.folder = "/tmp/tfa-specialised-XXXXXX"};
    assert_non_null(mkdtemp(b->folder));
    snprintf(b->sources, sizeof b->sources, "%s/sources", b->folder);
    snprintf(b->kernels, sizeof b->kernels, "%s/kernels", b->folder);
    make_folder(b, "sources");
    make_folder(b, "sources/dynamics");
    make_folder(b, "sources/dynamics/specialised");
    make_folder(b, "kernels");
    link_to(b, "lib/interface", "sources/interface");
    link_to(b, "lib/model", "sources/model");
    link_to(b, "lib/include", "sources/include");
    write_empty(b, "sources/dynamics/specialised/specialised_solve.c");
    write_empty(b, "sources/dynamics/specialised/specialised_body_lanes.c");
    write_empty(b, "sources/dynamics/specialised/specialised_derivatives.c");
    b->arm = bench_robot("arm7.urdf", TFA_BASE_FIXED);
}

void bench_close(bench *b)
{
    char command[128];
    tfa_model_free(b->arm);
    snprintf(command, sizeof command, "rm -rf %s 2>/dev/null", b->folder);
    /* a compiler of a killed build may still write there */
    assert_true(WAIT_FOR(system(command) == 0));
}

const char *bench_path(const bench *b, const char *name, char path[256])
{
    snprintf(path, 256, "%s/%s", b->folder, name);
    return path;
}

tfa_model *bench_robot(const char *file, tfa_base base)
{
    const tfa_model_options options = {.base = base};
    return bundled_model(file, &options);
}

char *bench_read(const char *path, size_t *size)
{
    FILE *file = fopen(path, "re");
    assert_non_null(file);
    struct stat facts;
    assert_int_equal(fstat(fileno(file), &facts), 0);
    *size = (size_t)facts.st_size;
    char *bytes = calloc(1, *size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

void bench_write(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "we");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

void bench_build(bench *b, const tfa_model *model, const char *fault, const char *path)
{
    char text[640], path_of[256];
    const tfa_specialise_options options = {.sources = b->sources, .algorithm = TFA_SPECIALISE_ABA};
    const int length = snprintf(text, sizeof text,
                                "#define FAKE_KERNEL_FAULT FAULT_%s\n#include \"" TFA_SOURCE_DIR
                                "/tests/specialised/fake_kernel.c\"\n",
                                fault);
    bench_write(bench_path(b, "sources/dynamics/specialised/specialised.c", path_of), text,
                (size_t)length);
    const int status =
        tfa_specialised_build(model, &options, path, NULL, b->error_text, sizeof b->error_text);
    if (status != TFA_OK)
        fail_msg("%s", b->error_text);
}

int bench_load(bench *b, const char *path)
{
    tfa_specialised *kernel;
    const int status =
        tfa_specialised_load(path, b->arm, &kernel, b->error_text, sizeof b->error_text);
    assert_true((status == TFA_OK) == (kernel != NULL));
    assert_true((status == TFA_OK) == (b->error_text[0] == '\0'));
    tfa_specialised_free(kernel);
    return status;
}

void bench_assert_error_text(const bench *b, const char *text)
{
    if (!strstr(b->error_text, text))
        fail_msg("'%s' is not in the reason: %s", text, b->error_text);
}

double bench_number(size_t k)
{
    const double x = sin(12.9898 * (double)k + 4.1) * 43758.5453;
    return (float)(2 * (x - floor(x)) - 1);
}

void bench_pose(size_t k, double pose[7])
{
    double norm = 0;
    for (size_t e = 0; e < 7; e++)
        pose[e] = bench_number(7 * k + e + 555) + (e == 6);
    for (size_t e = 3; e < 7; e++)
        norm += pose[e] * pose[e];
    for (size_t e = 3; e < 7; e++)
        pose[e] /= sqrt(norm);
}
