/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tells the service manager how the daemon is; says nothing where there is none.
 */
#include "control/daemon.h"

#ifdef TFA_HAVE_SYSTEMD

#include <inttypes.h>
#include <systemd/sd-daemon.h>

void notify_ready(void)
{
    (void)sd_notify(0, "READY=1\nSTATUS=Answering");
}

void notify_reloading(void)
{
    (void)sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRIu64 "\nSTATUS=Answering, reloading",
                     control_clock() / 1000);
}

void notify_stopping(void)
{
    (void)sd_notify(0, "STOPPING=1\nSTATUS=Draining");
}

void notify_watchdog(void)
{
    (void)sd_notify(0, "WATCHDOG=1");
}

uint64_t notify_watchdog_ns(void)
{
    uint64_t us = 0;
    return sd_watchdog_enabled(0, &us) > 0 ? us * 1000 : 0;
}

#else

void notify_ready(void) {}

void notify_reloading(void) {}

void notify_stopping(void) {}

void notify_watchdog(void) {}

uint64_t notify_watchdog_ns(void)
{
    return 0;
}

#endif
