/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Files of measurements: every round trip, a line a run, percentile distributions.
 */
#include "report.h"

#include "hgrm.h"

#include <inttypes.h>
#include <stdio.h>

/* Closes a file and says whether all of it was written. */
static int finish(FILE *file)
{
    int bad = ferror(file);
    return fclose(file) != 0 || bad ? -1 : 0;
}

static void write_samples(FILE *file, const latency_run *run, uint32_t client)
{
    const tally *t = run->clients[client].figures;
    for (uint64_t j = 0; j < t->sample_count; j++) {
        const latency_sample *sample = &t->samples[j];
        fprintf(file, "%s,%s,%" PRIu32 ",%" PRIu64 ",%" PRIu64, latency_via_names[run->via],
                latency_loop_name(&run->options), client, sample->index, sample->at);
        for (int k = 0; k < PART_COUNT; k++)
            fprintf(file, ",%" PRIu64, sample->parts[k]);
        fputc('\n', file);
    }
    if (t->sample_count < t->parts[PART_ROUND_TRIP].h.count)
        fprintf(stderr,
                "totalforce latency: client %" PRIu32 ": the first %" PRIu64
                " round trips are written; --count sets how many\n",
                client, t->sample_count);
}

int latency_write_csv(const char *path, const latency_session *session)
{
    FILE *file = fopen(path, "we");
    if (!file)
        return -1;
    fprintf(file, "via,loop,client,index,at_ns");
    for (int k = 0; k < PART_COUNT; k++)
        fprintf(file, ",%s_ns", latency_parts[k]);
    fputc('\n', file);
    for (int i = 0; i < session->count; i++)
        for (uint32_t client = 0; client < session->runs[i].client_count; client++)
            write_samples(file, &session->runs[i], client);
    return finish(file);
}

static void write_table_row(FILE *file, const latency_run *run, const machine_busy *busy)
{
    const latency_options *o = &run->options;
    const tally *t = run->total;
    const tfa_histogram *h = &t->parts[PART_ROUND_TRIP].h;
    fprintf(file, "%s,%s,%s,%s,%g,%" PRIu32 ",%" PRIu32 ",%s,", latency_via_names[run->via],
            latency_loop_name(o), run->swept ? run->swept : "", o->daemon.robot, o->rate, o->batch,
            o->clients, tfa_word(TFA_WORDS_WAIT, run->facts.info.wait));
    fprintf(file,
            "%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64,
            t->sent, h->count, t->lost, t->rejected, t->late, t->longest_run, t->full);
    fprintf(file, ",%" PRIu64, h->lowest);
    for (int i = 0; i < QUANTILE_COUNT; i++)
        if (tfa_histogram_supports(h, latency_quantiles[i].quantile))
            fprintf(file, ",%" PRIu64, tfa_histogram_quantile(h, latency_quantiles[i].quantile));
        else
            fputc(',', file);
    fprintf(file, ",%" PRIu64 ",%.1f,%.3f,%.3f,%d\n", h->highest, tfa_histogram_mean(h),
            run->daemon_cpu, run->tool_cpu, busy->busy || run->busy.busy);
}

int latency_write_table(const char *path, const latency_session *session)
{
    FILE *file = fopen(path, "we");
    if (!file)
        return -1;
    fputs("via,loop,swept,robot,rate,batch,clients,wait,sent,answered,lost,rejected,late,"
          "longest_run,full,min_ns",
          file);
    for (int i = 0; i < QUANTILE_COUNT; i++)
        fprintf(file, ",p%s_ns", latency_quantiles[i].name);
    fputs(",max_ns,mean_ns,daemon_cpu,tool_cpu,busy\n", file);
    for (int i = 0; i < session->count; i++)
        write_table_row(file, &session->runs[i], &session->baseline->busy);
    return finish(file);
}

int latency_write_histogram(const char *path, const latency_session *session)
{
    for (int i = 0; i < session->count; i++) {
        const latency_run *run = &session->runs[i];
        char name[4096], load[256];
        snprintf(name, sizeof name, "%s%s%s%s%s", path, i ? "." : "",
                 i ? latency_via_names[run->via] : "", i && run->swept ? "." : "",
                 i && run->swept ? run->swept : "");
        FILE *file = fopen(name, "we");
        if (!file)
            return -1;
        latency_describe_load(&run->options, load, sizeof load);
        hgrm_write(&run->total->parts[PART_ROUND_TRIP].h, file, 1000.0);
        fprintf(file, "#[%s: %s]\n", latency_via_names[run->via], load);
        if (finish(file) != 0)
            return -1;
    }
    return 0;
}
