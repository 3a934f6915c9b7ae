/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The example that streams torques, as the README shows it, runs and hears accelerations.
 */
#include "dds_test.h"
#include "gateway_process.h"

#include <math.h>
#include <totalforce/status.h>

/* Runs it. @return right answers to its samples, the first of which are lost to discovery */
static int stream(int samples)
{
    char command[256], line[128];
    unsigned long long seq, last = 0;
    int status, answers = 0;
    double qdd;
    snprintf(command, sizeof command, "%s/bin/example_dds_stream arm 7 %d", TFA_BINARY_DIR,
             samples);
    FILE *example = popen(command, "r");
    assert_non_null(example);
    while (fgets(line, sizeof line, example) != NULL) {
        assert_int_equal(sscanf(line, "seq %llu: status %d, qdd[0] = %lf", &seq, &status, &qdd), 3);
        if (status == TFA_E_AGAIN) /* the machine stood still for as many samples as slots */
            continue;
        assert_int_equal(status, TFA_OK);
        assert_true(isfinite(qdd));
        assert_true(answers == 0 || seq > last);
        last = seq;
        answers++;
    }
    assert_int_equal(pclose(example), 0);
    return answers;
}

/* A sample takes a millisecond: on a busy machine discovery may outlast a few of them. */
TEST(the_example_streams)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    int samples = 1000;
    char uri[512];
    /* The example takes the default domain; a configuration says which that is. */
    snprintf(uri, sizeof uri, "<CycloneDDS><Domain Id=\"%u\"/></CycloneDDS>,%s", test_domain(),
             getenv("CYCLONEDDS_URI"));
    setenv("CYCLONEDDS_URI", uri, 1);
    while (stream(samples) <= 10) {
        samples *= 2;
        assert_true(samples < WAIT_MS);
    }
}

int main(int argc, char **argv)
{
    test_daemon_main(argc, argv);
    return test_run(NULL, NULL);
}
