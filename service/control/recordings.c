/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recorders: each has the taps of one robot, until it hangs up, the robot gets another model, or
 * the daemon ends. A robot has one recorder at a time.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "control/daemon.h"
#include "ipc/recording.h"
#include "platform/log.h"

/* ---- taps ---- */

static uint32_t producers_of(const tfa_daemon *d)
{
    return d->settings->workers + TFA_GATEWAY_SOURCES;
}

/* From now on answers are recorded; `taps` NULL: no more. */
static void set_taps(tfa_daemon *d, uint32_t robot, struct tfa_tap *taps)
{
    const uint32_t workers = d->settings->workers;
    for (uint32_t k = 0; k < workers; k++)
        tfa_worker_set_tap(d->workers[k].worker, robot, taps ? &taps[k] : NULL);
    for (const gateway_slot *g = NULL; (g = gateways_next(d, robot, g));)
        g->kind->set_tap(g->self, robot, taps ? &taps[workers + g->kind->source] : NULL);
}

static int make_taps(const tfa_daemon *d, uint64_t ring_bytes, recording *r)
{
    const uint32_t count = producers_of(d);
    const size_t size = tfa_tap_segment_size(count, ring_bytes);
    r->taps = aligned_alloc(TFA_CACHE_LINE, count * sizeof *r->taps);
    const int status = r->taps ? tfa_segment_create(CONFIG_BACKEND_MEMFD, TFA_SEGMENT_PEER_WRITES,
                                                    size, &r->segment)
                               : TFA_E_MEMORY;
    if (status != TFA_OK)
        return status;
    *(tfa_tap_head *)r->segment.memory =
        (tfa_tap_head){.magic = TFA_TAP_MAGIC, .producers = count, .ring_bytes = ring_bytes};
    for (uint32_t k = 0; k < count; k++)
        r->taps[k] = (tfa_tap){.words = tfa_tap_words_of(r->segment.memory, k),
                               .bytes = tfa_tap_ring_of(r->segment.memory, count, ring_bytes, k),
                               .size = ring_bytes,
                               .producer = (uint16_t)k};
    return TFA_OK;
}

static void free_recording(recording *r)
{
    tfa_segment_destroy(&r->segment);
    free(r->taps);
    free(r);
}

/* ---- the beginning ---- */

/* "ROBOT MIB". @return MiB of a ring; 0: it is no order */
static uint32_t parse_order(const char *order, char robot[TFA_ROBOT_NAME_MAX + 1])
{
    const char *space = strchr(order, ' ');
    const size_t length = space ? (size_t)(space - order) : 0;
    char *end;
    if (!length || length > TFA_ROBOT_NAME_MAX || space[1] < '1' || space[1] > '9')
        return 0;
    memcpy(robot, order, length);
    robot[length] = 0;
    const unsigned long mib = strtoul(space + 1, &end, 10);
    return *end == 0 && mib <= TFA_TAP_RING_MAX >> 20 && tfa_tap_size_valid((uint64_t)mib << 20)
               ? (uint32_t)mib
               : 0;
}

/* The robot of this name, if it may be recorded; otherwise UINT32_MAX and the error in `text`. */
static uint32_t find_robot(const tfa_daemon *d, const char *name, char *text, size_t size)
{
    const uint32_t i = robot_set_find(&d->robot_set, name, text, size);
    if (i != UINT32_MAX && d->robot_set.robots[i].reshaping) {
        snprintf(text, size, "error: a reload is changing robot '%s': ask again", name);
        return UINT32_MAX;
    }
    for (const recording *r = d->recordings; r; r = r->next)
        if (r->robot == i && r->socket >= 0) {
            snprintf(text, size, "error: robot '%s' is being recorded by process %d", name,
                     (int)r->process);
            return UINT32_MAX;
        }
    return i;
}

/* Hands the recorder its segments and continues with its socket. */
static bool hand_over(tfa_daemon *d, recording *r, const tfa_segment *description)
{
    const int descriptors[] = {r->segment.fd, description->fd_readonly};
    struct epoll_event event = {.events = EPOLLIN | EPOLLRDHUP, .data.ptr = r};
    return commands_send(r->socket, "ok: taps", descriptors, 2) &&
           epoll_ctl(d->epoll, EPOLL_CTL_MOD, r->socket, &event) == 0;
}

static pid_t peer_of(int socket)
{
    struct ucred peer;
    socklen_t size = sizeof peer;
    return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 ? peer.pid : 0;
}

bool recordings_begin(tfa_daemon *d, int socket, const char *order, char *text, size_t size)
{
    char name[TFA_ROBOT_NAME_MAX + 1];
    const uint32_t mib = parse_order(order, name);
    snprintf(text, size, "error: record ROBOT MIB; MIB a power of two, 1 to 256");
    const uint32_t robot = mib ? find_robot(d, name, text, size) : UINT32_MAX;
    const tfa_segment *description =
        robot == UINT32_MAX ? NULL : description_segment(d, robot, text, size);
    if (!description)
        return false;
    recording *r = calloc(1, sizeof *r);
    int status = TFA_E_MEMORY;
    if (r) {
        *r = (recording){.next = d->recordings,
                         .socket = socket,
                         .robot = robot,
                         .process = peer_of(socket),
                         .segment = TFA_SEGMENT_NONE};
        status = make_taps(d, (uint64_t)mib << 20, r);
    }
    if (status == TFA_OK && !hand_over(d, r, description))
        status = TFA_E_SYSTEM;
    if (status != TFA_OK) {
        snprintf(text, size, "error: taps of %u MiB for %u producers: %s", mib, producers_of(d),
                 tfa_status_text(status));
        if (r)
            free_recording(r);
        return false;
    }
    tfa_segment_close(&r->segment);
    d->recordings = r;
    set_taps(d, robot, r->taps);
    tfa_log(TFA_LOG_INFO, "robot '%s': process %d records", name, (int)r->process);
    return true;
}

/* ---- the end ---- */

/* No answer is recorded from now on; memory is released when no worker uses it any more. */
static void end_recording(tfa_daemon *d, recording *r, const char *reason)
{
    set_taps(d, r->robot, NULL);
    if (reason)
        (void)!send(r->socket, reason, strlen(reason), MSG_NOSIGNAL | MSG_DONTWAIT);
    close(r->socket);
    r->socket = -1;
    tfa_log(TFA_LOG_INFO, "robot '%s': process %d records no more%s%s",
            d->robot_set.robots[r->robot].name, (int)r->process, reason ? ": " : "",
            reason ? reason : "");
}

bool recordings_event(tfa_daemon *d, void *what)
{
    recording *r = d->recordings;
    char byte;
    while (r && r != what)
        r = r->next;
    if (!r)
        return false;
    const ssize_t n = r->socket >= 0 ? recv(r->socket, &byte, 1, MSG_DONTWAIT) : -1;
    if (r->socket >= 0 && (n >= 0 || (errno != EAGAIN && errno != EINTR)))
        end_recording(d, r, n > 0 ? "error: a recorder has nothing to say" : NULL);
    return true;
}

void recordings_end(tfa_daemon *d, uint32_t robot, const char *reason)
{
    for (recording *r = d->recordings; r; r = r->next)
        if (r->robot == robot && r->socket >= 0)
            end_recording(d, r, reason);
}

static bool workers_let_go(const tfa_daemon *d)
{
    for (uint32_t k = 0; k < d->settings->workers; k++)
        if (!tfa_worker_taps_are_taken(d->workers[k].worker))
            return false;
    return true;
}

bool recordings_any_ending(const tfa_daemon *d)
{
    for (const recording *r = d->recordings; r; r = r->next)
        if (r->socket < 0)
            return true;
    return false;
}

void recordings_tick(tfa_daemon *d)
{
    if (!recordings_any_ending(d) || !workers_let_go(d))
        return;
    for (recording **link = &d->recordings, *r; (r = *link);) {
        if (r->socket >= 0) {
            link = &r->next;
            continue;
        }
        *link = r->next;
        free_recording(r);
    }
}

void recordings_close(tfa_daemon *d)
{
    for (recording *r = d->recordings, *next; r; r = next) {
        next = r->next;
        if (r->socket >= 0) {
            static const char reason[] = "the daemon has ended";
            (void)!send(r->socket, reason, sizeof reason - 1, MSG_NOSIGNAL | MSG_DONTWAIT);
            close(r->socket);
        }
        free_recording(r);
    }
    d->recordings = NULL;
}
