/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Makes ready for a replay: the file, the model or the daemon, the order of the records.
 */
#include "replay.h"

#include "common/commands.h"
#include "common/load_model.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* @return EXIT_FAILED */
__attribute__((format(printf, 1, 2))) static int fail(const char *format, ...)
{
    va_list arguments;
    fputs("totalforce replay: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    return EXIT_FAILED;
}

/* ---- the file ---- */

static int map_file(replay *r, const char *path, const void **bytes)
{
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    void *memory = MAP_FAILED;
    if (fd >= 0 && fstat(fd, &info) == 0 && info.st_size > 0)
        memory = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    else if (fd >= 0 && !errno)
        errno = ENODATA;
    const int saved = errno;
    if (fd >= 0)
        close(fd);
    if (memory == MAP_FAILED)
        return fail("%s: %s", path, saved ? strerror(saved) : "it is empty");
    r->mapped = (size_t)info.st_size;
    r->file.bytes = memory;
    *bytes = memory;
    return EXIT_GOOD;
}

static int open_file(replay *r)
{
    const char *path = r->options->file;
    const void *bytes = NULL;
    char text[200];
    errno = 0;
    if (map_file(r, path, &bytes) != EXIT_GOOD)
        return EXIT_FAILED;
    if (recording_open(bytes, r->mapped, &r->file, text, sizeof text) != 0)
        return fail("%s: %s", path, text);
    if (recorded_robot_read(r->file.settings, r->file.settings_bytes, &r->robot, text,
                            sizeof text) != 0)
        return fail("%s: %s", path, text);
    return EXIT_GOOD;
}

/* ---- the records ---- */

static int grow(replay *r, size_t *capacity)
{
    if (r->count < *capacity)
        return 1;
    *capacity = *capacity ? 2 * *capacity : 1024;
    size_t *records = reallocarray(r->records, *capacity, sizeof *records);
    r->records = records ? records : r->records;
    uint64_t *numbers = reallocarray(r->numbers, *capacity, sizeof *numbers);
    r->numbers = numbers ? numbers : r->numbers;
    return records && numbers;
}

static void note_sizes(replay *r, const replay_request *q)
{
    if (q->status != TFA_OK)
        return;
    if (q->request.count > r->max_batch)
        r->max_batch = q->request.count;
    if (q->request.tip_count > r->max_tips)
        r->max_tips = q->request.tip_count;
}

/* Checks every record before the first is played. */
static int list_records(replay *r)
{
    char text[200] = "its sizes do not fit the robot: the record is damaged";
    size_t capacity = 0, at = r->file.first;
    recorded from;
    r->max_batch = r->max_tips = 1;
    for (;;) {
        replay_request q;
        const size_t begin = at;
        const recording_state state = recording_next(&r->file, &at, &from, text, sizeof text);
        if (state == RECORDING_END)
            return EXIT_GOOD;
        if (state == RECORDING_CUT_OFF) {
            snprintf(r->cut_off, sizeof r->cut_off, "%.79s", text);
            return EXIT_GOOD;
        }
        if (state == RECORDING_DAMAGED || replay_decode(r, &from, &q) == REPLAY_DAMAGED)
            return fail("%s: record %" PRIu64 ": %s", r->options->file, r->count, text);
        if (!grow(r, &capacity))
            return fail("%s", tfa_status_text(TFA_E_MEMORY));
        note_sizes(r, &q);
        r->records[r->count] = begin;
        r->numbers[r->count] = r->count;
        r->count++;
    }
}

typedef struct sent_record {
    uint64_t sent, number;
    size_t at;
} sent_record;

static int by_time(const void *a, const void *b)
{
    const sent_record *x = a, *y = b;
    if (x->sent != y->sent)
        return x->sent < y->sent ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

/* At the recorded times: several producers wrote the records one after the other. */
static int sort_records(replay *r)
{
    if (!(r->options->hz < 0) || r->count == 0)
        return EXIT_GOOD;
    sent_record *list = calloc(r->count, sizeof *list);
    if (!list)
        return fail("%s", tfa_status_text(TFA_E_MEMORY));
    for (uint64_t k = 0; k < r->count; k++) {
        const tfa_tap_record *head = (const void *)(r->file.bytes + r->records[k]);
        const tfa_wire_request *line = (const void *)(head + 1);
        list[k] = (sent_record){line->t_sent, k, r->records[k]};
    }
    qsort(list, r->count, sizeof *list, by_time);
    for (uint64_t k = 0; k < r->count; k++) {
        r->records[k] = list[k].at;
        r->numbers[k] = list[k].number;
    }
    free(list);
    return EXIT_GOOD;
}

/* ---- what answers ---- */

static int check_hash(replay *r, const char *what, const char *hash)
{
    snprintf(r->hash, sizeof r->hash, "%s", hash);
    if (strcmp(hash, r->robot.model_hash) == 0)
        return EXIT_GOOD;
    if (r->options->any_model)
        return EXIT_GOOD;
    return fail("%s: other model: %.16s, the recording of robot '%s' has %.16s; --any-model "
                "compares all the same",
                what, hash, r->robot.robot, r->robot.model_hash);
}

static int compile(replay *r)
{
    const char *path = r->options->urdf;
    char *text = NULL;
    size_t bytes = r->file.urdf_bytes;
    if (path && !(text = read_robot(path, &bytes)))
        return EXIT_FAILED;
    const char *name = path ? path : r->robot.urdf_name;
    r->model = recorded_robot_compile(&r->robot, name, text ? text : r->file.urdf, bytes);
    free(text);
    if (!r->model)
        return fail("%s: no model", name);
    const int result = check_hash(r, name, tfa_model_hash_text(r->model));
    if (result == EXIT_GOOD && !recorded_robot_fits(&r->robot, r->model))
        return fail("%s: other joints or links than the recording of robot '%s'", name,
                    r->robot.robot);
    return result;
}

static int make_workspace(replay *r)
{
    char text[512];
    if (r->options->kernel) {
        const int status =
            tfa_specialised_load(r->options->kernel, r->model, &r->specialised, text, sizeof text);
        if (status != TFA_OK)
            return fail("%s: %s: %s", r->options->kernel, tfa_status_text(status), text);
    }
    r->robot.workspace.specialised = r->specialised;
    const int status = tfa_workspace_create(r->model, &r->robot.workspace, &r->workspace);
    return status == TFA_OK ? EXIT_GOOD : fail("workspace: %s", tfa_status_text(status));
}

/* A replay is in no hurry: the daemon may be busy with other programs. */
static const uint64_t patience_ns = UINT64_C(60000000000);

static int connect_to(replay *r)
{
    char text[512];
    const daemon_options options = {.robot = r->options->robot,
                                    .runtime_dir = r->options->runtime_dir,
                                    .timeout_ns = patience_ns,
                                    .max_batch = r->max_batch,
                                    .max_tips = r->max_tips,
                                    .slots = 2};
    const int status = daemon_connect(&options, DAEMON_SHM, &r->daemon);
    if (status != TFA_OK) {
        daemon_explain(&options, DAEMON_SHM, status, text, sizeof text);
        return fail("%s", text);
    }
    const tfa_client_info *info = daemon_info(r->daemon);
    const tfa_wire_shape *s = &r->robot.shape;
    const int result = check_hash(r, options.robot, info->model_hash);
    if (result == EXIT_GOOD && (info->q_count != s->q_count || info->v_count != s->v_count ||
                                info->base_freedoms != s->base_freedoms ||
                                info->frame_count != s->frames || info->mode_count != s->modes))
        return fail("%s: other joints or links than the recording of robot '%s'", options.robot,
                    r->robot.robot);
    return result;
}

int replay_open(replay *r, const replay_options *options)
{
    *r = (replay){.options = options};
    int result = open_file(r);
    if (result == EXIT_GOOD &&
        (tfa_histogram_init(&r->recorded, REPLAY_BITS, 64, r->buckets[0]) != TFA_OK ||
         tfa_histogram_init(&r->replayed, REPLAY_BITS, 64, r->buckets[1]) != TFA_OK))
        result = EXIT_FAILED;
    /* the shape of the settings bounds every size below: it is that of a model */
    if (result == EXIT_GOOD && !options->robot)
        result = compile(r);
    if (result == EXIT_GOOD)
        result = list_records(r);
    if (result == EXIT_GOOD)
        result = options->robot ? connect_to(r) : make_workspace(r);
    return result == EXIT_GOOD ? sort_records(r) : result;
}

void replay_close(replay *r)
{
    daemon_close(r->daemon);
    tfa_workspace_free(r->workspace);
    tfa_specialised_free(r->specialised);
    tfa_model_free(r->model);
    recorded_robot_free(&r->robot);
    if (r->mapped)
        munmap((void *)(uintptr_t)r->file.bytes, r->mapped);
    free(r->records);
    free(r->numbers);
    free(r->reply);
}
