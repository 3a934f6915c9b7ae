/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A system-call filter on a thread: from then on any allocation and any system call ends the
 * process. Whoever waits for a thread without a processor does more than in the steady state; these
 * two do not end the process:
 *   - The client's look at its socket, when no reply came for LIVENESS_CHECK_NS: it finds nothing.
 *     One that comes earlier than that after the last one traps.
 *   - The worker's nap, when a client that spins asked nothing for a second: its clock is slow, so
 *     that it takes this second for a minute.
 *
 * It is a library to be preloaded. A process under it filters a thread by itself when the
 * environment asks for it:
 *   TFA_FILTER_THREAD=NAME  the thread of that name,
 *   TFA_FILTER_AFTER=N      when it asks for the time for the N-th time,
 *   TFA_FILTER_POOL=1       with what a caller of a pool needs while one of its threads has lost
 *   its
 *                         processor: futex, sched_yield and nanosleep are left, too.
 * A program may also call tfa_test_filter_syscalls.
 */
#ifndef TFA_TESTS_SERVICE_SYSCALL_FILTER_H
#define TFA_TESTS_SERVICE_SYSCALL_FILTER_H

/** Descriptors that a filtered thread may still read and write, to report. */
#define FILTER_READ_FD 200
#define FILTER_WRITE_FD 201

/** Seals the calling thread: malloc and its family trap (SIGILL); of the system calls only
 *  getrusage, exit_group, read and write of the descriptors above, and clock_gettime (which the
 *  vDSO falls back to on machines without a usable counter) are left, any other is SIGSYS.
 *  @return 0, or errno */
int tfa_test_filter_syscalls(void) __attribute__((weak, visibility("default")));

#endif
