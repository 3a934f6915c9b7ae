/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Connection of a client: socket, HELLO and WELCOME, descriptors, mappings, names.
 */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "client/client.h"

#define NAMES_BYTES_MAX ((uint64_t)1 << 28)
#define BATCH_MAX (1u << 16)

/* ---- the socket ---- */

/* True if a daemon holds the lock of this runtime directory (tested without taking it) and has
 * opened its sockets. */
static bool daemon_is_ready(const char *runtime_dir)
{
    char path[sizeof(((struct sockaddr_un *)0)->sun_path) + sizeof TFA_LOCK_FILE];
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    snprintf(path, sizeof path, "%s/" TFA_LOCK_FILE, runtime_dir);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0)
        return false;
    char text[64] = "";
    bool ready = fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK &&
                 pread(fd, text, sizeof text - 1, 0) > 0 && strstr(text, TFA_LOCK_READY);
    close(fd);
    return ready;
}

static int connect_error(void)
{
    if (errno == ECONNREFUSED || errno == ENOENT || errno == ENOTDIR)
        return TFA_E_DISCONNECTED;
    if (errno == EACCES || errno == EPERM)
        return TFA_E_REFUSED;
    return errno == EAGAIN ? TFA_E_TIMEOUT : TFA_E_SYSTEM;
}

/* A daemon that gets no processor leaves its queue full: the kernel waits for room in it, and
 * reports EAGAIN when the socket's timeout for sending has passed. Then the socket does not block.
 * @return 0, or -1 with errno */
static int connect_until(int fd, const struct sockaddr_un *address, uint64_t deadline)
{
    int result;
    do {
        const uint64_t now = tfa_clock_ns(), least = 1000; /* no time at all would be no limit */
        const uint64_t left = deadline > now + least ? deadline - now : least;
        const struct timeval limit = {.tv_sec = (time_t)(left / 1000000000u),
                                      .tv_usec = (suseconds_t)(left % 1000000000u / 1000)};
        (void)setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
        result = connect(fd, (const struct sockaddr *)address, sizeof *address);
    } while (result != 0 && errno == EINTR);
    return result != 0 ? result : fcntl(fd, F_SETFL, O_NONBLOCK);
}

static int connect_robot(const tfa_client *client, int fd, const struct sockaddr_un *address,
                         uint64_t deadline)
{
    if (connect_until(fd, address, deadline) == 0)
        return TFA_OK;
    if (errno != ENOENT)
        return connect_error();
    if (!daemon_is_ready(client->runtime_dir))
        return TFA_E_DISCONNECTED;
    /* it may be ready only since then: its robots have their sockets now */
    if (connect_until(fd, address, deadline) == 0)
        return TFA_OK;
    return errno == ENOENT ? TFA_E_ROBOT : connect_error();
}

static int open_socket(const tfa_client *client, uint64_t deadline, int *out)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int length = snprintf(address.sun_path, sizeof address.sun_path, "%s/%s.sock",
                          client->runtime_dir, client->robot);
    if (length < 0 || (size_t)length >= sizeof address.sun_path)
        return TFA_E_ARGUMENT;
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return TFA_E_SYSTEM;
    int status = connect_robot(client, fd, &address, deadline);
    if (status != TFA_OK) {
        int saved = errno;
        close(fd);
        errno = saved;
        return status;
    }
    *out = fd;
    return TFA_OK;
}

static int send_hello(const tfa_client *client, int fd)
{
    tfa_hello hello = {.magic = TFA_HANDSHAKE_MAGIC,
                       .abi = TFA_HANDSHAKE_ABI,
                       .slots = client->options.slots,
                       .max_batch = client->options.max_batch,
                       .max_tips = client->options.max_tips,
                       .wait = (uint32_t)client->options.wait};
    memcpy(hello.robot, client->robot, strlen(client->robot));
    if (send(fd, &hello, sizeof hello, MSG_NOSIGNAL) == (ssize_t)sizeof hello)
        return TFA_OK;
    /* a full daemon sends its reason and hangs up without reading */
    return errno == EPIPE || errno == ECONNRESET ? TFA_OK : TFA_E_SYSTEM;
}

/* Extracts the descriptors of a message. @return how many; the kernel closes surplus ones */
static int receive_descriptors(struct msghdr *message, int *fds)
{
    int count = 0;
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS)
            continue;
        count = (int)((c->cmsg_len - CMSG_LEN(0)) / sizeof(int));
        memcpy(fds, CMSG_DATA(c), (size_t)count * sizeof(int));
    }
    return count;
}

static void close_all(const int *fds, int count)
{
    for (int i = 0; i < count; i++)
        if (fds[i] >= 0)
            close(fds[i]);
}

static _Thread_local char refusal[sizeof(((tfa_welcome *)0)->text)];

const char *tfa_connection_refusal(void)
{
    return refusal;
}

void tfa_connection_read_farewell(const client_connection *connection)
{
    tfa_welcome w;
    refusal[0] = 0;
    if (recv(connection->socket, &w, sizeof w, MSG_DONTWAIT) != (ssize_t)sizeof w ||
        w.magic != TFA_HANDSHAKE_MAGIC)
        return;
    memcpy(refusal, w.text, sizeof w.text);
    refusal[sizeof refusal - 1] = 0;
}

/* @return TFA_OK: there is something to read; TFA_E_TIMEOUT */
static int await_message(int fd, uint64_t deadline)
{
    struct pollfd ready = {.fd = fd, .events = POLLIN};
    int n;
    do {
        const uint64_t now = tfa_clock_ns(), left = deadline > now ? deadline - now : 0;
        const struct timespec timeout = {.tv_sec = (time_t)(left / 1000000000u),
                                         .tv_nsec = (long)(left % 1000000000u)};
        n = ppoll(&ready, 1, &timeout, NULL);
    } while (n < 0 && errno == EINTR);
    return n == 0 ? TFA_E_TIMEOUT : TFA_OK;
}

static int receive_welcome(int fd, uint64_t deadline, tfa_welcome *welcome, int *fds)
{
    union {
        char bytes[CMSG_SPACE(sizeof(int) * TFA_WELCOME_DESCRIPTORS)];
        struct cmsghdr align;
    } control;
    struct iovec part = {.iov_base = welcome, .iov_len = sizeof *welcome};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    if (await_message(fd, deadline) != TFA_OK)
        return TFA_E_TIMEOUT;
    ssize_t size = recvmsg(fd, &message, MSG_CMSG_CLOEXEC);
    if (size < 0 && errno == ECONNRESET) /* reported before the message, which is still there */
        size = recvmsg(fd, &message, MSG_CMSG_CLOEXEC);
    if (size == 0 || (size < 0 && (errno == ECONNRESET || errno == EPIPE)))
        return TFA_E_DISCONNECTED;
    if (size < 0)
        return TFA_E_SYSTEM;
    int count = receive_descriptors(&message, fds);
    welcome->model_hash[sizeof welcome->model_hash - 1] = 0;
    welcome->text[sizeof welcome->text - 1] = 0;
    memcpy(refusal, welcome->text, sizeof welcome->text);
    bool whole = (size_t)size == sizeof *welcome && !(message.msg_flags & (MSG_TRUNC | MSG_CTRUNC));
    int status = TFA_OK;
    if (!whole || welcome->magic != TFA_HANDSHAKE_MAGIC || welcome->abi != TFA_HANDSHAKE_ABI)
        status = TFA_E_PROTOCOL;
    else if (welcome->status != TFA_OK)
        status = welcome->status;
    else if (count != TFA_WELCOME_DESCRIPTORS)
        status = TFA_E_PROTOCOL;
    if (status != TFA_OK)
        close_all(fds, count);
    return status;
}

/* validation of the WELCOME */

static bool welcome_is_valid(const tfa_welcome *w)
{
    if (!tfa_ring_slots_valid(w->layout.slots) || w->shape.max_batch == 0 ||
        w->shape.max_batch > BATCH_MAX || w->shape.max_tips > TFA_MAX_TIPS ||
        w->shape.frames != w->frame_count || w->constraint_count > TFA_MAX_CONSTRAINTS ||
        w->names_bytes > NAMES_BYTES_MAX)
        return false;
    tfa_ring_layout ours = tfa_ring_layout_of(&w->shape, w->layout.slots);
    return memcmp(&ours, &w->layout, sizeof ours) == 0 && w->wait >= TFA_WAIT_SPIN &&
           w->wait <= TFA_WAIT_BLOCK;
}

/* A segment shorter than its layout would cause SIGBUS later. */
static void *map_segment(int fd, size_t size, int protection)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || (uint64_t)info.st_size < size)
        return NULL;
    void *memory = mmap(NULL, size, protection, MAP_SHARED | MAP_POPULATE, fd, 0);
    return memory == MAP_FAILED ? NULL : memory;
}

static int map_segments(const tfa_welcome *w, const int *fds, client_connection *c)
{
    c->requests =
        map_segment(fds[TFA_WELCOME_REQUESTS], w->layout.request_bytes, PROT_READ | PROT_WRITE);
    c->replies = map_segment(fds[TFA_WELCOME_REPLIES], w->layout.reply_bytes, PROT_READ);
    c->ring = (tfa_ring_client){.layout = w->layout,
                                .requests = c->requests,
                                .replies = c->replies,
                                .worker_status = c->replies,
                                .spin = w->wait == TFA_WAIT_SPIN};
    return c->requests && c->replies ? TFA_OK : TFA_E_MEMORY;
}

/* ---- names ---- */

static int split_names(client_names *n, uint32_t count, size_t text_bytes)
{
    const char *at = n->text, *end = n->text + text_bytes;
    for (uint32_t i = 0; i < count; i++) {
        const char *stop = memchr(at, 0, (size_t)(end - at));
        if (!stop)
            return TFA_E_PROTOCOL;
        n->strings[i] = at;
        at = stop + 1;
    }
    return TFA_OK;
}

static int read_names(const tfa_welcome *w, int fd, client_names **out)
{
    const size_t count = (size_t)w->joint_count + w->frame_count + w->constraint_count;
    const size_t bytes = (size_t)w->names_bytes;
    const size_t types = ((size_t)w->joint_count + w->shape.modes) * sizeof(uint32_t);
    if (bytes < types + count)
        return TFA_E_PROTOCOL;
    client_names *n = malloc(sizeof *n + count * sizeof n->strings[0] + bytes);
    if (!n)
        return TFA_E_MEMORY;
    n->older = NULL;
    n->bytes = bytes;
    n->types = (uint32_t *)(void *)(n->strings + count);
    n->text = (char *)n->types + types;
    memcpy(n->hash, w->model_hash, sizeof n->hash);
    int status = TFA_E_PROTOCOL;
    if (pread(fd, n->types, bytes, 0) == (ssize_t)bytes)
        status = split_names(n, (uint32_t)count, bytes - types);
    if (status != TFA_OK) {
        free(n);
        n = NULL;
    }
    *out = n;
    return status;
}

/* 1: same robot, whose old strings stay in use */
static bool same_names(const tfa_client *client, const client_names *n, const tfa_welcome *w)
{
    const client_names *old = client->names;
    return old && old->bytes == n->bytes && client->info.joint_count == w->joint_count &&
           client->info.frame_count == w->frame_count &&
           client->info.constraint_count == w->constraint_count &&
           memcmp(old->types, n->types, n->bytes) == 0;
}

static void store_names(tfa_client *client, client_names *n, const tfa_welcome *w)
{
    if (same_names(client, n, w)) {
        memcpy(client->names->hash, n->hash, sizeof n->hash);
        free(n);
        return;
    }
    n->older = client->names;
    client->names = n;
}

/* As tfa_model_tag: the first eight bytes of the hash. */
static uint64_t tag_of(const char *hash)
{
    char digits[17] = "";
    memcpy(digits, hash, 16);
    return strtoull(digits, NULL, 16);
}

static void fill_info(tfa_client *client, const tfa_welcome *w)
{
    const client_names *n = client->names;
    client->shape = w->shape;
    client->model = tag_of(w->model_hash);
    client->info = (tfa_client_info){
        .q_count = w->shape.q_count,
        .v_count = w->shape.v_count,
        .base_freedoms = w->shape.base_freedoms,
        .slots = w->layout.slots,
        .max_batch = w->shape.max_batch,
        .max_tips = w->shape.max_tips,
        .joint_count = w->joint_count,
        .frame_count = w->frame_count,
        .joint_names = n->strings,
        .joint_types = n->types,
        .frame_names = n->strings + w->joint_count,
        .mode_count = w->shape.modes,
        .mode_frames = n->types + w->joint_count,
        .constraint_count = w->constraint_count,
        .constraint_names = n->strings + w->joint_count + w->frame_count,
        .model_hash = n->hash,
        .wait = (tfa_wait)w->wait,
        .daemon_pid = w->daemon_pid,
    };
    client->spin_ns = client->options.spin_ns ? client->options.spin_ns : w->spin_ns;
}

/* 1: the robot has other array sizes than the program's buffers. States and tips are those of each
 * request, and no more of them are granted than at first (keep_grant). */
static bool robot_has_other_shape(const tfa_client *client, const tfa_welcome *w)
{
    return client->names != NULL &&
           (client->shape.q_count != w->shape.q_count ||
            client->shape.v_count != w->shape.v_count ||
            client->shape.base_freedoms != w->shape.base_freedoms ||
            client->shape.frames != w->shape.frames || client->shape.modes != w->shape.modes);
}

/* A program may have sized buffers by what the first daemon granted: later ones are asked for no
 * more. */
static void keep_grant(tfa_client *client, const tfa_welcome *w)
{
    if (client->names)
        return;
    client->options.max_batch = w->shape.max_batch;
    client->options.max_tips = w->shape.max_tips;
}

static int accept_welcome(tfa_client *client, const tfa_welcome *w, const int *fds, uint64_t model,
                          client_connection *c)
{
    client_names *names;
    if (!welcome_is_valid(w))
        return TFA_E_PROTOCOL;
    if (model && model != tag_of(w->model_hash))
        return TFA_E_MODEL;
    if (robot_has_other_shape(client, w))
        return TFA_E_SIZE;
    int status = map_segments(w, fds, c);
    if (status != TFA_OK)
        return status;
    status = read_names(w, fds[TFA_WELCOME_NAMES], &names);
    if (status != TFA_OK)
        return status;
    tfa_wire_reply_shape *reply_shapes =
        realloc(client->reply_shapes, w->layout.slots * sizeof *reply_shapes);
    if (!reply_shapes) {
        free(names);
        return TFA_E_MEMORY;
    }
    client->reply_shapes = reply_shapes;
    keep_grant(client, w);
    store_names(client, names, w);
    fill_info(client, w);
    return TFA_OK;
}

int tfa_connection_open(tfa_client *client, uint64_t deadline, uint64_t model)
{
    client_connection c = {.socket = -1, .doorbell = -1};
    int fds[TFA_WELCOME_DESCRIPTORS];
    tfa_welcome welcome = {0};
    refusal[0] = 0;
    int status = open_socket(client, deadline, &c.socket);
    if (status != TFA_OK)
        return status;
    status = send_hello(client, c.socket);
    if (status == TFA_OK)
        status = receive_welcome(c.socket, deadline, &welcome, fds);
    if (status != TFA_OK)
        goto err_socket;
    status = accept_welcome(client, &welcome, fds, model, &c);
    c.doorbell = fds[TFA_WELCOME_DOORBELL];
    close_all(fds, TFA_WELCOME_DOORBELL);
    if (status != TFA_OK)
        goto err_socket;
    c.alive = true;
    client->connection = c;
    return TFA_OK;

err_socket:;
    int saved = errno;
    tfa_connection_close(&c);
    errno = saved;
    return status;
}

void tfa_connection_close(client_connection *c)
{
    if (c->requests)
        munmap(c->requests, c->ring.layout.request_bytes);
    if (c->replies)
        munmap((void *)(uintptr_t)c->replies, c->ring.layout.reply_bytes);
    if (c->doorbell >= 0)
        close(c->doorbell);
    if (c->socket >= 0)
        close(c->socket);
    *c = (client_connection){.socket = -1, .doorbell = -1};
}
