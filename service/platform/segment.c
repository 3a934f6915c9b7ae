/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared memory without a name: a file of /dev/shm that never had one, or memfd.
 */
#include "segment.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* A second descriptor of the same file, for readers only. */
static int open_readonly(tfa_segment *s)
{
    char path[32];
    snprintf(path, sizeof path, "/proc/self/fd/%d", s->fd);
    s->fd_readonly = open(path, O_RDONLY | O_CLOEXEC);
    return s->fd_readonly >= 0 ? TFA_OK : TFA_E_SYSTEM;
}

/* Where shm_open makes its objects; but one that never has a name cannot be opened by anybody else,
 * nor stay behind when the daemon is killed between making and unlinking it. */
static int open_shm(tfa_segment *s)
{
    s->fd = open("/dev/shm", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    return s->fd >= 0 ? open_readonly(s) : TFA_E_SYSTEM;
}

/* A memfd is born with mode 0777, and whoever holds a descriptor of it may reopen it for writing
 * through /proc: 0600 stops other users. Its size can be sealed, which POSIX shm cannot. */
static int open_memfd(tfa_segment *s)
{
    s->fd = memfd_create("totalforce", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (s->fd < 0 || fchmod(s->fd, 0600) != 0)
        return TFA_E_SYSTEM;
    return open_readonly(s);
}

static int reserve_memory(const tfa_segment *s)
{
    if (ftruncate(s->fd, (off_t)s->size) != 0)
        return TFA_E_SYSTEM;
    int error;
    do
        error = posix_fallocate(s->fd, 0, (off_t)s->size);
    while (error == EINTR);
    if (!error)
        return TFA_OK;
    errno = error;
    return error == ENOSPC || error == ENOMEM ? TFA_E_MEMORY : TFA_E_SYSTEM;
}

static int map_memory(tfa_segment *s, int protection)
{
    s->memory = mmap(NULL, s->size, protection, MAP_SHARED | MAP_POPULATE, s->fd, 0);
    if (s->memory != MAP_FAILED)
        return TFA_OK;
    s->memory = NULL;
    return TFA_E_MEMORY;
}

/* Our own mapping was made before: it stays writable. */
static int seal(const tfa_segment *s, tfa_segment_access access)
{
    const int writes = access == TFA_SEGMENT_PEER_READS ? F_SEAL_FUTURE_WRITE : 0;
    const int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL | writes;
    return fcntl(s->fd, F_ADD_SEALS, seals) == 0 ? TFA_OK : TFA_E_SYSTEM;
}

/* Releases a segment of which a step failed. @return status */
static int abandon(tfa_segment *segment, int status)
{
    const int saved = errno;
    tfa_segment_destroy(segment);
    errno = saved;
    return status;
}

int tfa_segment_create(config_backend backend, tfa_segment_access access, size_t size,
                       tfa_segment *segment)
{
    const bool memfd = backend == CONFIG_BACKEND_MEMFD;
    *segment = TFA_SEGMENT_NONE;
    segment->size = size;
    int status = memfd ? open_memfd(segment) : open_shm(segment);
    if (status == TFA_OK)
        status = reserve_memory(segment);
    if (status == TFA_OK)
        status = map_memory(segment, PROT_READ | PROT_WRITE);
    if (status == TFA_OK && memfd)
        status = seal(segment, access);
    return status == TFA_OK ? TFA_OK : abandon(segment, status);
}

static bool write_all(int fd, const void *bytes, size_t size)
{
    const char *at = bytes;
    while (size) {
        const ssize_t n = write(fd, at, size);
        if (n < 0 && errno != EINTR)
            return false;
        at += n > 0 ? n : 0;
        size -= n > 0 ? (size_t)n : 0;
    }
    return true;
}

int tfa_segment_create_constant(const void *bytes, size_t size, tfa_segment *segment)
{
    const int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
    *segment = TFA_SEGMENT_NONE;
    segment->size = size;
    int status = open_memfd(segment);
    if (status == TFA_OK && !write_all(segment->fd, bytes, size))
        status = errno == ENOSPC || errno == ENOMEM ? TFA_E_MEMORY : TFA_E_SYSTEM;
    if (status == TFA_OK && fcntl(segment->fd, F_ADD_SEALS, seals) != 0)
        status = TFA_E_SYSTEM;
    if (status == TFA_OK)
        status = map_memory(segment, PROT_READ);
    return status == TFA_OK ? TFA_OK : abandon(segment, status);
}

bool tfa_segment_was_resized(const tfa_segment *segment)
{
    struct stat info;
    const uint64_t page = (uint64_t)sysconf(_SC_PAGESIZE);
    return segment->fd >= 0 && fstat(segment->fd, &info) == 0 &&
           ((uint64_t)info.st_size != segment->size ||
            (uint64_t)info.st_blocks * 512 > segment->size + page);
}

void tfa_segment_close(tfa_segment *segment)
{
    if (segment->fd >= 0)
        close(segment->fd);
    if (segment->fd_readonly >= 0)
        close(segment->fd_readonly);
    segment->fd = segment->fd_readonly = -1;
}

void tfa_segment_destroy(tfa_segment *segment)
{
    tfa_segment_close(segment);
    if (segment->memory)
        munmap(segment->memory, segment->size);
    *segment = TFA_SEGMENT_NONE;
}
