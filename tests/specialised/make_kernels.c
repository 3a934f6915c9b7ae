/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 *   test_make_kernels aba|crba|fastest FOLDER
 * builds the kernels that tests want (kernels.h) by one algorithm, or by those that are chosen, of
 * our robots and of some of ../shared/robots where that folder is there.
 * Without a compiler, or where kernels would be refused because others may write there, the folder
 * is removed, and this is skipped.
 */
#include <errno.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

#define SKIPPED 77

/* Kernels take most of the time of these tests. By aba: ours, one of them large. By crba and
 * chosen: no more than each needs, chosen where crba loses too much for some requests (arm7). */
enum { ABA = 1, CRBA = 2, FASTEST = 4 };
static const struct wanted {
    const char *file;
    tfa_base base;
    int ours, suites;
} wanted[] = {
    {"config/robots/arm7.urdf", TFA_BASE_FIXED, 1, ABA | CRBA | FASTEST},
    {"config/robots/arm7.urdf", TFA_BASE_FLOATING, 1, ABA},
    {"config/robots/quadruped.urdf", TFA_BASE_FIXED, 1, ABA | CRBA},
    {"config/robots/quadruped.urdf", TFA_BASE_FLOATING, 1, ABA},
    {"config/robots/humanoid.urdf", TFA_BASE_FLOATING, 1, ABA},
    {"../shared/robots/double_pendulum.urdf", TFA_BASE_FIXED, 0, ABA},
    {"../shared/robots/panda.urdf", TFA_BASE_FIXED, 0, CRBA},
    {"../shared/robots/iiwa14.urdf", TFA_BASE_FIXED, 0, FASTEST},
    {"../shared/robots/ur5.urdf", TFA_BASE_FIXED, 0, FASTEST},
    {"../shared/robots/go2.urdf", TFA_BASE_FLOATING, 0, ABA},
};

static const struct suite {
    const char *name;
    tfa_specialise_algorithm algorithm;
    int bit;
} suites[] = {
    {"aba", TFA_SPECIALISE_ABA, ABA},
    {"crba", TFA_SPECIALISE_CRBA, CRBA},
    {"fastest", TFA_SPECIALISE_FASTEST, FASTEST},
};
enum { SUITES = sizeof suites / sizeof *suites };

/* Empties the folder, or makes it. Nobody else may write there. */
static int clear(const char *folder)
{
    char pattern[4096];
    glob_t g = {0};
    snprintf(pattern, sizeof pattern, "%s/*.so", folder);
    if (glob(pattern, 0, NULL, &g) == 0)
        for (size_t k = 0; k < g.gl_pathc; k++)
            unlink(g.gl_pathv[k]);
    globfree(&g);
    if ((mkdir(folder, 0755) == 0 || errno == EEXIST) && chmod(folder, 0755) == 0)
        return 0;
    printf("%s: %s\n", folder, strerror(errno));
    return 1;
}

static int build(const struct wanted *w, const char *folder, tfa_specialise_algorithm algorithm,
                 tfa_model *model)
{
    char path[4096], name[TFA_SPECIALISED_NAME_SIZE], error_text[1024];
    const tfa_specialise_options options = {.sources = TFA_SOURCE_DIR "/lib",
                                            .algorithm = algorithm};
    tfa_specialise_result result;
    tfa_specialised_name(model, name);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    const int status =
        tfa_specialised_build(model, &options, path, &result, error_text, sizeof error_text);
    if (status == TFA_OK)
        printf("%-40s %s base, %s: %7zu bytes, %5.1f s\n", w->file,
               w->base == TFA_BASE_FLOATING ? "floating" : "fixed   ", tfa_isa_name(), result.bytes,
               result.compile_s);
    else
        printf("%s: %s\n", w->file, error_text);
    fflush(stdout);
    return status;
}

static int make(const struct wanted *w, const char *folder, tfa_specialise_algorithm algorithm)
{
    char path[4096];
    tfa_model *model;
    const tfa_model_options options = {.base = w->base};
    snprintf(path, sizeof path, "%s/%s", TFA_SOURCE_DIR, w->file);
    if (!w->ours && access(path, F_OK) != 0) {
        printf("SKIP: %s is not there\n", w->file);
        return TFA_OK;
    }
    int status = tfa_model_load(path, &options, NULL, &model);
    if (status != TFA_OK) {
        printf("%s: %s\n", path, tfa_status_text(status));
        return status;
    }
    status = build(w, folder, algorithm, model);
    tfa_model_free(model);
    return status;
}

static int skip(const char *folder, const char *why)
{
    printf("SKIP: %s\n", why);
    return rmdir(folder) == 0 ? SKIPPED : EXIT_FAILURE;
}

static const struct suite *suite_named(const char *name)
{
    for (int k = 0; name && k < SUITES; k++)
        if (strcmp(suites[k].name, name) == 0)
            return &suites[k];
    return NULL;
}

int main(int argc, char **argv)
{
    char error_text[1024];
    const struct suite *suite = argc == 3 ? suite_named(argv[1]) : NULL;
    if (!suite) {
        printf("usage: test_make_kernels aba|crba|fastest FOLDER\n");
        return EXIT_FAILURE;
    }
    const char *folder = argv[2];
    if (clear(folder) != 0)
        return EXIT_FAILURE;
    if (tfa_specialised_check_ownership(folder, error_text, sizeof error_text) != TFA_OK)
        return skip(folder, error_text);
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++) {
        if (!(wanted[k].suites & suite->bit))
            continue;
        const int status = make(&wanted[k], folder, suite->algorithm);
        if (k == 0 && status == TFA_E_UNSUPPORTED)
            return skip(folder, "no kernels without a compiler");
        if (status != TFA_OK)
            return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
