/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Copies a file into sealed memory: the checked bytes are the loaded bytes, independent of later
 * changes of the file.
 */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "specialised/specialised_internal.h"

#ifndef MFD_EXEC
#define MFD_EXEC 0x10u /* Linux 6.3: the file may hold code */
#endif

/* Opens the file behind all links; `at` gets its path and has room for PATH_MAX. */
static int open_trusted(const char *path, char *at, size_t *size, int *status,
                        struct error_text *err)
{
    struct stat s;
    const int file =
        realpath(path, at) ? open(at, O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK) : -1;
    if (file < 0) {
        *status = refuse(err, TFA_E_FILE, "'%s': %s", path, strerror(errno));
        return -1;
    }
    *status = check_ownership_of_file(file, at, geteuid(), err);
    if (*status == TFA_OK && (fstat(file, &s) != 0 || !S_ISREG(s.st_mode)))
        *status = refuse(err, TFA_E_FILE, "'%s' is no file", path);
    if (*status == TFA_OK && (s.st_size <= 0 || (size_t)s.st_size > TFA_SPECIALISED_FILE_MAX))
        *status = refuse(err, TFA_E_PARSE, "'%s' has %lld bytes, a kernel 1 to %zu", path,
                         (long long)s.st_size, TFA_SPECIALISED_FILE_MAX);
    if (*status == TFA_OK) {
        *size = (size_t)s.st_size;
        return file;
    }
    close(file);
    return -1;
}

static int memory_file(void)
{
    const int file = memfd_create("totalforce-kernel", MFD_CLOEXEC | MFD_ALLOW_SEALING | MFD_EXEC);
    if (file >= 0 || errno != EINVAL)
        return file;
    return memfd_create("totalforce-kernel", MFD_CLOEXEC | MFD_ALLOW_SEALING);
}

/* Copies `size` bytes, all of them. */
static int copy(int from, int to, size_t size)
{
    char block[65536];
    for (size_t done = 0; done < size;) {
        const size_t most = size - done < sizeof block ? size - done : sizeof block;
        const ssize_t got = pread(from, block, most, (off_t)done);
        if (got <= 0 || pwrite(to, block, (size_t)got, (off_t)done) != got)
            return -1;
        done += (size_t)got;
    }
    return 0;
}

/* Checks the copy, removes its trailer and seals it. */
static int check_copy(int copied, const char *path, size_t size, const tfa_model *model,
                      uint8_t digest[32], struct error_text *err)
{
    void *bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, copied, 0);
    if (bytes == MAP_FAILED)
        return refuse(err, TFA_E_SYSTEM, "'%s': mmap: %s", path, strerror(errno));
    const int status = checksum_trailer_check(path, bytes, size, model, err);
    if (status == TFA_OK)
        memcpy(digest, (const char *)bytes + size - 32, 32);
    munmap(bytes, size);
    if (status != TFA_OK)
        return status;
    if (ftruncate(copied, (off_t)(size - sizeof(struct checksum_trailer))) != 0 ||
        fcntl(copied, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
        return refuse(err, TFA_E_SYSTEM, "'%s': sealing memory: %s", path, strerror(errno));
    return TFA_OK;
}

int open_checked_copy(const char *path, const tfa_model *model, uint8_t digest[32], int *status,
                      struct error_text *err)
{
    char at[PATH_MAX];
    size_t size = 0;
    const int file = open_trusted(path, at, &size, status, err);
    if (file < 0)
        return -1;
    const int copied = memory_file();
    if (copied < 0 || ftruncate(copied, (off_t)size) != 0)
        *status = refuse(err, TFA_E_SYSTEM, "'%s': memory for a copy: %s", path, strerror(errno));
    else if (copy(file, copied, size) != 0)
        *status = refuse(err, TFA_E_FILE, "'%s' cannot be read to its end", path);
    else
        *status = check_copy(copied, path, size, model, digest, err);
    close(file);
    if (*status == TFA_OK)
        return copied;
    if (copied >= 0)
        close(copied);
    return -1;
}
