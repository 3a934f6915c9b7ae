/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Values of JSON.
 */
#include <inttypes.h>
#include <math.h>

#include "http/http_internal.h"

/* Bytes above 127 stay as they are: names are UTF-8, and a reader replaces what is not. */
void json_string(FILE *out, const char *text)
{
    fputc('"', out);
    for (const unsigned char *s = (const unsigned char *)text; *s; s++) {
        if (*s < ' ' || *s == '"' || *s == '\\' || *s == '<' || *s == '>' || *s == 127)
            fprintf(out, "\\u%04x", *s);
        else
            fputc(*s, out);
    }
    fputc('"', out);
}

void json_number(FILE *out, double number)
{
    if (isfinite(number))
        fprintf(out, "%.6g", number);
    else
        fputs("null", out);
}

void json_numbers(FILE *out, const double *numbers, size_t count)
{
    fputc('[', out);
    for (size_t i = 0; i < count; i++) {
        if (i)
            fputc(',', out);
        json_number(out, numbers[i]);
    }
    fputc(']', out);
}
