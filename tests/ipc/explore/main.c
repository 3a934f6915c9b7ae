/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Explores every execution of the ring that C17 admits, within small scenarios; then shows that a
 * weakened order or a wrong caller is found.
 */
#include <stdio.h>

#include "parts.h"

int main(void)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    int failures = litmus_run();
    failures += scenarios_run();
    failures += mutations_run();
    printf("\n%s\n", failures ? "FAILED" : "no finding; every mutation found");
    return failures != 0;
}
