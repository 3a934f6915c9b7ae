/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Settings of Cyclone as the daemon makes and judges them: lease of its participant, security.
 */
#include "dds_test.h"
#include "harness.h"
#include "herald.h"
#include "test.h"

#include <stdlib.h>
#include <string.h>

static bool contains(const char *path, const char *what)
{
    FILE *in = fopen(path, "r");
    char *line = NULL;
    size_t size = 0;
    bool found = false;
    assert_non_null(in);
    while (!found && getline(&line, &size, in) > 0)
        found = strstr(line, what) != NULL;
    free(line);
    assert_int_equal(fclose(in), 0);
    return found;
}

/* Foreign writers that keep all wait for a killed daemon for ten leases, or as the user says: by
 * what Cyclone traces of its settings. */
TEST(a_killed_daemon_is_missed_soon)
{
    static const struct {
        int lease_ms;
        const char *user, *says;
    } rows[] = {{300, "", "LeaseDuration/#text: 3 s"},
                {20, "", "LeaseDuration/#text: 1 s"},
                {6000, "", "LeaseDuration/#text: 10 s"},
                {300, "<LeaseDuration>7 s</LeaseDuration>", "LeaseDuration/#text: 7 s"}};
    (void)test_domain(); /* CYCLONEDDS_URI: loopback only */
    SCOPED_TEXT *before = strdup(getenv("CYCLONEDDS_URI"));
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        harness h = harness_make(ARM, dds_yaml(test_domain(), rows[i].lease_ms));
        char uri[1024], trace[300];
        snprintf(trace, sizeof trace, "%s/trace", h.directory);
        snprintf(uri, sizeof uri,
                 "%s,<CycloneDDS><Domain Id=\"any\"><Discovery>%s</Discovery><Tracing><Category>"
                 "config</Category><OutputFile>%s</OutputFile></Tracing></Domain></CycloneDDS>",
                 before, rows[i].user, trace);
        assert_int_equal(setenv("CYCLONEDDS_URI", uri, 1), 0);
        harness_start(&h, "arm");
        if (!contains(trace, rows[i].says))
            fail_msg("row %zu: not %s", i, rows[i].says);
        harness_remove(&h);
    }
    assert_int_equal(setenv("CYCLONEDDS_URI", before, 1), 0);
}

TEST(a_profile_without_its_tag)
{
    SCOPED_TEXT *before = strdup(getenv("CYCLONEDDS_URI"));
    SCOPED_HARNESS h = harness_make(ARM, dds_yaml(test_domain(), 300));
    assert_int_equal(setenv("CYCLONEDDS_URI", "file://" TFA_SOURCE_DIR "/config/dds/fleet.xml", 1),
                     0);
    harness_assert_refused(&h, "export ROBOT_TAG=NAME");
    assert_int_equal(setenv("CYCLONEDDS_URI", before, 1), 0);
}

/* Where nothing configures DDS Security, a start and a check say so: in the text of the variable,
 * or in one of the files that it names. */
TEST(missing_security_is_said)
{
    static const char says[] = "no DDS Security in CYCLONEDDS_URI";
    static const char secured[] = "<CycloneDDS><Domain><Security/></Domain></CycloneDDS>";
    harness h = harness_make(ARM, dds_yaml(test_domain(), TEST_LEASE_MS));
    SCOPED_TEXT *before = strdup(getenv("CYCLONEDDS_URI"));
    char uri[1024], file[300];
    snprintf(file, sizeof file, "%s/secured.xml", h.directory);
    harness_write(&h, "secured.xml", secured);
    assert_int_equal(harness_check(&h), 0);
    assert_int_equal(harness_log_lines(&h, says), 1);
    snprintf(uri, sizeof uri, "%s,%s", before, secured);
    assert_int_equal(setenv("CYCLONEDDS_URI", uri, 1), 0);
    assert_int_equal(harness_check(&h), 0);
    assert_int_equal(harness_log_lines(&h, says), 1);
    snprintf(uri, sizeof uri, "%s,file://%s", before, file);
    assert_int_equal(setenv("CYCLONEDDS_URI", uri, 1), 0);
    assert_int_equal(harness_check(&h), 0);
    assert_int_equal(harness_log_lines(&h, says), 1);
    assert_int_equal(setenv("CYCLONEDDS_URI", before, 1), 0);
    harness_remove(&h);
}

int main(void)
{
    return test_run(NULL, NULL);
}
