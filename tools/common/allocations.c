/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Counts the allocations of each thread.
 */
#include "allocations.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>

/* Sanitizers have an allocator of their own; other C libraries no names to pass on to. */
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) ||                         \
    __has_feature(memory_sanitizer)
#define SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(SANITIZED) ||         \
    !defined(__GLIBC__)

int64_t allocations_count(void)
{
    return -1;
}

#else

/* glibc's allocator by its other names */
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

static _Thread_local int64_t count __attribute__((tls_model("initial-exec")));

#define REPLACES __attribute__((visibility("default"), used))

REPLACES void *malloc(size_t size)
{
    count++;
    return __libc_malloc(size);
}

REPLACES void *calloc(size_t number, size_t size)
{
    count++;
    return __libc_calloc(number, size);
}

REPLACES void *realloc(void *memory, size_t size)
{
    count++;
    return __libc_realloc(memory, size);
}

REPLACES void *aligned_alloc(size_t alignment, size_t size)
{
    count++;
    return __libc_memalign(alignment, size);
}

REPLACES int posix_memalign(void **memory, size_t alignment, size_t size)
{
    if (alignment % sizeof(void *) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0)
        return EINVAL;
    void *made = aligned_alloc(alignment, size);
    if (!made)
        return ENOMEM;
    *memory = made;
    return 0;
}

int64_t allocations_count(void)
{
    return count;
}

#endif
