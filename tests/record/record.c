/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce record` at a real daemon, and what can happen to it: clients over both transports,
 * reloads, dead and hostile recorders, full rings and disks.
 *
 *   test_record [REQUESTS]    of the law, 30000: 25 MB
 */
#include "recorder.h"

#include "dds/dds_test.h"
#include "dds_client/dds_client.h"
#include "models.h"
#include "record/recording.h"
#include "record/taps.h"
#include "test.h"

#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define RING_CLIENTS 3
#define DDS_REQUESTS TEST_ROUNDS(4000)

static char *file_of(const harness *h, const char *name, char path[160])
{
    snprintf(path, 160, "%s/%s", h->directory, name);
    return path;
}

/* ---- clients ---- */

typedef struct asker {
    const harness *h;
    unsigned first;
    _Atomic unsigned count;
    bool dds;
    int failed;
    _Atomic unsigned answered;
    pthread_t thread;
} asker;

static void *ask(void *arg)
{
    asker *a = arg;
    tfa_client_options options = harness_options(a->h, "arm");
    const tfa_dds_client_options dds_options = {
        .domain = a->dds ? test_domain() : 0, .robot = "arm", .connect_timeout_ms = WAIT_MS};
    tfa_client *ring = NULL;
    tfa_dds_client *dds = NULL;
    options.max_batch = 8;
    a->failed =
        a->dds ? tfa_dds_client_connect(&dds_options, &dds) : tfa_client_connect(&options, &ring);
    for (unsigned i = a->first; i < a->first + a->count && !a->failed; i++) {
        const int status = ask_kind(ring, dds, i);
        a->failed = status != TFA_OK && status != TFA_E_VALUE ? status : 0;
        atomic_fetch_add_explicit(&a->answered, 1, memory_order_relaxed);
    }
    tfa_client_close(ring);
    tfa_dds_client_close(dds);
    return NULL;
}

/* Requests of several clients at once. */
static void ask_all(const harness *h, unsigned clients, unsigned ring_requests,
                    unsigned dds_requests)
{
    asker askers[RING_CLIENTS + 1];
    for (unsigned i = 0; i <= clients; i++) {
        const unsigned share = ring_requests / clients;
        askers[i] = (asker){.h = h,
                            .first = i * 1000003,
                            .count = i < clients ? share : dds_requests,
                            .dds = i == clients};
        if (i == 0)
            askers[i].count += ring_requests % clients;
        if (askers[i].count)
            assert_int_equal(pthread_create(&askers[i].thread, NULL, ask, &askers[i]), 0);
    }
    for (unsigned i = 0; i <= clients; i++)
        if (askers[i].count) {
            pthread_join(askers[i].thread, NULL);
            assert_int_equal(askers[i].failed, 0);
        }
}

static void ask_some(const harness *h, unsigned count)
{
    ask_all(h, RING_CLIENTS, count, 0);
}

/* ---- the law ---- */

static unsigned of_the_law = TEST_ROUNDS(30000);

/* All of them find room in the ring, however late the recorder is. */
TEST(every_request_again)
{
    char more[128];
    static recorder r;
    snprintf(more, sizeof more, "workers: 2\ndds: {enabled: true, domain: %u, lease_ms: %d}\n",
             test_domain(), TEST_LEASE_MS);
    SCOPED_HARNESS h = harness_serve(ARM, more);
    snprintf(more, sizeof more, "--count %u --buffer %d", of_the_law,
             of_the_law > 60000 ? 128 : 64);
    recorder_begin(&h, &r, "arm", "a.rec", more, 0);
    ask_all(&h, RING_CLIENTS, of_the_law - DDS_REQUESTS, DDS_REQUESTS);
    assert_int_equal(recorder_wait(&r), 0);
    assert_int_equal(recorder_number(&r, "a.rec: "), of_the_law);
    assert_int_equal(recorder_number(&r, "dropped "), 0);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), of_the_law);
    assert_int_equal(recorder_number(&r, "differ "), 0);
    snprintf(more, sizeof more, "--robot arm --runtime-dir %s", h.runtime_dir);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", more), 0);
    assert_int_equal(recorder_number(&r, "same bits "), of_the_law);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", "--json --tolerance 1e-12"), 0);
    assert_int_equal(recorder_number(&r, "\"same\": "), of_the_law);
}

/* ---- what a replay finds ---- */

/* A small recording in the harness's folder. */
static void make_recording(harness *h, const char *file, unsigned requests, unsigned clients)
{
    static recorder r;
    recorder_begin(h, &r, "arm", file, "", 0);
    ask_all(h, clients, requests, 0);
    assert_int_equal(recorder_end(&r), 0);
    assert_int_equal(recorder_number(&r, ".rec: "), (long)requests);
}

static void flip(const char *path, size_t at, unsigned char bits)
{
    unsigned char byte;
    const int fd = open(path, O_RDWR);
    assert_int_equal(pread(fd, &byte, 1, (off_t)at), 1);
    byte ^= bits;
    assert_int_equal(pwrite(fd, &byte, 1, (off_t)at), 1);
    close(fd);
}

/* Head and place of record `number`. */
static size_t find_record(const char *path, unsigned number, tfa_tap_record *head)
{
    tfa_recording_head file;
    const int fd = open(path, O_RDONLY);
    assert_int_equal(pread(fd, &file, sizeof file, 0), sizeof file);
    size_t at = sizeof file + tfa_recording_padded(file.settings_bytes) +
                tfa_recording_padded(file.urdf_bytes);
    for (unsigned k = 0;; k++, at += head->bytes) {
        assert_int_equal(pread(fd, head, sizeof *head, (off_t)at), sizeof *head);
        if (k == number)
            break;
    }
    close(fd);
    return at;
}

static void mend_checksum(const char *path, size_t at, const tfa_tap_record *head)
{
    unsigned char *bytes = malloc(head->bytes);
    const int fd = open(path, O_RDWR);
    assert_int_equal(pread(fd, bytes, head->bytes, (off_t)at), head->bytes);
    const uint32_t checksum = recording_crc32(0, bytes + 8, head->bytes - 8);
    assert_int_equal(pwrite(fd, &checksum, 4, (off_t)at + 4), 4);
    close(fd);
    free(bytes);
}

/* Requests of one client, so that kinds follow each other, and the last number of each kind. */
TEST(one_flipped_bit)
{
    static recorder r;
    char path[160], text[64];
    tfa_tap_record head;
    size_t at = 0;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    make_recording(&h, "a.rec", 50, 1);
    file_of(&h, "a.rec", path);
    for (unsigned record = 15; record < 22; record++) {
        at = find_record(path, record, &head);
        flip(path, at + head.bytes - 8, 1);
        assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 2);
        snprintf(text, sizeof text, "record %u", record);
        assert_non_null(strstr(r.text, text));
        assert_non_null(strstr(r.text, "checksum"));
        mend_checksum(path, at, &head); /* the file is whole, and an answer another one */
        assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 1);
        assert_int_equal(recorder_number(&r, "differ "), 1);
        snprintf(text, sizeof text, "first difference: record %u, state ", record);
        assert_non_null(strstr(r.text, text));
        assert_int_equal(recorder_replay(&h, &r, "a.rec", "--tolerance 1e-9"), 0);
        if (record != 21) {
            flip(path, at + head.bytes - 8, 1);
            mend_checksum(path, at, &head);
        }
    }
    assert_int_equal(recorder_number(&r, "within 1e-09 "), 1);
    flip(path, at + 1, 0x10); /* its length */
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 2);
    assert_int_equal(truncate(path, (off_t)at + 100), 0);
    flip(path, at + 1, 0x10);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), 21);
    assert_non_null(strstr(r.text, "the last record is cut off"));
}

TEST(another_model)
{
    harness h;
    static recorder r;
    char more[256];
    h = harness_serve(ARM "  - name: dog\n    urdf: @/config/robots/quadruped.urdf\n"
                          "  - name: moon\n    urdf: @/config/robots/arm7.urdf\n"
                          "    gravity: [0, 0, -1.62]\n",
                      "");
    make_recording(&h, "a.rec", 50, RING_CLIENTS);
    assert_int_equal(
        recorder_replay(&h, &r, "a.rec", "--urdf " TFA_SOURCE_DIR "/config/robots/quadruped.urdf"),
        2);
    assert_non_null(strstr(r.text, "other model"));
    assert_int_equal(
        recorder_replay(&h, &r, "a.rec", "--urdf " TFA_SOURCE_DIR "/config/robots/arm7.urdf"), 0);
    snprintf(more, sizeof more, "--robot dog --runtime-dir %s", h.runtime_dir);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", more), 2);
    assert_non_null(strstr(r.text, "dog: other model"));
    snprintf(more, sizeof more, "--robot moon --runtime-dir %s --any-model", h.runtime_dir);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", more), 1);
    assert_non_null(strstr(r.text, "the models differ"));
    assert_int_equal(recorder_replay(&h, &r, "a.rec", "--rate 1000 --tolerance -1"), 3);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", "--rate original"), 0);
    assert_int_equal(recorder_replay(&h, &r, "nothing.rec", ""), 2);
    harness_remove(&h);
}

/* The modes travel with the settings: the model is the same without their file. */
TEST(flexible_links)
{
    static recorder r;
    SCOPED_HARNESS h =
        harness_serve("  - name: arm\n    urdf: @/config/robots/flexible_arm.urdf\n"
                      "    scenes: [{name: bent, modes: [@/config/robots/flexible_arm.yaml]}]\n",
                      "");
    recorder_begin(&h, &r, "arm.bent", "a.rec", "", 0);
    tfa_client *client = harness_connect(&h, "arm.bent", TFA_WAIT_BLOCK);
    for (int i = 0; i < 5; i++) {
        double qdd[2], accelerations[6];
        const double q[2] = {0.3 * i, 1}, modes[6] = {0.01 * i, 0.001, 0, 0.02, 0, -0.001};
        tfa_request request = request_fd(q, q, NULL);
        tfa_reply reply = {.qdd = qdd, .modes = accelerations};
        request.modes = request.mode_velocities = modes;
        assert_int_equal(tfa_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
    }
    tfa_client_close(client);
    assert_int_equal(recorder_end(&r), 0);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), 5);
}

/* The same for constraints, which the hash of the model has */
TEST(constraints)
{
    static recorder r;
    SCOPED_HARNESS h = harness_serve(
        ARM
        "    scenes:\n      - name: held\n        actuated: [joint_2, joint_3]\n"
        "        constraints:\n"
        "          - {name: foot, second: {link: tool0, xyz: [0, 0, 0.1], rpy: [0.1, 0.2, 0.3]},"
        "\n             hold: [point, rz], unilateral: true}\n"
        "          - {name: grip, first: {link: link_2}, second: {link: tool0}, hold: weld}\n",
        "");
    recorder_begin(&h, &r, "arm.held", "a.rec", "", 0);
    tfa_client *client = harness_connect(&h, "arm.held", TFA_WAIT_BLOCK);
    for (int i = 0; i < 5; i++) {
        double q[7], v[7], tau[7], qdd[7];
        const tfa_request request = arm_request((double)i, q, v, tau);
        tfa_reply reply = {.qdd = qdd};
        assert_int_equal(tfa_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
    }
    tfa_client_close(client);
    assert_int_equal(recorder_end(&r), 0);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), 5);
}

/* Their status is that of the time, or of the daemon's configuration. */
TEST(late_and_refused)
{
    static recorder r;
    char more[128];
    double q[7], v[7], tau[7];
    long late = 0, sent = 0;
    SCOPED_HARNESS h = harness_serve(ARM "    refuse: [methods]\n", "");
    recorder_begin(&h, &r, "arm", "a.rec", "", 0);
    tfa_client_options options = harness_options(&h, "arm");
    options.deadline_us = 1;
    options.wait = TFA_WAIT_BLOCK;
    tfa_client *client = harness_connect_with(&options);
    for (; late < 20 && sent < 20000; sent++) {
        tfa_reply reply = {0};
        const tfa_request request = arm_request((double)sent, q, v, tau);
        late += tfa_client_call(client, &request, &reply, WAIT_NS, NULL) == TFA_E_LATE;
    }
    tfa_client_close(client);
    client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    tfa_request request = arm_request(1, q, v, tau);
    tfa_reply reply = {0};
    request.method = TFA_METHOD_ABA;
    assert_int_equal(tfa_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_E_REFUSED);
    tfa_client_close(client);
    assert_int_equal(recorder_end(&r), 0);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), sent - late);
    snprintf(more, sizeof more, "not played: %ld late, without room or sampled, 1 refused", late);
    assert_non_null(strstr(r.text, more));
    snprintf(more, sizeof more, "--robot arm --runtime-dir %s", h.runtime_dir);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", more), 0);
    assert_int_equal(recorder_number(&r, "same bits "), sent - late + 1);
}

/* ---- what happens meanwhile ---- */

TEST(one_recorder_at_a_time)
{
    static recorder r, other;
    char words[256];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    recorder_begin(&h, &r, "arm", "a.rec", "--seconds 100", 0);
    snprintf(words, sizeof words, "record arm -o %s/b.rec --runtime-dir %s", h.directory,
             h.runtime_dir);
    assert_int_equal(recorder_run(&h, &other, words), 2);
    assert_non_null(strstr(other.text, "is being recorded by process"));
    snprintf(words, sizeof words, "record leg -o %s/b.rec --runtime-dir %s", h.directory,
             h.runtime_dir);
    assert_int_equal(recorder_run(&h, &other, words), 2);
    assert_non_null(strstr(other.text, "no robot 'leg'"));
    assert_int_equal(recorder_end(&r), 0);
    snprintf(words, sizeof words, "record arm -o %s --runtime-dir %s", h.directory, h.runtime_dir);
    assert_int_equal(recorder_run(&h, &other, words), 2);
    assert_non_null(strstr(other.text, "Is a directory"));
    assert_null(strstr(other.text, "0 requests")); /* nothing was recorded */
}

TEST(a_killed_recorder)
{
    static recorder r;
    char text[64];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_true(harness_has_clients(&h, 0));
    assert_int_equal(tfa_daemon_command(h.runtime_dir, "describe arm", WAIT_MS, text, sizeof text),
                     TFA_OK); /* the description stays with the robot */
    const int descriptors = harness_descriptors(&h);
    for (int i = 0; i < 3; i++) {
        recorder_begin(&h, &r, "arm", "a.rec", "", 0);
        ask_some(&h, 3000);
        assert_int_equal(kill(r.pid, SIGKILL), 0);
        assert_int_equal(recorder_wait(&r), -SIGKILL);
        assert_true(harness_logged_times(&h, "records no more", (unsigned)i + 1));
        ask_some(&h, 1000);
    }
    harness_assert_descriptors(&h, descriptors);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0); /* as far as it came */
}

TEST(a_killed_client)
{
    static recorder r;
    int status, ends[2];
    char byte;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_int_equal(pipe(ends), 0);
    recorder_begin(&h, &r, "arm", "a.rec", "", 0);
    const pid_t child = fork();
    if (child == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        tfa_client_options options = harness_options(&h, "arm");
        tfa_client *client;
        options.max_batch = 8;
        if (tfa_client_connect(&options, &client) == TFA_OK)
            for (unsigned i = 0;; i++) {
                (void)ask_kind(client, NULL, i);
                if (i == 100)
                    (void)!write(ends[1], "a", 1);
            }
        _exit(1);
    }
    ask_some(&h, 5000);
    assert_int_equal(read(ends[0], &byte, 1), 1); /* it is asking */
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    close(ends[0]);
    close(ends[1]);
    ask_some(&h, 1000);
    assert_int_equal(recorder_end(&r), 0);
    assert_true(recorder_number(&r, "a.rec: ") > 6100);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
}

TEST(a_reload_ends_it)
{
    static recorder r;
    asker a;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    recorder_begin(&h, &r, "arm", "a.rec", "--seconds 100", 0);
    a = (asker){.h = &h, .count = UINT_MAX};
    assert_int_equal(pthread_create(&a.thread, NULL, ask, &a), 0);
    assert_true(WAIT_FOR(atomic_load(&a.answered) >= 100));
    harness_reload(&h, ARM "    gravity: [0, 0, -1.62]\n", "");
    assert_int_equal(recorder_wait(&r), 1);
    assert_non_null(strstr(r.text, "a reload gave the robot another model"));
    a.count = 0;
    pthread_join(a.thread, NULL);
    assert_int_equal(a.failed, 0);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0); /* no answer of the new model */
    recorder_begin(&h, &r, "arm", "b.rec", "", 0);
    assert_int_equal(kill(h.pid, SIGHUP), 0); /* nothing changes */
    ask_some(&h, 1000);
    assert_int_equal(recorder_end(&r), 0);
    assert_int_equal(recorder_number(&r, "b.rec: "), 1000);
    assert_int_equal(recorder_replay(&h, &r, "b.rec", ""), 0);
}

TEST(the_daemon_ends)
{
    static recorder r;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    recorder_begin(&h, &r, "arm", "a.rec", "--count 1000000", 0);
    ask_some(&h, 1000);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_int_equal(recorder_wait(&r), 1);
    assert_non_null(strstr(r.text, "the daemon has ended"));
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), 1000);
}

/* The daemon's file is another one now: the recording would be of no use. */
TEST(a_changed_urdf)
{
    char robots[256], words[256], path[160];
    static recorder r;
    SCOPED_HARNESS h = harness_make(ARM, "");
    file_of(&h, "robot.urdf", path);
    snprintf(words, sizeof words, "cp " TFA_SOURCE_DIR "/config/robots/arm7.urdf %s", path);
    assert_int_equal(system(words), 0);
    snprintf(robots, sizeof robots, "  - name: arm\n    urdf: %s\n", path);
    harness_configure(&h, robots, "");
    harness_start(&h, "arm");
    snprintf(words, sizeof words, "cp " TFA_SOURCE_DIR "/config/robots/arm6.urdf %s", path);
    assert_int_equal(system(words), 0);
    snprintf(words, sizeof words, "record arm -o %s/a.rec --runtime-dir %s", h.directory,
             h.runtime_dir);
    assert_int_equal(recorder_run(&h, &r, words), 2);
    assert_non_null(strstr(r.text, "is not what the daemon compiled robot 'arm' of"));
}

TEST(a_full_disk)
{
    static recorder r;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    recorder_begin(&h, &r, "arm", "a.rec", "", 1500000);
    ask_some(&h, 10000);
    assert_int_equal(recorder_wait(&r), 2);
    assert_non_null(strstr(r.text, "a.rec: File too large: the recording ends there"));
    const long records = recorder_number(&r, "a.rec: ");
    assert_true(records > 500 && records < 10000);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), records);
}

TEST(a_full_ring)
{
    static recorder r;
    int status;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    recorder_begin(&h, &r, "arm", "a.rec", "--buffer 1", 0);
    assert_int_equal(kill(r.pid, SIGSTOP), 0);
    assert_int_equal(waitpid(r.pid, &status, WUNTRACED), r.pid);
    ask_some(&h, 10000);
    assert_int_equal(kill(r.pid, SIGCONT), 0);
    assert_int_equal(recorder_end(&r), 1);
    const long records = recorder_number(&r, "a.rec: "), dropped = recorder_number(&r, "dropped ");
    assert_true(records > 500 && dropped > 100);
    assert_int_equal(records + dropped, 10000);
    assert_int_equal(recorder_replay(&h, &r, "a.rec", ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), records);
}

typedef struct scribbler {
    taps *t;
    _Atomic bool stop;
} scribbler;

/* Writes over all that it can reach. */
static void *scribble(void *arg)
{
    scribbler *s = arg;
    uint64_t x = 88172645463325252u;
    volatile uint64_t *words = s->t->segment;
    while (!atomic_load(&s->stop))
        for (size_t i = 0; i < 64; i++) {
            x ^= x << 13, x ^= x >> 7, x ^= x << 17;
            words[i % 2 ? i : x % (s->t->segment_bytes / 8)] = x;
        }
    return NULL;
}

TEST(a_hostile_recorder)
{
    taps t;
    pthread_t thread;
    char text[256];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_int_equal(taps_open(&t, h.runtime_dir, "arm", 1, text, sizeof text), 0);
    scribbler s = {.t = &t};
    assert_int_equal(pthread_create(&thread, NULL, scribble, &s), 0);
    ask_some(&h, 20000); /* each is answered */
    atomic_store(&s.stop, true);
    pthread_join(thread, NULL);
    assert_int_equal(send(t.socket, "x", 1, MSG_NOSIGNAL), 1); /* and it speaks */
    assert_true(harness_logged(&h, "a recorder has nothing to say"));
    taps_close(&t);
    for (const char *const *order =
             (const char *const[]){"arm", "arm 0", "arm 3", "arm 512", "arm 1x", " 1", NULL};
         *order; order++) {
        char word[64];
        snprintf(word, sizeof word, "record %s", *order);
        assert_int_equal(tfa_daemon_command(h.runtime_dir, word, WAIT_MS, text, sizeof text),
                         TFA_E_REFUSED);
    }
    ask_some(&h, 100);
}

int main(int argc, char **argv)
{
    if (argc > 1)
        of_the_law = (unsigned)atoi(argv[1]);
    return test_run(NULL, NULL);
}
