/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints replies as JSON lines.
 */
#include "jsonl.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void jsonl_print_number(FILE *out, double value)
{
    char text[32];
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

static void print_array(FILE *out, const char *key, const double *values, size_t count)
{
    if (!values)
        return;
    fprintf(out, ",\"%s\":", key);
    print_vector(out, values, count);
}

static void print_matrix(FILE *out, const char *key, const double *values, size_t rows,
                         size_t columns)
{
    if (!values)
        return;
    fprintf(out, ",\"%s\":[", key);
    for (size_t row = 0; row < rows; row++) {
        if (row)
            fputc(',', out);
        print_vector(out, values + row * columns, columns);
    }
    fputc(']', out);
}

static void print_number_key(FILE *out, const char *key, double value)
{
    fprintf(out, ",\"%s\":", key);
    jsonl_print_number(out, value);
}

void jsonl_print_reply(FILE *out, const json_t *id, const robot_names *names,
                       const tfa_request *request, const tfa_reply *reply)
{
    const tfa_answer *answer = reply->answers;
    size_t v_count = names->v_count;
    fputc('{', out);
    if (id) {
        print_id(out, id);
        fputc(',', out);
    }
    fprintf(out, "\"status\":\"ok\",\"method\":\"%s\"", tfa_method_name(answer->method));
    print_array(out, "qdd", reply->qdd, v_count);
    print_array(out, "base_acceleration", reply->base_acceleration, 6);
    print_array(out, "tau", reply->tau, v_count);
    print_array(out, "base_wrench", reply->base_wrench, 6);
    print_matrix(out, "lambda_inv", reply->lambda_inv, 6 * (size_t)request->tip_count,
                 6 * (size_t)request->tip_count);
    if (reply->spectrum) {
        fprintf(out, ",\"rank\":%u", reply->spectrum->rank);
        print_number_key(out, "eig_min", reply->spectrum->eig_min);
        print_number_key(out, "eig_max", reply->spectrum->eig_max);
    }
    print_matrix(out, "poses", reply->poses, request->tip_count, 7);
    print_matrix(out, "M", reply->mass_matrix, names->base_freedoms + v_count,
                 names->base_freedoms + v_count);
    if ((answer->flags & TFA_ANSWER_ESTIMATED) && isfinite(answer->error_estimate))
        print_number_key(out, "error_estimate", answer->error_estimate);
    if (answer->flags & TFA_ANSWER_SENTINEL)
        fputs(",\"sentinel\":true", out);
    if (answer->flags & TFA_ANSWER_FALLBACK)
        fprintf(out, ",\"fallback\":true,\"reason\":\"%s\"", tfa_fallback_text(answer->flags));
    if (answer->flags & TFA_ANSWER_RESIDUAL_PRECISION)
        fputs(",\"residual_precision\":true", out);
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
