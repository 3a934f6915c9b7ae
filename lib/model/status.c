/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names, texts and causes of the status codes, all from the one list in status.h.
 */
#include <totalforce/status.h>

const char *tfa_status_text(int status)
{
    switch (status) {
#define STATUS_TEXT(name, number, text, cause)                                                     \
    case number:                                                                                   \
        return text;
        TFA_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
    default:
        return "unknown status";
    }
}

const char *tfa_status_cause(int status)
{
    switch (status) {
#define STATUS_CAUSE(name, number, text, cause)                                                    \
    case number:                                                                                   \
        return cause;
        TFA_STATUS_LIST(STATUS_CAUSE)
#undef STATUS_CAUSE
    default:
        return "the number is no status of this version of the library";
    }
}

const char *tfa_status_name(int status)
{
    switch (status) {
#define STATUS_NAME(name, number, text, cause)                                                     \
    case number:                                                                                   \
        return #name;
        TFA_STATUS_LIST(STATUS_NAME)
#undef STATUS_NAME
    default:
        return "E_UNKNOWN";
    }
}
