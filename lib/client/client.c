/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Client library: connect, call, send, receive.
 */
#include "client/client.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "ipc/control_socket.h"

#define DEFAULT_SLOTS 16
#define DEFAULT_BATCH 1
#define DEFAULT_TIMEOUT_MS 1000
/* Pause between attempts to reconnect, doubled from the first to the last */
#define BACK_OFF_FIRST_NS 1000000
#define BACK_OFF_LAST_NS 100000000
/* Longest look of tfa_client_send for another daemon: ten handshakes */
#define SEND_LOOK_NS 2000000

/* ---- connecting ---- */

static int check_options(const tfa_client_options *o)
{
    if (!o->robot || !*o->robot || (unsigned)o->wait > TFA_WAIT_BLOCK || o->connect_timeout_ms < 0)
        return TFA_E_ARGUMENT;
    if (strlen(o->robot) > TFA_ROBOT_NAME_MAX || strchr(o->robot, '/'))
        return TFA_E_ROBOT;
    if (o->max_tips > TFA_MAX_TIPS)
        return TFA_E_SIZE;
    return o->slots == 0 || tfa_ring_slots_valid(o->slots) ? TFA_OK : TFA_E_SIZE;
}

static int copy_options(tfa_client *client, const tfa_client_options *o)
{
    client->options = *o;
    client->robot = strdup(o->robot);
    client->runtime_dir = tfa_find_runtime_dir(o->runtime_dir, o->robot);
    client->standby_dir = o->standby_dir ? strdup(o->standby_dir) : NULL;
    if (!client->robot || !client->runtime_dir || (o->standby_dir && !client->standby_dir))
        return TFA_E_MEMORY;
    client->options.standby_dir = client->standby_dir;
    client->options.robot = client->robot;
    client->options.runtime_dir = client->runtime_dir;
    if (o->slots == 0)
        client->options.slots = DEFAULT_SLOTS;
    if (o->max_batch == 0)
        client->options.max_batch = DEFAULT_BATCH;
    if (o->max_tips == 0)
        client->options.max_tips = TFA_DEFAULT_TIPS;
    if (o->connect_timeout_ms == 0)
        client->options.connect_timeout_ms = DEFAULT_TIMEOUT_MS;
    return TFA_OK;
}

static uint64_t connect_deadline(const tfa_client *client)
{
    return tfa_clock_ns() + (uint64_t)client->options.connect_timeout_ms * UINT64_C(1000000);
}

int tfa_client_connect(const tfa_client_options *options, tfa_client **client)
{
    if (!client)
        return TFA_E_ARGUMENT;
    *client = NULL;
    if (!options)
        return TFA_E_ARGUMENT;
    int status = check_options(options);
    if (status != TFA_OK)
        return status;
    tfa_client *c = calloc(1, sizeof *c);
    if (!c)
        return TFA_E_MEMORY;
    c->connection = (client_connection){.socket = -1, .doorbell = -1};
    c->first_id = 1;
    status = copy_options(c, options);
    const uint64_t deadline = connect_deadline(c);
    if (status == TFA_OK)
        status = tfa_connection_open(c, deadline, 0);
    if (status == TFA_E_DISCONNECTED && c->standby_dir)
        status = tfa_client_open_either(c, deadline, 0);
    if (status != TFA_OK) {
        int saved = errno;
        tfa_client_close(c);
        errno = saved;
        return status;
    }
    *client = c;
    return TFA_OK;
}

/* A group's name, or its number if it has none */
static const char *group_name(gid_t group, char *text, size_t size)
{
    struct group entry, *found = NULL;
    if (getgrgid_r(group, &entry, text, size, &found) == 0 && found)
        return entry.gr_name;
    snprintf(text, size, "%u", (unsigned)group);
    return text;
}

/* Message about a socket that the kernel does not let this user open; 0: it does. Members of the
 * group root are more than clients: that group is no remedy. */
static int explain_mode(const char *robot, const char *dir, char *text, size_t size)
{
    char path[128], name[4096];
    struct stat info;
    const int n = snprintf(path, sizeof path, "%s/%s.sock", dir, robot);
    if (n < 0 || n >= (int)sizeof path || stat(path, &info) != 0 ||
        faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) == 0)
        return 0;
    const char *group = group_name(info.st_gid, name, sizeof name);
    const bool joins = info.st_gid != 0 && (info.st_mode & S_IWGRP);
    return snprintf(text, size,
                    "robot '%s': this user may not open %s, of mode %04o and group '%s': %s%s%s"
                    "name a group of theirs with 'group' in the daemon's configuration",
                    robot, path, (unsigned)info.st_mode & 0777, group,
                    joins ? "sudo adduser $USER " : "", joins ? group : "",
                    joins ? " and log in again, or " : "");
}

/* Message about the folder DIR and the socket DIR/ROBOT.sock */
static int explain(const char *robot, const char *dir, int status, const char *cause, char *text,
                   size_t size)
{
    const char *reason = tfa_connection_refusal();
    const int length =
        status == TFA_E_REFUSED && !*reason ? explain_mode(robot, dir, text, size) : 0;
    if (length != 0)
        return length;
    if (status == TFA_E_DISCONNECTED && *reason)
        return snprintf(text, size, "robot '%s': the daemon at %s hung up: %s", robot, dir, reason);
    if (status == TFA_E_DISCONNECTED)
        return snprintf(
            text, size,
            "robot '%s': no daemon listens at %s/%s.sock: start one (totalforced FILE.yaml), or "
            "set TOTALFORCE_RUNTIME_DIR to the runtime_dir of one that runs",
            robot, dir, robot);
    if (status == TFA_E_ROBOT)
        return snprintf(text, size,
                        "robot '%s': the daemon at %s serves no robot of that name; 'robots' in "
                        "its configuration lists its robots",
                        robot, dir);
    if (status == TFA_E_TIMEOUT)
        return snprintf(text, size,
                        "robot '%s': the daemon at %s does not answer in time: it was stopped, or "
                        "other programs take its processor",
                        robot, dir);
    return snprintf(text, size, "robot '%s' at %s/%s.sock: %s: %s", robot, dir, robot,
                    tfa_status_text(status), *reason ? reason : cause);
}

size_t tfa_client_explain(const tfa_client_options *options, int status, char *text, size_t size)
{
    const char *cause = status == TFA_E_SYSTEM ? strerror(errno) : tfa_status_cause(status);
    const char *robot = options && options->robot ? options->robot : "";
    char *dir = options ? tfa_find_runtime_dir(options->runtime_dir, robot) : NULL;
    const int length =
        explain(robot, dir ? dir : TFA_DEFAULT_RUNTIME_DIR, status, cause, text, size);
    free(dir);
    return length < 0 ? 0 : (size_t)length;
}

void tfa_client_close(tfa_client *client)
{
    if (!client)
        return;
    tfa_connection_close(&client->connection);
    for (client_names *n = client->names, *older; n; n = older) {
        older = n->older;
        free(n);
    }
    free(client->reply_shapes);
    free(client->robot);
    free(client->runtime_dir);
    free(client->standby_dir);
    free(client);
}

/* Records the lost requests of tfa_client_send, for tfa_client_receive. */
static void mark_requests_lost(tfa_client *client)
{
    const tfa_ring_client *ring = &client->connection.ring;
    uint64_t first = ring->received > client->call_end ? ring->received : client->call_end;
    if (first < ring->sent) {
        if (client->lost == client->lost_end)
            client->lost = client->first_id + first;
        client->lost_end = client->first_id + ring->sent;
    }
    client->first_id += ring->sent;
    client->call_end = 0;
}

static void backoff_sleep(uint64_t ns)
{
    struct timespec time = {.tv_sec = (time_t)(ns / 1000000000u),
                            .tv_nsec = (long)(ns % 1000000000u)};
    nanosleep(&time, NULL);
}

int tfa_client_attempt(tfa_client *client, uint64_t deadline, uint64_t model)
{
    mark_requests_lost(client);
    tfa_connection_close(&client->connection);
    return tfa_client_open_either(client, deadline, model);
}

int tfa_client_reconnect(tfa_client *client)
{
    if (!client)
        return TFA_E_ARGUMENT;
    const uint64_t end = connect_deadline(client);
    uint64_t delay = BACK_OFF_FIRST_NS;
    for (;;) {
        int status = tfa_client_attempt(client, end, 0);
        if (status != TFA_E_DISCONNECTED || tfa_clock_ns() + delay > end)
            return status;
        backoff_sleep(delay);
        delay = 2 * delay < BACK_OFF_LAST_NS ? 2 * delay : BACK_OFF_LAST_NS;
    }
}

const tfa_client_info *tfa_client_get_info(const tfa_client *client)
{
    return client ? &client->info : NULL;
}

/* ---- requests ---- */

/* Marks the connection as ended until tfa_client_reconnect. */
static int disconnected(tfa_client *client)
{
    if (client->connection.alive)
        tfa_connection_read_farewell(&client->connection);
    client->connection.alive = false;
    return TFA_E_DISCONNECTED;
}

/* The doorbell does not block: EAGAIN means that it is already set. */
static void ring_doorbell(const tfa_client *client)
{
    const uint64_t one = 1;
    ssize_t n;
    do
        n = write(client->connection.doorbell, &one, sizeof one);
    while (n < 0 && errno == EINTR);
}

/* Drops replies to calls that timed out. */
static void release_abandoned(tfa_client *client)
{
    tfa_ring_client *ring = &client->connection.ring;
    while (ring->received < client->call_end && tfa_ring_reply_ready(ring))
        tfa_ring_release(ring);
}

/* Deadline for the wire: the sooner of the client's and of a call's timeout. */
static uint32_t wire_deadline(const tfa_client *client, uint64_t timeout_ns)
{
    const uint32_t own = client->options.deadline_us;
    const uint64_t timeout_us = timeout_ns / 1000 + 1;
    if (timeout_ns == 0 || timeout_us > UINT32_MAX)
        return own;
    return own && own < timeout_us ? own : (uint32_t)timeout_us;
}

static int send_request(tfa_client *client, const tfa_request *request, uint64_t want,
                        uint64_t t_sent, uint64_t timeout_ns, uint64_t *id, tfa_field *field)
{
    tfa_ring_client *ring = &client->connection.ring;
    if (!client->connection.alive)
        return TFA_E_DISCONNECTED;
    release_abandoned(client);
    if (tfa_ring_full(ring)) {
        if (tfa_connection_hung_up(&client->connection))
            return disconnected(client);
        return TFA_E_AGAIN;
    }
    const uint64_t index = ring->sent;
    int status =
        tfa_wire_encode_request(&client->shape, request, want, client->first_id + index, t_sent,
                                tfa_ring_next_request(ring),
                                &client->reply_shapes[index & (ring->layout.slots - 1)], field);
    if (status != TFA_OK)
        return status;
    tfa_wire_request *line = tfa_ring_next_request(ring);
    line->deadline_us = wire_deadline(client, timeout_ns);
    if (tfa_ring_send(ring))
        ring_doorbell(client);
    if (id)
        *id = client->first_id + index;
    return TFA_OK;
}

/* Reads the oldest reply, which has come. */
static int read_reply(tfa_client *client, tfa_reply *reply, tfa_exchange *exchange)
{
    tfa_ring_client *ring = &client->connection.ring;
    const tfa_wire_reply *line = tfa_ring_oldest_reply(ring);
    const tfa_wire_reply_shape *reply_shape =
        &client->reply_shapes[ring->received & (ring->layout.slots - 1)];
    if (line->id != client->first_id + ring->received) {
        client->connection.alive = false;
        return TFA_E_PROTOCOL;
    }
    uint64_t blocks = tfa_wire_decode_reply(line, reply);
    if (blocks != 0 && blocks == reply_shape->want)
        tfa_wire_copy_answers(&client->shape, reply_shape, line, reply);
    client->model = reply->model ? reply->model : client->model;
    if (exchange) {
        exchange->daemon = TFA_OK;
        exchange->id = line->id;
        exchange->t_received = line->t_received;
        exchange->t_start = line->t_start;
        exchange->t_done = line->t_done;
        exchange->t_reply = tfa_clock_ns();
    }
    tfa_ring_release(ring);
    return reply->status;
}

/* Waits for the oldest reply that was not abandoned. */
static int wait_reply(tfa_client *client, uint64_t deadline)
{
    tfa_ring_client *ring = &client->connection.ring;
    for (;;) {
        int status = tfa_connection_wait(client, deadline);
        if (status == TFA_E_DISCONNECTED)
            return disconnected(client);
        if (status != TFA_OK || ring->received >= client->call_end)
            return status;
        tfa_ring_release(ring);
    }
}

static uint64_t deadline_of(uint64_t start, uint64_t timeout_ns)
{
    return timeout_ns == 0 || timeout_ns > UINT64_MAX - start ? UINT64_MAX : start + timeout_ns;
}

static int call_daemon(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                       uint64_t now, uint64_t deadline, tfa_exchange *exchange)
{
    tfa_ring_client *ring = &client->connection.ring;
    uint64_t id = 0;
    reply->field = TFA_FIELD_NONE;
    reply->index = reply->state = 0;
    reply->model = 0;
    if (!client->connection.alive)
        return reply->status = TFA_E_DISCONNECTED;
    if (client->lost != client->lost_end ||
        (ring->sent > ring->received && client->call_end < ring->sent))
        return reply->status = TFA_E_ARGUMENT; /* replies of tfa_client_send are not received yet */
    int status = send_request(client, request, tfa_wire_want(request, reply), now,
                              deadline == UINT64_MAX ? 0 : deadline - now, &id, &reply->field);
    if (status != TFA_OK) {
        reply->index = tfa_wire_refused_index(request, reply->field);
        return reply->status = status;
    }
    client->call_end = ring->sent - 1;
    status = wait_reply(client, deadline);
    if (status != TFA_OK) {
        client->call_end = ring->sent; /* the reply is abandoned */
        if (exchange)
            *exchange = (tfa_exchange){.id = id, .t_sent = now};
        return reply->status = status;
    }
    if (exchange)
        exchange->t_sent = now;
    return read_reply(client, reply, exchange);
}

static uint64_t sooner(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* The connection has ended: is there another, for this call? A fallback answers soon, so that the
 * attempt is short; a standby may take as long as the call. */
static bool find_daemon(tfa_client *client, uint64_t deadline)
{
    return client->fallback.workspace
               ? tfa_client_retry(client)
               : tfa_client_fail_over(client, sooner(deadline, connect_deadline(client)));
}

/* Asks again, in the time that is left. */
static int call_again(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                      uint64_t deadline, tfa_exchange *exchange)
{
    const uint64_t now = tfa_clock_ns();
    if (now >= deadline)
        return reply->status = TFA_E_TIMEOUT;
    return call_daemon(client, request, reply, now, deadline, exchange);
}

int tfa_client_call(tfa_client *client, const tfa_request *request, tfa_reply *reply,
                    uint64_t timeout_ns, tfa_exchange *exchange)
{
    if (!client || !request || !reply)
        return TFA_E_ARGUMENT;
    const uint64_t now = tfa_clock_ns(), deadline = deadline_of(now, timeout_ns);
    int status = call_daemon(client, request, reply, now, deadline, exchange);
    if (status == TFA_E_DISCONNECTED && find_daemon(client, deadline))
        status = call_again(client, request, reply, deadline, exchange);
    return client->fallback.workspace ? tfa_client_compute(client, request, reply, exchange, status)
                                      : status;
}

int tfa_client_send(tfa_client *client, const tfa_request *request, uint64_t *id)
{
    if (!client || !request)
        return TFA_E_ARGUMENT;
    if (!client->connection.alive && !tfa_client_fail_over(client, tfa_clock_ns() + SEND_LOOK_NS))
        return TFA_E_DISCONNECTED;
    return send_request(client, request, tfa_wire_want(request, NULL), tfa_clock_ns(), 0, id, NULL);
}

/* The oldest request that was lost with an earlier connection. */
static int report_lost(tfa_client *client, tfa_reply *reply, tfa_exchange *exchange)
{
    if (exchange)
        exchange->id = client->lost;
    client->lost++;
    return reply->status = TFA_E_LOST;
}

int tfa_client_receive(tfa_client *client, tfa_reply *reply, uint64_t timeout_ns,
                       tfa_exchange *exchange)
{
    if (!client || !reply)
        return TFA_E_ARGUMENT;
    if (exchange)
        *exchange = (tfa_exchange){0};
    reply->field = TFA_FIELD_NONE;
    reply->index = reply->state = 0;
    reply->model = 0;
    if (client->lost != client->lost_end)
        return report_lost(client, reply, exchange);
    tfa_ring_client *ring = &client->connection.ring;
    if (!client->connection.alive)
        return reply->status = TFA_E_DISCONNECTED;
    if (ring->sent <= (ring->received > client->call_end ? ring->received : client->call_end))
        return reply->status = TFA_E_ARGUMENT; /* nothing was sent */
    const uint64_t deadline = deadline_of(tfa_clock_ns(), timeout_ns);
    int status = wait_reply(client, deadline);
    if (status == TFA_E_DISCONNECTED &&
        tfa_client_fail_over(client, sooner(deadline, connect_deadline(client))))
        return report_lost(client, reply, exchange);
    if (status != TFA_OK)
        return reply->status = status;
    const tfa_wire_request *sent =
        (const void *)(ring->requests + tfa_ring_request_offset(&ring->layout, ring->received));
    if (exchange)
        exchange->t_sent = sent->t_sent;
    return read_reply(client, reply, exchange);
}
