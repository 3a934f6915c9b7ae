/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared memory without a name: a file of /dev/shm that never had one, or memfd.
 */
#include "segment.h"

#include <errno.h>
#include <fcntl.h>
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

static int allocate(tfa_segment *s, config_backend backend)
{
    if (ftruncate(s->fd, (off_t)s->size) != 0)
        return TFA_E_SYSTEM;
    int error;
    do
        error = posix_fallocate(s->fd, 0, (off_t)s->size);
    while (error == EINTR);
    if (error) {
        errno = error;
        return error == ENOSPC || error == ENOMEM ? TFA_E_MEMORY : TFA_E_SYSTEM;
    }
    if (backend == CONFIG_BACKEND_MEMFD &&
        fcntl(s->fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
        return TFA_E_SYSTEM;
    s->memory = mmap(NULL, s->size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, s->fd, 0);
    if (s->memory != MAP_FAILED)
        return TFA_OK;
    s->memory = NULL;
    return TFA_E_MEMORY;
}

int tfa_segment_create(config_backend backend, size_t size, tfa_segment *segment)
{
    *segment = TFA_SEGMENT_NONE;
    segment->size = size;
    int status = backend == CONFIG_BACKEND_MEMFD ? open_memfd(segment) : open_shm(segment);
    if (status == TFA_OK)
        status = allocate(segment, backend);
    if (status != TFA_OK) {
        const int saved = errno;
        tfa_segment_destroy(segment);
        errno = saved;
    }
    return status;
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
