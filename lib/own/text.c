/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Text that grows, for C source. Numbers are the same in every locale.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "own/own.h"

#define NAME_SHOWN 63

static int grow(struct own_text *t, size_t wanted)
{
    size_t room = t->room ? t->room : 4096;
    while (room < wanted)
        room *= 2;
    char *text = room == t->room ? t->text : realloc(t->text, room);
    if (!text)
        return -1;
    t->text = text;
    t->room = room;
    return 0;
}

void own_say(struct own_text *t, const char *format, ...)
{
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    const int length = vsnprintf(NULL, 0, format, again);
    va_end(again);
    if (t->failed || length < 0 || grow(t, t->used + (size_t)length + 1) != 0) {
        t->failed = 1;
    } else {
        vsnprintf(t->text + t->used, t->room - t->used, format, arguments);
        t->used += (size_t)length;
    }
    va_end(arguments);
}

void own_say_name(struct own_text *t, const char *name)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    char shown[NAME_SHOWN + 1];
    size_t n = 0;
    for (; name[n] && n < NAME_SHOWN; n++)
        shown[n] = strchr(plain, name[n]) ? name[n] : '_';
    shown[n] = '\0';
    own_say(t, "%s", shown);
}
