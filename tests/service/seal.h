/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A seal on a thread: from then on any allocation and any system call ends the process.
 *
 * It is a library to be preloaded. A process under it seals a thread by itself when the
 * environment asks for it:
 *   TFA_SEAL_THREAD=NAME  the thread of that name,
 *   TFA_SEAL_AFTER=N      when it asks for the time for the N-th time,
 *   TFA_SEAL_POOL=1       with what a caller of a pool needs while one of its threads has lost its
 *                         processor: futex, sched_yield and nanosleep are left, too.
 * A program may also call tfa_test_seal.
 */
#ifndef TFA_TESTS_SERVICE_SEAL_H
#define TFA_TESTS_SERVICE_SEAL_H

/** Descriptors that a sealed thread may still read and write, to report. */
#define SEAL_READ_FD 200
#define SEAL_WRITE_FD 201

/** Seals the calling thread: malloc and its family trap (SIGILL); of the system calls only
 *  getrusage, exit_group, read and write of the descriptors above, and clock_gettime (which the
 *  vDSO falls back to on machines without a usable counter) are left, any other is SIGSYS.
 *  @return 0, or errno */
int tfa_test_seal(void) __attribute__((weak, visibility("default")));

#endif
