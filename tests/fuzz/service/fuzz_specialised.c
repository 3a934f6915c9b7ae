/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes as a specialised kernel. The checksum does not fit: refused with a
 * reason, and nothing of it runs.
 */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <totalforce/specialised.h>
#include <unistd.h>

#include "fuzz_service.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char path[64];
    char text[256] = "";
    tfa_specialised *specialised = NULL;
    if (!path[0])
        snprintf(path, sizeof path, "/tmp/tfa-fuzz-%d.so", (int)getpid());
    FILE *out = fopen(path, "w");
    require(out != NULL && fwrite(data, 1, size, out) == size && fclose(out) == 0);
    require(chmod(path, 0600) == 0);
    const int status = tfa_specialised_load(path, fuzz_model(), &specialised, text, sizeof text);
    require(status != TFA_OK && is_known_status(status) && specialised == NULL && text[0] != 0);
    unlink(path);
    return 0;
}
