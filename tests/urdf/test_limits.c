/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Files at and beyond the limits: size, depth, counts, names, bytes that are no text, no file.
 */
#include "faults.h"
#include "test.h"
#include "urdf/urdf.h"

#include <errno.h>
#include <pthread.h>
#include <unistd.h>

static int parse_urdf(const char *text, size_t length, tfa_description **d, tfa_report *report)
{
    *report = (tfa_report){0};
    return tfa_urdf_parse(text, length, "f.urdf", d, report);
}

/* Parses and expects this one message, and the line that says how many there are. */
static void expect_error(const char *text, size_t length, int status, const char *message)
{
    tfa_report report;
    tfa_description *d = NULL;
    assert_int_equal(parse_urdf(text, length, &d, &report), status);
    assert_null(d);
    assert_int_equal(report.count, 2);
    assert_string_equal(report.messages[1].text, "robot: not loaded: 1 error");
    char got[1024];
    tfa_report_format(&report, 0, got, sizeof got);
    assert_string_equal(got, message);
    tfa_report_free(&report);
}

/* A chain of n links with continuous joints; release with free(). */
static char *make_chain(size_t n, size_t *length)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, length);
    assert_non_null(out);
    fputs("<robot name=\"chain\">\n", out);
    for (size_t i = 0; i < n; i++)
        fprintf(out, "<link name=\"l%zu\"/>\n", i);
    for (size_t i = 1; i < n; i++)
        fprintf(out,
                "<joint name=\"j%zu\" type=\"continuous\"><parent link=\"l%zu\"/>"
                "<child link=\"l%zu\"/></joint>\n",
                i, i - 1, i);
    fputs("</robot>\n", out);
    assert_int_equal(fclose(out), 0);
    return text;
}

typedef struct chain_run {
    const char *text;
    size_t length;
    int status;
    tfa_description *description;
    tfa_report report;
} chain_run;

static void *run_chain(void *argument)
{
    chain_run *run = argument;
    run->status = parse_urdf(run->text, run->length, &run->description, &run->report);
    return NULL;
}

/*
 * On a small stack a recursion over the tree is fatal, also one in a destructor: with a megabyte,
 * releasing urdfdom's model as it is crashes at this length.
 */
TEST(test_longest_chain)
{
    chain_run run = {0};
    char *text = make_chain(TFA_URDF_MAX_LINKS, &run.length);
    run.text = text;
    pthread_attr_t attributes;
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstacksize(&attributes, 512 << 10), 0);
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, &attributes, run_chain, &run), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
    assert_int_equal(run.status, TFA_OK);
    tfa_description *d = run.description;
    assert_int_equal(d->link_count, TFA_URDF_MAX_LINKS);
    assert_int_equal(d->joints[TFA_URDF_MAX_LINKS - 2].child, TFA_URDF_MAX_LINKS - 1);
    tfa_description_free(d);
    tfa_report_free(&run.report);
    free(text);
}

TEST(test_one_link_too_many)
{
    size_t length = 0;
    char *text = make_chain(TFA_URDF_MAX_LINKS + 1, &length);
    expect_error(text, length, TFA_E_PARSE,
                 "f.urdf:1: error: robot: the robot has 100001 links; at most 100000 are supported "
                 "[too-large]");
    free(text);
}

static char *repeat(const char *part, size_t n, const char *before, const char *after)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    assert_non_null(out);
    fputs(before, out);
    for (size_t i = 0; i < n; i++)
        fputs(part, out);
    fputs(after, out);
    assert_int_equal(fclose(out), 0);
    return text;
}

TEST(test_nesting)
{
    char *deep = repeat("<a>", 1000000, "", "");
    expect_error(deep, strlen(deep), TFA_E_PARSE,
                 "f.urdf:1: error: xml: more than 200 elements inside one another; flatten the "
                 "file [too-deep]");
    free(deep);
    char *hidden =
        repeat("<a>", 1000000, "<robot name=\"r\"><link name=\"a\"/><!--", "--></robot>");
    tfa_report report;
    tfa_description *d = NULL;
    assert_int_equal(parse_urdf(hidden, strlen(hidden), &d, &report), TFA_OK);
    tfa_description_free(d);
    tfa_report_free(&report);
    free(hidden);
}

/* <robot> is the first level, so TFA_URDF_MAX_DEPTH - 1 fit inside it. */
TEST(test_deepest)
{
    char *text = NULL;
    size_t length = 0;
    for (int beyond = 0; beyond < 2; beyond++) {
        FILE *out = open_memstream(&text, &length);
        assert_non_null(out);
        fputs("<robot name=\"r\"><link name=\"a\"/>", out);
        for (int i = 0; i < TFA_URDF_MAX_DEPTH - 1 + beyond; i++)
            fputs("<gazebo>", out);
        for (int i = 0; i < TFA_URDF_MAX_DEPTH - 1 + beyond; i++)
            fputs("</gazebo>", out);
        fputs("</robot>", out);
        assert_int_equal(fclose(out), 0);
        tfa_report report;
        tfa_description *d = NULL;
        assert_int_equal(parse_urdf(text, length, &d, &report), beyond ? TFA_E_PARSE : TFA_OK);
        tfa_description_free(d);
        tfa_report_free(&report);
        free(text);
    }
}

TEST(test_attributes)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    assert_non_null(out);
    fputs("<robot", out);
    for (int i = 0; i < 1000; i++)
        fprintf(out, " a%d=\"\"", i);
    fputs("/>", out);
    assert_int_equal(fclose(out), 0);
    expect_error(text, length, TFA_E_PARSE,
                 "f.urdf:1: error: xml: too many attributes; split the file [too-large]");
    free(text);
}

TEST(test_names)
{
    char *name = repeat("n", TFA_URDF_MAX_NAME, "<robot name=\"r\"><link name=\"", "\"/></robot>");
    tfa_report report;
    tfa_description *d = NULL;
    assert_int_equal(parse_urdf(name, strlen(name), &d, &report), TFA_OK);
    assert_int_equal(strlen(d->links[0].name), TFA_URDF_MAX_NAME);
    tfa_description_free(d);
    tfa_report_free(&report);
    free(name);
    name = repeat("n", TFA_URDF_MAX_NAME + 1, "<robot name=\"r\"><link name=\"", "\"/></robot>");
    expect_error(name, strlen(name), TFA_E_PARSE,
                 "f.urdf:1: error: robot: "
                 "name=\"nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn...\" of "
                 "<link> has 256 bytes; use at most 255 [long-name]");
    free(name);
}

/* A thousand times the same fault: listed a hundred times, counted once more. */
TEST(test_repeats)
{
    char *text = repeat("<link/>\n", 1000, "<robot name=\"r\">\n", "</robot>");
    tfa_report report;
    tfa_description *d = NULL;
    assert_int_equal(parse_urdf(text, strlen(text), &d, &report), TFA_E_PARSE);
    assert_int_equal(report.count, TFA_URDF_MAX_REPEATS + 2);
    assert_int_equal(report.messages[TFA_URDF_MAX_REPEATS].count, 900);
    assert_int_equal(report.errors, 1000);
    assert_string_equal(report.messages[TFA_URDF_MAX_REPEATS + 1].text,
                        "robot: not loaded: 1000 errors of 1 kind");
    assert_string_equal(report.messages[TFA_URDF_MAX_REPEATS].text,
                        "robot: 900 more messages of this kind are not listed");
    tfa_report_free(&report);
    free(text);
}

TEST(test_bytes)
{
    static const char nul[] = "<robot name=\"r\">\n<link name=\"a\0b\"/></robot>";
    tfa_report report;
    tfa_description *d = NULL;
    assert_int_equal(parse_urdf(nul, sizeof nul - 1, &d, &report), TFA_E_PARSE);
    assert_string_equal(report.messages[0].code, "bad-encoding");
    assert_int_equal(report.messages[0].line, 2);
    tfa_report_free(&report);

    unsigned char garbage[4096];
    uint32_t seed = 12345;
    for (size_t i = 0; i < sizeof garbage; i++) {
        seed = seed * 1664525u + 1013904223u;
        garbage[i] = (unsigned char)(seed >> 24);
    }
    for (size_t length = 0; length < sizeof garbage; length += 7) {
        assert_int_equal(parse_urdf((const char *)garbage, length, &d, &report), TFA_E_PARSE);
        tfa_report_free(&report);
    }
}

/* Every way to cut a good file off gives an error and reads nothing beyond the end. */
TEST(test_truncation)
{
    static const char good[] =
        "<?xml version=\"1.0\"?><!-- c --><robot name=\"r\"><link name=\"\xC3\xA9&#65;\"/>"
        "<gazebo><![CDATA[x]]></gazebo></robot>";
    for (size_t length = 0; length < sizeof good - 1; length++) {
        char *exact = malloc(length + 1); /* malloc: the address sanitizer knows its end */
        assert_non_null(exact);
        memcpy(exact, good, length);
        exact = realloc(exact, length ? length : 1);
        assert_non_null(exact);
        tfa_report report;
        tfa_description *d = NULL;
        assert_int_equal(parse_urdf(exact, length, &d, &report), TFA_E_PARSE);
        assert_null(d);
        tfa_report_free(&report);
        free(exact);
    }
}

TEST(test_size)
{
    size_t most = TFA_URDF_MAX_BYTES;
    char *text = malloc(most + 1);
    assert_non_null(text);
    memset(text, ' ', most + 1);
    static const char good[] = "<robot name=\"r\"><link name=\"a\"/></robot>";
    memcpy(text, good, sizeof good - 1);
    tfa_report report;
    tfa_description *d = NULL;
    assert_int_equal(parse_urdf(text, most, &d, &report), TFA_OK);
    tfa_description_free(d);
    tfa_report_free(&report);
    expect_error(text, most + 1, TFA_E_FILE,
                 "f.urdf: error: file: more than 64 MiB; is it a URDF file? [too-large]");
    free(text);
}

static void expect_unreadable(const char *path, int error)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_load(path, &d, &report), TFA_E_FILE);
    assert_int_equal(errno, error);
    assert_null(d);
    assert_int_equal(report.errors, 1);
    assert_string_equal(report.messages[0].code, "unreadable");
    assert_string_equal(report.file, path);
    tfa_report_free(&report);
}

TEST(test_files)
{
    expect_unreadable("/nowhere/at-all.urdf", ENOENT);
    expect_unreadable("/", EISDIR);
    char path[] = "/tmp/tfa-urdf-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_load(path, &d, &report), TFA_E_PARSE);
    assert_string_equal(report.messages[0].code, "empty-file");
    tfa_report_free(&report);
    static const char good[] = "<robot name=\"r\"><link name=\"a\"/></robot>";
    assert_int_equal(write(file, good, sizeof good - 1), sizeof good - 1);
    assert_int_equal(tfa_urdf_load(path, &d, &report), TFA_OK);
    assert_int_equal(d->link_count, 1);
    tfa_description_free(d);
    tfa_report_free(&report);
    assert_int_equal(ftruncate(file, (off_t)TFA_URDF_MAX_BYTES + 1), 0);
    assert_int_equal(tfa_urdf_load(path, &d, &report), TFA_E_FILE);
    assert_string_equal(report.messages[0].code, "too-large");
    tfa_report_free(&report);
    close(file);
    unlink(path);
}

TEST(test_arguments)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_load(NULL, &d, &report), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_load("x", NULL, &report), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_load("x", &d, NULL), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_parse(NULL, 1, "x", &d, &report), TFA_E_ARGUMENT);
    tfa_description_free(NULL);
}
