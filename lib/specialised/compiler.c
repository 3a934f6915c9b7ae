/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Selection of a compiler.
 */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "specialised/specialised_internal.h"

/* Finds a program in PATH, or at `name` if that contains a folder. */
static int find(const char *name, struct compiler_info *c)
{
    const char *path = getenv("PATH");
    if (strchr(name, '/')) {
        snprintf(c->path, sizeof c->path, "%s", name);
        return access(c->path, X_OK) == 0;
    }
    for (const char *at = path ? path : "/usr/bin:/bin"; *at;) {
        const int length = (int)strcspn(at, ":");
        snprintf(c->path, sizeof c->path, "%.*s/%s", length, at, name);
        if (length && at[0] == '/' && access(c->path, X_OK) == 0)
            return 1;
        at += length + (at[length] == ':');
    }
    return 0;
}

/* Reads the version line and major version: "gcc (Debian 12.2.0-14) 12.2.0", "Debian clang version
 * 14.0.6". */
static int read_version(struct compiler_info *c, const char *folder,
                        const struct process_limits *limits, struct error_text *err)
{
    const char *const argv[] = {c->path, "--version", NULL};
    char file[600];
    int status = child_process_run(argv, folder, limits, err);
    if (status != TFA_OK)
        return status;
    snprintf(file, sizeof file, "%s/said0", folder);
    FILE *output_path = fopen(file, "re");
    const int read = output_path && fgets(c->version, sizeof c->version, output_path);
    if (output_path)
        fclose(output_path);
    if (!read)
        return refuse(err, TFA_E_UNSUPPORTED, "'%s --version' says nothing", c->path);
    c->version[strcspn(c->version, "\n")] = '\0';
    c->clang = strstr(c->version, "clang") != NULL;
    const char *number = c->clang ? strstr(c->version, "version ") : strrchr(c->version, ' ');
    while (number && *number && !isdigit((unsigned char)*number))
        number++;
    c->major = number ? atoi(number) : 0;
    return TFA_OK;
}

/* clang first: it compiles these sources several times as fast as gcc, in less memory. */
int find_compiler(const char *requested, const char *folder, const struct process_limits *limits,
                  struct compiler_info *compiler, struct error_text *err)
{
    static const char *const names[] = {"clang", "gcc", "cc"};
    int found = 0;
    if (requested && !find(requested, compiler))
        return refuse(
            err, TFA_E_UNSUPPORTED,
            "there is no compiler '%s': name one that is installed, or `apt install clang`",
            requested);
    for (size_t k = 0; !requested && !found && k < sizeof names / sizeof *names; k++)
        found = find(names[k], compiler);
    if (!requested && !found)
        return refuse(
            err, TFA_E_UNSUPPORTED,
            "no compiler found: looked for clang, gcc and cc in PATH; `apt install clang` (or gcc, "
            "which takes four times as long), or build the kernel on a machine that has one");
    return read_version(compiler, folder, limits, err);
}
