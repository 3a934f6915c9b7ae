/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The litmus tests.
 */
#ifndef TFA_EXPLORER_LITMUS_H
#define TFA_EXPLORER_LITMUS_H

/** Prints a table. @return number of failures */
int litmus_run(void);

#endif
