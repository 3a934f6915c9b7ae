/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Page and table of latencies of two scripted responders, in virtual time: the same numbers always.
 *
 *   draw_latency COMMAND TABLE.csv PAGE.html      COMMAND: command line that the page shows
 */
#include "latency/page/page.h"
#include "latency_figures.h"

enum { COUNT = 3000, SLOTS = 16, RUNS = 2, PINGPONG_NS = 400 };

/* Delays of the responder: every tenth is equal to the one before it, and one is far slower */
static script_line *make_delays(uint64_t factor)
{
    script_line *lines = script_delays(COUNT);
    for (uint64_t i = 0; i < COUNT; i++)
        lines[i].delay = i % 10 == 9 ? lines[i - 1].delay : factor * lines[i].delay;
    lines[COUNT / 2].delay = 40 * MS;
    return lines;
}

static void measure(latency_run *run, uint64_t factor)
{
    script s;
    script_line *lines = make_delays(factor);
    const load_shape shape = {.count = COUNT, .timeout_ns = 60 * SECOND};
    run->options = (latency_options){.daemon = {.robot = "arm"},
                                     .vias = 1u << run->via,
                                     .count = COUNT,
                                     .batch = 1,
                                     .clients = 1,
                                     .cpu = -1};
    run->facts.info = (tfa_client_info){.q_count = 7, .v_count = 7, .wait = TFA_WAIT_SPIN};
    run->daemon_cpu = run->tool_cpu = 0.5;
    run->client_count = 1;
    run->clients = calloc(1, sizeof *run->clients);
    run->total = tally_create(0);
    script_init(&s, lines, COUNT, SLOTS);
    run->clients[0].figures = script_measure(&s, &shape);
    tally_merge(run->total, run->clients[0].figures);
    script_free(&s);
    free(lines);
}

int main(int argc, char **argv)
{
    latency_baseline *baseline = malloc(sizeof *baseline);
    latency_run *runs = calloc(RUNS, sizeof *runs);
    if (argc != 4 || !baseline || !runs)
        return 3;
    latency_baseline_init(baseline);
    baseline->have_pingpong = 1;
    for (uint64_t i = 0; i < 1000; i++)
        tfa_histogram_add(&baseline->pingpong.h, PINGPONG_NS + i % 7);
    runs[0].via = VIA_SHM;
    runs[1].via = VIA_SOCKET;
    for (uint64_t i = 0; i < RUNS; i++)
        measure(&runs[i], 1 + 9 * i);
    const latency_session session = {.command = argv[1],
                                     .date = "2026-01-01T00:00:00Z",
                                     .environment = json_pack("{ss}", "processor", "none"),
                                     .baseline = baseline,
                                     .runs = runs,
                                     .count = RUNS};
    const int bad = latency_write_table(argv[2], &session) | latency_write_page(argv[3], &session);
    latency_runs_free(runs, RUNS);
    free(baseline);
    json_decref(session.environment);
    return bad ? 2 : 0;
}
