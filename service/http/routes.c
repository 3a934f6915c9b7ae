/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Paths and their replies.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "http/http_internal.h"
#include "metrics/metrics_text.h"

#define TYPE_TEXT "text/plain; charset=utf-8"

typedef void (*robot_writer)(tfa_http *http, uint32_t robot, FILE *out);

static void answer_text(http_reply *r, unsigned code, const char *text)
{
    r->code = code;
    r->type = TYPE_TEXT;
    r->text = strdup(text);
    r->size = r->text ? strlen(r->text) : 0;
}

/* Closes the memory stream of a reply. */
static void finish(http_reply *r, FILE *out, const char *type)
{
    const int failed = ferror(out);
    r->code = 200;
    r->type = type;
    if (fclose(out) == 0 && !failed)
        return;
    free(r->text);
    answer_text(r, 503, "out of memory\n");
}

static FILE *begin(http_reply *r)
{
    FILE *out = open_memstream(&r->text, &r->size);
    if (!out)
        answer_text(r, 503, "out of memory\n");
    return out;
}

static void answer_metrics(const tfa_http *http, http_reply *r)
{
    FILE *out = begin(r);
    if (!out)
        return;
    metrics_write(http->sampler.now, out);
    finish(r, out, METRICS_CONTENT_TYPE);
}

static void answer_page(tfa_http *http, http_reply *r)
{
    unsigned char random[16];
    FILE *out = begin(r);
    if (!out)
        return;
    if (getrandom(random, sizeof random, 0) != sizeof random)
        memset(random, 0, sizeof random);
    for (size_t i = 0; i < sizeof random; i++)
        snprintf(r->nonce + 2 * i, 3, "%02x", random[i]);
    page_write(http, r->nonce, out);
    finish(r, out, "text/html; charset=utf-8");
}

/* The first robot if none is named; robot_count: there is no such robot. */
static uint32_t find_robot(const tfa_http *http, const char *name)
{
    const tfa_snapshot *s = http->sampler.now;
    uint32_t i = 0;
    while (name && i < s->robot_count && strcmp(s->robots[i].served.name, name) != 0)
        i++;
    return i;
}

static void answer_robot(tfa_http *http, const char *name, robot_writer write, http_reply *r)
{
    const uint32_t robot = find_robot(http, name);
    if (robot >= http->robot_count) {
        answer_text(r, 404, "no robot of this name is served here\n");
        return;
    }
    FILE *out = begin(r);
    if (!out)
        return;
    write(http, robot, out);
    finish(r, out, "application/json");
}

void route_answer(tfa_http *http, bool metrics, const char *path, const char *robot, http_reply *r)
{
    static const struct {
        const char *path;
        robot_writer write;
    } robots[] = {
        {"/state", state_write}, {"/motion", state_write_motion}, {"/model", state_write_model}};
    *r = (http_reply){0};
    sampler_update(&http->sampler, http_clock());
    if (strcmp(path, "/metrics") == 0) {
        answer_metrics(http, r);
        return;
    }
    for (size_t i = 0; !metrics && i < sizeof robots / sizeof *robots; i++)
        if (strcmp(path, robots[i].path) == 0) {
            answer_robot(http, robot, robots[i].write, r);
            return;
        }
    if (!metrics && strcmp(path, "/") == 0)
        answer_page(http, r);
    else
        answer_text(r, 404,
                    metrics ? "here is /metrics only\n"
                            : "here are /, /state, /motion, /model and /metrics\n");
}
