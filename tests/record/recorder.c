/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "recorder.h"

#include "dds_client/dds_client.h"
#include "test.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define PROGRAM TFA_BINARY_DIR "/bin/totalforce"
#define WORDS 32

void recorder_spawn(const harness *h, recorder *r, const char *words, unsigned long limit)
{
    static unsigned count;
    snprintf(r->out, sizeof r->out, "%s/out%u", h->directory, count++);
    r->pid = fork();
    assert_true(r->pid >= 0);
    if (r->pid != 0)
        return;
    char copy[1024], *rest = copy, *argv[WORDS] = {(char *)(uintptr_t) "totalforce"};
    const struct rlimit files = {limit, limit};
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    snprintf(copy, sizeof copy, "%s", words);
    for (int i = 1; i < WORDS - 1 && rest;) {
        char *word = strsep(&rest, " ");
        if (*word)
            argv[i++] = word;
    }
    const int fd = open(r->out, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    (void)dup2(fd, STDOUT_FILENO);
    (void)dup2(fd, STDERR_FILENO);
    if (limit)
        (void)setrlimit(RLIMIT_FSIZE, &files);
    execv(PROGRAM, argv);
    _exit(127);
}

static void read_text(recorder *r)
{
    FILE *in = fopen(r->out, "r");
    assert_non_null(in);
    r->text[fread(r->text, 1, sizeof r->text - 1, in)] = 0;
    fclose(in);
}

int recorder_wait(recorder *r)
{
    int status;
    assert_int_equal(waitpid(r->pid, &status, 0), r->pid);
    r->pid = 0;
    read_text(r);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

int recorder_run(const harness *h, recorder *r, const char *words)
{
    recorder_spawn(h, r, words, 0);
    return recorder_wait(r);
}

void recorder_begin(const harness *h, recorder *r, const char *robot, const char *file,
                    const char *more, unsigned long limit)
{
    char words[512], text[128];
    snprintf(words, sizeof words, "record %s -o %s/%s --runtime-dir %s %s", robot, h->directory,
             file, h->runtime_dir, more);
    recorder_spawn(h, r, words, limit);
    snprintf(text, sizeof text, "robot '%s': process %d records", robot, (int)r->pid);
    if (harness_logged(h, text))
        return;
    read_text(r);
    fail_msg("'%s' is not logged; the recorder says: %s", text, r->text);
}

int recorder_end(recorder *r)
{
    assert_int_equal(kill(r->pid, SIGINT), 0);
    return recorder_wait(r);
}

int recorder_replay(const harness *h, recorder *r, const char *file, const char *more)
{
    char words[512];
    snprintf(words, sizeof words, "replay %s/%s %s", h->directory, file, more);
    return recorder_run(h, r, words);
}

long recorder_number(const recorder *r, const char *word)
{
    const char *at = strstr(r->text, word);
    return at ? strtol(at + strlen(word), NULL, 10) : -1;
}

#define BATCH 8

int ask_kind(tfa_client *ring, struct tfa_dds_client *dds, unsigned i)
{
    static const tfa_op ops[] = {TFA_OP_FORWARD_DYNAMICS, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_INVERSE_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA,
                                 TFA_OP_MASS_MATRIX,      TFA_OP_TASK_TORQUES,
                                 TFA_OP_FORWARD_DYNAMICS};
    double numbers[3][BATCH * 7], qdd[BATCH * 7], tau[BATCH * 7], lambda[36], mass[49], task[6];
    tfa_answer answers[BATCH];
    tfa_rank rank[BATCH];
    const unsigned kind = i % 7;
    for (int k = 0; k < 3; k++)
        for (int n = 0; n < BATCH * 7; n++)
            numbers[k][n] = 0.01 * (double)(((unsigned)n * 37 + (unsigned)k * 11 + i) % 300);
    for (int n = 0; n < 6; n++)
        task[n] = 0.1 * n;
    if (i % 97 == 0)
        numbers[0][0] = __builtin_nan(""); /* refused */
    const tfa_request r = {.op = ops[kind],
                           .refine = TFA_REFINE_DEFAULT,
                           .estimate = i % 11 == 0 ? TFA_ESTIMATE_ALWAYS : TFA_ESTIMATE_DEFAULT,
                           .count = kind == 1 ? BATCH : 1,
                           .q = numbers[0],
                           .v = numbers[1],
                           .tau = numbers[2],
                           .task_acceleration = task,
                           .tip_count = kind == 3 || kind == 5 || kind == 6,
                           .tips = {9}};
    tfa_reply reply = {.qdd = qdd,
                       .tau = tau,
                       .lambda_inv = lambda,
                       .mass_matrix = mass,
                       .rank = rank,
                       .answers = answers};
    return ring ? tfa_client_call(ring, &r, &reply, WAIT_NS, NULL)
                : tfa_dds_client_call(dds, &r, &reply, WAIT_NS, NULL);
}
