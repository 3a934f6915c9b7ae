/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * SIGKILL on either side: nothing leaks, nobody else notices, everybody recovers.
 */
#include "harness.h"
#include "models.h"
#include "support/sanitized.h"
#include "test.h"

#include <errno.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#define KILLS 200
#ifdef SANITIZED
#define GROWTH_KIB 16384 /* its records of the atomics of a client's counters, too */
#define MAPPINGS (KILLS / 2) /* its allocator maps, too: up to 58 on a busy machine */
#else
#define GROWTH_KIB 1024
#define MAPPINGS (KILLS / 4)
#endif
#define TIMEOUT_NS WAIT_NS
#define DAY_NS (UINT64_C(86400) * 1000000000)

/* ---- clients that die ---- */

/* Asks until it is killed, or, with `until`, until that descriptor is closed by the other side,
 * which gets a byte after the first answer. */
static void ask_until_killed(const harness *h, tfa_wait wait, int until)
{
    tfa_client_options options = harness_options(h, "arm");
    tfa_client *client;
    double qdd[7], first[7];
    char byte;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    options.wait = wait;
    if (tfa_client_connect(&options, &client) != TFA_OK ||
        ask_arm(client, 1, first, TIMEOUT_NS) != TFA_OK)
        _exit(10);
    if (until >= 0 && send(until, "a", 1, 0) != 1)
        _exit(13);
    for (;;) {
        if (ask_arm(client, 1, qdd, TIMEOUT_NS) != TFA_OK)
            _exit(11);
        if (memcmp(qdd, first, sizeof qdd) != 0)
            _exit(12);
        if (until >= 0 && recv(until, &byte, 1, MSG_DONTWAIT) == 0)
            _exit(0);
    }
}

static pid_t start_client(const harness *h, tfa_wait wait, int until)
{
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        ask_until_killed(h, wait, until);
    return pid;
}

static void kill_client(const harness *h, unsigned number)
{
    static const tfa_wait waits[] = {TFA_WAIT_HYBRID, TFA_WAIT_BLOCK, TFA_WAIT_SPIN};
    pid_t pid = start_client(h, waits[number % 3], -1);
    usleep(number * 7919 % 6000); /* nothing depends on it: in the greeting, or among requests */
    kill(pid, SIGKILL);
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    if (!WIFSIGNALED(status))
        fail_msg("the client ended by itself with %d", WEXITSTATUS(status));
}

TEST(clients_killed)
{
    int end[2];
    char byte;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, end), 0);
    pid_t honest_client = fork();
    if (honest_client == 0) {
        close(end[1]);
        ask_until_killed(&h, TFA_WAIT_HYBRID, end[0]);
    }
    close(end[0]);
    SCOPED_CLIENT *mine = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
    double qdd[7];
    assert_int_equal(recv(end[1], &byte, 1, 0), 1); /* the witness has its client */
    assert_true(harness_has_clients(&h, 2));
    const int descriptors = harness_descriptors(&h);
    for (unsigned i = 0; i < 20; i++) /* the allocator's pools fill up */
        kill_client(&h, i);
    harness_assert_descriptors(&h, descriptors);
    const long resident = harness_resident_kib(&h);
    const int mappings = harness_mappings(&h);
    for (unsigned i = 0; i < KILLS; i++) {
        kill_client(&h, i);
        assert_int_equal(ask_arm(mine, i, qdd, TIMEOUT_NS), TFA_OK);
    }
    harness_assert_descriptors(&h, descriptors);
    /* a client that is not unmapped leaves two */
    assert_in_range(harness_mappings(&h), 1, mappings + MAPPINGS);
    /* one client's segments are 300 KiB: 200 lost ones would be 60 MB */
    assert_in_range(harness_resident_kib(&h), 1, resident + GROWTH_KIB);
    assert_int_equal(harness_named_segments(&h), 0);
    close(end[1]);
    assert_int_equal(child_end(honest_client), 0);
}

/* ---- a daemon that dies ---- */

/* Kills the daemon from another process after a while, so that most of the time the call is under
 * way; nothing depends on it. */
static pid_t kill_after_delay(const harness *h)
{
    pid_t pid = fork();
    if (pid == 0) {
        sleep_ms(50);
        kill(h->pid, SIGKILL);
        _exit(0);
    }
    return pid;
}

/* A call under way hears of it, long before its timeout, in every wait mode. */
TEST(calls_report_the_restart)
{
    static const tfa_wait waits[] = {TFA_WAIT_SPIN, TFA_WAIT_HYBRID, TFA_WAIT_BLOCK};
    double qdd[7], before[7];
    SCOPED_HARNESS h = harness_make(ARM, "");
    for (int i = 0; i < 3; i++) {
        harness_start(&h, "arm");
        tfa_client *client = harness_connect(&h, "arm", waits[i]);
        const int32_t first = tfa_client_get_info(client)->daemon_pid;
        const char *const *names = tfa_client_get_info(client)->joint_names;
        assert_int_equal(first, h.pid);
        assert_int_equal(ask_arm(client, 1, before, TIMEOUT_NS), TFA_OK);
        harness_pause(&h);
        assert_int_equal(harness_named_segments(&h), 0); /* none stays behind */
        pid_t killer = kill_after_delay(&h);
        assert_int_equal(ask_arm(client, 2, qdd, DAY_NS), TFA_E_DISCONNECTED);
        assert_int_equal(ask_arm(client, 2, qdd, DAY_NS), TFA_E_DISCONNECTED);
        waitpid(killer, NULL, 0);
        waitpid(h.pid, NULL, 0);
        harness_start(&h, "arm"); /* over the dead one's socket and lock */
        assert_int_equal(tfa_client_reconnect(client), TFA_OK);
        assert_int_not_equal(tfa_client_get_info(client)->daemon_pid, first);
        assert_ptr_equal(tfa_client_get_info(client)->joint_names, names);
        assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
        assert_memory_equal(qdd, before, sizeof qdd);
        tfa_client_close(client);
        assert_int_equal(harness_stop(&h, SIGTERM), 0);
        assert_int_equal(rmdir(h.runtime_dir), 0); /* nothing is left of either */
    }
}

TEST(lost_requests_are_reported)
{
    double q[7] = {0}, qdd[7];
    const tfa_request r = request_fd(q, NULL, NULL);
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange times;
    uint64_t ids[3];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
    harness_pause(&h);
    for (int i = 0; i < 3; i++)
        assert_int_equal(tfa_client_send(client, &r, &ids[i]), TFA_OK);
    (void)harness_stop(&h, SIGKILL);
    assert_int_equal(tfa_client_receive(client, &reply, TIMEOUT_NS, NULL), TFA_E_DISCONNECTED);
    harness_start(&h, "arm");
    assert_int_equal(tfa_client_reconnect(client), TFA_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(tfa_client_receive(client, &reply, TIMEOUT_NS, &times), TFA_E_LOST);
        assert_int_equal(times.id, ids[i]);
    }
    uint64_t id;
    assert_int_equal(tfa_client_send(client, &r, &id), TFA_OK);
    assert_true(id > ids[2]); /* ids are never used twice */
    assert_int_equal(tfa_client_receive(client, &reply, TIMEOUT_NS, &times), TFA_OK);
    assert_int_equal(times.id, id);
}

TEST(reconnect_waits_for_the_daemon)
{
    double qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client_options options = harness_options(&h, "arm");
    tfa_client *hasty, *patient = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
    options.connect_timeout_ms = 15; /* as short as it connects here: it is waited for below */
    assert_true(WAIT_FOR(
        (options.connect_timeout_ms *= 2, tfa_client_connect(&options, &hasty) == TFA_OK)));
    (void)harness_stop(&h, SIGKILL);
    assert_int_equal(tfa_client_reconnect(hasty), TFA_E_DISCONNECTED);
    assert_int_equal(tfa_client_reconnect(hasty), TFA_E_DISCONNECTED);
    assert_int_equal(ask_arm(hasty, 1, qdd, TIMEOUT_NS), TFA_E_DISCONNECTED);
    pid_t late = fork(); /* starts the daemon while the client is trying */
    if (late == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        sleep_ms(100); /* nothing depends on it: the client may also come when it is there */
        execl(TFA_BINARY_DIR "/bin/totalforced", "totalforced", h.config, (char *)NULL);
        _exit(127);
    }
    assert_int_equal(tfa_client_reconnect(patient), TFA_OK);
    assert_int_equal(ask_arm(patient, 1, qdd, TIMEOUT_NS), TFA_OK);
    tfa_client_close(patient);
    tfa_client_close(hasty);
    h.pid = late;
}

static bool socket_is_late; /* the next connect finds no socket */

/* takes the place of the C library's */
__attribute__((visibility("default"))) int connect(int fd, __CONST_SOCKADDR_ARG address,
                                                   socklen_t size)
{
    if (!socket_is_late)
        return (int)syscall(SYS_connect, fd, address.__sockaddr__, size);
    socket_is_late = false;
    errno = ENOENT;
    return -1;
}

/* A daemon that opens its sockets right after a client's connect is not one without the robot. */
TEST(a_robot_of_a_daemon_that_just_started_is_known)
{
    tfa_client *client;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client_options options = harness_options(&h, "arm");
    socket_is_late = true;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
    assert_false(socket_is_late);
    tfa_client_close(client);
    options.robot = "leg";
    assert_int_equal(tfa_client_connect(&options, &client), TFA_E_ROBOT);
}

/* @return how many connections the paused daemon's queue takes */
static int fill_queue(const harness *h, int *fds, int most)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s/arm.sock", h->runtime_dir);
    for (int n = 0; n < most; n++) {
        fds[n] = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        assert_true(fds[n] >= 0);
        if (connect(fds[n], (const struct sockaddr *)&address, sizeof address) == 0)
            continue;
        assert_int_equal(errno, EAGAIN);
        close(fds[n]);
        return n;
    }
    fail_msg("the queue takes more than %d", most);
    return most;
}

/* A daemon that gets no processor does not take clients from its queue for a while. */
TEST(a_full_queue_is_waited_for)
{
    enum { SHORT_MS = 50, MOST = 1000 };
    tfa_client *client;
    int fds[MOST];
    SCOPED_HARNESS h = harness_serve(ARM, "limits: {clients: 200, clients_per_user: 200, "
                                          "connects_per_second: 100000}\n");
    tfa_client_options options = harness_options(&h, "arm");
    harness_pause(&h);
    const int n = fill_queue(&h, fds, MOST);
    options.connect_timeout_ms = SHORT_MS;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_E_TIMEOUT);
    const pid_t waiting = start_client(&h, TFA_WAIT_BLOCK, -1);
    sleep_ms(20); /* nothing depends on it: it waits by now, or comes when there is room */
    assert_int_equal(kill(h.pid, SIGCONT), 0);
    assert_true(harness_has_clients(&h, 1));
    int status;
    kill(waiting, SIGKILL);
    assert_int_equal(waitpid(waiting, &status, 0), waiting);
    assert_true(WIFSIGNALED(status));
    for (int i = 0; i < n; i++)
        close(fds[i]);
}

/* After the restart the name stands for a robot of another size: the buffers do not fit. */
TEST(another_robot_is_refused)
{
    harness h, other;
    double qdd[7];
    h = harness_make(ARM, "");
    other = harness_make("  - name: arm\n    urdf: @/config/robots/snake64.urdf\n", "");
    harness_start(&h, "arm");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
    (void)harness_stop(&h, SIGKILL);
    char more[256];
    snprintf(more, sizeof more, "sed -i 's|^runtime_dir:.*|runtime_dir: %s|' %s", h.runtime_dir,
             other.config);
    assert_int_equal(system(more), 0);
    strcpy(other.runtime_dir, h.runtime_dir);
    harness_start(&other, "arm");
    assert_int_equal(tfa_client_reconnect(client), TFA_E_SIZE);
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_E_DISCONNECTED);
    harness_remove(&other);
    harness_remove(&h);
}
