/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Litmus tests with known outcomes: they test the explorer.
 *
 * A thread is a text of operations: W writes, R reads into the thread's next register, A adds 1 and
 * reads the old value; then a variable x, y or z, for W a value, and the order: . relaxed, a
 * acquire, r release, s seq_cst. P writes plain memory, p reads it if the last register is 1. An
 * outcome is the registers of all threads.
 */
#include <stdio.h>
#include <string.h>

#include "explorer.h"
#include "litmus.h"

typedef struct litmus {
    const char *name, *threads[4], *outcome;
    bool seen; /* the outcome occurs; "race": a data race is found */
    bool weak_sc;
} litmus;

static const litmus tests[] = {
    {"store buffering, seq_cst", {"Wx1s Rys", "Wy1s Rxs"}, "00", false, false},
    {"store buffering, release and acquire", {"Wx1r Rya", "Wy1r Rxa"}, "00", true, false},
    {"store buffering, one store release", {"Wx1r Rys", "Wy1s Rxs"}, "00", true, false},
    {"store buffering, one load acquire", {"Wx1s Rya", "Wy1s Rxs"}, "00", true, false},
    {"store buffering, usual outcome", {"Wx1s Rys", "Wy1s Rxs"}, "11", true, false},
    {"message passing, release and acquire", {"Wx1. Wy1r", "Rya Rx."}, "10", false, false},
    {"message passing, release read late", {"Wx1. Wy1r", "Rya Rx."}, "01", true, false},
    {"message passing, relaxed store", {"Wx1. Wy1.", "Rya Rx."}, "10", true, false},
    {"message passing, relaxed load", {"Wx1. Wy1r", "Ry. Rx."}, "10", true, false},
    {"message passing, seq_cst data, relaxed flag", {"Wx1s Wy1.", "Ry. Rxs"}, "10", true, false},
    {"message passing, seq_cst", {"Wx1s Wy1s", "Rys Rxs"}, "10", false, false},
    {"plain data, release and acquire", {"P Wy1r", "Rya p"}, "race", false, false},
    {"plain data, relaxed store", {"P Wy1.", "Rya p"}, "race", true, false},
    {"plain data, relaxed load", {"P Wy1r", "Ry. p"}, "race", true, false},
    {"plain data, written after", {"Wy1r P", "Rya p"}, "race", true, false},
    {"coherence, reads in order", {"Wx1. Wx2.", "Rx. Rx."}, "12", true, false},
    {"coherence, reads against the order", {"Wx1. Wx2.", "Rx. Rx."}, "21", false, false},
    {"coherence, relaxed read of an old value", {"Wx1. Wx2.", "Rx. Rx."}, "00", true, false},
    {"coherence, read after own write", {"Wx1. Rx.", "Wx2."}, "0", false, false},
    {"coherence, own write read before", {"Rx. Wx1."}, "1", false, false},
    {"coherence, two readers", {"Wx1.", "Wx2.", "Rx. Rx.", "Rx. Rx."}, "1221", false, false},
    {"seq_cst read behind the last seq_cst store",
     {"Wx1s Wx2s Rys", "Wy1s Rxs"},
     "01",
     false,
     false},
    {"seq_cst, through happens-before", {"Wx1s Wz1r", "Rza Rys", "Wy1s Rxs"}, "100", false, false},
    {"the same, S without happens-before", {"Wx1s Wz1r", "Rza Rys", "Wy1s Rxs"}, "100", true, true},
    {"store buffering, S without happens-before", {"Wx1s Rys", "Wy1s Rxs"}, "00", false, true},
    {"independent reads, seq_cst", {"Wx1s", "Wy1s", "Rxs Rys", "Rys Rxs"}, "1010", false, false},
    {"independent reads, acquire", {"Wx1s", "Wy1s", "Rxa Rya", "Rya Rxa"}, "1010", true, false},
    {"write to read causality", {"Wx1.", "Rx. Wy1r", "Rya Rx."}, "110", false, false},
    {"write to read causality, relaxed", {"Wx1.", "Rx. Wy1.", "Rya Rx."}, "110", true, false},
    {"message passing in two hops", {"Wx1. Wy1r", "Rya Wz1r", "Rza Rx."}, "110", false, false},
    {"message passing in two hops, relaxed",
     {"Wx1. Wy1r", "Ry. Wz1r", "Rza Rx."},
     "110",
     true,
     false},
    {"read-modify-write, both read 0", {"Ax.", "Ax."}, "00", false, false},
    {"release sequence, read-modify-write", {"Wx1. Wy1r", "Ay.", "Rya Rx."}, "120", false, false},
    {"release sequence, own store (as C++20)", {"Wx1. Wy1r Wy2.", "Rya Rx."}, "20", true, false},
    {"load buffering (outside the model)", {"Rx. Wy1.", "Ry. Wx1."}, "11", false, false},
};

static struct {
    const litmus *test;
    _Atomic uint64_t variables[3];
    uint64_t plain;
    char registers[4][8], next[4];
    int thread; /* the next body to start */
    bool seen;
} run;

static memory_order order_of(char c)
{
    return c == 's'   ? memory_order_seq_cst
           : c == 'a' ? memory_order_acquire
           : c == 'r' ? memory_order_release
                      : memory_order_relaxed;
}

static void read_into(int thread, uint64_t value)
{
    run.registers[thread][(int)run.next[thread]++] = (char)('0' + value);
}

static void execute_operation(int thread, const char *text)
{
    _Atomic uint64_t *variable =
        &run.variables[text[0] == 'p' || text[0] == 'P' ? 0 : text[1] - 'x'];
    switch (text[0]) {
    case 'W':
        atomic_store_explicit(variable, text[2] - '0', order_of(text[3]));
        break;
    case 'R':
        read_into(thread, atomic_load_explicit(variable, order_of(text[2])));
        break;
    case 'A':
        read_into(thread, atomic_fetch_add_explicit(variable, 1, order_of(text[2])));
        break;
    case 'P':
        explorer_data_write(&run.plain, 1);
        break;
    default:
        if (run.registers[thread][run.next[thread] - 1] == '1')
            (void)explorer_data_read(&run.plain);
    }
}

static void body(void *argument)
{
    (void)argument;
    const int thread = run.thread++;
    for (const char *at = run.test->threads[thread]; at; at = strchr(at, ' '))
        execute_operation(thread, at += *at == ' ');
}

static void reset(void *argument)
{
    (void)argument;
    run.thread = 0;
    memset(run.next, 0, sizeof run.next);
    memset(run.registers, 0, sizeof run.registers);
}

static void finish(void *argument)
{
    char outcome[32] = "";
    (void)argument;
    for (int k = 0; k < 4; k++)
        strcat(outcome, run.registers[k]);
    run.seen |= strcmp(outcome, run.test->outcome) == 0;
}

static bool passes(const litmus *test)
{
    explorer_program program = {.name = test->name,
                                .reset = reset,
                                .finish = finish,
                                .many_writers = true,
                                .weak_sc = test->weak_sc};
    for (int k = 0; k < 4 && test->threads[k]; k++)
        program.body[k] = body;
    run.test = test;
    run.seen = false;
    const explorer_result result = explorer_run(&program);
    const bool race = result.finding && strcmp(result.finding, "data race") == 0;
    const bool seen = race ? strcmp(test->outcome, "race") == 0 : run.seen;
    const bool good = seen == test->seen && (race || !result.finding);
    printf("  %-45s %-5s %-6s %6llu executions%s\n", test->name, test->outcome,
           seen ? "seen" : "never", (unsigned long long)result.executions, good ? "" : "  WRONG");
    return good;
}

int litmus_run(void)
{
    int failures = 0;
    printf("litmus tests\n");
    for (size_t k = 0; k < sizeof tests / sizeof *tests; k++)
        failures += !passes(&tests[k]);
    return failures;
}
