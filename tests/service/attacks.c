/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hostile sessions: each attack runs in a process of its own, until it is killed.
 */
#include "attacks.h"

#include "fuzz/random.h"
#include "raw_client.h"
#include "test.h"

#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

int attack_parked = 500;

static tfa_client *connect_session(const harness *h, uint32_t batch, tfa_wait wait)
{
    tfa_client_options options = harness_options(h, "arm");
    tfa_client *client;
    options.max_batch = batch;
    options.slots = 4;
    options.wait = wait;
    return tfa_client_connect(&options, &client) == TFA_OK ? client : NULL;
}

/* Keeps a session's ring full of the same request. */
static void ask_for_ever(const harness *h, uint32_t batch, uint32_t tips, uint32_t flags)
{
    static double zeros[64 * 7];
    tfa_client *client = connect_session(h, batch, TFA_WAIT_BLOCK);
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = flags,
                     .count = batch,
                     .tip_count = tips,
                     .q = zeros};
    tfa_reply reply = {0};
    for (uint32_t k = 0; k < tips; k++)
        r.tips[k] = 9 - k;
    while (client) {
        while (tfa_client_send(client, &r, NULL) == TFA_OK)
            ;
        (void)tfa_client_receive(client, &reply, WAIT_NS, NULL);
    }
}

static void spectra(const harness *h)
{
    ask_for_ever(h, 1, 8, TFA_WANT_SPECTRUM);
}

static void batches(const harness *h)
{
    ask_for_ever(h, 32, 0, 0);
}

static void large_batches(const harness *h)
{
    ask_for_ever(h, 64, 4, TFA_WANT_SPECTRUM);
}

static void single_states(const harness *h)
{
    ask_for_ever(h, 1, 0, 0);
}

/* Random bytes in every slot, refused or answered. */
static void garbage(const harness *h)
{
    raw_client v = connect_client(h, TFA_WAIT_BLOCK);
    struct random_source bits = {1};
    for (;;) {
        uint64_t *slot = tfa_ring_next_request(&v.ring);
        for (size_t k = 1; k < v.ring.layout.request_stride / 8; k++)
            slot[k] = random_next(&bits);
        if (tfa_ring_send(&v.ring))
            wake(&v);
        while (!tfa_ring_reply_ready(&v.ring))
            usleep(10);
        tfa_ring_release(&v.ring);
    }
}

static void bad_hellos(const harness *h)
{
    for (;;) {
        tfa_welcome w;
        const int fd = connect_raw(h);
        (void)!send(fd, "hello", 5, MSG_NOSIGNAL);
        (void)!recv(fd, &w, sizeof w, 0);
        close(fd);
    }
}

static void connections(const harness *h)
{
    for (;;)
        tfa_client_close(connect_session(h, 1, TFA_WAIT_BLOCK));
}

static void doorbells(const harness *h)
{
    raw_client v = connect_client(h, TFA_WAIT_BLOCK);
    for (;;) {
        wake(&v);
        usleep(20);
    }
}

static void *park(void *word)
{
    for (;;)
        (void)syscall(SYS_futex, word, FUTEX_WAIT, *(volatile uint32_t *)word, NULL, NULL, 0);
    return NULL;
}

/* Hundreds of threads sleep on the word of a reply, and the flag says so. */
static void parked_threads(const harness *h)
{
    raw_client v = connect_client(h, TFA_WAIT_BLOCK);
    pthread_attr_t small;
    pthread_t thread;
    pthread_attr_init(&small);
    pthread_attr_setstacksize(&small, 65536);
    for (int i = 0; i < attack_parked; i++)
        (void)pthread_create(
            &thread, &small, park,
            (void *)(uintptr_t)tfa_ring_futex_word(tfa_ring_oldest_reply(&v.ring)));
    for (;;) {
        const tfa_wire_request line = {.count = 1, .op = TFA_OP_MASS_MATRIX};
        unsigned char *slot = tfa_ring_next_request(&v.ring);
        memcpy(slot + 8, (const unsigned char *)&line + 8, sizeof line - 8);
        atomic_store(&tfa_ring_client_flags_of(&v.ring)->asleep, 1);
        if (tfa_ring_send(&v.ring))
            wake(&v);
        while (!tfa_ring_reply_ready(&v.ring))
            usleep(10);
        tfa_ring_release(&v.ring);
    }
}

/* Connected in spin mode, then stopped: the worker must not wait for it. */
static void stopped_spinner(const harness *h)
{
    (void)connect_client(h, TFA_WAIT_SPIN);
    pause();
}

/* Takes a processor and asks for nothing. */
void attack_loop(const harness *h)
{
    (void)h;
    for (volatile unsigned k = 0;; k++)
        ;
}

const attack attacks[] = {
    {"spectra of 8 tips", 1, spectra, false},
    {"spectra of 8 tips", 16, spectra, false},
    {"batches of 32 states", 31, batches, false},
    {"batches of 64, 4 tips, spectra", 16, large_batches, false},
    {"single states, full rings", 31, single_states, false},
    {"garbage in slots", 8, garbage, false},
    {"bad hellos", 4, bad_hellos, true},
    {"connections", 4, connections, true},
    {"doorbells", 4, doorbells, false},
    {"threads on one futex word", 1, parked_threads, false},
    {"stopped spinner", 1, stopped_spinner, false},
};

const size_t attack_count = sizeof attacks / sizeof *attacks;

static const attack *current;

static void *run_session(void *h)
{
    current->run(h);
    return NULL;
}

pid_t attack_start(const attack *a, harness *h)
{
    const pid_t child = fork();
    pthread_t thread;
    current = a;
    if (child != 0)
        return child;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (int i = 0; i < a->sessions; i++)
        if (pthread_create(&thread, NULL, run_session, h) != 0)
            _exit(1);
    for (;;)
        pause();
}

void attack_stop(pid_t process)
{
    kill(process, SIGKILL);
    assert_int_equal(waitpid(process, NULL, 0), process);
}
