/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The latency report on a run whose figures are known: percentiles only as far as the samples
 * allow, ratio, expectations, files. And the ping-pong and the thread counters on this machine.
 */
#include "latency/report/hgrm.h"
#include "latency/report/report.h"
#include "support/wait.h"
#include "test.h"

#include <errno.h>
#include <jansson.h>
#include <sched.h>
#include <unistd.h>

#define MINUTE_NS UINT64_C(60000000000)

static const latency_options plain = {.daemon = {.robot = "arm"},
                                      .vias = 1u << VIA_SHM,
                                      .count = 1000,
                                      .warmup = 10,
                                      .batch = 1,
                                      .clients = 1,
                                      .cpu = -1};

/* A session of one run: 1000 round trips of 1, 2, .. 1000 us; half of each is the solve. Ping-pong
 * 100 ns. */
static void make(latency_session *session, const latency_options *options)
{
    latency_run *run = calloc(1, sizeof *run);
    latency_baseline *baseline = malloc(sizeof *baseline);
    assert_non_null(run);
    assert_non_null(baseline);
    latency_baseline_init(baseline);
    run->options = *options;
    run->facts.info = (tfa_client_info){.q_count = 6, .v_count = 6, .wait = TFA_WAIT_SPIN};
    run->thread_count = 1;
    run->threads[0] = (thread_usage){.name = "worker", .voluntary = 3};
    run->client_count = 1;
    run->clients = calloc(1, sizeof *run->clients);
    tally *t = tally_create(1000);
    for (uint64_t i = 1; i <= 1000; i++) {
        const latency_sample sample = {.index = i - 1,
                                       .at = i == 1000 ? 123456789 : i,
                                       .parts = {1000 * i, 0, 500 * i, 0, 500 * i, 0}};
        tally_add(t, &sample, (unsigned)(i - 1) / 100);
    }
    t->method = TFA_METHOD_ABA;
    run->clients[0].figures = t;
    run->total = tally_create(0);
    tally_merge(run->total, t);
    baseline->have_pingpong = 1;
    for (int i = 0; i < 100; i++)
        tfa_histogram_add(&baseline->pingpong.h, 100);
    *session = (latency_session){.command = "totalforce latency arm",
                                 .date = "2026-01-01T00:00:00Z",
                                 .environment = environment_read(),
                                 .baseline = baseline,
                                 .runs = run,
                                 .count = 1};
}

static void unmake(latency_session *session)
{
    latency_runs_free(session->runs, session->count);
    free(session->baseline);
    json_decref(session->environment);
}

static json_t *json_of(const latency_session *session)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    assert_int_equal(latency_print_json(out, session), 0);
    fclose(out);
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(root);
    free(text);
    return root;
}

static json_int_t integer(const json_t *json, const char *key)
{
    const json_t *value = json_object_get(json, key);
    assert_true(json_is_integer(value));
    return json_integer_value(value);
}

TEST(test_json)
{
    latency_session session;
    make(&session, &plain);
    json_t *root = json_of(&session);
    json_t *first = json_array_get(json_object_get(root, "runs"), 0);
    json_t *trip = json_object_get(json_object_get(first, "ns"), "round_trip");
    json_t *percentiles = json_object_get(trip, "percentiles");
    assert_string_equal(json_string_value(json_object_get(first, "loop")), "closed");
    assert_true(json_real_value(json_object_get(first, "rate")) == 0);
    assert_string_equal(json_string_value(json_object_get(first, "via")), "shm");
    assert_int_equal(integer(trip, "count"), 1000);
    assert_int_equal(integer(trip, "min"), 1000);
    assert_int_equal(integer(trip, "max"), 1000000);
    assert_int_equal(integer(first, "max_index"), 999);
    assert_int_equal(integer(first, "max_at_ns"), 123456789);
    assert_int_equal(integer(first, "min_at_ns"), 1);
    json_int_t p50 = integer(percentiles, "50");
    assert_true(p50 >= 500000 && p50 <= 504000);
    assert_non_null(json_object_get(percentiles, "99"));
    /* a single sample lies beyond p99.9: not told */
    assert_null(json_object_get(percentiles, "99.9"));
    assert_int_equal(json_array_size(json_object_get(first, "threads")), 2);
    assert_int_equal(json_array_size(json_object_get(first, "per_client")), 1);
    json_t *breakdown = json_object_get(json_object_get(first, "breakdown_ns"), "max");
    assert_true(json_real_value(json_object_get(breakdown, "compute")) == 500000);
    assert_non_null(json_object_get(json_object_get(root, "environment"), "kernel"));
    json_decref(root);
    unmake(&session);
}

TEST(test_ratio_and_expectations)
{
    latency_session session;
    make(&session, &plain);
    latency_run *run = session.runs;
    latency_baseline *baseline = session.baseline;
    /* 500 us / (0.1 us + 250 us) */
    double ratio = latency_ratio(run, baseline);
    assert_true(ratio > 1.98 && ratio < 2.02);
    assert_true(latency_expected(run, baseline));
    run->options.fail_p99_us = 1000;
    assert_true(latency_expected(run, baseline));
    run->options.fail_p99_us = 900;
    assert_false(latency_expected(run, baseline));
    run->options.fail_p99_us = 0;
    run->options.fail_ratio = 2.5;
    assert_true(latency_expected(run, baseline));
    run->total->lost = 1;
    assert_false(latency_expected(run, baseline));
    run->total->lost = 0;
    run->options.fail_ratio = 1.5;
    assert_false(latency_expected(run, baseline));
    /* a solve measured in process takes the place of the daemon's stamps */
    run->options.fail_ratio = 1.1;
    tfa_histogram_add(&baseline->solve.h, 500000);
    assert_true(latency_expected(run, baseline));
    baseline->have_pingpong = 0;
    assert_true(latency_ratio(run, baseline) == 0.0);
    /* no baseline, no proof */
    assert_false(latency_expected(run, baseline));
    unmake(&session);
}

/* What a function prints; free it. */
static char *text_of(void (*print)(FILE *out, const latency_session *session),
                     const latency_session *session)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    print(out, session);
    fclose(out);
    return text;
}

static void says(const char *text, const char *wanted)
{
    if (!strstr(text, wanted))
        fail_msg("'%s' is not in:\n%s", wanted, text);
}

TEST(test_text)
{
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
        "slowest        1000.000      0.000    500.000      0.000    500.000      0.000         1",
    };
    latency_session session;
    make(&session, &plain);
    char *text = text_of(latency_print_text, &session);
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++)
        says(text, wanted[i]);
    assert_null(strstr(text, "p99.9 "));
    free(text);
    session.runs[0].options.open = 1;
    session.runs[0].options.rate = 500;
    session.baseline->have_pingpong = 0; /* too few round trips for a baseline */
    text = text_of(latency_print_text, &session);
    says(text, "open loop, 500 a second, from the intended times: 1000 round trips");
    says(text, "\n  ping-pong  ");
    free(text);
    session.runs[0].clients[0].usage = (thread_usage){.tid = 4321, .priority = 80};
    text = text_of(latency_print_cyclictest, &session);
    says(text, "# shm, open loop");
    says(text,
         "T: 0 ( 4321) P:80 I:2000 C:   1000 Min:   1000 Act:1000000 Avg:500500 Max: 1000000");
    free(text);
    session.runs[0].swept = "500";
    session.runs[0].options.sweep = strdup("rate");
    text = text_of(latency_print_text, &session);
    says(text, "sweep of rate, open loop");
    says(text, "shm 500");
    free(text);
    free(session.runs[0].options.sweep);
    unmake(&session);
}

TEST(test_busy)
{
    machine_busy busy = {.gap_share = 0.0004, .steal = 0, .load = 1.5, .processors = 2};
    machine_judge(&busy);
    assert_false(busy.busy);
    busy.load = 3.25;
    busy.gap_share = 0.12;
    machine_judge(&busy);
    assert_true(busy.busy);
    says(busy.text, "gaps took 12.0 % of a spinning thread's time");
    says(busy.text, ", load 3.2 on 2 processors");
    busy = (machine_busy){.gap_share = -1, .steal = 0.5, .load = -1, .processors = 1};
    machine_judge(&busy);
    says(busy.text, "the host stole 50.0 %");
}

static void expect_lines(const char *path, const char *const *lines, int count)
{
    char line[512];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    for (int i = 0; i < count; i++) {
        assert_non_null(fgets(line, sizeof line, file));
        assert_string_equal(line, lines[i]);
    }
    fclose(file);
}

TEST(test_files)
{
    static const char *const csv_lines[] = {
        "via,loop,client,index,at_ns,round_trip_ns,client_ns,request_ns,queue_ns,compute_ns,"
        "reply_ns\n",
        "shm,closed,0,0,1,1000,0,500,0,500,0\n"};
    static const char *const table_lines[] = {
        "via,loop,swept,robot,rate,batch,clients,wait,sent,answered,lost,rejected,late,"
        "longest_run,full,min_ns,p50_ns,p90_ns,p99_ns,p99.9_ns,p99.99_ns,p99.999_ns,p99.9999_ns,"
        "max_ns,mean_ns,daemon_cpu,tool_cpu,busy\n",
        "shm,closed,,arm,0,1,1,spin,0,1000,0,0,0,0,0,1000,501759,901119,991231,,,,,1000000,"
        "500500.0,0.000,0.000,0\n"};
    latency_session session;
    char csv[] = "/tmp/tfa-latency-csv-XXXXXX", hgrm[] = "/tmp/tfa-latency-hgrm-XXXXXX";
    make(&session, &plain);
    close(mkstemp(csv));
    close(mkstemp(hgrm));
    assert_int_equal(latency_write_csv(csv, &session), 0);
    expect_lines(csv, csv_lines, 2);
    assert_int_equal(latency_write_table(csv, &session), 0);
    expect_lines(csv, table_lines, 2);
    assert_int_equal(latency_write_histogram(hgrm, &session), 0);
    unlink(csv);
    unlink(hgrm);
    assert_int_equal(latency_write_csv("/nonexistent/file", &session), -1);
    assert_int_equal(errno, ENOENT);
    unmake(&session);
}

TEST(test_pingpong)
{
    enum { COUNT = 50 }; /* spinning sides wait for turns of the scheduler where others run */
    latency_baseline *baseline = malloc(sizeof *baseline);
    assert_non_null(baseline);
    latency_baseline_init(baseline);
    tfa_histogram *h = &baseline->pingpong.h;
    assert_int_equal(pingpong_run((pingpong_size){1, 1}, COUNT, 5, MINUTE_NS, NULL, h), TFA_OK);
    assert_int_equal(pingpong_run((pingpong_size){5, 3}, COUNT, 5, MINUTE_NS, NULL, h), TFA_OK);
    assert_int_equal(h->count, 2 * COUNT);
    assert_true(h->lowest > 0);
    free(baseline);
}

/* One processor for this side, with a real-time priority, the others for the other side */
TEST(test_pingpong_at_real_time_priority)
{
    latency_baseline *baseline = malloc(sizeof *baseline);
    cpu_set_t before, others, one;
    assert_non_null(baseline);
    latency_baseline_init(baseline);
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    CPU_ZERO(&one);
    CPU_SET((size_t)sched_getcpu(), &one);
    CPU_XOR(&others, &before, &one);
    if (CPU_COUNT(&others) == 0 || machine_set_priority(50) != 0) {
        free(baseline);
        skip();
    }
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    const int status = pingpong_run((pingpong_size){1, 1}, 1000, 0, MINUTE_NS / 20, &others,
                                    &baseline->pingpong.h);
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
    assert_int_equal(machine_set_priority(0), 0);
    assert_int_equal(status, TFA_OK);
    free(baseline);
}

/* Both sides on one processor: a round trip takes two turns of the scheduler. The run ends by its
 * limit with what it saw. */
TEST(test_pingpong_is_bounded)
{
    enum { COUNT = 1000000 };
    static const uint64_t limit = 200000000;
    latency_baseline *baseline = malloc(sizeof *baseline);
    cpu_set_t one, before;
    assert_non_null(baseline);
    latency_baseline_init(baseline);
    tfa_histogram *h = &baseline->pingpong.h;
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
    free(baseline);
}

TEST(test_threads)
{
    static thread_usage threads[THREADS_MAX];
    assert_int_equal(environment_threads(getpid(), threads), 1);
    assert_int_equal(threads[0].tid, getpid());
    assert_true(strlen(threads[0].name) > 0);
    const thread_usage before = environment_this_thread();
    thread_usage after;
    /* sleeping is a voluntary switch */
    assert_true(WAIT_FOR((after = environment_this_thread(),
                          environment_difference(&before, &after).voluntary >= 1)));
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
