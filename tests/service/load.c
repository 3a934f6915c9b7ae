/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients that ask 10 000 times a second and check every bit.
 */
#include "load.h"

#include "models.h"
#include "test.h"

static tfa_request make_request(uint32_t state, double numbers[3][LOAD_JOINTS])
{
    for (int i = 0; i < LOAD_JOINTS; i++) {
        numbers[0][i] = 0.1 * state + 0.2 * i;
        numbers[1][i] = 0.3 - 0.05 * state * i;
        numbers[2][i] = 1 - 0.1 * i + 0.2 * state;
    }
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = numbers[0],
                         .v = numbers[1],
                         .tau = numbers[2]};
}

static void expect(load_client *l, int which, const tfa_model *model)
{
    double numbers[3][LOAD_JOINTS];
    l->tags[which] = tfa_model_tag(model);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    for (uint32_t s = 0; s < LOAD_STATES; s++) {
        const tfa_request r = make_request(s, numbers);
        tfa_reply reply = {.qdd = l->expected[which][s]};
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        assert_true(reply.model == l->tags[which]);
    }
}

static const char *check(const load_client *l, uint32_t state, const tfa_reply *reply, int *model)
{
    *model = 0;
    while (*model < LOAD_MODELS && l->tags[*model] != reply->model)
        ++*model;
    if (*model == LOAD_MODELS)
        return "the reply names neither model";
    if (memcmp(reply->qdd, l->expected[*model][state], sizeof l->expected[0][0]) != 0)
        return "the reply is not that of the model it names";
    return NULL;
}

static uint32_t small(uint64_t ns)
{
    return ns < UINT32_MAX ? (uint32_t)ns : UINT32_MAX;
}

/* Requests are numbered through; the clients take turns. */
static load_client *client_of(load *l, uint32_t number)
{
    return &l->clients[number % LOAD_CLIENTS];
}

static uint32_t state_of(uint32_t number)
{
    return number / LOAD_CLIENTS % LOAD_STATES;
}

static int send(load *l, uint32_t number, uint64_t due)
{
    double numbers[3][LOAD_JOINTS];
    const tfa_request request = make_request(state_of(number), numbers);
    uint64_t id;
    l->samples[number].due = due;
    return tfa_client_send(client_of(l, number)->client, &request, &id);
}

/* Takes the reply to a request. @return what is wrong with it */
static const char *take_reply(load *l, uint32_t number, uint64_t timeout_ns)
{
    load_client *c = client_of(l, number);
    load_sample *sample = &l->samples[number];
    double qdd[LOAD_JOINTS];
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange times;
    int model;
    l->status = tfa_client_receive(c->client, &reply, timeout_ns, &times);
    if (l->status == TFA_E_TIMEOUT)
        return NULL;
    if (l->status != TFA_OK)
        return "a request was not answered";
    if (times.id != c->id + 1)
        return "an id was left out";
    c->id = times.id;
    const char *error = check(c, state_of(number), &reply, &model);
    if (error)
        return error;
    const int before = atomic_exchange(&c->model, model);
    sample->latency = small(times.t_reply - sample->due);
    sample->wait = small(times.t_start - times.t_sent);
    sample->computation = small(times.t_done - times.t_start);
    sample->first = before >= 0 && before != model;
    atomic_store(&l->count, number + 1);
    return NULL;
}

/* The next reply: waits for it until the next request is due, or, with full rings, until it comes.
 * @return it may go on */
static bool receive(load *l, uint32_t *received, uint64_t timeout_ns)
{
    l->error = take_reply(l, *received, timeout_ns);
    *received += !l->error && l->status == TFA_OK;
    return l->error == NULL;
}

static void *load_thread(void *argument)
{
    load *l = argument;
    uint64_t due = l->start = now_ns();
    uint32_t sent = 0, received = 0;
    bool good = true;
    while (good && sent < LOAD_MAX && !atomic_load(&l->stop)) {
        const uint64_t now = now_ns();
        if (now > due + LOAD_BEHIND_NS) {
            due = now;
            l->resyncs++;
        }
        if (now >= due && sent - received < LOAD_CLIENTS * LOAD_SLOTS) {
            l->status = send(l, sent, due);
            good = l->status == TFA_OK;
            l->error = good ? NULL : "a request could not be sent";
            sent++;
            due += LOAD_PERIOD_NS;
        } else if (received < sent) {
            good = receive(l, &received, now < due ? due - now : WAIT_NS);
        }
    }
    while (good && received < sent)
        good = receive(l, &received, WAIT_NS) && l->status == TFA_OK;
    l->end = now_ns();
    return NULL;
}

void load_start(load *l, const harness *h, const load_robot robots[LOAD_CLIENTS], tfa_wait wait)
{
    memset(l, 0, sizeof *l);
    l->samples = calloc(LOAD_MAX, sizeof *l->samples);
    assert_non_null(l->samples);
    for (int i = 0; i < LOAD_CLIENTS; i++) {
        load_client *c = &l->clients[i];
        for (int k = 0; k < LOAD_MODELS; k++)
            expect(c, k, robots[i].models[k]);
        c->model = -1;
        tfa_client_options options = harness_options(h, robots[i].name);
        options.slots = LOAD_SLOTS;
        options.wait = wait;
        assert_int_equal(tfa_client_connect(&options, &c->client), TFA_OK);
    }
    assert_int_equal(pthread_create(&l->thread, NULL, load_thread, l), 0);
}

static bool all_answered_by(load *l, int model)
{
    for (int i = 0; i < LOAD_CLIENTS; i++)
        if (atomic_load(&l->clients[i].model) != model)
            return false;
    return true;
}

bool load_count_answers(load *l, int model)
{
    return WAIT_FOR(all_answered_by(l, model));
}

bool load_stop(load *l)
{
    atomic_store(&l->stop, true);
    pthread_join(l->thread, NULL);
    if (l->error)
        print_error("request %u: %s (%s)\n", l->count, l->error, tfa_status_name(l->status));
    for (int i = 0; i < LOAD_CLIENTS; i++)
        tfa_client_close(l->clients[i].client);
    return l->error == NULL;
}

void load_free(load *l)
{
    free(l->samples);
}

uint64_t load_time(const load *l)
{
    return l->end - l->start;
}

static int by_size(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

load_figures load_poll(const load *l, uint32_t from, uint32_t to, bool first, size_t member)
{
    load_figures f = {0};
    uint32_t *values = calloc(to - from + 1, sizeof *values);
    assert_non_null(values);
    for (uint32_t i = from; i < to; i++)
        if (l->samples[i].first == first)
            memcpy(&values[f.count++], (const char *)&l->samples[i] + member, sizeof *values);
    qsort(values, f.count, sizeof *values, by_size);
    if (f.count) {
        f.median = values[f.count / 2];
        f.p99 = values[f.count - 1 - f.count / 100];
        f.worst = values[f.count - 1];
    }
    free(values);
    return f;
}
