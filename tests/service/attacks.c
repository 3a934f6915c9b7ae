/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hostile sessions: each attack runs in a process of its own, until it is killed.
 */
#include "attacks.h"

#include "fuzz/random.h"
#include "raw_client.h"
#include "support/any_request.h"
#include "test.h"

#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

int attack_parked = 500;
const char *attack_robot = "arm";

static _Atomic unsigned long *steps; /* shared with the process of the sessions */

static void count_step(void)
{
    atomic_fetch_add_explicit(steps, 1, memory_order_relaxed);
}

static tfa_client *connect_session(const harness *h, const char *robot, uint32_t batch,
                                   tfa_wait wait)
{
    tfa_client_options options = harness_options(h, robot);
    tfa_client *client;
    options.max_batch = batch;
    options.slots = 4;
    options.wait = wait;
    return tfa_client_connect(&options, &client) == TFA_OK ? client : NULL;
}

/* The attack before this one may have used up the connections of its user for this second. */
static raw_client connect_later(const harness *h, tfa_wait wait)
{
    raw_client v;
    if (!WAIT_FOR((try_connect_client(h, wait, &v))))
        _exit(1);
    return v;
}

/* Keeps a session's ring full of the same request. */
static void ask_for_ever(const harness *h, uint32_t batch, uint32_t tips, uint32_t flags)
{
    static double zeros[64 * 7];
    tfa_client *client = NULL;
    if (!WAIT_FOR((client = connect_session(h, "arm", batch, TFA_WAIT_BLOCK)) != NULL))
        _exit(1);
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = flags,
                     .count = batch,
                     .tip_count = tips,
                     .q = zeros};
    tfa_reply reply = {0};
    for (uint32_t k = 0; k < tips; k++)
        r.tips[k] = 9 - k;
    for (;;) {
        while (tfa_client_send(client, &r, NULL) == TFA_OK)
            ;
        (void)tfa_client_receive(client, &reply, WAIT_NS, NULL);
        count_step();
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

/* Everything that can be asked of one state, by every method, with up to 8 tips anywhere. A load
 * beside which the robot weighs nothing trips the sentinel. */
static void ask_every_kind(const harness *h, bool loaded)
{
    static const double load[TFA_PAYLOAD_NUMBERS] = {1e9, 0.1, 0, 0, 1e7, 0, 0, 1e7, 0, 1e7};
    static _Atomic uint64_t seeds = 1;
    struct random_source bits = {atomic_fetch_add(&seeds, 1)};
    tfa_client *client = NULL;
    if (!WAIT_FOR((client = connect_session(h, attack_robot, 1, TFA_WAIT_BLOCK)) != NULL))
        _exit(1);
    const tfa_client_info *info = tfa_client_get_info(client);
    for (;;) {
        tfa_reply reply = {0};
        tfa_request r = any_request((unsigned)(random_next(&bits) % ANY_REQUESTS), info);
        r.op = (tfa_op)(1 + random_next(&bits) % TFA_OP_LAST);
        r.count = 1;
        r.tip_count = (uint32_t)(random_next(&bits) % (TFA_DEFAULT_TIPS + 1));
        for (uint32_t k = 0; k < r.tip_count; k++)
            r.tips[k] = (uint32_t)(random_next(&bits) % info->frame_count);
        if (loaded) {
            r.payload_count = 1;
            r.payloads = load;
            r.payload_frames[0] = (uint32_t)(random_next(&bits) % info->frame_count);
        }
        (void)tfa_client_call(client, &r, &reply, WAIT_NS, NULL);
        count_step();
    }
}

static void every_kind(const harness *h)
{
    ask_every_kind(h, false);
}

static void every_kind_loaded(const harness *h)
{
    ask_every_kind(h, true);
}

/* Random bytes in every slot, refused or answered. */
static void garbage(const harness *h)
{
    raw_client v = connect_later(h, TFA_WAIT_BLOCK);
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
        count_step();
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
        count_step();
    }
}

static void connections(const harness *h)
{
    for (;; count_step())
        tfa_client_close(connect_session(h, "arm", 1, TFA_WAIT_BLOCK));
}

static void doorbells(const harness *h)
{
    raw_client v = connect_later(h, TFA_WAIT_BLOCK);
    for (;;) {
        wake(&v);
        usleep(20);
        count_step();
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
    raw_client v = connect_later(h, TFA_WAIT_BLOCK);
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
        count_step();
    }
}

/* Connected in spin mode, then stopped: the worker must not wait for it. */
static void stopped_spinner(const harness *h)
{
    (void)connect_later(h, TFA_WAIT_SPIN);
    count_step();
    pause();
}

/* Takes a processor and asks for nothing. */
void attack_loop(const harness *h)
{
    (void)h;
    count_step();
    for (volatile unsigned k = 0;; k++)
        ;
}

const attack attacks[] = {
    {"spectra of 8 tips", 1, spectra, 100, false},
    {"spectra of 8 tips", 16, spectra, 100, false},
    {"batches of 32 states", 31, batches, 100, false},
    {"batches of 64, 4 tips, spectra", 16, large_batches, 32, false},
    {"single states, full rings", 31, single_states, 1000, false},
    {"every kind of request", 4, every_kind, 4000, false},
    {"the same, loads of 1e9 kg", 4, every_kind_loaded, 4000, false},
    {"garbage in slots", 8, garbage, 1000, false},
    {"bad hellos", 4, bad_hellos, 100, true},
    {"connections", 4, connections, 40, true},
    {"doorbells", 4, doorbells, 1000, false},
    {"threads on one futex word", 1, parked_threads, 100, false},
    {"stopped spinner", 1, stopped_spinner, 1, false},
};

const size_t attack_count = sizeof attacks / sizeof *attacks;

static const attack *current;

static void *run_session(void *h)
{
    current->run(h);
    return NULL;
}

unsigned long attack_steps(void)
{
    return atomic_load(steps);
}

static void reset_steps(void)
{
    if (!steps)
        steps =
            mmap(NULL, sizeof *steps, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(steps, MAP_FAILED);
    atomic_store(steps, 0);
}

pid_t attack_start(const attack *a, harness *h)
{
    reset_steps();
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
