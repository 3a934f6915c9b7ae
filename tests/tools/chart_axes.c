/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Axes of time: two to twelve numbers on every one of them.
 */
#include "chart/chart.h"
#include "test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Labels of the first axis in what chart_set_times writes: those listed, or one a decade */
static int count_labels(const char *text, double low, double high)
{
    const char *list = strstr(text, "time_tics[1] = '(");
    if (!list)
        return (int)(floor(log10(high)) - ceil(log10(low))) + 1;
    const char *at = list + strlen("time_tics[1] = '(");
    int count = *at != ')';
    for (; *at != ')'; at++)
        count += *at == ',';
    return count;
}

static double value_of(const char *text, const char *name)
{
    const char *at = strstr(text, name);
    assert_non_null(at);
    return strtod(at + strlen(name), NULL);
}

/* Fails unless the axis of times from low to high has labels enough. */
static void check_axis(double low, double high)
{
    const chart_range times = {.low = low, .high = high};
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    chart_set_times(out, &times, 1);
    assert_int_equal(fclose(out), 0);
    const int labels =
        count_labels(text, value_of(text, "low_time[1] = "), value_of(text, "high_time[1] = "));
    if (labels < 2 || labels > 12)
        fail_msg("%d labels from %g to %g: %s", labels, low, high, text);
    free(text);
}

TEST(every_axis_has_labels)
{
    for (double low = 0.1; low < 1.0; low *= 1.1)
        for (double ratio = 1.0; ratio < 1e6; ratio *= 1.07)
            check_axis(low, low * ratio);
}
