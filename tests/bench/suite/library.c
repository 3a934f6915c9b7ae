/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Several builds of one library in one process: each keeps its symbols to itself.
 */
#include "suite.h"

#include <dlfcn.h>
#include <stdio.h>

static int bind(struct library *l, const char *call, void *slot)
{
    void **out = slot;
    *out = dlsym(l->handle, call);
    return *out ? 0 : -1;
}

int library_open(struct library *l, const char *name, const char *path)
{
    int bad = 0;
    l->name = name;
    l->handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!l->handle) {
        fprintf(stderr, "bench_suite: %s\n", dlerror());
        return -1;
    }
#define BIND(call) bad |= bind(l, #call, &l->call);
    SUITE_CALLS(BIND)
    if (bad)
        fprintf(stderr, "bench_suite: %s: another library\n", path);
    const int missing = bad;
    SUITE_LATER_CALLS(BIND)
#undef BIND
    return missing ? -1 : 0;
}
