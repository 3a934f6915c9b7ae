/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Coroutines: the threads of a program under test. Their stacks are made once; each execution
 * starts their bodies anew, wherever the last one left them.
 */
#ifndef TFA_EXPLORER_COROUTINE_H
#define TFA_EXPLORER_COROUTINE_H

#include <stdbool.h>

#define COROUTINES 4

/** Makes coroutine k run `body(argument)` from its beginning at the next resume. */
void coroutine_start(int k, void (*body)(void *), void *argument);

/** Runs coroutine k until it yields. @return false: its body has ended */
bool coroutine_resume(int k);

/** From within a coroutine: back to coroutine_resume. */
void coroutine_yield(void);

/** Coroutine that runs */
int coroutine_current(void);

#endif
