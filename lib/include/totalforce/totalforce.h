/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * All public headers of libtotalforce. Reading order: status, description, report, model, dynamics.
 */
#ifndef TOTALFORCE_TOTALFORCE_H
#define TOTALFORCE_TOTALFORCE_H

#include <totalforce/advise.h>
#include <totalforce/batch_pool.h>
#include <totalforce/client.h>
#include <totalforce/close_loops.h>
#include <totalforce/configuration.h>
#include <totalforce/constraints.h>
#include <totalforce/description.h>
#include <totalforce/dynamics.h>
#include <totalforce/histogram.h>
#include <totalforce/limits.h>
#include <totalforce/model.h>
#include <totalforce/modes.h>
#include <totalforce/observer.h>
#include <totalforce/report.h>
#include <totalforce/specialised.h>
#include <totalforce/statistics.h>
#include <totalforce/status.h>
#include <totalforce/text.h>
#include <totalforce/version.h>

#endif
