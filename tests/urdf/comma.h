/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Switches the decimal comma of C++ streams on and off.
 */
#ifndef TESTS_URDF_COMMA_H
#define TESTS_URDF_COMMA_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

void comma_set(bool on);
bool comma_is_set(void);

#ifdef __cplusplus
}
#endif
#endif
