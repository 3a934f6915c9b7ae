/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the daemon does around serving: service manager, user, rights, very large robots.
 */
#include "harness.h"
#include "test.h"

#include <pwd.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#define TIMEOUT_NS WAIT_NS
#define LINKS 1000

/* ---- the service manager ---- */

static int listen_notify(harness *h)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const struct timeval limit = {.tv_sec = WAIT_MS / 1000};
    snprintf(h->notify, sizeof h->notify, "%s/notify", h->directory);
    memcpy(address.sun_path, h->notify, strlen(h->notify) + 1);
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit), 0);
    return fd;
}

static void expect_message(int fd, const char *text)
{
    char message[256];
    ssize_t n = recv(fd, message, sizeof message - 1, 0);
    assert_true(n > 0);
    message[n] = 0;
    assert_non_null(strstr(message, text));
}

TEST(tells_the_service_manager)
{
    harness h;
    char socket_name[160], message[256];
#ifndef TFA_TEST_SYSTEMD
    print_message("skipped: built without libsystemd\n");
    skip();
#endif
    h = harness_make(ARM, "");
    int fd = listen_notify(&h);
    harness_start(&h, "arm");
    expect_message(fd, "READY=1");
    snprintf(socket_name, sizeof socket_name, "%s/arm.sock", h.runtime_dir);
    assert_int_equal(access(socket_name, F_OK), 0);
    /* signs of life, as long as the workers make progress; asleep they are woken to show it */
    for (int i = 0; i < 3; i++)
        expect_message(fd, "WATCHDOG=1");
    kill(h.pid, SIGTERM);
    do {
        ssize_t n = recv(fd, message, sizeof message - 1, 0);
        assert_true(n > 0);
        message[n] = 0;
    } while (!strstr(message, "STOPPING=1"));
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    close(fd);
    harness_remove(&h);
}

/* ---- rights ---- */

static uid_t user_of(pid_t pid)
{
    char path[64];
    struct stat info;
    snprintf(path, sizeof path, "/proc/%d", (int)pid);
    assert_int_equal(stat(path, &info), 0);
    return info.st_uid;
}

TEST(becomes_the_user)
{
    double qdd[7];
    const struct passwd *nobody = getpwnam("nobody");
    if (geteuid() != 0 || !nobody) {
        print_message("skipped: only root can become somebody else\n");
        skip();
    }
    const uid_t user = nobody->pw_uid;
    SCOPED_HARNESS h = harness_make(ARM, "user: nobody\n");
    assert_int_equal(chmod(h.directory, 0755), 0);
    harness_start(&h, "arm");
    assert_int_equal(user_of(h.pid), user);
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
    tfa_client_close(client);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    (void)rmdir(h.runtime_dir);
    assert_int_equal(access(h.runtime_dir, F_OK), -1); /* it could remove its files */
}

/* Had or not had: it is said, and the daemon serves. */
TEST(rights_are_reported)
{
    double qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "realtime: {priority: 1, affinity: [0], mlock: yes}\n");
    assert_true(harness_logged(&h, "FIFO priority 1") ||
                harness_logged(&h, "realtime.priority: worker 0 stays"));
    assert_true(harness_logged(&h, "memory is locked") ||
                harness_logged(&h, "realtime.mlock: not had"));
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
}

TEST(unknown_user_is_named)
{
    SCOPED_HARNESS h = harness_make(ARM, "group: nobody-has-this-name\n");
    harness_assert_refused(&h, "no group 'nobody-has-this-name'");
}

/* It opens; reading at address 0 fails. */
TEST(the_cause_of_an_unreadable_robot_is_named)
{
    SCOPED_HARNESS h = harness_make("  - name: arm\n    urdf: /proc/self/mem\n", "");
    harness_assert_refused(&h, "(/proc/self/mem): file cannot be read: Input/output error");
}

TEST(open_directory_is_refused)
{
    SCOPED_HARNESS h = harness_make(ARM, "");
    assert_int_equal(mkdir(h.runtime_dir, 0777), 0);
    assert_int_equal(chmod(h.runtime_dir, 0777), 0);
    harness_assert_refused(&h, "must belong to user");
}

/* ---- a very long robot: names do not fit a packet, M does not fit a slot ---- */

static void write_chain(const char *path)
{
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fprintf(out, "<robot name=\"chain\"><link name=\"base\"/>\n");
    for (int i = 1; i <= LINKS; i++) {
        fprintf(out,
                "<link name=\"a_link_with_a_rather_long_name_%d\"><inertial><mass value=\"1\"/>"
                "<origin xyz=\"0 0 0.05\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" "
                "iyz=\"0\" izz=\"0.01\"/></inertial></link>\n",
                i);
        fprintf(out, "<joint name=\"a_joint_with_a_rather_long_name_%d\" type=\"continuous\">", i);
        if (i == 1)
            fprintf(out, "<parent link=\"base\"/>");
        else
            fprintf(out, "<parent link=\"a_link_with_a_rather_long_name_%d\"/>", i - 1);
        fprintf(out,
                "<child link=\"a_link_with_a_rather_long_name_%d\"/><origin xyz=\"0 0 0.1\"/>"
                "<axis xyz=\"%d %d 0\"/></joint>\n",
                i, i % 2, 1 - i % 2);
    }
    fprintf(out, "</robot>\n");
    fclose(out);
}

static void ask_chain(tfa_client *client)
{
    static double q[2 * LINKS], qdd[2 * LINKS], tau[2 * LINKS], mass[1];
    for (int i = 0; i < 2 * LINKS; i++)
        q[i] = 0.01 * (i % 17);
    tfa_request r = {
        .op = TFA_OP_FORWARD_DYNAMICS, .refine = TFA_REFINE_DEFAULT, .count = 2, .q = q};
    tfa_reply reply = {.qdd = qdd, .tau = tau, .mass_matrix = mass};
    assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_OK);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.qdd = qdd;
    assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_OK);
    for (int i = 0; i < 2 * LINKS; i++) /* M qdd + h = tau, which was zero */
        assert_true(tau[i] < 1e-6 && tau[i] > -1e-6);
    r.op = TFA_OP_MASS_MATRIX;
    r.qdd = NULL;
    r.count = 1;
    assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_E_UNSUPPORTED);
    assert_int_equal(reply.field, TFA_FIELD_OP);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.count = 3;
    assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_E_SIZE);
    assert_int_equal(reply.field, TFA_FIELD_COUNT);
}

TEST(very_long_robot)
{
    char file[96], name[64];
    SCOPED_HARNESS h = harness_make("  - {name: chain, urdf: chain.urdf}\n", "");
    snprintf(file, sizeof file, "%s/chain.urdf", h.directory);
    write_chain(file);
    harness_start(&h, "chain");
    tfa_client_options options = harness_options(&h, "chain");
    options.max_batch = 2;
    SCOPED_CLIENT *client = harness_connect_with(&options);
    const tfa_client_info *info = tfa_client_get_info(client);
    assert_int_equal(info->joint_count, LINKS);
    assert_int_equal(info->frame_count, LINKS + 1);
    for (uint32_t i = 0; i < LINKS; i++) {
        snprintf(name, sizeof name, "a_joint_with_a_rather_long_name_%u", i + 1);
        assert_string_equal(info->joint_names[i], name);
        assert_int_equal(info->joint_types[i], TFA_JOINT_CONTINUOUS);
    }
    ask_chain(client);
}
