/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints replies as JSON lines.
 */
#include "jsonl_answers.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void jsonl_print_number(FILE *out, double value)
{
    char text[32];
    if (!isfinite(value)) {
        fputs("null", out);
        return;
    }
    snprintf(text, sizeof text, "%.17g", value);
    /* "-0" and "3" would be read as integers, and the sign of zero lost */
    fprintf(out, "%s%s", text, strpbrk(text, ".e") ? "" : ".0");
}

/* Length of the valid UTF-8 sequence at `text`, 0 if there is none. Bounded by the terminator. */
static size_t utf8_length(const unsigned char *text)
{
    static const struct {
        unsigned char mask, lead, low, high; /* low, high: range of the second byte */
        size_t length;
    } forms[] = {
        {0xff, 0xe0, 0xa0, 0xbf, 3}, {0xff, 0xed, 0x80, 0x9f, 3}, {0xf0, 0xe0, 0x80, 0xbf, 3},
        {0xff, 0xf0, 0x90, 0xbf, 4}, {0xff, 0xf4, 0x80, 0x8f, 4}, {0xfc, 0xf0, 0x80, 0xbf, 4},
    };
    if (text[0] < 0x80)
        return 1;
    if (text[0] >= 0xc2 && text[0] <= 0xdf)
        return (text[1] & 0xc0) == 0x80 ? 2 : 0;
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        if ((text[0] & forms[i].mask) != forms[i].lead)
            continue;
        if (text[1] < forms[i].low || text[1] > forms[i].high || (text[2] & 0xc0) != 0x80)
            return 0;
        return forms[i].length == 3 || (text[3] & 0xc0) == 0x80 ? forms[i].length : 0;
    }
    return 0;
}

void jsonl_print_string(FILE *out, const char *text)
{
    fputc('"', out);
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        size_t length = utf8_length(c);
        if (length == 0)
            fputs("\\ufffd", out);
        else if (*c == '"' || *c == '\\')
            fprintf(out, "\\%c", *c);
        else if (*c < 0x20 || *c == 0x7f)
            fprintf(out, "\\u%04x", *c);
        else
            fwrite(c, 1, length, out);
        c += length ? length : 1;
    }
    fputc('"', out);
}

static void print_id(FILE *out, const json_t *id)
{
    fputs("\"id\":", out);
    if (!id || json_dumpf(id, out, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(17)) != 0)
        fputs("null", out);
}

static void print_vector(FILE *out, const double *values, size_t count)
{
    fputc('[', out);
    for (size_t i = 0; i < count; i++) {
        if (i)
            fputc(',', out);
        jsonl_print_number(out, values[i]);
    }
    fputc(']', out);
}

static void print_key(FILE *out, const char *prefix, const char *key)
{
    fprintf(out, ",\"%s%s\":", prefix, key);
}

static void print_number_key(FILE *out, const char *key, double value)
{
    print_key(out, "", key);
    jsonl_print_number(out, value);
}

static void print_matrix(FILE *out, const double *values, size_t rows, size_t columns)
{
    fputc('[', out);
    for (size_t row = 0; row < rows; row++) {
        if (row)
            fputc(',', out);
        print_vector(out, values + row * columns, columns);
    }
    fputc(']', out);
}

static void print_by_link(FILE *out, const tfa_names *names, const double *values, size_t columns)
{
    fputc('{', out);
    for (uint32_t frame = 0; frame < names->frame_count; frame++) {
        if (frame)
            fputc(',', out);
        jsonl_print_string(out, tfa_names_frame(names, frame));
        fputc(':', out);
        print_vector(out, values + frame * columns, columns);
    }
    fputc('}', out);
}

static void print_by_constraint(FILE *out, const tfa_names *names, uint32_t constraints,
                                const double *values)
{
    fputc('{', out);
    for (uint32_t k = 0; k < (uint32_t)__builtin_popcount(constraints); k++) {
        if (k)
            fputc(',', out);
        jsonl_print_string(out, tfa_names_active(names, constraints, k));
        fputc(':', out);
        print_vector(out, values + 6 * k, 6);
    }
    fputc('}', out);
}

static void print_energy(FILE *out, const double energy[2])
{
    fputs("{\"kinetic\":", out);
    jsonl_print_number(out, energy[0]);
    fputs(",\"potential\":", out);
    jsonl_print_number(out, energy[1]);
    fputc('}', out);
}

static void print_answer(FILE *out, const jsonl_answer *answer, const char *key,
                         const tfa_names *names, const tfa_request *request, const double *values)
{
    size_t rows, columns;
    jsonl_answer_size(answer, names, request, &rows, &columns);
    print_key(out, "", key);
    switch (answer->layout) {
    case LAYOUT_VECTOR:
        print_vector(out, values, columns);
        break;
    case LAYOUT_MATRIX:
        print_matrix(out, values, rows, columns);
        break;
    case LAYOUT_NUMBER:
        jsonl_print_number(out, values[0]);
        break;
    case LAYOUT_FREEDOMS:
        print_vector(out, values + names->base_freedoms, names->v_count);
        if (names->base_freedoms) {
            print_key(out, "base_", key);
            print_vector(out, values, names->base_freedoms);
        }
        break;
    case LAYOUT_BY_LINK:
        print_by_link(out, names, values, columns);
        break;
    case LAYOUT_BY_CONSTRAINT:
        print_by_constraint(out, names, request->constraints, values);
        break;
    case LAYOUT_ENERGY:
        print_energy(out, values);
        break;
    default: /* print_rank */
        break;
    }
}

/* Directions at or below the threshold */
static void print_lost(FILE *out, const tfa_names *names, const tfa_request *request,
                       const tfa_reply *reply)
{
    const size_t constraints = tfa_constraint_numbers(request);
    const size_t rows = constraints ? constraints : rows_of(request) * (size_t)request->tip_count;
    const double *row = reply->lost;
    print_key(out, "", "lost");
    fputc('[', out);
    for (uint32_t k = 0; k < reply->rank->lost && k < TFA_LOST_MAX; k++, row += 2 + rows) {
        double square = 0;
        for (size_t e = 0; e < rows; e++)
            square += row[2 + e] * row[2 + e];
        if (square == 0)
            break;
        fputs(k ? ",{\"singular_value\":" : "{\"singular_value\":", out);
        jsonl_print_number(out, row[0]);
        if (TFA_OP_BIT(request->op) & TFA_OPS_LOST)
            print_number_key(out, "given_up", row[1]);
        print_key(out, "", "direction");
        if (constraints)
            print_by_constraint(out, names, request->constraints, row + 2);
        else
            print_vector(out, row + 2, rows);
        fputc('}', out);
    }
    fputc(']', out);
}

/* The rank that lambda, task torques and constraints used, with its threshold; otherwise that of
 * the spectrum */
static void print_rank(FILE *out, const tfa_names *names, const tfa_request *request,
                       const tfa_reply *reply)
{
    if (reply->rank) {
        fprintf(out, ",\"rank\":%u", reply->rank->rank);
        print_number_key(out, "threshold", reply->rank->threshold);
        print_number_key(out, "condition", reply->rank->condition);
        print_number_key(out, "length", reply->rank->length);
        print_number_key(out, "lambda_error_estimate", reply->rank->error_estimate);
        if (reply->rank->lost && reply->lost)
            print_lost(out, names, request, reply);
    } else if (reply->spectrum) {
        fprintf(out, ",\"rank\":%u", reply->spectrum->rank);
    }
    if (reply->spectrum) {
        print_number_key(out, "eig_min", reply->spectrum->eig_min);
        print_number_key(out, "eig_max", reply->spectrum->eig_max);
    }
}

static void print_quality(FILE *out, const tfa_answer *answer)
{
    if ((answer->flags & TFA_ANSWER_ESTIMATED) && isfinite(answer->error_estimate))
        print_number_key(out, "error_estimate", answer->error_estimate);
    if (answer->flags & TFA_ANSWER_SENTINEL)
        fputs(",\"sentinel\":true", out);
    if (answer->flags & TFA_ANSWER_FALLBACK)
        fprintf(out, ",\"fallback\":true,\"reason\":\"%s\"", tfa_fallback_text(answer->flags));
    if (answer->flags & TFA_ANSWER_RESIDUAL_PRECISION)
        fputs(",\"residual_precision\":true", out);
    if (answer->flags & TFA_ANSWER_MODE_LIMIT)
        fputs(",\"mode_limit\":true", out);
    if (answer->flags & TFA_ANSWER_PULLS)
        fputs(",\"pulls\":true", out);
}

void jsonl_print_reply(FILE *out, const json_t *id, const tfa_names *names,
                       const jsonl_buffers *buffers, const tfa_request *request,
                       const tfa_reply *reply)
{
    fputc('{', out);
    if (id) {
        print_id(out, id);
        fputc(',', out);
    }
    fprintf(out, "\"status\":\"ok\",\"method\":\"%s\"", tfa_method_name(reply->answers->method));
    for (size_t i = 0; i < jsonl_answer_count; i++) {
        const jsonl_answer *answer = &jsonl_answers[i];
        const double *values = tfa_output_buffer(&tfa_outputs[answer->block], reply);
        const int is_tip_poses = answer->block == TFA_WIRE_POSES && buffers->tip_poses_key;
        if (values && answer->layout < LAYOUT_LOST)
            print_answer(out, answer, is_tip_poses ? buffers->tip_poses_key : answer->key, names,
                         request, values);
        if (answer->block == TFA_WIRE_LAMBDA_INV)
            print_rank(out, names, request, reply);
    }
    print_quality(out, reply->answers);
    if (reply->model)
        fprintf(out, ",\"model\":\"%016" PRIx64 "\"", reply->model);
    fputs("}\n", out);
}

void jsonl_print_error(FILE *out, const json_t *id, const jsonl_error *error)
{
    fputc('{', out);
    print_id(out, id);
    fputs(",\"status\":\"error\",\"error\":", out);
    jsonl_print_string(out, error->text);
    fprintf(out, ",\"code\":\"%s\"}\n", tfa_status_name(error->status));
}
