/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the files that change robots as trees of elements.
 */
#ifndef TESTS_FUZZ_TREE_HPP
#define TESTS_FUZZ_TREE_HPP

#include "random.h"

#include <tinyxml.h>

/* One tree with names that differ, numbers that are numbers; other faults stay. */
void repair_robot(TiXmlElement *root, struct random_source &c);

#endif
