/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Why a kernel was refused, in a buffer of the caller.
 */
#include <stdarg.h>
#include <stdio.h>

#include "own/own.h"

int own_refuse(struct own_reason *why, int status, const char *format, ...)
{
    va_list arguments;
    if (!why->text || !why->size || why->text[0])
        return status;
    va_start(arguments, format);
    vsnprintf(why->text, why->size, format, arguments);
    va_end(arguments);
    return status;
}
