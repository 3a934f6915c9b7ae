/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A DDS domain of this test's own on the loopback interface. Scripts get theirs from with_domain.
 */
#ifndef TESTS_SUPPORT_DOMAIN_H
#define TESTS_SUPPORT_DOMAIN_H

#include "support/wait.h"
#include "test.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

/* Domains 76 to 99 are for tests; nobody serves anything in 100. Their ports, from 7400 + 250 x
 * domain on, end before those that the kernel gives to sockets (from 32768 on): a test that had got
 * such a one kept another from its domain. */
#define TEST_FIRST_DOMAIN 76u
#define TEST_EMPTY_DOMAIN 100u

static inline bool test_domain_bind(int fd, uint32_t domain)
{
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    snprintf(name.sun_path + 1, sizeof name.sun_path - 1, "totalforce-test-%u", domain);
    return bind(fd, (struct sockaddr *)&name, sizeof name) == 0;
}

/* A free domain; 0: all are taken by other tests of this machine. */
static inline uint32_t test_domain_reserve(int fd)
{
    const uint32_t domains = TEST_EMPTY_DOMAIN - TEST_FIRST_DOMAIN;
    for (uint32_t i = 0; i < domains; i++) {
        const uint32_t domain = TEST_FIRST_DOMAIN + ((uint32_t)getpid() + i) % domains;
        if (test_domain_bind(fd, domain))
            return domain;
    }
    return 0;
}

/** The domain, the same in every call. A socket in the abstract name space reserves it while this
 * process lives, so that tests that run at the same time, of other builds too, do not meet. */
static inline uint32_t test_domain(void)
{
    static uint32_t domain;
    if (domain == 0) {
        setenv("CYCLONEDDS_URI", "file://" TFA_SOURCE_DIR "/config/dds/local.xml", 1);
        const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        assert_true(WAIT_FOR((domain = test_domain_reserve(fd)) != 0));
    }
    return domain;
}

#endif
