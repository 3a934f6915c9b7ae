/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics as text for Prometheus: every line has the form, every metric stands once with help
 * and type, histograms are cumulative, and the figures are those of the snapshot.
 */
#include <ctype.h>
#include <totalforce/statistics.h>

#include "harness.h"
#include "metrics/metrics_text.h"
#include "test.h"

enum { ASKED = 30, REFUSED = 3 };

static char *text_of(const tfa_snapshot *s)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    metrics_write(s, out);
    assert_int_equal(fclose(out), 0);
    assert_true(size > 0 && text[size - 1] == '\n');
    return text;
}

/* Value of the line that begins so, after its labels. */
static double value_of(const char *text, const char *beginning)
{
    const char *line = strstr(text, beginning);
    if (!line || (line != text && line[-1] != '\n'))
        fail_msg("no line '%s' in:\n%s", beginning, text);
    return strtod(line + strlen(beginning), NULL);
}

/* ---- the form ---- */

static const char *skip_name(const char *at)
{
    assert_true(isalpha((unsigned char)*at) || *at == '_');
    while (isalnum((unsigned char)*at) || *at == '_')
        at++;
    return at;
}

/* {label="value",...}, with \\, \" and \n as the only escapes */
static const char *skip_labels(const char *at)
{
    if (*at != '{')
        return at;
    do {
        at = skip_name(at + 1);
        assert_true(at[0] == '=' && at[1] == '"');
        for (at += 2; *at != '"'; at++) {
            assert_true(*at && *at != '\n');
            if (*at == '\\')
                assert_non_null(strchr("\\\"n", *++at));
        }
        at++;
    } while (*at == ',');
    assert_int_equal(*at, '}');
    return at + 1;
}

static void check_sample(const char *line, const char *family)
{
    const char *at = skip_name(line);
    char *end;
    assert_memory_equal(line, family, strlen(family)); /* or with _bucket, _sum, _count */
    at = skip_labels(at);
    assert_int_equal(*at, ' ');
    const double value = strtod(at + 1, &end);
    assert_true(end > at + 1 && *end == '\n');
    /* as the format spells them */
    if (isnan(value))
        assert_memory_equal(at, " NaN\n", 5);
    if (isinf(value))
        assert_memory_equal(at, value > 0 ? " +Inf\n" : " -Inf\n", 6);
}

static void check_form(const char *text)
{
    char family[100] = "", type[100] = "";
    for (const char *line = text; *line; line = strchr(line, '\n') + 1) {
        char word[100] = "";
        if (sscanf(line, "# HELP %99s", word) == 1) {
            char again[120];
            snprintf(again, sizeof again, "# HELP %s ", word);
            assert_null(strstr(line + 1, again)); /* one block for each metric */
            snprintf(family, sizeof family, "%s", word);
        } else if (sscanf(line, "# TYPE %99s %99s", word, type) == 2) {
            assert_string_equal(word, family);
            assert_non_null(strstr(" counter gauge histogram ", type));
            if (strcmp(type, "counter") == 0)
                assert_string_equal(word + strlen(word) - 6, "_total");
        } else {
            assert_true(family[0] && type[0]);
            check_sample(line, family);
        }
    }
}

/* Bounds grow, counts do not fall, the last is the count. */
static void check_histogram(const char *text, const char *name)
{
    char beginning[120];
    double bound = 0, below = 0, le, count;
    int buckets = 0;
    snprintf(beginning, sizeof beginning, "totalforce_%s_bucket{robot=\"arm\",le=\"", name);
    for (const char *line = strstr(text, beginning);
         line && strncmp(line, beginning, strlen(beginning)) == 0;
         line = strchr(line, '\n') + 1, buckets++) {
        assert_int_equal(sscanf(line + strlen(beginning), "%lf\"} %lf", &le, &count), 2);
        assert_true(le > bound && count >= below);
        bound = le;
        below = count;
    }
    assert_true(buckets > 20 && isinf(bound));
    snprintf(beginning, sizeof beginning, "totalforce_%s_count{robot=\"arm\"} ", name);
    assert_true(value_of(text, beginning) == below);
}

/* ---- tests ---- */

static uint64_t counts(const tfa_statistics *statistics, tfa_snapshot *s)
{
    int status; /* busy: a writer has no processor */
    (void)WAIT_FOR((status = tfa_statistics_read(statistics, s)) != TFA_E_BUSY);
    assert_int_equal(status, TFA_OK);
    return s->robots[0].total.requests;
}

static tfa_snapshot *read_after(const harness *h, uint64_t requests, tfa_statistics **statistics)
{
    tfa_snapshot *s;
    assert_int_equal(tfa_statistics_open(h->runtime_dir, WAIT_MS, statistics), TFA_OK);
    assert_int_equal(tfa_snapshot_create(*statistics, &s), TFA_OK);
    (void)WAIT_FOR(counts(*statistics, s) >= requests);
    assert_int_equal(s->robots[0].total.requests, requests);
    return s;
}

TEST(figures_of_a_daemon)
{
    double qdd[7];
    tfa_statistics *statistics;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    for (int i = 0; i < ASKED; i++)
        assert_int_equal(ask_arm(client, i, qdd, WAIT_NS), TFA_OK);
    for (int i = 0; i < REFUSED; i++)
        assert_int_equal(ask_arm(client, NAN, qdd, WAIT_NS), TFA_E_VALUE);
    tfa_snapshot *s = read_after(&h, ASKED + REFUSED, &statistics);
    SCOPED_TEXT *text = text_of(s);
    check_form(text);
    assert_true(value_of(text, "totalforce_requests_total{robot=\"arm\"} ") == ASKED + REFUSED);
    assert_true(value_of(text, "totalforce_answers_total{robot=\"arm\",method=\"aba\"} ") == ASKED);
    assert_true(value_of(text, "totalforce_failures_total{robot=\"arm\",status=\"E_VALUE\"} ") ==
                REFUSED);
    assert_true(value_of(text, "totalforce_clients{robot=\"arm\"} ") == 1);
    assert_true(value_of(text, "totalforce_queue_seconds_count{robot=\"arm\"} ") ==
                ASKED + REFUSED);
    const double busy = value_of(text, "totalforce_busy_seconds_total{robot=\"arm\"} ");
    assert_true(busy > 0 && busy <= 1e-9 * s->robots[0].total.compute.sum + 1e-8);
    assert_non_null(strstr(text, s->robots[0].served.model_hash));
    check_histogram(text, "queue_seconds");
    check_histogram(text, "compute_seconds");
    check_histogram(text, "latency_seconds");
    tfa_snapshot_free(s);
    tfa_statistics_close(statistics);
}

/* Names with quotes and line ends, inputs, and DDS: the form stays. */
TEST(awkward_labels)
{
    static tfa_robot_statistics robot;
    static uint64_t buckets[3][TFA_STATISTICS_BUCKETS];
    tfa_histogram *const times[] = {&robot.total.queue, &robot.total.compute, &robot.total.total};
    tfa_snapshot s = {.robots = &robot, .robot_count = 1, .dds_on = 1, .time = 5};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(
            tfa_histogram_init(times[i], TFA_STATISTICS_BITS, TFA_STATISTICS_RANGE, buckets[i]),
            TFA_OK);
        tfa_histogram_add(times[i], 127);
        tfa_histogram_add(times[i], 128);
        tfa_histogram_add(times[i], UINT64_MAX);
    }
    snprintf(robot.served.name, sizeof robot.served.name, "a\"b\\c\nd");
    robot.ros2.input_count = 2;
    snprintf(robot.ros2.inputs[0].name, sizeof robot.ros2.inputs[0].name, "/joint_states");
    robot.ros2.inputs[1].last = 3;
    robot.total.largest_estimate = INFINITY;
    SCOPED_TEXT *text = text_of(&s);
    check_form(text);
    assert_non_null(strstr(text, "{robot=\"a\\\"b\\\\c\\nd\""));
    assert_non_null(strstr(text, "le=\"1.27e-07\"} 1\n"));
    assert_non_null(strstr(text, "le=\"2.55e-07\"} 2\n"));
    assert_non_null(strstr(text, "le=\"+Inf\"} 3\n"));
    assert_non_null(strstr(text, "topic=\"/joint_states\"} NaN\n"));
    assert_non_null(strstr(text, "totalforce_dds_endpoints{kind=\"reply_readers\"} 0\n"));
}
