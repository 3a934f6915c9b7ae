/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the DDS tests share: a domain of their own on the loopback interface, and a clock.
 */
#ifndef TFA_TESTS_DDS_TEST_H
#define TFA_TESTS_DDS_TEST_H

#include "test.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

/* Domains 201 to 224 are for these tests; nobody serves anything in 225; 230 is the last of all. */
#define TEST_FIRST_DOMAIN 201u
#define TEST_EMPTY_DOMAIN 225u

/* A domain id of this process's own, on the loopback interface. A socket in the abstract name space
 * reserves it while we live, so that tests that run at the same time do not meet. */
static inline uint32_t test_domain(void)
{
    static uint32_t domain;

    if (domain != 0)
        return domain;
    setenv("CYCLONEDDS_URI", "file://" TFA_SOURCE_DIR "/config/dds/local.xml", 1);
    const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const uint32_t domains = TEST_EMPTY_DOMAIN - TEST_FIRST_DOMAIN;
    for (uint32_t i = 0; i < domains && domain == 0; i++) {
        struct sockaddr_un name = {.sun_family = AF_UNIX};
        const uint32_t candidate = TEST_FIRST_DOMAIN + ((uint32_t)getpid() + i) % domains;
        snprintf(name.sun_path + 1, sizeof name.sun_path - 1, "totalforce-test-%u", candidate);
        if (bind(fd, (struct sockaddr *)&name, sizeof name) == 0)
            domain = candidate;
    }
    assert_int_not_equal(domain, 0);
    return domain;
}

/* Pseudo-random numbers in [-1, 1), the same in every run. */
static inline double test_random(uint64_t *seed)
{
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(int64_t)*seed * 0x1p-63;
}

/* CLOCK_MONOTONIC, ns */
static inline uint64_t now_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

#endif
