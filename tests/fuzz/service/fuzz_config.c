/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes as a configuration. It is read or refused with a line for each error;
 * what was read can be printed, read again, and prints the same.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "config/config.h"
#include "fuzz_service.h"

static config *read_text(const char *text, size_t size, char **errors)
{
    char path[32];
    size_t length = 0;
    config *c = NULL;
    const int fd = memfd_create("config", MFD_CLOEXEC);
    require(fd >= 0 && write(fd, text, size) == (ssize_t)size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    FILE *out = open_memstream(errors, &length);
    require(out != NULL);
    const int status = config_load(path, out, &c);
    fclose(out);
    require((c != NULL) == (status == TFA_OK));
    require((length == 0) == (status == TFA_OK));
    close(fd);
    return c;
}

static char *print(const config *c, size_t *size)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, size);
    require(out != NULL);
    config_dump(c, out);
    fclose(out);
    return text;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *errors = NULL, *more = NULL, reason[256];
    config *c = read_text((const char *)data, size, &errors);
    if (c) {
        size_t first_size, second_size;
        char *first = print(c, &first_size);
        config *again = read_text(first, first_size, &more);
        if (again) { /* paths of robots may not exist from elsewhere */
            char *second = print(again, &second_size);
            require(first_size == second_size && memcmp(first, second, first_size) == 0);
            require(!config_needs_restart(c, again, reason, sizeof reason));
            free(second);
        }
        config_free(again);
        free(first);
    }
    config_free(c);
    free(errors);
    free(more);
    return 0;
}
