/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The example that streams torques, as the README shows it, runs and hears accelerations.
 */
#include "dds_test.h"
#include "gateway_process.h"

#include <math.h>
#include <totalforce/status.h>

TEST(the_example_streams)
{
    test_daemon daemon = test_daemon_start(test_domain(), NULL);
    char uri[512], line[128];
    unsigned long long seq, last = 0;
    int status, lines = 0;
    double qdd;

    /* The example takes the default domain; a configuration says which that is. */
    snprintf(uri, sizeof uri, "<CycloneDDS><Domain Id=\"%u\"/></CycloneDDS>,%s", test_domain(),
             getenv("CYCLONEDDS_URI"));
    setenv("CYCLONEDDS_URI", uri, 1);
    FILE *example = popen(TFA_BINARY_DIR "/bin/example_dds_stream arm 7 1000", "r");
    assert_non_null(example);
    while (fgets(line, sizeof line, example) != NULL) {
        assert_int_equal(sscanf(line, "seq %llu: status %d, qdd[0] = %lf", &seq, &status, &qdd), 3);
        if (status == TFA_E_AGAIN) /* the machine stood still for as many samples as slots */
            continue;
        assert_int_equal(status, TFA_OK);
        assert_true(isfinite(qdd));
        assert_true(lines == 0 || seq > last);
        last = seq;
        lines++;
    }
    assert_int_equal(pclose(example), 0);
    assert_true(lines > 10); /* the first ones are lost to discovery */
    test_daemon_stop(&daemon);
}

int main(int argc, char **argv)
{
    test_daemon_main(argc, argv);
    return test_run(NULL, NULL);
}
