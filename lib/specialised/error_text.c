/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Why a kernel was refused, in a buffer of the caller.
 */
#include <stdarg.h>
#include <stdio.h>

#include "specialised/specialised_internal.h"

int set_error_text(struct error_text *err, int status, const char *format, ...)
{
    va_list arguments;
    if (!err->text || !err->size || err->text[0])
        return status;
    va_start(arguments, format);
    vsnprintf(err->text, err->size, format, arguments);
    va_end(arguments);
    return status;
}
