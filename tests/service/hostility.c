/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a client that asks little feels of each kind of attack: its times beside hostile sessions
 * and, just before, without them. Prints a table; "queue" is the time from the client's store to
 * the worker's start, which the scheduler answers for.
 *
 *   test_hostility [SAMPLES]    of each run; 3000
 *
 * An attack may double the queue's 90th percentile, or add as much as a few turns: that is
 * asserted, in the best of several attempts, because other programs take the processor, too.
 */
#include "raw_client.h"
#include "test.h"

#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define PERIOD_NS 200000 /* of the polite client */
#define TURN_NS 20000    /* the daemon's default */
#define ATTEMPTS 4
#define PARKED 500

static int samples = 3000;

/* ---- attacks: each runs in a process of its own, until it is killed ---- */

typedef struct attack {
    const char *name;
    int sessions;
    void (*run)(const harness *h); /* in a thread of each session */
    bool busy;                     /* takes the processors, too: compared with idle loops that do */
} attack;

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
    uint64_t seed = 88172645463325252u;
    for (;;) {
        uint64_t *slot = tfa_ring_next_request(&v.ring);
        for (size_t k = 1; k < v.ring.layout.request_stride / 8; k++) {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            slot[k] = seed;
        }
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
    for (int i = 0; i < PARKED; i++)
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
static void loop(const harness *h)
{
    (void)h;
    for (volatile unsigned k = 0;; k++)
        ;
}

static const attack attacks[] = {
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

static const attack *current;

static void *run_session(void *h)
{
    current->run(h);
    return NULL;
}

static pid_t start_attack(const attack *a, harness *h)
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

/* ---- the polite client ---- */

typedef struct figures {
    double queue[3], trip[3]; /* us: p50, p90, p99 */
} figures;

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void percentiles(double *us, int count, double p[3])
{
    qsort(us, (size_t)count, sizeof *us, by_value);
    p[0] = us[count / 2];
    p[1] = us[count * 9 / 10];
    p[2] = us[count * 99 / 100];
}

static uint64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static figures ask_politely(tfa_client *client)
{
    double q[7], v[7], tau[7], qdd[7];
    const tfa_request r = arm_request(1, q, v, tau);
    double *queue = calloc((size_t)samples, sizeof *queue);
    double *trip = calloc((size_t)samples, sizeof *trip);
    figures f;
    assert_true(queue && trip);
    for (int i = 0; i < samples; i++) {
        const uint64_t begin = clock_ns();
        tfa_reply reply = {.qdd = qdd};
        tfa_exchange x;
        assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, &x), TFA_OK);
        queue[i] = (double)(x.t_start - x.t_sent) * 1e-3;
        trip[i] = (double)(x.t_reply - x.t_sent) * 1e-3;
        const uint64_t spent = clock_ns() - begin;
        if (spent < PERIOD_NS)
            usleep((useconds_t)((PERIOD_NS - spent) / 1000));
    }
    percentiles(queue, samples, f.queue);
    percentiles(trip, samples, f.trip);
    free(queue);
    free(trip);
    return f;
}

static void print_row(const attack *a, const figures *alone, const figures *beside)
{
    print_message("%-32s %3d | %7.1f %7.1f | %7.1f %7.1f || %7.1f %7.1f | %7.1f %7.1f\n", a->name,
                  a->sessions, alone->queue[0], alone->queue[2], beside->queue[0], beside->queue[2],
                  alone->trip[0], alone->trip[2], beside->trip[0], beside->trip[2]);
}

static figures ask_beside(harness *h, tfa_client *polite, const attack *a)
{
    const pid_t child = start_attack(a, h);
    sleep_ms(150);
    const figures f = ask_politely(polite);
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    return f;
}

static bool withstands(harness *h, tfa_client *polite, const attack *a)
{
    const attack loops = {"loops", a->sessions, loop, true};
    const figures alone = a->busy ? ask_beside(h, polite, &loops) : ask_politely(polite);
    const figures beside = ask_beside(h, polite, a);
    print_row(a, &alone, &beside);
    return beside.queue[1] <= 2 * alone.queue[1] + 3e-3 * TURN_NS;
}

TEST(polite_clients_hardly_notice)
{
    harness h;
    harness_serve(&h, ARM,
                  "limits: {clients: 100, clients_per_user: 100, memory_mib: 2048, "
                  "memory_mib_per_user: 2048}\nlog: error\n");
    tfa_client *polite = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
    print_message("us, p50 and p99               sessions |      queue alone |    queue beside ||"
                  "  round trip alone |  round trip beside\n");
    for (size_t i = 0; i < sizeof attacks / sizeof *attacks; i++) {
        int attempt = 1;
        while (!withstands(&h, polite, &attacks[i]))
            if (++attempt > ATTEMPTS)
                fail_msg("%s: the queue of a polite client grew too long", attacks[i].name);
    }
    tfa_client_close(polite);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    harness_remove(&h);
}

int main(int argc, char **argv)
{
    signal(SIGPIPE, SIG_IGN);
    if (argc > 1)
        samples = atoi(argv[1]) > 100 ? atoi(argv[1]) : 100;
    return test_run(NULL, NULL);
}
