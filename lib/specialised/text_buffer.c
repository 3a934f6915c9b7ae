/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Growing text for C source, and error texts in a buffer of the caller.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "specialised/specialised_internal.h"

#define NAME_LENGTH_MAX 63

static int reserve(struct text_buffer *t, size_t wanted)
{
    size_t capacity = t->capacity ? t->capacity : 4096;
    while (capacity < wanted)
        capacity *= 2;
    char *text = capacity == t->capacity ? t->text : realloc(t->text, capacity);
    if (!text)
        return -1;
    t->text = text;
    t->capacity = capacity;
    return 0;
}

void text_append(struct text_buffer *t, const char *format, ...)
{
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    const int length = vsnprintf(NULL, 0, format, again);
    va_end(again);
    if (t->failed || length < 0 || reserve(t, t->used + (size_t)length + 1) != 0) {
        t->failed = 1;
    } else {
        vsnprintf(t->text + t->used, t->capacity - t->used, format, arguments);
        t->used += (size_t)length;
    }
    va_end(arguments);
}

void text_append_name(struct text_buffer *t, const char *name)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    char shown[NAME_LENGTH_MAX + 1];
    size_t n = 0;
    for (; name[n] && n < NAME_LENGTH_MAX; n++)
        shown[n] = strchr(plain, name[n]) ? name[n] : '_';
    shown[n] = '\0';
    text_append(t, "%s", shown);
}

int refuse(struct error_text *err, int status, const char *format, ...)
{
    va_list arguments;
    if (!err->text || !err->size || err->text[0])
        return status;
    va_start(arguments, format);
    vsnprintf(err->text, err->size, format, arguments);
    va_end(arguments);
    return status;
}
