/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Models that change while the daemon answers: none lost, none mixed, nothing half built.
 *
 * `test_reload SWAPS [spin]` measures what an exchange costs the requests around it.
 */
#include "load.h"
#include "models.h"
#include "test.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define TIMEOUT_NS WAIT_NS
#define SWAPS TEST_ROUNDS(24)
#define QUIET 200 /* for each exchange: requests without exchanges, to compare with */

static const double gravities[LOAD_MODELS][3] = {{0, 0, -9.80665}, {0.5, 0, -1.62}};
static const tfa_payload payloads[LOAD_MODELS] = {
    {.link = "tool0", .mass = 2, .com = {0, 0, 0.05}, .inertia = {4e-3, 0, 0, 4e-3, 0, 2e-3}},
    {.link = "link_6", .mass = 0.5, .com = {0.1, 0, 0}},
};

/* One robot and one scene of it, both other in the two configurations. */
static const char *const yaml[LOAD_MODELS] = {
    ARM "    scenes:\n"
        "      - name: loaded\n"
        "        payload: [{link: tool0, mass: 2, com: [0, 0, 0.05],\n"
        "                   inertia: [4.0e-3, 0, 0, 4.0e-3, 0, 2.0e-3]}]\n",
    ARM "    gravity: [0.5, 0, -1.62]\n"
        "    scenes:\n"
        "      - name: loaded\n"
        "        payload: [{link: link_6, mass: 0.5, com: [0.1, 0, 0]}]\n",
};

typedef struct models {
    tfa_model *plain[LOAD_MODELS], *loaded[LOAD_MODELS];
} models;

/* As the daemon makes them: the scene shares the constants of the robot. */
static void make_models(models *m)
{
    for (int i = 0; i < LOAD_MODELS; i++) {
        const tfa_model_options options = {.gravity = gravities[i]};
        tfa_report report = {0};
        m->plain[i] = bundled_model("arm7.urdf", &options);
        assert_int_equal(
            tfa_model_derive(m->plain[i], NULL, &payloads[i], 1, &report, &m->loaded[i]), TFA_OK);
        tfa_report_free(&report);
    }
}

static void free_models(models *m)
{
    for (int i = 0; i < LOAD_MODELS; i++) {
        tfa_model_free(m->loaded[i]);
        tfa_model_free(m->plain[i]);
    }
}

/* ---- under load ---- */

static void print_figures(const char *what, load_figures f)
{
    print_message("%-22s %7u requests, median %7.2f us, p99 %8.2f, worst %9.2f\n", what, f.count,
                  f.median * 1e-3, f.p99 * 1e-3, f.worst * 1e-3);
}

/* Requests before the first exchange, between exchanges, and the first of each new model. */
static void print_all(const load *l, uint32_t quiet, uint32_t end)
{
    static const struct {
        const char *what;
        size_t member;
    } members[] = {{"from when it was due", offsetof(load_sample, latency)},
                   {"in the ring", offsetof(load_sample, wait)},
                   {"computing", offsetof(load_sample, computation)}};
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        print_message("%s:\n", members[i].what);
        print_figures("  no exchanges", load_poll(l, 0, quiet, false, members[i].member));
        print_figures("  between exchanges", load_poll(l, quiet, end, false, members[i].member));
        print_figures("  first of a new model", load_poll(l, quiet, end, true, members[i].member));
    }
}

static void swap_often(const harness *h, load *l, int swaps)
{
    for (int i = 1; i <= swaps; i++) {
        const int next = i % LOAD_MODELS;
        harness_reload(h, yaml[next], "");
        if (!load_count_answers(l, next))
            break;
        sleep_ms((unsigned)i % 7 * 3); /* nothing depends on it */
    }
}

static void under_load(int swaps, tfa_wait wait)
{
    models m;
    load l;
    make_models(&m);
    const load_robot robots[LOAD_CLIENTS] = {{"arm", {m.plain[0], m.plain[1]}},
                                             {"arm.loaded", {m.loaded[0], m.loaded[1]}}};
    SCOPED_HARNESS h = harness_serve(yaml[0], "");
    load_start(&l, &h, robots, wait);
    assert_true(WAIT_FOR(atomic_load(&l.count) >= (uint32_t)QUIET * (uint32_t)swaps));
    const uint32_t quiet = atomic_load(&l.count);
    const int descriptors = harness_descriptors(&h);
    swap_often(&h, &l, swaps);
    const uint32_t end = atomic_load(&l.count);
    assert_true(load_stop(&l));
    assert_true(harness_logged_times(&h, "reload: done, 2 of 2", (unsigned)swaps));
    harness_assert_descriptors(&h, descriptors);
    assert_int_equal(load_poll(&l, quiet, end, true, 0).count, swaps * LOAD_CLIENTS);
    print_message("%.0f requests/s; %u times more than %u ms behind\n",
                  end * 1e9 / (double)load_time(&l), l.resyncs, LOAD_BEHIND_NS / 1000000);
    print_all(&l, quiet, end);
    load_free(&l);
    free_models(&m);
}

TEST(swapped_under_load)
{
    under_load(SWAPS, TFA_WAIT_HYBRID);
}

/* ---- other shapes ---- */

#define SHAPES 6
#define SNAKE "  - name: arm\n    urdf: @/config/robots/snake64.urdf\n"
#define ARM_ENTRY "  - name: arm\n    urdf: arm.urdf\n"

/* What was sent is answered by the old model, then it hangs up; connected again, the new one. */
static void other_shape(tfa_wait wait)
{
    double q[LOAD_JOINTS] = {0.1, 0.2}, qdd[LOAD_JOINTS];
    const tfa_request request = request_fd(q, NULL, NULL);
    uint64_t id;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client *client = harness_connect(&h, "arm", wait);
    tfa_client *idle = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    const uint32_t slots = tfa_client_get_info(client)->slots;
    harness_configure(&h, SNAKE, "");
    for (uint32_t i = 0; i < slots; i++)
        assert_int_equal(tfa_client_send(client, &request, &id), TFA_OK);
    harness_reload(&h, NULL, "");
    assert_true(harness_logged(&h, "reload: done, 1 of 1"));
    assert_true(harness_logged(&h, "hung up on"));
    for (uint32_t i = 0; i < slots; i++) {
        tfa_reply reply = {.qdd = qdd};
        assert_int_equal(tfa_client_receive(client, &reply, TIMEOUT_NS, NULL), TFA_OK);
    }
    for (int i = 0; i < 2; i++) {
        const tfa_client_options options = harness_options(&h, "arm");
        char text[300];
        assert_int_equal(ask_arm(i ? idle : client, 1, qdd, TIMEOUT_NS), TFA_E_DISCONNECTED);
        (void)tfa_client_explain(&options, TFA_E_DISCONNECTED, text, sizeof text);
        assert_non_null(strstr(text, "hung up: the robot has other joints"));
    }
    assert_int_equal(tfa_client_reconnect(client), TFA_E_SIZE); /* its buffers would not fit */
    tfa_client_close(client);
    tfa_client_close(idle);
    client = harness_connect(&h, "arm", wait);
    assert_int_equal(tfa_client_get_info(client)->v_count, 64);
    tfa_client_close(client);
}

TEST(shape_changes)
{
    other_shape(TFA_WAIT_HYBRID);
    other_shape(TFA_WAIT_SPIN);
    other_shape(TFA_WAIT_BLOCK);
}

/* A link more, and the same joints: the poses of all frames need a larger buffer. */
TEST(link_added)
{
    static const char camera[] = "<link name=\"camera\"/><joint name=\"camera\" type=\"fixed\">"
                                 "<parent link=\"tool0\"/><child link=\"camera\"/></joint></robot>";
    double qdd[7];
    SCOPED_TEXT *arm = bundled_text("arm7.urdf");
    SCOPED_HARNESS h = harness_make(ARM_ENTRY, "");
    harness_write(&h, "arm.urdf", arm);
    harness_start(&h, "arm");
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    const uint32_t frames = tfa_client_get_info(client)->frame_count;
    arm = realloc(arm, strlen(arm) + sizeof camera);
    char *end = strstr(arm, "</robot>");
    assert_non_null(end);
    strcpy(end, camera);
    harness_write(&h, "arm.urdf", arm);
    harness_reload(&h, NULL, "");
    assert_true(harness_logged(&h, "reload: done, 1 of 1"));
    assert_true(harness_logged(&h, "hung up on"));
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_E_DISCONNECTED);
    assert_int_equal(tfa_client_reconnect(client), TFA_E_SIZE);
    assert_int_equal(tfa_client_get_info(client)->frame_count, frames);
    tfa_client_close(client);
    client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(tfa_client_get_info(client)->frame_count, frames + 1);
    tfa_client_close(client);
}

/* A robot that allows more tips than it did: the program's buffers are of the size granted first.
 * */
TEST(more_tips_granted)
{
    SCOPED_HARNESS h = harness_serve(ARM "    max_tips: 2\n", "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(tfa_client_get_info(client)->max_tips, 2);
    (void)harness_stop(&h, SIGKILL);
    harness_configure(&h, ARM "    max_tips: 4\n", "");
    harness_start(&h, "arm");
    assert_int_equal(tfa_client_reconnect(client), TFA_OK);
    assert_int_equal(tfa_client_get_info(client)->max_tips, 2);
}

/* One who asks without a pause; hung up on, it connects anew. Every reply fits the robot it saw.
 * `answered`: shapes that answered it. */
typedef struct asker {
    const harness *h;
    tfa_wait wait;
    int shapes;
    int status;
    _Atomic unsigned answered;
    pthread_t thread;
} asker;

static void ask_until_hung_up(asker *a)
{
    static const double zeros[64];
    double qdd[64];
    tfa_client_options options = harness_options(a->h, "arm");
    tfa_client *client;
    options.wait = a->wait;
    a->status = tfa_client_connect(&options, &client);
    if (a->status != TFA_OK)
        return;
    const tfa_request request = request_fd(zeros, NULL, NULL);
    tfa_reply reply = {.qdd = qdd};
    for (bool first = true; a->status == TFA_OK; first = false) {
        a->status = tfa_client_call(client, &request, &reply, TIMEOUT_NS, NULL);
        if (first && a->status == TFA_OK)
            atomic_fetch_add(&a->answered, 1);
    }
    tfa_client_close(client);
}

static void *ask_all_shapes(void *argument)
{
    asker *a = argument;
    for (a->status = TFA_E_DISCONNECTED; a->shapes < SHAPES && a->status == TFA_E_DISCONNECTED;
         a->shapes++)
        ask_until_hung_up(a);
    return NULL;
}

TEST(shape_changes_while_asked)
{
    SCOPED_HARNESS h = harness_serve(ARM, "");
    asker askers[2] = {{.h = &h, .wait = TFA_WAIT_HYBRID}, {.h = &h, .wait = TFA_WAIT_BLOCK}};
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&askers[i].thread, NULL, ask_all_shapes, &askers[i]), 0);
    for (unsigned i = 1; i <= SHAPES; i++) {
        for (int k = 0; k < 2; k++)
            assert_true(WAIT_FOR(atomic_load(&askers[k].answered) == i));
        harness_reload(&h, i % 2 ? SNAKE : ARM, "");
        assert_true(harness_logged_times(&h, "reload: done, 1 of 1", i));
    }
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    for (int i = 0; i < 2; i++) {
        pthread_join(askers[i].thread, NULL);
        assert_int_equal(askers[i].status, TFA_E_DISCONNECTED);
        assert_int_equal(askers[i].shapes, SHAPES);
    }
}

/* ---- what fails ---- */

/* Each reload is refused and named, and the model of before answers with the same bits. */
TEST(refused)
{
    static const struct {
        const char *robots, *more, *urdf, *text;
    } cases[] = {
        {ARM_ENTRY, "", "<robot name=\"arm\"><link name=\"base_link\">", "malformed file"},
        {ARM_ENTRY, "", "", "arm.urdf"},
        {ARM_ENTRY "    gravityy: [0, 0, 1]\n", "", NULL, "gravityy"},
        {ARM_ENTRY "    gravity: [0, 0]\n", "", NULL, "gravity"},
        {ARM_ENTRY "    urdf: nowhere.urdf\n", "", NULL, "urdf"},
        {ARM_ENTRY "    scenes: [{name: s}]\n", "", NULL, "scenes has 1 entries, it had 0"},
        {ARM_ENTRY ARM, "", NULL, "already the name"},
        {ARM_ENTRY "  - name: another\n    urdf: arm.urdf\n", "", NULL, "robots has 2 entries"},
        {"  - name: leg\n    urdf: arm.urdf\n", "", NULL, "robots[0].name is another"},
        {ARM_ENTRY, "workers: 2\n", NULL, "workers is another: that needs a restart"},
        {ARM_ENTRY "    armature: [{joint: joint_8, value: 1}]\n", "", NULL,
         "no joint 'joint_8'; nearest: 'joint_"},
    };
    double before[7], after[7];
    SCOPED_TEXT *arm = bundled_text("arm7.urdf");
    SCOPED_HARNESS h = harness_make(ARM_ENTRY, "");
    harness_write(&h, "arm.urdf", arm);
    harness_start(&h, "arm");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
    assert_int_equal(ask_arm(client, 1, before, TIMEOUT_NS), TFA_OK);
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        harness_write(&h, "arm.urdf", cases[i].urdf ? cases[i].urdf : arm);
        harness_reload(&h, cases[i].robots, cases[i].more);
        assert_true(harness_logged_times(&h, "everything stays as it was", i + 1));
        if (!harness_logged(&h, cases[i].text))
            fail_msg("case %u does not name '%s'", i, cases[i].text);
        assert_int_equal(ask_arm(client, 1, after, TIMEOUT_NS), TFA_OK);
        assert_memory_equal(before, after, sizeof before);
    }
    assert_int_equal(harness_log_lines(&h, "reload: done"), 0);
    harness_write(&h, "arm.urdf", arm); /* and a good one is taken */
    harness_reload(&h, ARM_ENTRY "    gravity: [0, 0, -1]\n", "");
    assert_true(harness_logged(&h, "reload: done, 1 of 1"));
    assert_int_equal(ask_arm(client, 1, after, TIMEOUT_NS), TFA_OK);
    assert_memory_not_equal(before, after, sizeof before);
}

/* What only the control thread reads is taken over, too; the models need not change. */
TEST(limits_are_taken)
{
    tfa_client *second;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    harness_reload(&h, ARM, "limits: {clients: 1}\n");
    assert_true(harness_logged(&h, "reload: done, 0 of 1"));
    const tfa_client_options options = harness_options(&h, "arm");
    assert_int_equal(tfa_client_connect(&options, &second), TFA_E_REFUSED);
}

/* Its answer is neither of these. */
static bool is_another(tfa_client *client, const double one[7], const double two[7])
{
    double qdd[7];
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
    return memcmp(qdd, one, sizeof qdd) != 0 && memcmp(qdd, two, sizeof qdd) != 0;
}

/* Signals that come faster than reloads end are not forgotten: the last file is the one. */
TEST(many_signals)
{
    double with_payload[7], last[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
    assert_int_equal(ask_arm(client, 1, with_payload, TIMEOUT_NS), TFA_OK);
    for (int i = 0; i < 50; i++) {
        harness_reload(&h, i % 2 ? ARM : ARM "    gravity: [0, 0, -3]\n", "");
        assert_int_equal(ask_arm(client, 1, last, TIMEOUT_NS), TFA_OK);
    }
    harness_reload(&h, ARM "    gravity: [0, 0, -2]\n", "");
    assert_true(WAIT_FOR(is_another(client, with_payload, last)));
    assert_int_equal(harness_stop(&h, SIGTERM), 0); /* a reload may be under way */
}

/* SIGKILL or SIGTERM in the middle of a reload: nothing is left, it starts again. */
TEST(ended_in_a_reload)
{
    double qdd[7];
    SCOPED_HARNESS h = harness_make(ARM, "");
    for (unsigned i = 0; i < 24; i++) {
        harness_configure(&h, ARM, "");
        harness_start(&h, "arm");
        SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
        harness_reload(&h, i % 2 ? SNAKE : ARM "    gravity: [0, 0, -2]\n", "");
        usleep(i * 211); /* nothing depends on it: at every stage of the reload */
        const int signal = i % 4 == 3 ? SIGTERM : SIGKILL;
        assert_int_equal(harness_named_segments(&h), 0); /* none stays behind */
        const int status = harness_stop(&h, signal);
        assert_true(signal == SIGKILL ? WIFSIGNALED(status) : status == 0);
        assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_E_DISCONNECTED);
    }
}

/* The file is a FIFO, so its reader is at work as long as this test wants. It logs while the daemon
 * ends without it. */
TEST(ended_while_the_file_is_read)
{
    (void)signal(SIGPIPE, SIG_IGN); /* the daemon may be gone before the last line */
    SCOPED_HARNESS h = harness_make(ARM, "");
    for (unsigned i = 0; i < 12; i++) {
        harness_configure(&h, ARM, "");
        harness_start(&h, "arm");
        assert_int_equal(unlink(h.config), 0);
        assert_int_equal(mkfifo(h.config, 0600), 0);
        harness_reload(&h, NULL, "");
        const int file = open(h.config, O_WRONLY | O_CLOEXEC); /* waits for the reader */
        assert_true(file >= 0);
        assert_int_equal(harness_named_segments(&h), 0); /* none stays behind */
        assert_int_equal(kill(h.pid, SIGTERM), 0);
        usleep(96000 + i * 1000); /* about ABANDON_NS of reload.c; nothing depends on it */
        for (unsigned k = 0; k < 40; k++)
            dprintf(file, "nonsense%u: 1\n", k);
        close(file);
        assert_int_equal(harness_stop(&h, SIGTERM), 0);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1) {
        under_load(atoi(argv[1]),
                   argc > 2 && strcmp(argv[2], "spin") == 0 ? TFA_WAIT_SPIN : TFA_WAIT_HYBRID);
        return 0;
    }
    return test_run(NULL, NULL);
}
