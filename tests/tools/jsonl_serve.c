/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The loop around JSON lines with a peer of the test's own: every line gets one reply, in order,
 * within bounded memory, whatever the lines hold and whatever the peer does.
 */
#include "jsonl/jsonl_serve.h"

#include "test.h"

#include <errno.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *const joints[] = {"a", "b"};
static const char *const links[] = {"base", "tip"};
static const tfa_client_info info = {.q_count = 2,
                                     .v_count = 2,
                                     .joint_count = 2,
                                     .frame_count = 2,
                                     .joint_names = joints,
                                     .frame_names = links};

/* Answers tau = 2 qdd; gone for the lines that `gone` counts down. */
typedef struct backend {
    tfa_names names;
    int gone;
} backend;

static int prepare(void *self, const tfa_names **names, jsonl_error *error)
{
    backend *p = self;
    *names = &p->names;
    if (p->gone && p->gone--)
        return jsonl_fail(error, TFA_E_DISCONNECTED, "nobody there");
    return TFA_OK;
}

static int answer_request(void *self, const tfa_request *request, tfa_reply *reply)
{
    (void)self;
    reply->field = TFA_FIELD_NONE;
    if (request->op != TFA_OP_INVERSE_DYNAMICS)
        return TFA_E_UNSUPPORTED;
    for (int i = 0; i < 2; i++)
        reply->tau[i] = request->qdd ? 2 * request->qdd[i] : 0;
    *reply->answers = (tfa_answer){.method = TFA_METHOD_RNEA};
    return TFA_OK;
}

/* Serves what a child writes into a pipe; returns the replies. */
static char *serve_with(backend *p, void (*write_lines)(int out), jsonl_tally *tally, int want)
{
    int ends[2];
    char *text = NULL;
    size_t size = 0;
    const jsonl_defaults defaults = JSONL_DEFAULTS;
    assert_int_equal(tfa_names_of_info(&p->names, "robot", &info), TFA_OK);
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        close(ends[0]);
        write_lines(ends[1]);
        _exit(0);
    }
    close(ends[1]);
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    const jsonl_backend answerer = {.self = p, .prepare = prepare, .answer = answer_request};
    assert_int_equal(jsonl_serve(ends[0], out, &answerer, &defaults, tally), want);
    fclose(out);
    close(ends[0]);
    waitpid(child, NULL, 0);
    tfa_names_free(&p->names);
    return text;
}

static const char *lines_to_write;

static void put(int out, const char *bytes, size_t length)
{
    while (length) {
        ssize_t done = write(out, bytes, length);
        if (done <= 0)
            _exit(1);
        bytes += done;
        length -= (size_t)done;
    }
}

static void write_text(int out)
{
    put(out, lines_to_write, strlen(lines_to_write));
}

static void check(backend *p, const char *lines, const char *replies, uint64_t errors)
{
    jsonl_tally tally;
    lines_to_write = lines;
    char *text = serve_with(p, write_text, &tally, TFA_OK);
    assert_string_equal(text, replies);
    assert_int_equal(tally.errors, errors);
    free(text);
}

#define ASK "\"op\":\"inverse_dynamics\",\"q\":[0,0],\"qdd\":[1,2]}"
#define TOLD "\"status\":\"ok\",\"method\":\"rnea\",\"tau\":[2.0,4.0]}\n"

TEST(test_in_order)
{
    backend p = {0};
    check(&p, "{\"id\":1," ASK "\n{\"id\":\"two\"," ASK "\n{" ASK "\n",
          "{\"id\":1," TOLD "{\"id\":\"two\"," TOLD "{" TOLD, 0);
}

TEST(test_byte_order_mark)
{
    backend p = {0};
    check(&p, "\xef\xbb\xbf{\"id\":1," ASK "\n{\"id\":2," ASK "\n\xef\xbb\xbf{\"id\":3," ASK,
          "{\"id\":1," TOLD "{\"id\":2," TOLD "{\"id\":3," TOLD, 0);
}

TEST(test_bad_lines_in_between)
{
    backend p = {0};
    check(&p, "garbage\n\n{\"id\":[1]," ASK "\n{\"id\":9}\n{\"id\":3," ASK "\r\n",
          "{\"id\":null,\"status\":\"error\",\"error\":\"line 1, column 7: invalid token near "
          "'garbage'; one request a line, as `jq -c .` writes it\",\"code\":\"E_PARSE\"}\n"
          "{\"id\":null,\"status\":\"error\",\"error\":\"line 2: empty\",\"code\":\"E_PARSE\"}\n"
          "{\"id\":null,\"status\":\"error\",\"error\":\"id: must be a number or a string\","
          "\"code\":\"E_ARGUMENT\"}\n"
          "{\"id\":9,\"status\":\"error\",\"error\":\"op: missing; there are "
          "forward_dynamics, inverse_dynamics, operational_inertia, mass_matrix, kinematics, bias, "
          "task_torques, derivatives, inverse_dynamics_derivatives, constrained_dynamics, impact, "
          "constrained_inverse_dynamics, regressor\",\"code\":\"E_ARGUMENT\"}\n"
          "{\"id\":3," TOLD,
          4);
}

TEST(test_peer_refuses)
{
    backend p = {0};
    check(&p, "{\"id\":1,\"op\":\"mass_matrix\",\"q\":[0,0]}\n{\"id\":2," ASK "\n",
          "{\"id\":1,\"status\":\"error\",\"error\":\"mass_matrix of robot 'robot': not supported: "
          "this build or "
          "this robot cannot do that\",\"code\":\"E_UNSUPPORTED\"}\n{\"id\":2," TOLD,
          1);
}

TEST(test_peer_gone_and_back)
{
    backend p = {.gone = 2};
    check(&p, "{\"id\":1," ASK "\n{\"id\":2," ASK "\n{\"id\":3," ASK "\n",
          "{\"id\":1,\"status\":\"error\",\"error\":\"nobody there\",\"code\":\"E_DISCONNECTED\"}\n"
          "{\"id\":2,\"status\":\"error\",\"error\":\"nobody there\",\"code\":\"E_DISCONNECTED\"}\n"
          "{\"id\":3," TOLD,
          2);
}

TEST(test_last_line)
{
    backend p = {0};
    /* whole, without its newline: answered; half of one: told so; nothing: no reply */
    check(&p, "{\"id\":1," ASK, "{\"id\":1," TOLD, 0);
    check(&p, "{\"id\":1," ASK "\n{\"id\":2,\"op\":\"mass",
          "{\"id\":1," TOLD "{\"id\":null,\"status\":\"error\",\"error\":\"line 2, column 18: "
          "premature end of input near '\\\"mass'; one request a line, as `jq -c .` writes "
          "it\",\"code\":\"E_PARSE\"}\n",
          1);
    check(&p, "", "", 0);
}

static void write_huge(int out)
{
    static char block[1 << 20];
    memset(block, ' ', sizeof block);
    for (int i = 0; i < 200; i++)
        put(out, block, sizeof block);
    put(out, "\n{\"id\":2," ASK "\n", strlen("\n{\"id\":2," ASK "\n"));
}

TEST(test_huge_line)
{
    backend p = {0};
    jsonl_tally tally;
    struct rusage before, after;
    getrusage(RUSAGE_SELF, &before);
    char *text = serve_with(&p, write_huge, &tally, TFA_OK);
    getrusage(RUSAGE_SELF, &after);
    assert_string_equal(text, "{\"id\":null,\"status\":\"error\",\"error\":\"line 1: longer than "
                              "16777216 bytes\",\"code\":\"E_SIZE\"}\n{\"id\":2," TOLD);
    assert_int_equal(tally.lines, 2);
    /* 200 MB came in; twice the limit and some stayed at most (in KiB) */
    assert_true(after.ru_maxrss - before.ru_maxrss < 100 << 10);
    free(text);
}

static void write_garbage(int out)
{
    char line[512];
    uint32_t seed = 12345;
    for (int i = 0; i < 500; i++) {
        for (size_t k = 0; k < sizeof line; k++) {
            seed = seed * 1664525u + 1013904223u;
            line[k] = (char)(seed >> 24);
            if (line[k] == '\n')
                line[k] = '\0';
        }
        line[sizeof line - 1] = '\n';
        put(out, line, sizeof line);
    }
    put(out, "{\"id\":1," ASK "\n", strlen("{\"id\":1," ASK "\n"));
}

/* Every reply to random bytes is a JSON error of its own line. */
TEST(test_binary_garbage)
{
    backend p = {0};
    jsonl_tally tally;
    char *text = serve_with(&p, write_garbage, &tally, TFA_OK), *rest = text;
    assert_int_equal(tally.lines, 501);
    assert_int_equal(tally.errors, 500);
    for (int i = 0; i < 501; i++) {
        char *line = strsep(&rest, "\n");
        assert_non_null(line);
        json_t *reply = json_loads(line, 0, NULL);
        assert_non_null(reply);
        assert_string_equal(json_string_value(json_object_get(reply, "status")),
                            i < 500 ? "error" : "ok");
        json_decref(reply);
    }
    free(text);
}

TEST(test_reader_of_replies_gone)
{
    int in[2], out[2];
    backend p = {0};
    jsonl_tally tally;
    const jsonl_defaults defaults = JSONL_DEFAULTS;
    static const char line[] = "{" ASK "\n";
    signal(SIGPIPE, SIG_IGN);
    assert_int_equal(tfa_names_of_info(&p.names, "robot", &info), TFA_OK);
    assert_int_equal(pipe(in), 0);
    assert_int_equal(pipe(out), 0);
    put(in[1], line, sizeof line - 1);
    close(in[1]);
    close(out[0]);
    FILE *stream = fdopen(out[1], "w");
    assert_non_null(stream);
    const jsonl_backend answerer = {.self = &p, .prepare = prepare, .answer = answer_request};
    assert_int_equal(jsonl_serve(in[0], stream, &answerer, &defaults, &tally), TFA_E_SYSTEM);
    assert_int_equal(errno, EPIPE);
    fclose(stream);
    close(in[0]);
    tfa_names_free(&p.names);
}
