/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Explores every execution of a subject that C17 admits, within small scenarios; then shows that a
 * weakened order or a wrong caller is found.
 *
 *   test_explorer ring | tap
 */
#include <stdio.h>
#include <string.h>

#include "litmus.h"
#include "subject.h"

int main(int argc, char **argv)
{
    const subject *s = argc == 2 && strcmp(argv[1], "ring") == 0  ? &ring_subject
                       : argc == 2 && strcmp(argv[1], "tap") == 0 ? &tap_subject
                                                                  : NULL;
    if (!s) {
        fputs("test_explorer ring | tap\n", stderr);
        return 3;
    }
    setvbuf(stdout, NULL, _IOLBF, 0);
    int failures = litmus_run();
    failures += scenarios_run(s);
    failures += mutations_run(s);
    printf("\n%s\n", failures ? "FAILED" : "no finding; every mutation found");
    return failures != 0;
}
