/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Large and hostile files: the time they take is printed, the stack they need is small.
 */
#include "faults.h"
#include "test.h"
#include "urdf/urdf.h"

#include <pthread.h>
#include <stdbool.h>
#include <time.h>
#include <totalforce/model.h>

enum { CHAIN = 20000, STACK = 128 << 10 };

static double processor_time(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One load and compilation on a thread of its own. */
struct run {
    const char *text;
    size_t length;
    int parsed, compiled;
    double parse_time, compile_time;
    tfa_model_summary summary;
    char code[32]; /* of the first message */
};

static void *run_thread(void *argument)
{
    struct run *run = argument;
    tfa_report report = {0};
    tfa_description *d = NULL;
    tfa_model *model = NULL;
    double start = processor_time();
    run->parsed = tfa_urdf_parse(run->text, run->length, "f.urdf", &d, &report);
    double parsed = processor_time();
    run->parse_time = parsed - start;
    run->compiled = d ? tfa_model_create(d, NULL, &report, &model) : TFA_E_PARSE;
    run->compile_time = processor_time() - parsed;
    if (model)
        run->summary = tfa_model_summarise(model);
    snprintf(run->code, sizeof run->code, "%s", report.count > 0 ? report.messages[0].code : "");
    tfa_model_free(model);
    tfa_description_free(d);
    tfa_report_free(&report);
    return NULL;
}

/* A recursion over elements, links or joints cannot hide: a level has to do with a few bytes. */
static struct run run_on_small_stack(const char *text, size_t length)
{
    struct run run = {.text = text, .length = length};
    pthread_attr_t attributes;
    pthread_t thread;
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstacksize(&attributes, STACK), 0);
    assert_int_equal(pthread_create(&thread, &attributes, run_thread, &run), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
    return run;
}

static void put_link(FILE *out, int i)
{
    fprintf(out,
            "<link name=\"l%d\"><inertial><origin xyz=\"0 0 0.1\"/><mass value=\"1.5\"/>" INERTIA
            "</inertial></link>\n",
            i);
}

static void put_joint(FILE *out, int i)
{
    fprintf(out,
            "<joint name=\"j%d\" type=\"%s\"><origin xyz=\"0 0 0.2\"/><parent link=\"l%d\"/>"
            "<child link=\"l%d\"/><axis xyz=\"0 1 0\"/></joint>\n",
            i, i % 5 == 0 ? "fixed" : "continuous", i - 1, i);
}

/* A chain from the base to the tip or, backwards, with every child before its parent. */
static char *make_chain(bool backwards, size_t *length)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, length);
    assert_non_null(out);
    fputs("<robot name=\"chain\">\n", out);
    for (int i = 0; i < CHAIN; i++)
        put_link(out, backwards ? CHAIN - 1 - i : i);
    for (int i = 1; i < CHAIN; i++)
        put_joint(out, backwards ? CHAIN - i : i);
    fputs("</robot>\n", out);
    assert_int_equal(fclose(out), 0);
    return text;
}

TEST(test_chain)
{
    for (int backwards = 0; backwards < 2; backwards++) {
        size_t length = 0;
        char *text = make_chain(backwards, &length);
        struct run run = run_on_small_stack(text, length);
        print_message("chain of %d links%s: read in %.2f s, compiled in %.2f s\n", CHAIN,
                      backwards ? ", backwards" : "", run.parse_time, run.compile_time);
        assert_int_equal(run.parsed, TFA_OK);
        assert_int_equal(run.compiled, TFA_OK);
        assert_int_equal(run.summary.bodies, (CHAIN - 1) - (CHAIN - 1) / 5);
        assert_int_equal(run.summary.depth, run.summary.bodies);
        free(text);
    }
}

/* Fills 64 MiB with a repeated part. */
static char *fill(const char *part)
{
    size_t n = strlen(part);
    char *text = malloc(TFA_URDF_MAX_BYTES);
    assert_non_null(text);
    for (size_t at = 0; at < TFA_URDF_MAX_BYTES; at += n)
        memcpy(text + at, part, at + n <= TFA_URDF_MAX_BYTES ? n : TFA_URDF_MAX_BYTES - at);
    return text;
}

TEST(test_hostile_files)
{
    static const struct {
        const char *what, *part, *code;
    } files[] = {
        {"nested tags", "<a>", "too-deep"}, {"nested robots", "<robot name=\"r\">", "too-deep"},
        {"end tags", "</a>", "bad-xml"},    {"brackets", "<", "bad-xml"},
        {"quotes", "<a b=\"", "bad-xml"},   {"comments without end", "<!--", "bad-xml"},
        {"blanks", " ", "empty-file"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char *text = fill(files[i].part);
        struct run run = run_on_small_stack(text, TFA_URDF_MAX_BYTES);
        print_message("64 MiB of %s: %.2f s, %s\n", files[i].what, run.parse_time, run.code);
        assert_int_equal(run.parsed, TFA_E_PARSE);
        assert_string_equal(run.code, files[i].code);
        free(text);
    }
}

/* `count` times `part` between a good head and a good tail. */
static struct run run_repeated(const char *head, const char *part, size_t count, const char *tail)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    assert_non_null(out);
    fputs(head, out);
    for (size_t i = 0; i < count; i++)
        fputs(part, out);
    fputs(tail, out);
    assert_int_equal(fclose(out), 0);
    struct run run = run_on_small_stack(text, length);
    free(text);
    return run;
}

/* What takes quadratic time does not end here before the test's own limit. */
TEST(test_repetitions)
{
    static const struct {
        const char *what, *head, *part, *tail;
        int status;
    } files[] = {
        {"actuators", "<transmission>", "<actuator><drake:rotor_inertia value=\"1\"/></actuator>\n",
         "</transmission>", TFA_E_PARSE},
        {"visuals", "<link name=\"b\">", "<visual/>\n", "</link>", TFA_E_PARSE},
        {"inertials", "<link name=\"b\">", "<inertial/>\n", "</link>", TFA_E_PARSE},
        {"links of one name", "", "<link name=\"a\"/>\n", "", TFA_E_PARSE},
        {"roots", "", "<link name=\"b\"/><link name=\"c\"/>\n", "", TFA_E_PARSE},
        {"unknown elements", "", "<vendor/>\n", "", TFA_OK},
        {"misspelled elements", "", "<lnik/>\n", "", TFA_E_PARSE},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char head[128];
        char tail[128];
        snprintf(head, sizeof head, "<robot name=\"r\"><link name=\"a\"/>%s", files[i].head);
        snprintf(tail, sizeof tail, "%s</robot>", files[i].tail);
        struct run run = run_repeated(head, files[i].part, 49000, tail);
        print_message("49000 %s: %.2f s, %s\n", files[i].what, run.parse_time, run.code);
        assert_int_equal(run.parsed, files[i].status);
    }
}
