/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * URDF text for the fuzzer: made from scratch, or by changing what there is element by element.
 */
#ifndef TESTS_FUZZ_GENERATE_HPP
#define TESTS_FUZZ_GENERATE_HPP

#include "random.h"

#include <string>

/* One of the values that parsers trip over. */
std::string hostile_value(struct random_source &c);

/* A number or three, as a robot may have them; hostile now and then. */
std::string plain_number(struct random_source &c);
std::string plain_vector(struct random_source &c);

/* A robot of 1 to 16 links, right in most respects. */
std::string generate_robot(struct random_source &c);

/*
 * `text` with one to four changes: elements swapped, duplicated, deleted, moved, renamed;
 * attributes made hostile or exchanged; links renamed, joints hung elsewhere. Empty if `text` is no
 * XML.
 */
std::string change_robot(const std::string &text, struct random_source &c);

/* The first robot with some of the links and joints of the second. Empty if one is no XML. */
std::string cross_robots(const std::string &first, const std::string &second,
                         struct random_source &c);

#endif
