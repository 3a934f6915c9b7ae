/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * gnuplot as a child process, fed through its standard input; our scripts say how pictures look.
 */
#include "common/commands.h"
#include "results.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Where the scripts are: beside the program, as installed and as built. */
static int find_scripts(gnuplot_pipe *g, const char *scripts)
{
    struct stat facts;
    char program[2048] = "";
    if (scripts) {
        snprintf(g->scripts, sizeof g->scripts, "%s", scripts);
    } else {
        ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
        program[length > 0 ? length : 0] = '\0';
        char *slash = strrchr(program, '/');
        if (slash)
            *slash = '\0';
        snprintf(g->scripts, sizeof g->scripts, "%s/../" TFA_SCRIPTS "/%s", program, g->name);
    }
    if (stat(g->scripts, &facts) == 0)
        return 0;
    fprintf(stderr, "totalforce %s: no gnuplot scripts in %s: %s; --scripts says where they are\n",
            g->name, g->scripts, strerror(errno));
    return -1;
}

int gnuplot_start(gnuplot_pipe *g, const char *name, const char *scripts, const char *folder)
{
    int ends[2];
    *g = (gnuplot_pipe){.name = name};
    if (find_scripts(g, scripts) != 0 || pipe(ends) != 0)
        return -1;
    g->pid = fork();
    if (g->pid == 0) {
        dup2(ends[0], STDIN_FILENO);
        close(ends[0]);
        close(ends[1]);
        execlp("gnuplot", "gnuplot", "-", (char *)NULL);
        fprintf(stderr, "totalforce %s: gnuplot: %s (package gnuplot-nox)\n", name,
                strerror(errno));
        _exit(127);
    }
    close(ends[0]);
    g->in = g->pid > 0 ? fdopen(ends[1], "w") : NULL;
    if (!g->in) {
        close(ends[1]);
        return -1;
    }
    gnuplot_string(g->in, "scripts", g->scripts);
    gnuplot_string(g->in, "folder", folder);
    return 0;
}

int gnuplot_finish(gnuplot_pipe *g)
{
    int status = 0;
    if (g->in)
        fclose(g->in);
    if (g->pid > 0 && waitpid(g->pid, &status, 0) == g->pid && status == 0)
        return EXIT_GOOD;
    fprintf(stderr, "totalforce %s: no pictures, or not all; the file of rows is complete\n",
            g->name);
    return EXIT_FAILED;
}

void gnuplot_string(FILE *in, const char *name, const char *text)
{
    fprintf(in, "%s = \"", name);
    for (const char *c = text; *c; c++)
        if (*c == '\n')
            fputs("\\n", in);
        else
            fprintf(in, *c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
    fputs("\"\n", in);
}
