/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rates and shares of users: no user, and no two, take what belongs to others, whatever their
 * numbers; and of publishers of robot descriptions.
 */
#include "control/daemon.h"
#include "raw_client.h"
#include "test.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define SECOND UINT64_C(1000000000)

/* A flood of user 64 costs nobody else a connection: root and others of the same remainder by any
 * power of two, and users beyond as many as the table has. */
TEST(rates_are_by_user)
{
    static const uid_t others[] = {0, 1, 64 + 128, 64 + 4096, 1000};
    tfa_connect_rate rate = {0};
    uint64_t now = SECOND;
    uint32_t allowed = 0;
    for (int i = 0; i < 1000; i++, now += SECOND / 1000)
        allowed += tfa_connect_rate_allows(&rate, 64, 10, now);
    assert_in_range(allowed, 20, 31); /* twice ten at once, then ten a second */
    while (tfa_connect_rate_allows(&rate, 64, 10, now))
        ;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        for (int k = 0; k < 20; k++)
            assert_true(tfa_connect_rate_allows(&rate, others[i], 10, now));
    assert_false(tfa_connect_rate_allows(&rate, 64, 10, now));
}

/* More users than rows: what is forgotten of them is not the flood of one. */
TEST(a_flood_is_not_forgotten)
{
    tfa_connect_rate rate = {0};
    for (int i = 0; i < 20; i++)
        assert_true(tfa_connect_rate_allows(&rate, 7, 10, SECOND));
    for (uid_t user = 1000; user < 1000 + 4 * TFA_CONNECT_USERS; user++)
        assert_true(tfa_connect_rate_allows(&rate, user, 10, SECOND + user));
    assert_false(tfa_connect_rate_allows(&rate, 7, 10, SECOND + 2000));
}

/* Users take turns, each as much as it may: the later one finds something, and an operator all that
 * is left, at least a sixteenth. */
TEST(shares_leave_something)
{
    static const uint64_t totals[] = {16, 64, 1000, UINT64_C(1) << 40};
    for (size_t i = 0; i < sizeof totals / sizeof *totals; i++) {
        uint64_t taken = 0;
        for (uid_t user = 1000; user < 1004; user++) {
            const uint64_t share = tfa_share_of(totals[i], taken, user);
            assert_true(share > 0 && taken + share <= totals[i] - totals[i] / 16);
            taken += share;
        }
        assert_true(tfa_share_of(totals[i], taken, 0) == totals[i] - taken);
        assert_true(tfa_share_of(totals[i], taken, 0) >= totals[i] / 16);
    }
    assert_int_equal(tfa_share_of(1, 0, 1000), 1);
    assert_int_equal(tfa_share_of(1, 1, 1000), 0);
    assert_int_equal(tfa_share_of(8, 9, 1000), 0); /* after a reload with less */
}

/* Becomes that user, connects so often as it is let, and stays until `done` ends. The number goes
 * to `count`. */
static _Noreturn void take_seats(const harness *h, uid_t user, int count, int done)
{
    const tfa_hello hello = good_hello(TFA_WAIT_BLOCK);
    unsigned char seats = 0;
    tfa_welcome w;
    int status = TFA_OK;
    if (!become_user(user))
        _exit(1);
    while (status == TFA_OK && seats < 100) {
        const int fd = connect_raw(h);
        (void)!send(fd, &hello, sizeof hello, MSG_NOSIGNAL);
        status = receive_status(fd, &w);
        if (status == TFA_OK)
            seats++;
    }
    _exit(status != TFA_E_REFUSED || write(count, &seats, 1) != 1 || read(done, &seats, 1) != 0);
}

/* Two users take all that they get, in the real daemon, of which the scene's client is root's: a
 * third one and root are served. */
TEST(two_users_do_not_take_all)
{
    static const unsigned char expected[] = {15, 7, 4}; /* halves of 29, 14, 7 */
    int count[2], done[2];
    pid_t children[3];
    if (geteuid() != 0)
        skip();
    SCOPED_SCENE s = open_scene("group: nogroup\nlimits: {clients: 32, clients_per_user: 32}\n");
    assert_int_equal(chmod(s.h.directory, 0711), 0);
    assert_true(pipe2(count, O_CLOEXEC) == 0 && pipe2(done, O_CLOEXEC) == 0);
    for (size_t i = 0; i < 3; i++) {
        unsigned char seats = 0;
        children[i] = fork();
        if (children[i] == 0) {
            close(done[1]);
            take_seats(&s.h, 60000 + (uid_t)i, count[1], done[0]);
        }
        assert_int_equal(read(count[0], &seats, 1), 1);
        assert_int_equal(seats, expected[i]);
    }
    SCOPED_CLIENT *client = harness_connect(&s.h, "arm", TFA_WAIT_BLOCK);
    assert_unharmed(&s);
    close(done[1]);
    for (size_t i = 0; i < 3; i++)
        assert_int_equal(child_end(children[i]), 0);
    close(done[0]);
    close(count[0]);
    close(count[1]);
}

/* After a description that hung up on clients the robot's next one waits, the newest; other robots'
 * do not. */
TEST(a_publisher_does_not_hang_up_at_will)
{
    static config settings = {.robots_count = 2};
    static tfa_daemon d = {.settings = &settings};
    d.descriptions = (robot_descriptions){.event = -1, .mutex = PTHREAD_MUTEX_INITIALIZER};
    size_t robot = 0;
    assert_int_equal(descriptions_open(&d), TFA_OK);
    descriptions_receive(&d, 0, "first");
    char *text = descriptions_take(&d, &robot);
    assert_string_equal(text, "first");
    free(text);
    descriptions_rest(&d, 0);
    assert_true(d.descriptions.not_before[0] > 0);
    d.descriptions.not_before[0] = UINT64_MAX; /* however slow this machine is */
    descriptions_receive(&d, 0, "second");
    descriptions_receive(&d, 0, "third");
    descriptions_receive(&d, 1, "other");
    text = descriptions_take(&d, &robot);
    assert_string_equal(text, "other");
    free(text);
    assert_null(descriptions_take(&d, &robot));
    d.descriptions.not_before[0] = 0;
    text = descriptions_take(&d, &robot);
    assert_string_equal(text, "third");
    assert_int_equal(robot, 0);
    free(text);
    descriptions_close(&d);
}

int main(void)
{
    return test_run(NULL, NULL);
}
