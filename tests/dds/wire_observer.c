/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A participant that counts what goes over the wire.
 */
#include "wire_observer.h"

#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
#include "test.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#define JOINTS 7
#define PERIOD_NS DDS_MSECS(1)
#define REMEMBERED (1u << 20) /* calls; a power of two: they are numbered through */

/* Answers to calls or to samples of a stream, by number, with the epoch of the last one to each. */
typedef struct answers {
    uint64_t *numbers, *epochs;
    _Atomic uint64_t count, twice;
} answers;

static struct {
    const char *robot;
    dds_entity_t participant, replies, accelerations, torques;
    pthread_t thread;
    uint64_t epoch; /* the highest so far */
    answers calls, stream;
    _Atomic uint64_t repeated, outdated, takeovers, published;
    _Atomic bool stop;
} observer;

/* @return it is of the daemon that leads, as far as is known here */
static bool is_current(uint64_t epoch)
{
    if (epoch > observer.epoch && observer.epoch != 0)
        atomic_fetch_add(&observer.takeovers, 1);
    if (epoch > observer.epoch)
        observer.epoch = epoch;
    if (epoch == observer.epoch)
        return true;
    atomic_fetch_add(&observer.outdated, 1);
    return false;
}

static void count_answer(answers *a, uint64_t number, uint64_t epoch)
{
    const uint64_t at = number % REMEMBERED;
    if (!is_current(epoch))
        return;
    atomic_fetch_add(&a->count, 1);
    if (a->numbers[at] == number)
        atomic_fetch_add(a->epochs[at] == epoch ? &a->twice : &observer.repeated, 1);
    a->numbers[at] = number;
    a->epochs[at] = epoch;
}

static void take_replies(void)
{
    static totalforce_dds_Reply reply;
    dds_sample_info_t info;
    while (dds_take(observer.replies, (void *[]){&reply}, &info, 1, 1) == 1)
        if (info.valid_data && reply.id != 0 && reply.answers._length > 0)
            count_answer(&observer.calls, reply.id, reply.epoch);
}

static void take_accelerations(void)
{
    static totalforce_dds_JointAccelerations out;
    dds_sample_info_t info;
    while (dds_take(observer.accelerations, (void *[]){&out}, &info, 1, 1) == 1) {
        if (info.valid_data && out.status == TFA_OK)
            count_answer(&observer.stream, out.seq, out.epoch);
    }
}

static void *observe(void *unused)
{
    double zeros[JOINTS] = {0};
    totalforce_dds_JointTorques in = {.q = {JOINTS, JOINTS, zeros, false}};
    (void)unused;
    (void)tfa_dds_set_robot(in.robot, observer.robot);
    while (!atomic_load(&observer.stop)) {
        in.seq++;
        in.stamp = tfa_dds_ros_time();
        if (dds_write(observer.torques, &in) == DDS_RETCODE_OK)
            atomic_fetch_add(&observer.published, 1);
        take_replies();
        take_accelerations();
        dds_sleepfor(PERIOD_NS);
    }
    return NULL;
}

/* A reader that keeps everything: between two looks there are many replies. */
static dds_entity_t make_reader(dds_entity_t topic)
{
    dds_qos_t *qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    const dds_entity_t reader = dds_create_reader(observer.participant, topic, qos, NULL);
    dds_delete_qos(qos);
    assert_true(reader > 0);
    return reader;
}

static void make_answers(answers *a)
{
    a->numbers = calloc(REMEMBERED, sizeof *a->numbers);
    a->epochs = calloc(REMEMBERED, sizeof *a->epochs);
    assert_true(a->numbers && a->epochs);
}

static void free_answers(answers *a)
{
    free(a->numbers);
    free(a->epochs);
}

void wire_observer_start(uint32_t domain, const char *robot)
{
    observer.robot = robot;
    make_answers(&observer.calls);
    make_answers(&observer.stream);
    const dds_entity_t p = dds_create_participant(domain, NULL, NULL);
    assert_true(p > 0);
    observer.participant = p;
    observer.replies = make_reader(tfa_dds_create_topic(p, TFA_DDS_REPLY));
    observer.accelerations = make_reader(tfa_dds_create_topic(p, TFA_DDS_ACCELERATIONS));
    observer.torques =
        tfa_dds_create_writer(p, tfa_dds_create_topic(p, TFA_DDS_TORQUES), TFA_DDS_TORQUES, NULL);
    assert_true(observer.torques > 0);
    assert_int_equal(pthread_create(&observer.thread, NULL, observe, NULL), 0);
}

wire_counts wire_observer_count(void)
{
    return (wire_counts){
        .replies = atomic_load(&observer.calls.count),
        .accelerations = atomic_load(&observer.stream.count),
        .repeated = atomic_load(&observer.repeated),
        .twice_called = atomic_load(&observer.calls.twice),
        .twice_streamed = atomic_load(&observer.stream.twice),
        .outdated = atomic_load(&observer.outdated),
        .takeovers = atomic_load(&observer.takeovers),
        .published = atomic_load(&observer.published),
    };
}

void wire_observer_stop(void)
{
    atomic_store(&observer.stop, true);
    pthread_join(observer.thread, NULL);
    (void)dds_delete(observer.participant);
    free_answers(&observer.calls);
    free_answers(&observer.stream);
}
