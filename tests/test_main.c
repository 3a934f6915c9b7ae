/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The main of a test that has none.
 */
#include "test.h"

int main(void)
{
    return test_run(NULL, NULL);
}
