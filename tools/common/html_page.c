/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Writes pages of results.
 */
#include "html_page.h"

#include <errno.h>
#include <string.h>

/* page.css and page.js, made by embed.cmake */
extern const char html_page_css[], html_page_js[];

FILE *html_open(const char *name, const char *path)
{
    FILE *out = fopen(path, "we");
    if (!out)
        fprintf(stderr, "totalforce %s: %s: %s\n", name, path, strerror(errno));
    return out;
}

static void write_text(FILE *out, const char *text, size_t size)
{
    for (size_t i = 0; i < size; i++)
        switch (text[i]) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        case '\'':
            fputs("&#39;", out);
            break;
        default:
            fputc((unsigned char)text[i] < ' ' && text[i] != '\n' ? ' ' : text[i], out);
        }
}

void html_text(FILE *out, const char *text)
{
    write_text(out, text, strlen(text));
}

static void write_attribute(FILE *out, const char *name, const char *value)
{
    fprintf(out, " %s=\"", name);
    html_text(out, value);
    fputc('"', out);
}

void html_begin(FILE *out, const html_page *page)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
          "style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"light dark\">\n"
          "<link rel=\"icon\" href=\"data:,\">\n<title>",
          out);
    html_text(out, page->title);
    fprintf(out, "</title>\n<style>\n%s</style>\n</head>\n<body>\n<main", html_page_css);
    write_attribute(out, "data-filters", page->filters);
    write_attribute(out, "data-tip", page->tip);
    write_attribute(out, "data-also", page->also ? page->also : "");
    fputs(">\n<h1>", out);
    html_text(out, page->title);
    fputs("</h1>\n", out);
    if (page->lead) {
        fputs("<p class=\"lead\">", out);
        html_text(out, page->lead);
        fputs("</p>\n", out);
    }
}

/* Whether it is "# WORD: " of results_print_head */
static int is_origin(const char *line)
{
    static const char *const words[] = {
        "# command: ", "# date: ", "# processor: ", "# client_kernels: ", "# version: "};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strncmp(line, words[i], strlen(words[i])) == 0)
            return 1;
    return 0;
}

/* The comment lines as terms and definitions: those of the origin, or the others */
static void write_comments(FILE *out, const char *csv, int origin)
{
    fputs("<dl>\n", out);
    for (const char *line = csv, *end; *line; line = *end ? end + 1 : end) {
        end = line + strcspn(line, "\n");
        if (line[0] != '#' || is_origin(line) != origin)
            continue;
        const char *word = line + strspn(line, "# "), *colon = word;
        while (colon < end && strncmp(colon, ": ", 2) != 0)
            colon++;
        fputs("<dt>", out);
        write_text(out, word, (size_t)(colon - word));
        fputs("</dt><dd>", out);
        if (colon < end)
            write_text(out, colon + 2, (size_t)(end - colon - 2));
        fputs("</dd>\n", out);
    }
    fputs("</dl>\n", out);
}

void html_end(FILE *out, const char *csv)
{
    fputs("<details class=\"notes\"><summary>How to read the numbers</summary>\n", out);
    write_comments(out, csv, 0);
    fputs(
        "</details>\n<details><summary>All rows (CSV)</summary>\n<pre id=\"rows\" tabindex=\"0\">",
        out);
    for (const char *line = csv, *end; *line; line = *end ? end + 1 : end) {
        end = line + strcspn(line, "\n");
        if (line[0] != '#')
            write_text(out, line, (size_t)(end - line) + (*end == '\n'));
    }
    fputs("</pre></details>\n</main>\n<footer>\n", out);
    write_comments(out, csv, 1);
    fprintf(out,
            "</footer>\n<div id=\"tip\" role=\"status\" hidden></div>\n<script>\n%s</script>\n"
            "</body>\n</html>\n",
            html_page_js);
}
