/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Location of the sources of the kernels.
 */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "specialised/specialised_internal.h"

static int has_kernel_sources(const char *folder)
{
    char file[1024];
    snprintf(file, sizeof file, "%s/dynamics/specialised/specialised.c", folder);
    return access(file, R_OK) == 0;
}

int find_kernel_sources(const char *wanted, char *folder, size_t size, struct error_text *err)
{
    char program[512];
    if (wanted) {
        snprintf(folder, size, "%s", wanted);
        if (has_kernel_sources(folder))
            return TFA_OK;
        return refuse(err, TFA_E_FILE, "no dynamics/specialised/specialised.c in '%s'", wanted);
    }
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(program, '/');
    if (slash)
        *slash = '\0';
    snprintf(folder, size, "%s/../" TFA_SOURCES, program);
    if (has_kernel_sources(folder))
        return TFA_OK;
    snprintf(folder, size, "%s", TFA_SOURCES_INSTALLED);
    if (has_kernel_sources(folder))
        return TFA_OK;
    return refuse(err, TFA_E_FILE,
                  "the sources of the kernels are neither in '%s/../%s' nor in '%s': "
                  "install them or say where they are (--sources)",
                  program, TFA_SOURCES, TFA_SOURCES_INSTALLED);
}
