/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A self-contained page of results: head, text, rows, origin, and the one script of all pages
 * (page.js), whose style and script stand inside. Without scripts its pictures and tables are
 * complete; the script adds numbers under the pointer and filters.
 *
 * The script expects: elements with data-r="N" belong to row N of the CSV, those with data-f="N"
 * (curves) are filtered as it is; figures of class panel are hidden when all of theirs are; marks
 * are of class m, with their label in data-l.
 */
#ifndef TOOLS_COMMON_HTML_PAGE_H
#define TOOLS_COMMON_HTML_PAGE_H

#include <stddef.h>
#include <stdio.h>

/** Opens the file of a page before anything is measured. @return NULL after a message that begins
 * with "totalforce NAME" */
FILE *html_open(const char *name, const char *path);

/** Text of elements and attributes: the characters of HTML are escaped, control characters are
 * blanks. */
void html_text(FILE *out, const char *text);

typedef struct html_page {
    const char *title;   /**< states the conclusion */
    const char *lead;    /**< sentences below it, or NULL */
    const char *filters; /**< columns that can be filtered, "A B=x|y C": of B first x and y only */
    const char *tip;     /**< columns that are shown under the pointer */
    const char *also;    /**< heading there of the row in data-also, or NULL */
} html_page;

void html_begin(FILE *out, const html_page *page);

/** Ends it: the rows for the script, the notes among their comment lines ("# word: text"), and in
 * the footer command, date, machine and version (results_print_head). */
void html_end(FILE *out, const char *csv);

#endif
