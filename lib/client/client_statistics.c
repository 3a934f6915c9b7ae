/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of a daemon: opens and maps them.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "client/client_statistics.h"

#include "client/client.h"

const char *tfa_client_kind_name(uint32_t kind)
{
    static const char *const names[] = {"", "shm", "dds", "ros2", "self-test"};
    return kind < sizeof names / sizeof *names ? names[kind] : "";
}

/* The header's counts describe a segment of exactly this size. They are copied: no process can
 * write them now, but a reader need not believe that. */
static int check_header(tfa_statistics *s, size_t size)
{
    const tfa_shared_header *h = s->memory;
    if (size < sizeof *h || h->magic != TFA_STATISTICS_MAGIC || h->abi != TFA_STATISTICS_ABI)
        return TFA_E_PROTOCOL;
    s->workers = h->workers;
    s->robots = h->robots;
    s->clients = h->clients;
    if (s->workers > TFA_STATISTICS_WORKERS_MAX || s->robots > TFA_STATISTICS_ROBOTS_MAX ||
        s->clients > TFA_STATISTICS_CLIENTS_MAX)
        return TFA_E_PROTOCOL;
    const tfa_statistics_layout layout =
        tfa_statistics_layout_of(s->workers, s->robots, s->clients);
    s->view = tfa_statistics_view_of(s->memory, &layout);
    return layout.bytes <= size ? TFA_OK : TFA_E_PROTOCOL;
}

int tfa_statistics_map(int descriptor, tfa_statistics **statistics)
{
    struct stat info;
    if (!statistics)
        return TFA_E_ARGUMENT;
    *statistics = NULL;
    if (fstat(descriptor, &info) != 0)
        return TFA_E_SYSTEM;
    if (info.st_size <= 0)
        return TFA_E_PROTOCOL;
    tfa_statistics *s = calloc(1, sizeof *s);
    if (!s)
        return TFA_E_MEMORY;
    s->size = (size_t)info.st_size;
    s->memory = mmap(NULL, s->size, PROT_READ, MAP_SHARED, descriptor, 0);
    if (s->memory == MAP_FAILED) {
        free(s);
        return TFA_E_SYSTEM;
    }
    const int status = check_header(s, s->size);
    if (status == TFA_OK)
        *statistics = s;
    else
        tfa_statistics_close(s);
    return status;
}

int tfa_statistics_open(const char *runtime_dir, int32_t timeout_ms, tfa_statistics **statistics)
{
    char text[256];
    int descriptor;
    if (!statistics)
        return TFA_E_ARGUMENT;
    *statistics = NULL;
    int status =
        tfa_daemon_ask(runtime_dir, "statistics", timeout_ms, text, sizeof text, &descriptor);
    if (status == TFA_E_REFUSED && *text) /* a daemon that does not know the command */
        status = TFA_E_PROTOCOL;
    if (status == TFA_OK)
        status = descriptor >= 0 ? tfa_statistics_map(descriptor, statistics) : TFA_E_PROTOCOL;
    const int saved = errno;
    if (descriptor >= 0)
        close(descriptor);
    errno = saved;
    return status;
}

void tfa_statistics_close(tfa_statistics *s)
{
    if (!s)
        return;
    munmap(s->memory, s->size);
    free(s);
}
