/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The file of rows that a measuring subcommand leaves behind.
 */
#include "results.h"
#include "common/commands.h"
#include "common/environment.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

FILE *results_open(const char *name, const char *folder, int json)
{
    char path[4096];
    if (!folder)
        return stdout;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        fprintf(stderr, "totalforce %s: %s: %s\n", name, folder, strerror(errno));
        return NULL;
    }
    snprintf(path, sizeof path, "%s/%s.%s", folder, name, json ? "jsonl" : "csv");
    FILE *out = fopen(path, "w");
    if (!out)
        fprintf(stderr, "totalforce %s: %s: %s\n", name, path, strerror(errno));
    return out;
}

int results_flush(FILE *out)
{
    static int first_error;
    errno = 0;
    if (!first_error && (fflush(out) != 0 || ferror(out)))
        first_error = errno ? errno : EIO;
    return first_error;
}

int results_close(const char *name, FILE *out)
{
    int error = results_flush(out);
    if (out != stdout && fclose(out) != 0 && !error)
        error = errno;
    if (error)
        fprintf(stderr, "totalforce %s: output: %s\n", name, strerror(error));
    return error ? EXIT_FAILED : EXIT_GOOD;
}

static void print_fact(FILE *out, const json_t *facts, const char *key)
{
    const json_t *value = json_object_get(facts, key);
    if (json_is_string(value))
        fprintf(out, "# %s: %s\n", key, json_string_value(value));
}

void results_print_head(FILE *out, const char *command)
{
    char date[32] = "unknown";
    time_t seconds = time(NULL);
    struct tm day;
    if (gmtime_r(&seconds, &day))
        strftime(date, sizeof date, "%Y-%m-%d", &day);
    json_t *facts = environment_read();
    fprintf(out, "# command: %s\n# date: %s\n", command, date);
    print_fact(out, facts, "processor");
    print_fact(out, facts, "client_kernels");
    print_fact(out, facts, "version");
    json_decref(facts);
}

void results_print_number(FILE *out, const char *format, double value)
{
    if (isfinite(value))
        fprintf(out, format, value);
}

void results_print_text(FILE *out, const char *text)
{
    const char *c = text;
    while (*c && *c != ',' && *c != '"' && (unsigned char)*c >= ' ')
        c++;
    if (!*c) {
        fputs(text, out);
        return;
    }
    fputc('"', out);
    for (c = text; *c; c++)
        if (*c == '"')
            fputs("\"\"", out);
        else
            fputc((unsigned char)*c < ' ' ? ' ' : *c, out);
    fputc('"', out);
}

void results_set_number(json_t *object, const char *key, double value)
{
    json_object_set_new(object, key, isfinite(value) ? json_real(value) : json_null());
}
