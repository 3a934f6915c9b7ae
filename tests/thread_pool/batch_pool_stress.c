/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A pool with several times as many threads as cores, whose threads, the caller's too, are stopped
 * by signals for milliseconds at any moment: every answer comes, with the same bits. And one thread
 * pool for two pools of different models, used by several threads at once. Meant to run under
 * ThreadSanitizer too.
 */
#include "models.h"
#include "support/wait.h"
#include "test.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <sys/syscall.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

#define THREADS 8
#define TURNS 200 /* of each test, and as many stops at least */
#define TARGETS 64
#define STATES 61

/* ---- requests ---- */

/* A robot, a request, and what must come back. */
struct question {
    tfa_model *model;
    tfa_request request;
    size_t numbers; /* of qdd */
    double *memory, *expected;
};

static tfa_model *chain(uint32_t joints)
{
    tfa_link *links = calloc(joints + 1, sizeof *links);
    tfa_joint *chain_joints = calloc(joints, sizeof *chain_joints);
    assert_non_null(links);
    assert_non_null(chain_joints);
    for (uint32_t k = 0; k <= joints; k++)
        links[k] = (tfa_link){.name = "link",
                              .mass = 1,
                              .com = {0.5, 0, 0},
                              .quat = {0, 0, 0, 1},
                              .inertia = {0.01, 0, 0, 0.1, 0, 0.1}};
    for (uint32_t k = 0; k < joints; k++)
        chain_joints[k] = (tfa_joint){.name = "joint",
                                      .type = TFA_JOINT_REVOLUTE,
                                      .parent = k,
                                      .child = k + 1,
                                      .xyz = {1, 0, 0},
                                      .quat = {0.1, 0, 0, 0.995},
                                      .axis = {0, k % 2, 1 - k % 2},
                                      .mimic = -1};
    const tfa_description d = {.name = "chain",
                               .links = links,
                               .link_count = joints + 1,
                               .joints = chain_joints,
                               .joint_count = joints};
    tfa_model *model = compiled(&d, NULL);
    free(links);
    free(chain_joints);
    return model;
}

static void ask(struct question *x, tfa_model *model, tfa_method method, uint32_t states)
{
    const size_t n = (size_t)tfa_model_v_count(model) * states;
    x->model = model;
    x->numbers = n;
    x->memory = calloc(4 * n, sizeof *x->memory);
    assert_non_null(x->memory);
    for (size_t k = 0; k < 3 * n; k++)
        x->memory[k] = 0.01 * (double)(k * 37 % 101) - 0.5;
    x->expected = x->memory + 3 * n;
    x->request = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                               .method = method,
                               .estimate = TFA_ESTIMATE_NEVER,
                               .count = states,
                               .q = x->memory,
                               .v = x->memory + n,
                               .tau = x->memory + 2 * n};
    tfa_reply reply = {.qdd = x->expected};
    const tfa_workspace_options options = {.methods = TFA_METHODS_ALL};
    tfa_workspace *w = workspace_for(model, &options);
    assert_int_equal(tfa_compute(w, &x->request, &reply), TFA_OK);
    tfa_workspace_free(w);
}

static void forget(struct question *x)
{
    free(x->memory);
}

static double *buffer(const struct question *x)
{
    double *qdd = calloc(x->numbers, sizeof *qdd);
    assert_non_null(qdd);
    return qdd;
}

/* The answer of the pool. @return false: it is busy */
static bool answer_question(tfa_batch_pool *pool, const struct question *x, double *qdd)
{
    tfa_reply reply = {.qdd = qdd};
    memset(qdd, 0xff, x->numbers * sizeof *qdd);
    const int status = tfa_batch_pool_compute(pool, &x->request, &reply);
    if (status == TFA_E_BUSY)
        return false;
    if (status != TFA_OK || memcmp(qdd, x->expected, x->numbers * sizeof *qdd) != 0) {
        print_error("method %s, %u states: %s, other bits\n",
                    tfa_method_name((uint32_t)x->request.method), (unsigned)x->request.count,
                    tfa_status_name(status));
        abort(); /* may be in any thread */
    }
    return true;
}

/* ---- stopping of threads ---- */

static _Atomic uint32_t stops; /* that came to pass */

/* Holds the thread that it hits: it sleeps, or turns around as if others had its processor. */
static void stop_here(int signal)
{
    (void)signal;
    const int error = errno;
    const uint32_t number = atomic_fetch_add(&stops, 1);
    const struct timespec time = {.tv_nsec = 1000000 + 700000 * (number % 5)};
    if (number % 3) {
        (void)nanosleep(&time, NULL);
    } else {
        const uint64_t start = now_ns();
        while (now_ns() - start < 1000000)
            ;
    }
    errno = error;
}

/* The threads of all pools, and this one. */
static int find_threads(pid_t threads[TARGETS])
{
    int count = 0;
    DIR *d = opendir("/proc/self/task");
    assert_non_null(d);
    threads[count++] = (pid_t)syscall(SYS_gettid);
    for (const struct dirent *e; count < TARGETS && (e = readdir(d)) != NULL;) {
        char path[300], name[32] = "";
        snprintf(path, sizeof path, "/proc/self/task/%s/comm", e->d_name);
        FILE *in = fopen(path, "r");
        if (in && fgets(name, sizeof name, in) && strncmp(name, "tfa-pool", 8) == 0)
            threads[count++] = (pid_t)atoi(e->d_name);
        if (in)
            fclose(in);
    }
    closedir(d);
    return count;
}

struct trouble {
    pthread_t thread;
    pid_t targets[TARGETS];
    int count;
    _Atomic bool end;
};

static void *stop_others(void *argument)
{
    struct trouble *t = argument;
    uint32_t chance = 1;
    while (!atomic_load(&t->end)) {
        chance = chance * 1664525 + 1013904223;
        const struct timespec pause = {.tv_nsec = 50000 + 1000 * (chance >> 24)};
        nanosleep(&pause, NULL);
        (void)syscall(SYS_tgkill, getpid(), t->targets[(chance >> 16) % (uint32_t)t->count],
                      SIGUSR1);
    }
    return NULL;
}

static void begin_trouble(struct trouble *t)
{
    const struct sigaction action = {.sa_handler = stop_here};
    atomic_store(&stops, 0);
    assert_int_equal(sigaction(SIGUSR1, &action, NULL), 0);
    t->count = find_threads(t->targets);
    assert_true(t->count >= THREADS);
    atomic_store(&t->end, false);
    assert_int_equal(pthread_create(&t->thread, NULL, stop_others, t), 0);
}

static void end_trouble(struct trouble *t)
{
    atomic_store(&t->end, true);
    pthread_join(t->thread, NULL);
    signal(SIGUSR1, SIG_IGN);
}

/* ---- the tests ---- */

static void stress(uint32_t spin_ns)
{
    struct question batch, few, parts[2];
    tfa_model *robot = bundled_model("humanoid.urdf", NULL), *snake = chain(300);
    ask(&batch, robot, TFA_METHOD_AUTO, STATES);
    ask(&few, robot, TFA_METHOD_TFA, 3);
    ask(&parts[0], snake, TFA_METHOD_SCAN, 1);
    ask(&parts[1], snake, TFA_METHOD_TFA_CR, 2);
    const struct question *const asked[] = {&batch, &few, &parts[0], &parts[1]};
    tfa_batch_pool *pools[2];
    const tfa_batch_pool_options options = {
        .threads = THREADS, .spin_ns = spin_ns, .methods = TFA_METHODS_ALL};
    assert_int_equal(tfa_batch_pool_create(robot, &options, &pools[0]), TFA_OK);
    assert_int_equal(tfa_batch_pool_create(snake, &options, &pools[1]), TFA_OK);
    double *qdd = calloc(batch.numbers + parts[1].numbers, sizeof *qdd);
    assert_non_null(qdd);
    struct trouble trouble;
    begin_trouble(&trouble);
    uint32_t turns = 0;
    for (const uint64_t end = now_ns() + WAIT_NS; turns < TURNS || atomic_load(&stops) < TURNS;
         turns++) {
        assert_true(now_ns() < end);
        assert_true(answer_question(pools[turns / 2 % 2], asked[turns % 4], qdd));
    }
    end_trouble(&trouble);
    print_message("%u answers, %u stops\n", turns, atomic_load(&stops));
    free(qdd);
    for (int k = 0; k < 2; k++)
        tfa_batch_pool_free(pools[k]);
    for (int k = 0; k < 4; k++)
        free(asked[k]->memory);
    tfa_model_free(robot);
    tfa_model_free(snake);
}

/* Threads that sleep between requests, and threads that never do. */
TEST(test_stopped_sleepers)
{
    stress(1000);
}

TEST(test_stopped_spinners)
{
    stress(100000000);
}

static _Atomic uint32_t served, alone; /* of all askers */

/* A thread that asks, and computes alone while the thread pool is in use, until all together have
 * done both often enough. */
struct asker {
    pthread_t thread;
    tfa_batch_pool *pool;
    const struct question *question;
};

static void *ask_on(void *argument)
{
    struct asker *a = argument;
    double *qdd = buffer(a->question);
    const tfa_workspace_options options = {.methods = TFA_METHODS_ALL};
    tfa_workspace *own = workspace_for(a->question->model, &options);
    const uint64_t end = now_ns() + WAIT_NS;
    while (now_ns() < end && (atomic_load(&served) < TURNS || atomic_load(&alone) < TURNS)) {
        if (answer_question(a->pool, a->question, qdd)) {
            atomic_fetch_add(&served, 1);
            continue;
        }
        tfa_reply reply = {.qdd = qdd};
        assert_int_equal(tfa_compute(own, &a->question->request, &reply), TFA_OK);
        atomic_fetch_add(&alone, 1);
    }
    tfa_workspace_free(own);
    free(qdd);
    return NULL;
}

/* Three threads, two models, one thread pool: one is served at a time, none waits for another. */
TEST(test_shared_thread_pool)
{
    tfa_model *models[2] = {bundled_model("humanoid.urdf", NULL), chain(300)};
    struct question questions[2];
    tfa_batch_pool *pools[2];
    tfa_thread_pool *thread_pool = NULL;
    const tfa_thread_pool_options threads = {.threads = 3, .spin_ns = 20000};
    assert_int_equal(tfa_thread_pool_create(&threads, &thread_pool), TFA_OK);
    ask(&questions[0], models[0], TFA_METHOD_AUTO, STATES);
    ask(&questions[1], models[1], TFA_METHOD_SCAN, 1);
    const tfa_batch_pool_options options = {.thread_pool = thread_pool, .methods = TFA_METHODS_ALL};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(tfa_batch_pool_create(models[k], &options, &pools[k]), TFA_OK);
        assert_int_equal(tfa_batch_pool_threads(pools[k]), 3);
    }
    struct asker askers[3] = {0};
    for (int k = 0; k < 3; k++) {
        askers[k].pool = pools[k % 2];
        askers[k].question = &questions[k % 2];
        assert_int_equal(pthread_create(&askers[k].thread, NULL, ask_on, &askers[k]), 0);
    }
    for (int k = 0; k < 3; k++)
        pthread_join(askers[k].thread, NULL);
    print_message("%u by the team, %u alone\n", atomic_load(&served), atomic_load(&alone));
    assert_true(atomic_load(&served) >= TURNS);
    assert_true(atomic_load(&alone) >= TURNS);
    for (int k = 0; k < 2; k++) {
        tfa_batch_pool_free(pools[k]); /* the other one works on */
        forget(&questions[k]);
        tfa_model_free(models[k]);
    }
    tfa_thread_pool_free(thread_pool);
}
