/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What makes a call cold. Data: another 64 MiB are written, more than the largest cache here, so
 * that what the call reads stands in memory. Code: every line of what the process has mapped to
 * execute is thrown out by name (CLFLUSH, on x86), for a walk over data need not reach what lies in
 * an instruction cache. Predictors of branches keep what they know.
 */
#include "suite.h"

#include <link.h>
#include <stdlib.h>
#include <string.h>

#define FLUSH_BYTES ((size_t)64 << 20)
#define LINE 64

#if defined(__x86_64__)
static void flush_segment(const struct dl_phdr_info *object, const ElfW(Phdr) * segment)
{
    const char *start = (const char *)object->dlpi_addr + segment->p_vaddr;
    for (size_t k = 0; k < segment->p_memsz; k += LINE)
        __builtin_ia32_clflush(start + k);
}

static int flush_object(struct dl_phdr_info *object, size_t size, void *context)
{
    (void)size;
    (void)context;
    if (strstr(object->dlpi_name, "vdso"))
        return 0;
    for (int k = 0; k < object->dlpi_phnum; k++)
        if (object->dlpi_phdr[k].p_type == PT_LOAD && object->dlpi_phdr[k].p_flags & PF_X)
            flush_segment(object, &object->dlpi_phdr[k]);
    return 0;
}
#endif

void flush_all(void)
{
    static volatile unsigned char *memory;
    if (!memory)
        memory = malloc(FLUSH_BYTES);
    for (size_t k = 0; memory && k < FLUSH_BYTES; k += LINE)
        memory[k]++;
#if defined(__x86_64__)
    (void)dl_iterate_phdr(flush_object, NULL);
    __builtin_ia32_mfence();
#endif
}
