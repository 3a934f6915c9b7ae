/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robot descriptions on their way from the ROS 2 gateway's thread to a reload: of each robot the
 * newest waits, in memory of one text.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "control/daemon.h"

int descriptions_open(tfa_daemon *d)
{
    robot_descriptions *s = &d->descriptions;
    const size_t count = d->settings->robots_count;
    s->next = calloc(count, sizeof *s->next);
    s->last = calloc(count, sizeof *s->last);
    s->loaded = calloc(count, sizeof *s->loaded);
    s->not_before = calloc(count, sizeof *s->not_before);
    if (!s->next || !s->last || !s->loaded || !s->not_before)
        return TFA_E_MEMORY;
    s->count = count;
    s->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    return s->event < 0 ? TFA_E_SYSTEM : TFA_OK;
}

void descriptions_close(tfa_daemon *d)
{
    robot_descriptions *s = &d->descriptions;
    for (size_t i = 0; i < s->count; i++) {
        free(s->next[i]);
        free(s->last[i]);
        free(s->loaded[i]);
    }
    free(s->next);
    free(s->last);
    free(s->loaded);
    free(s->not_before);
    if (s->event >= 0)
        close(s->event);
    *s = (robot_descriptions){.event = -1, .mutex = PTHREAD_MUTEX_INITIALIZER};
}

/* Where memory is short the description is lost, and the model stays. */
void descriptions_receive(tfa_daemon *d, size_t robot, const char *text)
{
    robot_descriptions *s = &d->descriptions;
    const uint64_t one = 1;
    bool is_new = false;
    pthread_mutex_lock(&s->mutex);
    if (!s->last[robot] || strcmp(s->last[robot], text) != 0) {
        char *last = strdup(text), *next = strdup(text);
        is_new = last && next;
        free(is_new ? s->last[robot] : last);
        free(is_new ? s->next[robot] : next);
        if (is_new) {
            s->last[robot] = last;
            s->next[robot] = next;
        }
    }
    pthread_mutex_unlock(&s->mutex);
    if (is_new)
        (void)!write(s->event, &one, sizeof one); /* full: the event is there already */
}

char *descriptions_take(tfa_daemon *d, size_t *robot)
{
    robot_descriptions *s = &d->descriptions;
    const uint64_t now = control_clock();
    char *text = NULL;
    pthread_mutex_lock(&s->mutex);
    for (size_t i = 0; i < s->count && !text; i++) {
        if (now < s->not_before[i])
            continue;
        text = s->next[i];
        s->next[i] = NULL;
        *robot = i;
    }
    pthread_mutex_unlock(&s->mutex);
    return text;
}

void descriptions_rest(tfa_daemon *d, size_t robot)
{
    d->descriptions.not_before[robot] = control_clock() + DESCRIPTION_REST_NS;
}
