/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The latency report on a run whose figures are known: percentiles only as far as the samples
 * allow, ratio, expectations, files. And the ping-pong and the thread counters on this machine.
 */
#include "latency/latency.h"

#include "latency/pingpong.h"
#include "test.h"

#include <errno.h>
#include <jansson.h>
#include <sched.h>
#include <unistd.h>

#define MINUTE_NS UINT64_C(60000000000)

static const latency_options plain = {
    .daemon = {.robot = "arm"}, .shm = 1, .count = 1000, .warmup = 10, .batch = 1, .cpu = -1};

/* 1000 round trips of 1, 2, .. 1000 us; half of each is the solve. Ping-pong 100 ns. */
static void make(latency_run **run, latency_baseline **baseline)
{
    *run = calloc(1, sizeof **run);
    *baseline = calloc(1, sizeof **baseline);
    assert_non_null(*run);
    assert_non_null(*baseline);
    latency_run_init(*run);
    latency_baseline_init(*baseline);
    (*run)->info = (tfa_client_info){.q_count = 6, .v_count = 6, .wait = TFA_WAIT_SPIN};
    (*run)->method = TFA_METHOD_ABA;
    (*run)->thread_count = 1;
    (*run)->threads[0] = (thread_usage){.name = "worker", .voluntary = 3};
    for (uint64_t i = 1; i <= 1000; i++) {
        tfa_histogram_add(&(*run)->parts[PART_ROUND_TRIP], 1000 * i);
        tfa_histogram_add(&(*run)->parts[PART_COMPUTE], 500 * i);
    }
    (*run)->highest_at = 123456789;
    (*baseline)->have_pingpong = 1;
    for (int i = 0; i < 100; i++)
        tfa_histogram_add(&(*baseline)->pingpong, 100);
}

static json_t *json_of(const latency_options *options, const latency_run *run,
                       const latency_baseline *baseline)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    assert_int_equal(latency_print_json(out, options, run, 1, baseline), 0);
    fclose(out);
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(root);
    free(text);
    return root;
}

TEST(test_json)
{
    latency_run *run;
    latency_baseline *baseline;
    make(&run, &baseline);
    json_t *root = json_of(&plain, run, baseline);
    json_t *first = json_array_get(json_object_get(root, "runs"), 0);
    json_t *trip = json_object_get(json_object_get(first, "ns"), "round_trip");
    json_t *percentiles = json_object_get(trip, "percentiles");
    assert_string_equal(json_string_value(json_object_get(first, "loop")), "closed");
    assert_true(json_real_value(json_object_get(first, "rate")) == 0);
    assert_string_equal(json_string_value(json_object_get(first, "via")), "shm");
    assert_int_equal(json_integer_value(json_object_get(trip, "count")), 1000);
    assert_int_equal(json_integer_value(json_object_get(trip, "min")), 1000);
    assert_int_equal(json_integer_value(json_object_get(trip, "max")), 1000000);
    assert_int_equal(json_integer_value(json_object_get(first, "max_index")), 999);
    assert_int_equal(json_integer_value(json_object_get(first, "max_at_ns")), 123456789);
    json_int_t p50 = json_integer_value(json_object_get(percentiles, "50"));
    assert_true(p50 >= 500000 && p50 <= 504000);
    assert_non_null(json_object_get(percentiles, "99"));
    /* a single sample lies beyond p99.9: not told */
    assert_null(json_object_get(percentiles, "99.9"));
    assert_int_equal(json_array_size(json_object_get(first, "threads")), 2);
    assert_non_null(json_object_get(json_object_get(root, "environment"), "kernel"));
    json_decref(root);
    free(run);
    free(baseline);
}

TEST(test_ratio_and_expectations)
{
    latency_run *run;
    latency_baseline *baseline;
    latency_options options = plain;
    make(&run, &baseline);
    /* 500 us / (0.1 us + 250 us) */
    double ratio = latency_ratio(run, baseline);
    assert_true(ratio > 1.98 && ratio < 2.02);
    assert_true(latency_expected(&options, run, baseline));
    options.fail_p99_us = 1000;
    assert_true(latency_expected(&options, run, baseline));
    options.fail_p99_us = 900;
    assert_false(latency_expected(&options, run, baseline));
    options.fail_p99_us = 0;
    options.fail_ratio = 2.5;
    assert_true(latency_expected(&options, run, baseline));
    run->misses = 1;
    assert_false(latency_expected(&options, run, baseline));
    run->misses = 0;
    options.fail_ratio = 1.5;
    assert_false(latency_expected(&options, run, baseline));
    /* a solve measured in process takes the place of the daemon's stamps */
    options.fail_ratio = 1.1;
    tfa_histogram_add(&baseline->solve, 500000);
    assert_true(latency_expected(&options, run, baseline));
    baseline->have_pingpong = 0;
    assert_true(latency_ratio(run, baseline) == 0.0);
    /* no baseline, no proof */
    assert_false(latency_expected(&options, run, baseline));
    free(run);
    free(baseline);
}

TEST(test_text)
{
    latency_run *run;
    latency_baseline *baseline;
    char *text = NULL;
    size_t size = 0;
    make(&run, &baseline);
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    latency_print_text(out, &plain, run, 1, baseline);
    fclose(out);
    static const char *const wanted[] = {
        "closed loop: 1000 round trips after 10 of warm-up",
        "the slowest was number 999, 0.123457 s after the start",
        "forward dynamics by aba",
        "wait spin",
        "ping-pong",
        "kernel",
        "misses 0, late 0",
        "worker",
        "by the daemon's stamps",
    };
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++)
        if (!strstr(text, wanted[i]))
            fail_msg("'%s' is not in:\n%s", wanted[i], text);
    assert_null(strstr(text, "p99.9 "));
    free(text);
    free(run);
    free(baseline);
}

TEST(test_files)
{
    latency_run *run;
    latency_baseline *baseline;
    char csv[] = "/tmp/tfa-latency-csv-XXXXXX", hgrm[] = "/tmp/tfa-latency-hgrm-XXXXXX", line[256];
    latency_sample sample = {.index = 4, .at = 5, .parts = {10, 1, 2, 3, 4}};
    make(&run, &baseline);
    close(mkstemp(csv));
    close(mkstemp(hgrm));
    latency_options options = plain;
    options.csv = csv;
    options.histogram = hgrm;
    run->samples = &sample;
    run->sample_count = 1;
    assert_int_equal(latency_write_csv(&options, run, 1), 0);
    assert_int_equal(latency_write_histogram(&options, run, 1), 0);
    FILE *file = fopen(csv, "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line,
                        "via,index,at_ns,round_trip_ns,request_ns,queue_ns,compute_ns,reply_ns\n");
    assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line, "shm,4,5,10,1,2,3,4\n");
    fclose(file);
    unlink(csv);
    unlink(hgrm);
    options.csv = "/nonexistent/file";
    assert_int_equal(latency_write_csv(&options, run, 1), -1);
    assert_int_equal(errno, ENOENT);
    free(run);
    free(baseline);
}

TEST(test_pingpong)
{
    enum { COUNT = 200 };
    latency_baseline *baseline = calloc(1, sizeof *baseline);
    assert_non_null(baseline);
    latency_baseline_init(baseline);
    tfa_histogram *h = &baseline->pingpong;
    assert_int_equal(pingpong_run((pingpong_size){1, 1}, COUNT, 10, MINUTE_NS, NULL, h), TFA_OK);
    assert_int_equal(pingpong_run((pingpong_size){5, 3}, COUNT, 10, MINUTE_NS, NULL, h), TFA_OK);
    assert_int_equal(h->count, 2 * COUNT);
    assert_true(h->lowest > 0);
    free(h);
}

/* Both sides on one processor: a round trip takes two turns of the scheduler. The run ends by its
 * limit with what it saw. */
TEST(test_pingpong_is_bounded)
{
    enum { COUNT = 1000000 };
    static const uint64_t limit = 200000000;
    latency_baseline *baseline = calloc(1, sizeof *baseline);
    cpu_set_t one, before;
    assert_non_null(baseline);
    latency_baseline_init(baseline);
    tfa_histogram *h = &baseline->pingpong;
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    CPU_ZERO(&one);
    for (size_t cpu = 0; CPU_COUNT(&one) == 0; cpu++)
        if (CPU_ISSET(cpu, &before))
            CPU_SET(cpu, &one);
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    const int status = pingpong_run((pingpong_size){1, 1}, COUNT, 0, limit, NULL, h);
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
    assert_int_equal(status, TFA_E_TIMEOUT);
    assert_true(h->count < COUNT);
    free(h);
}

TEST(test_threads)
{
    static thread_usage threads[THREADS_MAX];
    assert_int_equal(environment_threads(getpid(), threads), 1);
    assert_int_equal(threads[0].tid, getpid());
    assert_true(strlen(threads[0].name) > 0);
    thread_usage before = environment_this_thread();
    usleep(1000); /* sleeping is a voluntary switch */
    thread_usage after = environment_this_thread();
    assert_true(environment_difference(&before, &after).voluntary >= 1);
    assert_int_equal(environment_threads(0, threads), 0);
}

TEST(test_hgrm)
{
    uint64_t buckets[LATENCY_BUCKETS];
    tfa_histogram h;
    char *text = NULL;
    size_t size = 0;
    assert_int_equal(tfa_histogram_init(&h, LATENCY_BITS, 64, buckets), TFA_OK);
    for (uint64_t v = 1; v <= 4; v++)
        tfa_histogram_add(&h, 1000 * v);
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    hgrm_write(&h, out, 1000.0);
    fclose(out);
    assert_non_null(strstr(text, "Value     Percentile TotalCount 1/(1-Percentile)"));
    assert_non_null(strstr(text, "0.250000000000          1           1.33"));
    assert_non_null(strstr(text, "4.000 1.000000000000          4\n"));
    assert_non_null(strstr(text, "#[Max     =        4.000, Total count    =            4]"));
    free(text);
}
