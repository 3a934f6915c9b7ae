/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hot standby: each robot's election (election.h) between DDS and the clock.
 *
 * The leader thread advertises this daemon and looks at the clock; Cyclone's receiving thread takes
 * the others, and looks at the clock, too, while requests keep it busy: a mutex is not fair. All
 * decide under the robot's mutex, in whose shelter requests are answered. A receiving thread that
 * hangs there stops the advertisements, and so does a worker without progress: another daemon takes
 * over.
 */
#include "dds/topics/dds_internal.h"

#include "platform/log.h"

#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

_Static_assert((int)TFA_ROLE_LISTENING == totalforce_dds_LEADER_LISTENING, "on the wire");
_Static_assert((int)TFA_ROLE_STANDBY == totalforce_dds_LEADER_STANDBY, "on the wire");
_Static_assert((int)TFA_ROLE_LEADING == totalforce_dds_LEADER_LEADING, "on the wire");
_Static_assert((int)TFA_ROLE_UNLIKE == totalforce_dds_LEADER_UNLIKE, "on the wire");

#define NS_PER_MS INT64_C(1000000)
#define NICE (-10)

/* ---- what follows from a decision; the robot is locked ---- */

static void write_advertisement(const tfa_dds *gateway, const dds_robot *robot)
{
    const tfa_advertisement *self = &robot->election.self;
    totalforce_dds_Leader sample = {
        .epoch = self->epoch,
        .priority = self->priority,
        .role = (uint32_t)self->role,
        .lease_ms = (uint32_t)(self->lease / NS_PER_MS),
        .progress = tfa_worker_heartbeat(gateway->worker),
    };

    memcpy(sample.robot, robot->name, sizeof sample.robot);
    memcpy(sample.daemon, self->daemon, sizeof sample.daemon);
    memcpy(sample.model_hash, self->model, sizeof sample.model_hash);
    memcpy(sample.follows, self->leader, sizeof sample.follows);
    (void)dds_write(gateway->leader_writer, &sample); /* if it fails, the lease runs out */
}

static void report_role(const dds_robot *robot)
{
    const tfa_advertisement *self = &robot->election.self;
    const tfa_election_peer *leader = tfa_election_leader(&robot->election);
    const unsigned long long epoch = self->epoch;
    const bool unlike = self->role == TFA_ROLE_UNLIKE;

    if (self->role == TFA_ROLE_LEADING)
        tfa_log(TFA_LOG_INFO, "dds: robot '%s': leads, epoch %llu", robot->name, epoch);
    else if (self->role == TFA_ROLE_LISTENING)
        tfa_log(TFA_LOG_WARNING,
                "dds: robot '%s': stood still for longer than its lease (dds.lease_ms): does not "
                "answer until it knows whether another daemon leads",
                robot->name);
    else
        tfa_log(unlike ? TFA_LOG_WARNING : TFA_LOG_INFO,
                "dds: robot '%s': standby, the leader has epoch %llu, priority %u%s", robot->name,
                epoch, leader != NULL ? leader->said.priority : 0,
                !unlike ? ""
                : robot->election.superseded
                    ? ", and another model: leads again when that leader is gone"
                    : ", and another model: never takes over; give both the same robot "
                      "description and scene, then reload");
}

/* RobotInfo is the leader's word. It is written again if a write failed, and if a daemon comes or
 * goes or gives up: after a partition readers may have the word of that one. */
static void keep_announced(tfa_dds *gateway, dds_robot *robot, tfa_role before)
{
    const tfa_election *e = &robot->election;
    const bool rival = tfa_election_leader(e) != NULL;

    if (e->self.role != TFA_ROLE_LEADING) {
        robot->announced = false;
        if (before == TFA_ROLE_LEADING)
            tfa_dds_withdraw_info(gateway, robot);
        return;
    }
    if (rival != robot->rival || e->peer_count != robot->peers)
        robot->announced = false;
    robot->rival = rival;
    robot->peers = e->peer_count;
    if (!robot->announced)
        robot->announced = tfa_dds_write_info(gateway, robot) == DDS_RETCODE_OK;
}

static void follow_decision(tfa_dds *gateway, dds_robot *robot, tfa_role before, bool advertise)
{
    const tfa_role role = robot->election.self.role;

    keep_announced(gateway, robot, before);
    if (advertise)
        write_advertisement(gateway, robot);
    if (role != before)
        report_role(robot);
    robot->next_tick = tfa_election_next(&robot->election);
}

/* ---- the clock ---- */

/* An idle worker is woken: it shows that it runs until the next look. */
static bool has_progress(const tfa_dds *gateway, dds_robot *robot, int64_t now)
{
    const uint64_t beat = tfa_worker_heartbeat(gateway->worker);

    if (beat != robot->worker_beat || robot->worker_beat_time == 0) {
        robot->worker_beat = beat;
        robot->worker_beat_time = now;
    }
    tfa_worker_wake(gateway->worker);
    return now - robot->worker_beat_time < 2 * gateway->lease_ns / TFA_ELECTION_BEATS;
}

void tfa_dds_tick_election(tfa_dds *gateway, dds_robot *robot, int64_t now)
{
    if (!robot->electing || now < robot->next_tick)
        return;
    const tfa_role before = robot->election.self.role;
    const bool progress = robot->election.peer_count == 0 || has_progress(gateway, robot, now);
    const bool advertise = tfa_election_tick(&robot->election, progress, now);
    follow_decision(gateway, robot, before, advertise);
}

/* @return when the robot's election wants to be looked at again */
static int64_t tick(tfa_dds *gateway, dds_robot *robot)
{
    const int64_t now = tfa_dds_monotonic();

    pthread_mutex_lock(&robot->mutex);
    tfa_dds_tick_election(gateway, robot, now);
    const int64_t next = robot->electing ? robot->next_tick : now + gateway->lease_ns;
    pthread_mutex_unlock(&robot->mutex);
    return next;
}

static void write_guid(const uint8_t guid[16], char text[33])
{
    for (int i = 0; i < 16; i++)
        snprintf(text + 2 * i, 3, "%02x", guid[i]);
}

/* Another leader than at the last look is named: Cyclone is asked without the robot's mutex. */
static void describe_leader(const tfa_dds *gateway, dds_robot *robot)
{
    static const uint8_t none[16] = {0};
    uint8_t leader[16];
    char guid[33], origin[TFA_DDS_ORIGIN_SIZE] = "";

    pthread_mutex_lock(&robot->mutex);
    const bool known = memcmp(robot->described, robot->election.self.leader, sizeof leader) == 0;
    memcpy(leader, robot->election.self.leader, sizeof leader);
    pthread_mutex_unlock(&robot->mutex);
    if (known)
        return;
    const bool follows = memcmp(leader, none, sizeof leader) != 0;
    if (follows)
        tfa_dds_describe_origin(gateway->member.participant, leader, origin);
    pthread_mutex_lock(&robot->mutex);
    memcpy(robot->described, leader, sizeof leader);
    memcpy(robot->origin, origin, sizeof origin);
    write_guid(leader, guid);
    if (follows) /* one after the other with what a listener says of the robot */
        tfa_log(TFA_LOG_INFO, "dds: robot '%s': follows the participant %s: %s", robot->name, guid,
                origin);
    pthread_mutex_unlock(&robot->mutex);
}

/* Advertisements are few and small, and late ones cost a takeover. Where that is not permitted the
 * thread stays as it is. */
static void raise_thread(void)
{
    (void)setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), NICE);
}

static void set_relaxed(tfa_counter *word, uint64_t value)
{
    atomic_store_explicit(word, value, memory_order_relaxed);
}

static uint32_t writers_of(dds_entity_t reader)
{
    dds_subscription_matched_status_t status = {0};

    if (reader > 0)
        (void)dds_get_subscription_matched_status(reader, &status);
    return status.current_count;
}

static uint32_t readers_of(dds_entity_t writer)
{
    dds_publication_matched_status_t status = {0};

    if (writer > 0)
        (void)dds_get_publication_matched_status(writer, &status);
    return status.current_count;
}

/* Endpoints of others, for the statistics, once a second. */
static void count_endpoints(const tfa_dds *gateway, int64_t *next)
{
    const int64_t now = tfa_dds_monotonic();

    if (now < *next)
        return;
    *next = now + 1000000000;
    set_relaxed(&gateway->count->request_writers, writers_of(gateway->request_reader));
    set_relaxed(&gateway->count->reply_readers, readers_of(gateway->reply_writer));
    set_relaxed(&gateway->count->torque_writers, writers_of(gateway->torques_reader));
    set_relaxed(&gateway->count->acceleration_readers, readers_of(gateway->accelerations_writer));
}

void *tfa_dds_leader_thread(void *arg)
{
    tfa_dds *gateway = arg;
    struct timespec until;
    int64_t next_count = 0;

    raise_thread();
    do {
        int64_t next = INT64_MAX;
        for (uint32_t i = 0; i < gateway->robot_count; i++) {
            const int64_t robot_next = tick(gateway, &gateway->robots[i]);
            describe_leader(gateway, &gateway->robots[i]);
            next = robot_next < next ? robot_next : next;
        }
        count_endpoints(gateway, &next_count);
        until = (struct timespec){next / 1000000000, next % 1000000000};
    } while (sem_clockwait(&gateway->leader_stop, CLOCK_MONOTONIC, &until) != 0);
    return NULL;
}

/* ---- the others ---- */

/* A daemon advertises itself only. */
static bool is_its_own(dds_entity_t reader, const totalforce_dds_Leader *sample,
                       dds_instance_handle_t writer)
{
    dds_builtintopic_endpoint_t *endpoint = dds_get_matched_publication_data(reader, writer);

    if (endpoint == NULL)
        return false;
    const bool own =
        memcmp(endpoint->participant_key.v, sample->daemon, sizeof sample->daemon) == 0;
    dds_builtintopic_free_endpoint(endpoint);
    return own;
}

/* Runs under a lock of Cyclone's cache: one writer has one instance for each robot, whatever it
 * claims, or many would crowd out others. */
bool tfa_dds_leader_is_ours(const void *sample, const dds_sample_info_t *info, void *arg)
{
    const totalforce_dds_Leader *said = sample;
    tfa_dds *gateway = arg;

    if (tfa_dds_find_robot(gateway, said->robot) == NULL)
        return false;
    if (info->publication_handle == DDS_HANDLE_NIL)
        return true; /* in dds_write of this daemon */
    pthread_mutex_lock(&gateway->mutex);
    const dds_entity_t reader = gateway->leader_reader; /* 0: it is being made */
    pthread_mutex_unlock(&gateway->mutex);
    return reader > 0 && is_its_own(reader, said, info->publication_handle);
}

static tfa_advertisement advertisement_of(const totalforce_dds_Leader *sample)
{
    tfa_advertisement said = {
        .epoch = sample->epoch,
        .priority = sample->priority,
        .role = sample->role < TFA_ROLE_COUNT ? (tfa_role)sample->role : TFA_ROLE_COUNT,
        .lease = NS_PER_MS * sample->lease_ms,
    };

    memcpy(said.daemon, sample->daemon, sizeof said.daemon);
    memcpy(said.model, sample->model_hash, sizeof said.model);
    memcpy(said.leader, sample->follows, sizeof said.leader);
    return said;
}

static bool has_no_writer(const dds_sample_info_t *info)
{
    return info->instance_state == DDS_NOT_ALIVE_NO_WRITERS_INSTANCE_STATE;
}

/* Disposed: it says good-bye. Without a writer: it ended, or its liveliness was lost; what it said
 * last does not count any more. */
static void hear(tfa_dds *gateway, dds_robot *robot, const totalforce_dds_Leader *sample,
                 const dds_sample_info_t *info)
{
    const int64_t now = tfa_dds_monotonic();
    const tfa_role before = robot->election.self.role;
    bool advertise = false;

    if (has_no_writer(info)) {
        tfa_election_lose(&robot->election, sample->daemon, now);
    } else if (info->valid_data) {
        const tfa_advertisement said = advertisement_of(sample);
        advertise = tfa_election_hear(&robot->election, &said, now);
    } else if (info->instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE) {
        advertise = tfa_election_leave(&robot->election, sample->daemon, now);
    }
    follow_decision(gateway, robot, before, advertise);
}

void tfa_dds_on_leader(dds_entity_t reader, void *arg)
{
    tfa_dds *gateway = arg;
    totalforce_dds_Leader sample = {0};
    dds_sample_info_t info;

    while (dds_take(reader, (void *[]){&sample}, &info, 1, 1) > 0) {
        dds_robot *robot = tfa_dds_find_robot(gateway, sample.robot);
        if (robot == NULL ||
            (!has_no_writer(&info) &&
             !is_its_own(reader, &sample, info.publication_handle))) /* disposals */
            continue;
        pthread_mutex_lock(&robot->mutex);
        if (robot->electing)
            hear(gateway, robot, &sample, &info);
        pthread_mutex_unlock(&robot->mutex);
    }
}

/* ---- begin and end ---- */

/* More takeovers than one in a millisecond are not to be had, so an epoch is lower than this number
 * of any later start. */
static uint64_t first_epoch(void)
{
    const int64_t ms = tfa_dds_ros_time() / NS_PER_MS;

    return ms > 0 ? (uint64_t)ms : 0;
}

/* The robot is locked: the readers listen by now. */
static void begin_election(tfa_dds *gateway, dds_robot *robot, const uint8_t daemon[16])
{
    tfa_advertisement self = {
        .priority = gateway->priority, .lease = gateway->lease_ns, .epoch = first_epoch()};

    memcpy(self.daemon, daemon, sizeof self.daemon);
    memcpy(self.model, robot->hash, sizeof self.model);
    tfa_election_begin(&robot->election, &self, tfa_dds_monotonic());
    robot->next_tick = tfa_election_next(&robot->election);
    robot->electing = true;
    robot->stepped_down = false;
}

void tfa_dds_begin_elections(tfa_dds *gateway, const uint8_t daemon[16])
{
    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        dds_robot *robot = &gateway->robots[i];
        pthread_mutex_lock(&robot->mutex);
        begin_election(gateway, robot, daemon);
        pthread_mutex_unlock(&robot->mutex);
    }
}

void tfa_dds_set_leader_model(tfa_dds *gateway, dds_robot *robot)
{
    if (robot->stepped_down) {
        begin_election(gateway, robot, robot->election.self.daemon);
        return;
    }
    const tfa_role before = robot->election.self.role;
    const bool advertise =
        tfa_election_set_model(&robot->election, robot->hash, tfa_dds_monotonic());

    follow_decision(gateway, robot, before, advertise);
}

static void resign(tfa_dds *gateway, dds_robot *robot)
{
    totalforce_dds_Leader sample = {0};

    if (robot->election.self.role == TFA_ROLE_LEADING)
        tfa_dds_withdraw_info(gateway, robot);
    memcpy(sample.robot, robot->name, sizeof sample.robot);
    memcpy(sample.daemon, robot->election.self.daemon, sizeof sample.daemon);
    (void)dds_dispose(gateway->leader_writer, &sample);
    (void)dds_unregister_instance(gateway->leader_writer, &sample);
}

void tfa_dds_step_down(tfa_dds *gateway, dds_robot *robot)
{
    if (!robot->electing)
        return;
    resign(gateway, robot);
    robot->election.self.role = TFA_ROLE_LISTENING;
    robot->electing = robot->announced = false;
    robot->stepped_down = true;
    tfa_log(TFA_LOG_WARNING,
            "dds: robot '%s': no memory or no entry at the worker for its new arrays: does not "
            "answer over DDS, another daemon may lead; free some and reload",
            robot->name);
}

void tfa_dds_resign_all(tfa_dds *gateway)
{
    sem_post(&gateway->leader_stop);
    if (gateway->leader_running)
        pthread_join(gateway->leader_thread, NULL);
    gateway->leader_running = false;
    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        dds_robot *robot = &gateway->robots[i];
        pthread_mutex_lock(&robot->mutex);
        if (robot->electing)
            resign(gateway, robot);
        robot->electing = false;
        pthread_mutex_unlock(&robot->mutex);
    }
    (void)dds_wait_for_acks(gateway->info_writer, DDS_MSECS(100));
}

bool tfa_dds_get_leadership(void *self, uint32_t index, gateway_leadership *leadership)
{
    static const char *const names[] = {"listening", "standby", "leading", "unlike"};
    tfa_dds *gateway = self;

    if (index >= gateway->robot_count)
        return false;
    dds_robot *robot = &gateway->robots[index];
    pthread_mutex_lock(&robot->mutex);
    const int64_t now = tfa_dds_monotonic();
    tfa_dds_tick_election(gateway, robot, now);
    *leadership = (gateway_leadership){
        .leads = robot->electing && tfa_election_may_answer(&robot->election, now),
        .role = names[robot->election.self.role],
        .epoch = robot->election.self.epoch,
        .peers = robot->election.peer_count,
        .pause_ms = 1e-6 * (double)robot->election.longest_pause,
        .silence_ms = 1e-6 * (double)robot->election.longest_silence,
    };
    if (robot->electing && *robot->origin != '\0') {
        write_guid(robot->described, leadership->leader);
        snprintf(leadership->origin, sizeof leadership->origin, "%s", robot->origin);
        leadership->follows_ms = 1e-6 * (double)(now - robot->election.follows_since);
    }
    pthread_mutex_unlock(&robot->mutex);
    return true;
}
