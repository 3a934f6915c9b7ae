/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One thread computes one block: draws or reads states, solves them in batches, counts.
 */
#include "sweep_block.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Doubles of the answers of a chunk; a mass matrix of a thousand freedoms is 8 MB alone. */
enum { CHUNK_DOUBLES = 1 << 21 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Adds the time since `from` to a part. @return now */
static double spend(sweep_worker *w, sweep_time part, double from)
{
    const double at = now();
    w->seconds[part] += at - from;
    return at;
}

/* One walk for sizes and pointers */
static int allocate(sweep_worker *w)
{
    const sweep_plan *p = w->plan;
    const size_t n = w->chunk;
    const size_t sizes[] = {n * p->record.width,
                            n * p->record.size[0],
                            n * p->record.size[1],
                            n * p->record.size[2],
                            n * p->record.size[3],
                            n * p->record.size[4],
                            n * p->record.size[5],
                            n * p->base,
                            n * p->joint,
                            n * p->matrix,
                            p->answer,
                            n * p->answer};
    double **const arrays[] = {&w->records,   &w->fields[0], &w->fields[1], &w->fields[2],
                               &w->fields[3], &w->fields[4], &w->fields[5], &w->base,
                               &w->joint,     &w->matrix,    &w->exact,     &w->packed};
    enum { ARRAYS = sizeof arrays / sizeof *arrays };
    size_t total = 0;
    for (int k = 0; k < ARRAYS; k++)
        total += (sizes[k] + 7) & ~(size_t)7;
    w->answers = calloc(n, sizeof *w->answers);
    w->memory = aligned_alloc(64, (total + 8) * sizeof(double));
    if (!w->memory || !w->answers)
        return TFA_E_MEMORY;
    memset(w->memory, 0, (total + 8) * sizeof(double));
    double *at = w->memory;
    for (int k = 0; k < ARRAYS; at += (sizes[k++] + 7) & ~(size_t)7)
        *arrays[k] = at;
    return TFA_OK;
}

/* Absent fields are NULL in a request. */
static const double *field(const sweep_worker *w, state_field f)
{
    return w->plan->record.size[f] ? w->fields[f] : NULL;
}

static void set_request(sweep_worker *w)
{
    const sweep_plan *p = w->plan;
    const int inverse = p->request.op == TFA_OP_INVERSE_DYNAMICS;
    const double *force = field(w, STATE_FORCE), *base_force = field(w, STATE_BASE_FORCE);
    w->request = p->request;
    w->request.base_pose = field(w, STATE_BASE_POSE);
    w->request.base_twist = field(w, STATE_BASE_TWIST);
    w->request.q = w->fields[STATE_Q];
    w->request.v = field(w, STATE_V);
    *(inverse ? &w->request.qdd : &w->request.tau) = force;
    *(inverse ? &w->request.base_acceleration : &w->request.base_wrench) = base_force;
    w->reply = (tfa_reply){.answers = w->answers};
    *(inverse ? &w->reply.tau : &w->reply.qdd) = w->joint;
    *(inverse ? &w->reply.base_wrench : &w->reply.base_acceleration) = w->base;
    if (p->matrix)
        *(p->request.op == TFA_OP_MASS_MATRIX ? &w->reply.mass_matrix : &w->reply.lambda_inv) =
            w->matrix;
}

int sweep_worker_open(sweep_worker *w, const sweep_plan *plan)
{
    tfa_workspace_options options = plan->workspace, reference = {.precision = TFA_F128};
    *w = (sweep_worker){.plan = plan, .chunk = STATISTICS_GROUP};
    w->states.number = w->out.number = w->out_states.number = -1;
    while (w->chunk > 1 && (size_t)w->chunk * plan->answer > CHUNK_DOUBLES)
        w->chunk /= 2;
    options.methods = TFA_METHOD_BIT(plan->request.method);
    if (plan->request.op == TFA_OP_MASS_MATRIX)
        options.methods |= TFA_METHOD_BIT(TFA_METHOD_CRBA);
    options.max_tips = reference.max_tips = plan->request.tip_count;
    reference.methods = options.methods;
    int status = allocate(w);
    if (status == TFA_OK)
        status = tfa_workspace_create(plan->model, &options, &w->workspace);
    if (status == TFA_OK && plan->reference)
        status = tfa_workspace_create(plan->model, &reference, &w->reference);
    if (status == TFA_OK)
        set_request(w);
    return status;
}

void sweep_worker_close(sweep_worker *w)
{
    tfa_workspace_free(w->workspace);
    tfa_workspace_free(w->reference);
    free(w->memory);
    free(w->answers);
}

static int read_states(sweep_worker *w, uint64_t state, uint32_t count)
{
    const size_t record = w->plan->record.width * sizeof(double);
    size_t left = count * record;
    off_t offset = (off_t)(state * record);
    for (char *at = (char *)w->records; left > 0;) {
        const ssize_t got = pread(w->states.number, at, left, offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0) {
            snprintf(w->error, sizeof w->error, "%s: state %" PRIu64 ": %s", w->states.path, state,
                     got < 0 ? strerror(errno) : "the file has become shorter");
            return -1;
        }
        at += got;
        offset += got;
        left -= (size_t)got;
    }
    return 0;
}

/* Few at a time: the records of a slice are still in the first-level cache when they are copied. */
static void draw_states(sweep_worker *w, uint64_t state, uint32_t count)
{
    enum { SLICE = 64 };
    const state_record *r = &w->plan->record;
    double *fields[STATE_FIELDS];
    for (uint32_t at = 0; at < count; at += SLICE) {
        const uint32_t slice = count - at < SLICE ? count - at : SLICE;
        double *records = w->records + (size_t)at * r->width;
        for (int field = 0; field < STATE_FIELDS; field++)
            fields[field] = w->fields[field] + (size_t)at * r->size[field];
        state_record_draw(r, w->plan->seed, state + at, slice, records);
        state_record_scatter(r, records, slice, fields);
    }
}

static int take_states(sweep_worker *w, uint64_t state, uint32_t count)
{
    if (w->states.number < 0) {
        draw_states(w, state, count);
        return 0;
    }
    if (read_states(w, state, count) != 0)
        return -1;
    state_record_scatter(&w->plan->record, w->records, count, w->fields);
    return 0;
}

/* A status that answers[k] cannot have is about the input of a state, or about the request. */
static int is_of_input(int status)
{
    return status == TFA_E_VALUE || status == TFA_E_QUATERNION;
}

static int is_of_state(int status)
{
    return status == TFA_OK || status == TFA_E_SINGULAR || status == TFA_E_NOT_COMPUTED ||
           is_of_input(status);
}

/* NaN, as the library leaves the answers of a state that failed */
static void fail_state(sweep_worker *w, uint32_t at, int status)
{
    const sweep_plan *p = w->plan;
    w->answers[at] = (tfa_answer){.status = status, .error_estimate = NAN};
    for (uint32_t k = 0; k < p->base; k++)
        w->base[(size_t)at * p->base + k] = NAN;
    for (uint32_t k = 0; k < p->joint; k++)
        w->joint[(size_t)at * p->joint + k] = NAN;
    for (uint32_t k = 0; k < p->matrix; k++)
        w->matrix[(size_t)at * p->matrix + k] = NAN;
}

/* The places of state `at` of the chunk as a request of one */
static void take_one(const sweep_worker *w, uint32_t at, tfa_request *request, tfa_reply *reply)
{
    const sweep_plan *p = w->plan;
    const uint32_t *size = p->record.size;
    const size_t n = at;
    *request = w->request;
    *reply = w->reply;
    request->count = 1;
    const double **const inputs[] = {
        &request->base_pose,   &request->base_twist,
        &request->base_wrench, &request->q,
        &request->v,           &request->tau,
        &request->qdd,         &request->base_acceleration,
    };
    const uint32_t sizes[] = {size[STATE_BASE_POSE], size[STATE_BASE_TWIST], size[STATE_BASE_FORCE],
                              size[STATE_Q],         size[STATE_V],          size[STATE_FORCE],
                              size[STATE_FORCE],     size[STATE_BASE_FORCE]};
    for (size_t k = 0; k < sizeof inputs / sizeof *inputs; k++)
        if (*inputs[k])
            *inputs[k] += n * sizes[k];
    double **const outputs[] = {&reply->qdd,         &reply->base_acceleration, &reply->tau,
                                &reply->base_wrench, &reply->mass_matrix,       &reply->lambda_inv};
    const uint32_t lengths[] = {p->joint, p->base, p->joint, p->base, p->matrix, p->matrix};
    for (size_t k = 0; k < sizeof outputs / sizeof *outputs; k++)
        if (*outputs[k])
            *outputs[k] += n * lengths[k];
    reply->answers += n;
}

/* A bad input refuses a whole request: then each state is asked alone. */
static void solve_apart(sweep_worker *w, uint32_t count)
{
    tfa_request request;
    tfa_reply reply;
    for (uint32_t s = 0; s < count; s++) {
        take_one(w, s, &request, &reply);
        const int status = tfa_compute(w->workspace, &request, &reply);
        if (is_of_input(status))
            fail_state(w, s, status);
    }
}

static void solve(sweep_worker *w, uint32_t count)
{
    w->request.count = count;
    if (is_of_input(tfa_compute(w->workspace, &w->request, &w->reply)))
        solve_apart(w, count);
}

int sweep_worker_try(sweep_worker *w)
{
    if (take_states(w, w->plan->first, 1) != 0)
        return TFA_E_FILE;
    w->request.count = 1;
    const int status = tfa_compute(w->workspace, &w->request, &w->reply);
    return is_of_state(status) ? TFA_OK : status;
}

static int write_numbers(sweep_worker *w, const sweep_file *file, const double *numbers,
                         uint64_t state, uint32_t count, uint32_t width)
{
    const size_t record = width * sizeof(double);
    size_t left = count * record;
    off_t offset = (off_t)((state - w->plan->first) * record);
    for (const char *at = (const char *)numbers; file->number >= 0 && left > 0;) {
        const ssize_t put = pwrite(file->number, at, left, offset);
        if (put < 0 && errno != EINTR) {
            snprintf(w->error, sizeof w->error, "%s: %s", file->path, strerror(errno));
            return -1;
        }
        if (put <= 0)
            continue;
        at += put;
        offset += put;
        left -= (size_t)put;
    }
    return 0;
}

/* Base and joints of one state stand together in the file. */
static const double *pack(sweep_worker *w, uint32_t count)
{
    const sweep_plan *p = w->plan;
    if (p->base == 0)
        return p->matrix ? w->matrix : w->joint;
    double *to = w->packed;
    for (uint32_t s = 0; s < count; s++, to += p->answer) {
        memcpy(to, w->base + (size_t)s * p->base, p->base * sizeof *to);
        memcpy(to + p->base, w->joint + (size_t)s * p->joint, p->joint * sizeof *to);
    }
    return w->packed;
}

static int write_chunk(sweep_worker *w, uint64_t state, uint32_t count)
{
    const sweep_plan *p = w->plan;
    if (w->out.number >= 0 &&
        write_numbers(w, &w->out, pack(w, count), state, count, p->answer) != 0)
        return -1;
    return write_numbers(w, &w->out_states, w->records, state, count, p->record.width);
}

/* What the answer of one state is, as one vector */
static void copy_answer(const sweep_worker *w, uint32_t at, double *to)
{
    const sweep_plan *p = w->plan;
    memcpy(to, w->base + (size_t)at * p->base, p->base * sizeof *to);
    memcpy(to + p->base, w->joint + (size_t)at * p->joint, p->joint * sizeof *to);
    memcpy(to + p->base + p->joint, w->matrix + (size_t)at * p->matrix, p->matrix * sizeof *to);
}

/* |found - exact| / |exact| */
static double relative_error(const sweep_worker *w, uint32_t at, const double *found)
{
    double difference = 0, size = 0;
    copy_answer(w, at, w->exact);
    for (uint32_t k = 0; k < w->plan->answer; k++) {
        difference += (found[k] - w->exact[k]) * (found[k] - w->exact[k]);
        size += w->exact[k] * w->exact[k];
    }
    return difference == 0 ? 0.0 : sqrt(difference / size);
}

static void compare(sweep_worker *w, uint64_t state, uint32_t at)
{
    const tfa_answer found = w->answers[at];
    tfa_request request;
    tfa_reply reply;
    copy_answer(w, at, w->packed);
    take_one(w, at, &request, &reply);
    request.method = TFA_METHOD_AUTO;
    request.estimate = TFA_ESTIMATE_NEVER;
    request.refine = TFA_REFINE_DEFAULT;
    w->statistics.references++;
    if (found.status != TFA_OK || tfa_compute(w->reference, &request, &reply) != TFA_OK) {
        w->statistics.unreferenced++;
        return;
    }
    const double error = relative_error(w, at, w->packed);
    series_add(&w->statistics.series[SERIES_ERROR], &w->groups[SERIES_ERROR], error, state);
    if (found.flags & TFA_ANSWER_ESTIMATED)
        series_add(&w->statistics.series[SERIES_RATIO], &w->groups[SERIES_RATIO],
                   error > 0 ? error / found.error_estimate : 0.0, state);
}

/* After everything else has used the answers, which the exact ones replace */
static void compare_chunk(sweep_worker *w, uint64_t state, uint32_t count)
{
    const uint64_t every = w->plan->reference;
    const uint64_t skip = every ? (every - state % every) % every : 0;
    for (uint64_t at = skip; every && at < count; at += every)
        compare(w, state + at, (uint32_t)at);
}

static int do_chunk(sweep_worker *w, uint64_t state, uint32_t count)
{
    double at = now();
    if (take_states(w, state, count) != 0)
        return -1;
    at = spend(w, SWEEP_TIME_STATES, at);
    solve(w, count);
    at = spend(w, SWEEP_TIME_DYNAMICS, at);
    sweep_worker_count(w, state, count);
    at = spend(w, SWEEP_TIME_STATISTICS, at);
    if (write_chunk(w, state, count) != 0)
        return -1;
    at = spend(w, SWEEP_TIME_OUTPUT, at);
    compare_chunk(w, state, count);
    if (w->reference)
        spend(w, SWEEP_TIME_REFERENCE, at);
    return 0;
}

int sweep_worker_block(sweep_worker *w, uint64_t first, uint64_t count)
{
    memset(&w->statistics, 0, sizeof w->statistics);
    memset(w->groups, 0, sizeof w->groups);
    for (uint64_t at = 0; at < count; at += w->chunk) {
        const uint64_t left = count - at;
        const uint32_t now_count = left < w->chunk ? (uint32_t)left : w->chunk;
        if (do_chunk(w, first + at, now_count) != 0)
            return -1;
        if ((at + w->chunk) % STATISTICS_GROUP == 0)
            statistics_end_groups(&w->statistics, w->groups);
    }
    statistics_end_groups(&w->statistics, w->groups);
    return 0;
}
