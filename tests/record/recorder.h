/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce record` and `replay` as processes, and clients that ask for all kinds of answers.
 */
#ifndef TFA_TESTS_RECORDER_H
#define TFA_TESTS_RECORDER_H

#include <stdbool.h>
#include <sys/types.h>

#include "harness.h"

#define RECORDER_TEXT 65536

/** A child and the file of its standard output and error. */
typedef struct recorder {
    pid_t pid;
    char out[128];
    char text[RECORDER_TEXT];
} recorder;

/** Starts `totalforce COMMAND WORDS`; `words` are separated by spaces. `limit`: of its files, 0:
 *  none. */
void recorder_spawn(const harness *h, recorder *r, const char *words, unsigned long limit);
/** Waits for its end, reads its text. @return exit status; -signal */
int recorder_wait(recorder *r);
/** Both. */
int recorder_run(const harness *h, recorder *r, const char *words);

/** Starts `totalforce record ROBOT -o FILE MORE` in the harness's folder and waits until it
 *  records. */
void recorder_begin(const harness *h, recorder *r, const char *robot, const char *file,
                    const char *more, unsigned long limit);
/** SIGINT, then recorder_wait. */
int recorder_end(recorder *r);

/** `totalforce replay FILE MORE` of a file in the harness's folder. */
int recorder_replay(const harness *h, recorder *r, const char *file, const char *more);

/** The number after `word` in the text; -1: it is not there. */
long recorder_number(const recorder *r, const char *word);

/** One request of kind `i` about the 7-joint arm, over either transport. @return status */
struct tfa_dds_client;
int ask_kind(tfa_client *ring, struct tfa_dds_client *dds, unsigned i);

#endif
