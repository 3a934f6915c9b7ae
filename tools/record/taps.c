/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Taps of a daemon: the order, the segments, the rings.
 */
#include "taps.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ipc/control_socket.h"
#include "recording.h"

#define ANSWER_MS 60000 /* the daemon's control thread yields to everything that computes */

/* ---- the order ---- */

/* One packet with two descriptors, within ANSWER_MS. @return its length, or -1 */
static ssize_t receive(int socket, char *text, size_t size, int descriptors[2])
{
    struct pollfd ready = {.fd = socket, .events = POLLIN};
    const int n = poll(&ready, 1, ANSWER_MS);
    if (n <= 0) {
        errno = n == 0 ? ETIMEDOUT : errno;
        return -1;
    }
    const ssize_t length = tfa_control_receive(socket, text, size, descriptors, 2);
    return length > 0 ? length : -1;
}

/* ---- the segments ---- */

static void *map_whole(int fd, int protection, size_t *size)
{
    struct stat info;
    if (fd < 0 || fstat(fd, &info) != 0 || info.st_size <= 0)
        return NULL;
    *size = (size_t)info.st_size;
    void *memory = mmap(NULL, *size, protection, MAP_SHARED, fd, 0);
    return memory == MAP_FAILED ? NULL : memory;
}

static int map_rings(taps *t, int fd)
{
    t->segment = map_whole(fd, PROT_READ | PROT_WRITE, &t->segment_bytes);
    if (!t->segment || t->segment_bytes < sizeof(tfa_tap_head))
        return 0;
    const tfa_tap_head *head = t->segment;
    if (head->magic != TFA_TAP_MAGIC || head->producers < 1 ||
        head->producers > TFA_TAP_PRODUCERS_MAX || !tfa_tap_size_valid(head->ring_bytes) ||
        t->segment_bytes != tfa_tap_segment_size(head->producers, head->ring_bytes))
        return 0;
    t->producers = head->producers;
    t->ring_bytes = head->ring_bytes;
    t->readers = calloc(t->producers, sizeof *t->readers);
    for (uint32_t k = 0; t->readers && k < t->producers; k++)
        t->readers[k] =
            (tfa_tap_reader){.words = tfa_tap_words_of(t->segment, k),
                             .bytes = tfa_tap_ring_of(t->segment, t->producers, t->ring_bytes, k),
                             .size = t->ring_bytes};
    return t->readers != NULL;
}

static int map_texts(taps *t, int fd)
{
    t->texts = map_whole(fd, PROT_READ, &t->texts_bytes);
    if (!t->texts || t->texts_bytes < sizeof(tfa_recording_description))
        return 0;
    const tfa_recording_description *d = taps_description(t);
    return d->settings_bytes <= TFA_RECORDING_SETTINGS_MAX &&
           d->urdf_bytes <= TFA_RECORDING_URDF_MAX &&
           t->texts_bytes == sizeof *d + tfa_recording_padded(d->settings_bytes) +
                                 tfa_recording_padded(d->urdf_bytes);
}

/* Gives the order and maps what comes back. @return whether; else `text` says why not */
static int begin(taps *t, const char *directory, const char *order, char *text, size_t size)
{
    char answer[512];
    int fds[2] = {-1, -1};
    const size_t length = strlen(order);
    *text = 0;
    t->socket = tfa_control_connect(directory);
    if (t->socket < 0)
        snprintf(text, size,
                 "no daemon answers in '%s' (%s): start one (totalforced FILE.yaml), or name its "
                 "runtime_dir with --runtime-dir",
                 directory, strerror(errno));
    else if (send(t->socket, order, length, MSG_NOSIGNAL) != (ssize_t)length ||
             receive(t->socket, answer, sizeof answer, fds) < 0)
        snprintf(text, size, "the daemon in '%s' does not answer: %s", directory, strerror(errno));
    else if (strncmp(answer, "ok", 2) != 0)
        snprintf(text, size, "%s", strncmp(answer, "error: ", 7) == 0 ? answer + 7 : answer);
    else if (!map_rings(t, fds[0]) || !map_texts(t, fds[1]))
        snprintf(text, size, "the daemon's taps are of another version, or cannot be mapped: %s",
                 strerror(errno));
    for (int i = 0; i < 2; i++)
        if (fds[i] >= 0)
            close(fds[i]);
    return !*text;
}

int taps_open(taps *t, const char *runtime_dir, const char *robot, unsigned mib, char *text,
              size_t size)
{
    char order[128];
    *t = (taps){.socket = -1};
    const int n = snprintf(order, sizeof order, "record %s %u", robot, mib);
    if (n < 0 || (size_t)n >= sizeof order || strchr(robot, ' ')) {
        snprintf(text, size, "robot '%.80s': no robot has such a name", robot);
        return -1;
    }
    char *directory = tfa_find_runtime_dir(runtime_dir, TFA_CONTROL_NAME);
    if (!directory)
        snprintf(text, size, "%s", strerror(ENOMEM));
    const int good = directory && begin(t, directory, order, text, size);
    free(directory);
    if (good)
        return 0;
    taps_close(t);
    return -1;
}

void taps_close(taps *t)
{
    if (t->socket >= 0)
        close(t->socket);
    if (t->segment)
        munmap(t->segment, t->segment_bytes);
    if (t->texts)
        munmap((void *)(uintptr_t)t->texts, t->texts_bytes);
    free(t->readers);
    *t = (taps){.socket = -1};
}

const tfa_recording_description *taps_description(const taps *t)
{
    return t->texts;
}

const char *taps_texts(const taps *t)
{
    return (const char *)t->texts + sizeof(tfa_recording_description);
}

/* ---- the rings ---- */

/* One producer's. @return records, or -1; *more: `take` wants more */
static int64_t drain_one(tfa_tap_reader *r, int (*take)(void *self, const tfa_tap_record *record),
                         void *self, int *more)
{
    const tfa_tap_record *record;
    int64_t records = 0;
    tfa_tap_look(r);
    while (*more && (record = tfa_tap_next(r)) != NULL) {
        if (record->bytes != r->found || !recording_is_record(record))
            return -1;
        *more = take(self, record);
        records++;
        tfa_tap_release(r, r->found);
    }
    return r->broken ? -1 : records;
}

int64_t taps_drain(taps *t, int (*take)(void *self, const tfa_tap_record *record), void *self)
{
    int64_t records = 0;
    int more = 1;
    for (uint32_t k = 0; k < t->producers && more; k++) {
        const int64_t n = drain_one(&t->readers[k], take, self, &more);
        if (n < 0)
            return -1;
        records += n;
    }
    return records;
}

int taps_wait(taps *t, int timeout_ms)
{
    struct pollfd ready = {.fd = t->socket, .events = POLLIN};
    if (poll(&ready, 1, timeout_ms) <= 0)
        return 0;
    const ssize_t n = recv(t->socket, t->reason, sizeof t->reason - 1, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return 0;
    t->reason[n > 0 ? n : 0] = 0;
    return 1;
}

uint64_t taps_dropped(const taps *t)
{
    uint64_t dropped = 0;
    for (uint32_t k = 0; k < t->producers; k++)
        dropped += tfa_tap_dropped(t->readers[k].words);
    return dropped;
}
