/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page of latencies.
 */
#ifndef TOOLS_LATENCY_PAGE_PAGE_H
#define TOOLS_LATENCY_PAGE_PAGE_H

#include "latency/report/report.h"

/** A self-contained page. @return as latency_write_csv */
int latency_write_page(const char *path, const latency_session *session);

#endif
