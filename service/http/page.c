/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page: a file with places for the nonce and for the numbers of the moment, which are all of
 * it without scripts.
 */
#include <inttypes.h>
#include <string.h>

#include "http/http_internal.h"

extern const char http_page_html[];

static void html_text(FILE *out, const char *text)
{
    for (; *text; text++)
        switch (*text) {
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
        default:
            fputc(*text, out);
        }
}

static void write_time(FILE *out, const http_second *h, int quantile)
{
    if (h && h->times[TIME_COMPUTE][quantile] >= 0)
        fprintf(out, "<td class=n>%.4g</td>", (double)h->times[TIME_COMPUTE][quantile]);
    else
        fputs("<td class=n>-</td>", out);
}

static void write_row(const sampler *s, uint32_t robot, FILE *out)
{
    const tfa_robot_statistics *r = &s->now->robots[robot];
    const http_second *h = sampler_second(s, robot, 0);
    fputs("<tr><th scope=row>", out);
    html_text(out, r->served.name);
    fprintf(out, "</th><td class=n>%u</td>", r->clients);
    if (h)
        fprintf(out, "<td class=n>%.4g</td>", (double)h->requests);
    else
        fputs("<td class=n>-</td>", out);
    write_time(out, h, QUANTILE_50);
    write_time(out, h, QUANTILE_99);
    fprintf(out,
            "<td class=n>%" PRIu64 "</td><td class=n>%" PRIu64 "</td><td class=n>%" PRIu64
            "</td></tr>\n",
            r->total.requests, r->total.rejected, r->total.fallbacks);
}

static void write_table(const sampler *s, FILE *out)
{
    fprintf(
        out,
        "<p>totalforced %s, process %d, up for %.0f s, workers: %u</p>\n<div class=scroll>"
        "<table><thead><tr><th>Robot</th><th class=n>Clients</th><th class=n>Requests/s</th>"
        "<th class=n>Median, &micro;s</th><th class=n>99 %%, &micro;s</th><th class=n>Requests</th>"
        "<th class=n>Refused</th><th class=n>Fallbacks</th></tr></thead><tbody>\n",
        s->now->version, s->now->process, (double)(s->now->time - s->now->start) * 1e-9,
        s->now->worker_count);
    for (uint32_t i = 0; i < s->now->robot_count; i++)
        write_row(s, i, out);
    fputs("</tbody></table></div>\n", out);
}

/* "@NONCE@" and "@TABLE@" are the places. */
void page_write(tfa_http *http, const char *nonce, FILE *out)
{
    const char *text = http_page_html, *at;
    while ((at = strchr(text, '@'))) {
        fwrite(text, 1, (size_t)(at - text), out);
        if (strncmp(at, "@NONCE@", 7) == 0) {
            fputs(nonce, out);
            text = at + 7;
        } else if (strncmp(at, "@TABLE@", 7) == 0) {
            write_table(&http->sampler, out);
            text = at + 7;
        } else {
            fputc('@', out);
            text = at + 1;
        }
    }
    fputs(text, out);
}
