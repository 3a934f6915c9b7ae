/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names, texts and causes of the status codes, from the list in status.h.
 */
#include <stddef.h>
#include <totalforce/status.h>

struct row {
    const char *name, *text, *cause;
};

#define ROW(name, number, text, cause) [-(number)] = {#name, text, cause},
static const struct row rows[] = {TFA_STATUS_LIST(ROW)};
#undef ROW

static const struct row *row_of(int status)
{
    static const struct row unknown = {"E_UNKNOWN", "unknown status",
                                       "the number is no status of this version of the library"};
    const size_t count = sizeof rows / sizeof *rows;
    return status <= 0 && status > -(int)count ? &rows[-status] : &unknown;
}

const char *tfa_status_text(int status)
{
    return row_of(status)->text;
}

const char *tfa_status_cause(int status)
{
    return row_of(status)->cause;
}

const char *tfa_status_name(int status)
{
    return row_of(status)->name;
}
