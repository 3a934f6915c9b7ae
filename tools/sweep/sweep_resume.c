/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Resume files.
 */
#include "sweep_resume.h"
#include "common/commands.h"

#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#define HEAD "totalforce-sweep 1 "

/* FNV-1a, 64 bits */
static uint64_t checksum(const char *text, size_t length)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (size_t k = 0; k < length; k++)
        hash = (hash ^ (unsigned char)text[k]) * UINT64_C(0x100000001b3);
    return hash;
}

/* The first word in which two identities differ, of both */
static void print_difference(const char *path, const char *theirs, const char *ours)
{
    size_t at = 0, word = 0;
    for (; theirs[at] && theirs[at] == ours[at]; at++)
        if (theirs[at] == ' ')
            word = at + 1;
    fprintf(stderr,
            "totalforce sweep: %s: is of another sweep: it has %.*s, this one %.*s; take another "
            "--resume FILE\n",
            path, (int)strcspn(theirs + word, " \n"), theirs + word,
            (int)strcspn(ours + word, " \n"), ours + word);
}

/* Cuts the checksum off. @return whether it is that of the line */
static int is_whole(char *line)
{
    char *mark = strrchr(line, '#');
    if (!mark || mark == line || mark[-1] != ' ')
        return 0;
    mark[-1] = '\0';
    char *end;
    const uint64_t found = strtoull(mark + 1, &end, 16);
    return end == mark + 17 && (*end == '\n' || *end == '\0') &&
           found == checksum(line, strlen(line));
}

/* A broken line is that of a process which was killed while it wrote: its block is missing. */
static void take_line(const sweep_plan *plan, char *line, statistics *scratch,
                      sweep_results *results)
{
    char *end;
    if (strncmp(line, "block ", 6) != 0 || !is_whole(line))
        return;
    const uint64_t block = strtoull(line + 6, &end, 10);
    if (block >= plan->blocks || sweep_is_done(results->done, block) ||
        statistics_read(scratch, end) != 0)
        return;
    sweep_set_done(results->done, block);
    statistics_merge(&results->statistics, scratch);
    results->found++;
}

static int read_lines(const sweep_plan *plan, const char *path, FILE *in, sweep_results *results)
{
    char *line = NULL;
    size_t size = 0;
    int result = EXIT_GOOD;
    statistics *scratch = malloc(sizeof *scratch);
    while (scratch && result == EXIT_GOOD && getline(&line, &size, in) > 0) {
        line[strcspn(line, "\n")] = '\0';
        if (strncmp(line, HEAD, strlen(HEAD)) != 0) {
            take_line(plan, line, scratch, results);
        } else if (strcmp(line + strlen(HEAD), plan->identity) != 0) {
            print_difference(path, line + strlen(HEAD), plan->identity);
            result = EXIT_FAILED;
        }
    }
    if (!scratch || ferror(in)) {
        fprintf(stderr, "totalforce sweep: %s: %s\n", path, strerror(errno));
        result = EXIT_FAILED;
    }
    free(scratch);
    free(line);
    return result;
}

/* The pattern that finds the files of the prefix, which is no pattern itself */
static char *pattern_of(const char *prefix)
{
    static const char ending[] = ".[0-9]*";
    char *pattern = malloc(2 * strlen(prefix) + sizeof ending), *to = pattern;
    for (const char *at = prefix; pattern && *at; at++) {
        if (strchr("*?[\\", *at))
            *to++ = '\\';
        *to++ = *at;
    }
    if (pattern)
        strcpy(to, ending);
    return pattern;
}

int sweep_resume_read(const sweep_plan *plan, sweep_results *results)
{
    glob_t found = {0};
    int result = EXIT_GOOD;
    char *pattern = pattern_of(plan->options->resume);
    const int error = pattern ? glob(pattern, 0, NULL, &found) : GLOB_NOSPACE;
    free(pattern);
    if (error && error != GLOB_NOMATCH) {
        fprintf(stderr, "totalforce sweep: --resume %s: cannot be read\n", plan->options->resume);
        return EXIT_FAILED;
    }
    for (size_t k = 0; result == EXIT_GOOD && k < found.gl_pathc; k++) {
        FILE *in = fopen(found.gl_pathv[k], "r");
        if (!in) {
            fprintf(stderr, "totalforce sweep: %s: %s\n", found.gl_pathv[k], strerror(errno));
            result = EXIT_FAILED;
            break;
        }
        result = read_lines(plan, found.gl_pathv[k], in, results);
        fclose(in);
    }
    globfree(&found);
    return result;
}

static FILE *open_locked(const char *path)
{
    const int file = open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
    FILE *out = NULL;
    if (file < 0)
        fprintf(stderr, "totalforce sweep: %s: %s\n", path, strerror(errno));
    else if (flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        fprintf(stderr,
                "totalforce sweep: %s: another sweep writes it: wait for it, or take another "
                "--resume FILE\n",
                path);
    else
        out = fdopen(file, "a");
    if (!out && file >= 0)
        close(file);
    return out;
}

FILE *sweep_resume_open(const sweep_plan *plan, unsigned number)
{
    char *path;
    if (asprintf(&path, "%s.%u", plan->options->resume, number) < 0)
        return NULL;
    FILE *out = open_locked(path);
    /* a line that was cut off ends here, and its successor stays whole */
    if (out && (fprintf(out, "%s" HEAD "%s\n", ftello(out) ? "\n" : "", plan->identity) < 0 ||
                fflush(out) != 0)) {
        fprintf(stderr, "totalforce sweep: %s: %s\n", path, strerror(errno));
        fclose(out);
        out = NULL;
    }
    free(path);
    return out;
}

int sweep_resume_add(FILE *out, uint64_t block, const statistics *s)
{
    char *line = NULL;
    size_t length = 0;
    FILE *text = open_memstream(&line, &length);
    if (!text)
        return ENOMEM;
    fprintf(text, "block %" PRIu64, block);
    statistics_write(s, text);
    const int bad = fclose(text) != 0;
    int error = bad ? ENOMEM : 0;
    if (!bad && (fprintf(out, "%s #%016" PRIx64 "\n", line, checksum(line, length)) < 0 ||
                 fflush(out) != 0))
        error = errno;
    free(line);
    return error;
}
