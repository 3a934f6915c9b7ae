/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads lines within bounded memory, has them answered, prints the replies.
 */
#include "jsonl_serve.h"

#include "jsonl_answers.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int jsonl_buffers_init(jsonl_buffers *buffers, const tfa_names *names)
{
    *buffers = (jsonl_buffers){0};
    double **arrays[] = {&buffers->q,
                         &buffers->v,
                         &buffers->tau,
                         &buffers->qdd,
                         &buffers->modes,
                         &buffers->mode_velocities,
                         &buffers->torque_weights};
    const size_t v = names->v_count,
                 counts[] = {names->q_count, v, v, v, names->mode_count, names->mode_count, v};
    int allocated = 1;
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        *arrays[i] = calloc(counts[i] + 1, sizeof(double));
        allocated &= *arrays[i] != NULL;
    }
    buffers->locked = calloc(names->v_count + (size_t)1, sizeof *buffers->locked);
    buffers->named = calloc(names->v_count + (size_t)1, sizeof *buffers->named);
    buffers->answers = calloc(jsonl_answer_count, sizeof *buffers->answers);
    if (allocated && buffers->locked && buffers->named && buffers->answers)
        return TFA_OK;
    jsonl_buffers_free(buffers);
    return TFA_E_MEMORY;
}

void jsonl_buffers_free(jsonl_buffers *buffers)
{
    for (size_t i = 0; buffers->answers && i < jsonl_answer_count; i++)
        free(buffers->answers[i].items);
    free(buffers->answers);
    free(buffers->q);
    free(buffers->v);
    free(buffers->tau);
    free(buffers->qdd);
    free(buffers->modes);
    free(buffers->mode_velocities);
    free(buffers->torque_weights);
    free(buffers->locked);
    free(buffers->named);
    *buffers = (jsonl_buffers){0};
}

int jsonl_load(const char *line, size_t length, uint64_t number, json_t **object,
               jsonl_error *error)
{
    static const char one_line[] = "; one request a line, as `jq -c .` writes it";
    unsigned long long n = (unsigned long long)number;
    *object = NULL;
    if (length >= 3 && memcmp(line, "\xef\xbb\xbf", 3) == 0) { /* a byte order mark */
        line += 3;
        length -= 3;
    }
    const size_t blanks = strspn(line, " \t\r");
    if (blanks == length)
        return jsonl_fail(error, TFA_E_PARSE, "line %llu: empty", n);
    if (length >= 2 && (memcmp(line, "\xff\xfe", 2) == 0 || memcmp(line, "\xfe\xff", 2) == 0))
        return jsonl_fail(error, TFA_E_PARSE, "line %llu: UTF-16, must be UTF-8", n);
    json_error_t why;
    json_t *root = json_loadb(line, length, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &why);
    if (!root) {
        const int is_part =
            line[blanks] != '{' || json_error_code(&why) == json_error_premature_end_of_input;
        return jsonl_fail(error, TFA_E_PARSE, "line %llu, column %d: %s%s", n, why.column, why.text,
                          is_part ? one_line : "");
    }
    if (!json_is_object(root)) {
        json_decref(root);
        return jsonl_fail(error, TFA_E_PARSE, "line %llu: not a JSON object%s", n, one_line);
    }
    *object = root;
    return TFA_OK;
}

/* A line being collected. */
typedef struct line_reader {
    int input;
    int ended; /* the input has no more bytes */
    char chunk[65536];
    size_t at, have; /* of the chunk */
    char *line;      /* terminated by NUL */
    size_t length, capacity;
    int too_long;
} line_reader;

static int line_append(line_reader *r, const char *bytes, size_t count)
{
    if (r->too_long || r->length + count > JSONL_LINE_MAX) {
        r->too_long = 1;
        return TFA_OK;
    }
    if (r->length + count + 1 > r->capacity) {
        size_t capacity = 2 * (r->length + count + 1);
        char *line = realloc(r->line, capacity);
        if (!line)
            return TFA_E_MEMORY;
        r->line = line;
        r->capacity = capacity;
    }
    memcpy(r->line + r->length, bytes, count);
    r->length += count;
    r->line[r->length] = '\0';
    return TFA_OK;
}

static int line_fill(line_reader *r)
{
    ssize_t got;
    do
        got = read(r->input, r->chunk, sizeof r->chunk);
    while (got < 0 && errno == EINTR);
    if (got < 0)
        return TFA_E_SYSTEM;
    r->ended = got == 0;
    r->at = 0;
    r->have = (size_t)got;
    return TFA_OK;
}

/* Reads the next line without its newline. *got is 0 at the end of the input; a last line without
 * a newline counts as a line. */
static int line_next(line_reader *r, int *got)
{
    r->length = 0;
    r->too_long = 0;
    *got = 0;
    int status = line_append(r, "", 0);
    while (status == TFA_OK && !r->ended) {
        if (r->at == r->have) {
            status = line_fill(r);
            continue;
        }
        *got = 1;
        const char *start = r->chunk + r->at;
        const char *newline = memchr(start, '\n', r->have - r->at);
        size_t count = newline ? (size_t)(newline - start) : r->have - r->at;
        status = line_append(r, start, count);
        r->at += count + (newline ? 1 : 0);
        if (newline)
            break;
    }
    return status;
}

/* The buffers follow the names: rebuilt when the robot's sizes change. */
typedef struct server {
    const jsonl_backend *backend;
    const jsonl_defaults *defaults;
    jsonl_buffers buffers;
    uint32_t q_count, v_count, base_freedoms, mode_count;
    int ready;
} server;

static int fit_buffers(server *s, const tfa_names *names, jsonl_error *error)
{
    if (s->ready && s->q_count == names->q_count && s->v_count == names->v_count &&
        s->base_freedoms == names->base_freedoms && s->mode_count == names->mode_count)
        return TFA_OK;
    if (s->ready)
        jsonl_buffers_free(&s->buffers);
    s->q_count = names->q_count;
    s->v_count = names->v_count;
    s->base_freedoms = names->base_freedoms;
    s->mode_count = names->mode_count;
    s->ready = jsonl_buffers_init(&s->buffers, names) == TFA_OK;
    return s->ready ? TFA_OK : jsonl_fail(error, TFA_E_MEMORY, "no memory for a request");
}

static int check_id(const json_t *id, jsonl_error *error)
{
    if (!id || json_is_string(id) || json_is_number(id) || json_is_null(id))
        return TFA_OK;
    return jsonl_fail(error, TFA_E_ARGUMENT, "id: must be a number or a string");
}

/* Answers one request; prints the reply when it is a good one. */
static int answer_line(server *s, const json_t *object, FILE *out, jsonl_error *error)
{
    const json_t *id = json_object_get(object, "id");
    const tfa_names *names = NULL;
    tfa_request request;
    tfa_reply reply;
    int status = check_id(id, error);
    if (status == TFA_OK)
        status = s->backend->prepare(s->backend->self, &names, error);
    if (status == TFA_OK)
        status = fit_buffers(s, names, error);
    if (status == TFA_OK)
        status = jsonl_read(object, names, s->defaults, &s->buffers, &request, &reply, error);
    if (status != TFA_OK)
        return status;
    reply.status = s->backend->answer(s->backend->self, &request, &reply);
    if (reply.status != TFA_OK)
        return jsonl_explain(names, &request, &reply, error);
    jsonl_print_reply(out, id, names, &s->buffers, &request, &reply);
    return TFA_OK;
}

static void serve_line(server *s, const line_reader *lines, FILE *out, jsonl_tally *tally)
{
    jsonl_error error = {0};
    json_t *object = NULL;
    int status;
    tally->lines++;
    if (lines->too_long)
        status = jsonl_fail(&error, TFA_E_SIZE, "line %llu: longer than %zu bytes",
                            (unsigned long long)tally->lines, JSONL_LINE_MAX);
    else
        status = jsonl_load(lines->line, lines->length, tally->lines, &object, &error);
    if (status == TFA_OK)
        status = answer_line(s, object, out, &error);
    if (status != TFA_OK) {
        const json_t *id = json_object_get(object, "id");
        jsonl_print_error(out, json_is_array(id) || json_is_object(id) ? NULL : id, &error);
        tally->errors++;
    }
    json_decref(object);
}

int jsonl_serve(int input, FILE *out, const jsonl_backend *backend, const jsonl_defaults *defaults,
                jsonl_tally *tally)
{
    server s = {.backend = backend, .defaults = defaults};
    line_reader *lines = calloc(1, sizeof *lines);
    int got = 0, status = lines ? TFA_OK : TFA_E_MEMORY;
    *tally = (jsonl_tally){0};
    if (lines)
        lines->input = input;
    while (status == TFA_OK) {
        status = line_next(lines, &got);
        if (status != TFA_OK || !got)
            break;
        serve_line(&s, lines, out, tally);
        if (fflush(out) != 0 || ferror(out))
            status = TFA_E_SYSTEM;
    }
    int saved = errno;
    jsonl_buffers_free(&s.buffers);
    if (lines)
        free(lines->line);
    free(lines);
    errno = saved;
    return status;
}
