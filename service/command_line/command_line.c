/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parses command lines and prints their tables.
 */
#include "command_line.h"

#include <stdlib.h>
#include <string.h>

void command_line_print_field(const char *text, FILE *out)
{
    fputc('\t', out);
    for (; text && *text; text++) {
        if (*text == '\n')
            fputs("\\n", out);
        else if (*text == '\\')
            fputs("\\\\", out);
        else
            fputc(*text == '\t' ? ' ' : *text, out);
    }
}

static void print_fact(const char *fact, const char *text, FILE *out)
{
    if (!text || !*text)
        return;
    fputs(fact, out);
    command_line_print_field(text, out);
    fputc('\n', out);
}

static void print_option(const struct argp_option *o, FILE *out)
{
    const char letter[2] = {o->key > ' ' && o->key < 0x7f ? (char)o->key : '\0', '\0'};
    fputs("option", out);
    command_line_print_field(o->name, out);
    command_line_print_field(letter, out);
    command_line_print_field(o->arg, out);
    command_line_print_field(o->doc, out);
    fputc('\n', out);
}

/* Tables of the parser and its children; texts of children belong to their options. */
static void print_tables(const struct argp *argp, FILE *out)
{
    const struct argp_option *o = argp->options;
    for (; o && (o->name || o->key || o->doc || o->group); o++) {
        if (!o->name && !o->key)
            print_fact("group", o->doc, out);
        else if (!(o->flags & OPTION_HIDDEN))
            print_option(o, out);
    }
    for (const struct argp_child *c = argp->children; c && c->argp; c++) {
        print_fact("group", c->header, out);
        print_tables(c->argp, out);
    }
}

/* The part of the text before or behind its vertical tab */
static void print_about(const char *doc, FILE *out)
{
    const char *mark = doc ? strchr(doc, '\v') : NULL;
    char *before = doc ? strndup(doc, mark ? (size_t)(mark - doc) : strlen(doc)) : NULL;
    print_fact("about", before, out);
    print_fact("after", mark ? mark + 1 : NULL, out);
    free(before);
}

void command_line_print(const struct argp *argp, const command_line_values *values, FILE *out)
{
    static const struct argp_option help = {.name = "help", .key = '?', .doc = "Give this help"};
    static const struct argp_option usage = {
        .name = "usage", .key = 1, .doc = "Give a short usage"};
    static const struct argp_option version = {
        .name = "version", .key = 'V', .doc = "Print the program's version"};
    print_about(argp->doc, out);
    print_fact("arguments", argp->args_doc, out);
    print_tables(argp, out);
    fputs("group\tHelp:\n", out);
    print_option(&help, out);
    print_option(&usage, out);
    if (argp_program_version || argp_program_version_hook)
        print_option(&version, out);
    for (; values && values->name; values++) {
        fputs("values", out);
        command_line_print_field(values->name, out);
        for (size_t i = 0; values->word(i); i++)
            command_line_print_field(values->word(i), out);
        fputc('\n', out);
    }
}

bool command_line_asks(int argc, char **argv, const char *option)
{
    return argc == 2 && strcmp(argv[1], option) == 0;
}

error_t command_line_parse(const struct argp *argp, const command_line_values *values, int argc,
                           char **argv, void *input)
{
    if (command_line_asks(argc, argv, "--print-options")) {
        command_line_print(argp, values, stdout);
        exit(fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    return argp_parse(argp, argc, argv, 0, NULL, input);
}
