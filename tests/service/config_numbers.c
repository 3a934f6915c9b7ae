/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Numbers of the configuration are read whole or refused: every numeric key of the table of keys,
 * good spellings and bad ones. The keys come from the table itself, so that a new one is tested
 * from its first day.
 */
#include "config/config_table.h"
#include "test.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

enum { DEPTH_MAX = 6 };

/* A numeric key: the rows from the top of the file down to it. */
typedef struct numeric_key {
    const config_row *rows[DEPTH_MAX];
    size_t depth;
    config_kind kind;
    double low, high;
    char path[160]; /* as messages name it */
} numeric_key;

typedef void (*visitor)(const numeric_key *key);

static unsigned visited;

static void visit_table(const config_table *table, numeric_key *key, visitor visit)
{
    const size_t length = strlen(key->path);
    for (const config_row *row = table->rows; row->key; row++) {
        const config_kind kind = row->kind == CONFIG_LIST && !row->table ? row->entry : row->kind;
        assert_true(key->depth < DEPTH_MAX);
        key->rows[key->depth++] = row;
        snprintf(key->path + length, sizeof key->path - length, "%s%s%s", length ? "." : "",
                 row->key, row->kind == CONFIG_LIST ? "[0]" : "");
        if (row->table) {
            visit_table(row->table, key, visit);
        } else if (kind == CONFIG_COUNT || kind == CONFIG_NUMBER) {
            const bool entry = row->kind == CONFIG_LIST;
            key->kind = kind;
            key->low = !entry ? row->low : kind == CONFIG_COUNT ? 0 : -HUGE_VAL;
            key->high = !entry ? row->high : kind == CONFIG_COUNT ? UINT32_MAX : HUGE_VAL;
            visit(key);
            visited++;
        }
        key->depth--;
        key->path[length] = 0;
    }
}

static void visit_all(visitor visit, unsigned at_least)
{
    numeric_key key = {.depth = 0};
    visited = 0;
    visit_table(&config_top, &key, visit);
    assert_true(visited >= at_least);
}

/* ---- a configuration with one number in it ---- */

/* What a required key has where it is not what the test is about. */
static const char *sample(const config_row *row)
{
    if (row->kind == CONFIG_NUMBER || row->kind == CONFIG_COUNT)
        return "1";
    if (strcmp(row->key, "urdf") == 0)
        return "\"" TFA_SOURCE_DIR "/config/robots/arm7.urdf\"";
    return "x";
}

/* The number that is written, below which rows it stands, and where it came to stand. */
typedef struct file_writer {
    const numeric_key *key;
    const char *value;
    FILE *out;
    long at;
} file_writer;

static void write_table(file_writer *w, const config_table *table, bool chosen, size_t level,
                        int indent);

static void write_scalars(file_writer *w, const config_row *row, bool chosen)
{
    fputs(row->kind == CONFIG_LIST ? "[" : "", w->out);
    if (chosen)
        w->at = ftell(w->out);
    fputs(chosen ? w->value : sample(row), w->out);
    for (unsigned k = 1; row->kind == CONFIG_LIST && k < row->low; k++)
        fputs(", 1", w->out);
    fputs(row->kind == CONFIG_LIST ? "]\n" : "\n", w->out);
}

static void write_table(file_writer *w, const config_table *table, bool chosen, size_t level,
                        int indent)
{
    for (const config_row *row = table->rows; row->key; row++) {
        const bool here = chosen && level < w->key->depth && w->key->rows[level] == row;
        if (!row->required && !here)
            continue;
        fprintf(w->out, "%*s%s: ", indent, "", row->key);
        if (row->kind == CONFIG_GROUP && !here) {
            fputs("{}\n", w->out); /* no key in it is required */
        } else if (row->table) {
            fprintf(w->out, row->kind == CONFIG_LIST ? "\n%*s-\n" : "\n", indent, "");
            write_table(w, row->table, here, level + 1, indent + 2);
        } else {
            write_scalars(w, row, here);
        }
    }
}

typedef struct written {
    char name[32];
    size_t line, column; /* of the value */
} written;

static written write_file(const numeric_key *key, const char *value, size_t length)
{
    written w = {.name = "/tmp/tfa-numbers-XXXXXX"};
    char *text = NULL;
    size_t size = 0;
    file_writer writer = {.key = key, .value = "@", .out = open_memstream(&text, &size)};
    write_table(&writer, &config_top, true, 0, 0);
    fclose(writer.out);
    const long at = writer.at;
    w.line = w.column = 1;
    for (long k = 0; k < at; k++) {
        w.column = text[k] == '\n' ? 1 : w.column + 1;
        w.line += text[k] == '\n';
    }
    const int fd = mkstemp(w.name);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, (size_t)at), at);
    assert_int_equal(write(fd, value, length), length);
    assert_int_equal(write(fd, text + at + 1, size - (size_t)at - 1), size - (size_t)at - 1);
    close(fd);
    free(text);
    return w;
}

/* The number of a key in what was read. */
static double number_at(const config *c, const numeric_key *key)
{
    const char *in = (const char *)c;
    for (size_t k = 0; k < key->depth; k++) {
        const config_row *row = key->rows[k];
        in += row->at;
        if (row->kind == CONFIG_LIST)
            in = *(const char *const *)(const void *)in;
    }
    return key->kind == CONFIG_COUNT ? *(const uint32_t *)(const void *)in
                                     : *(const double *)(const void *)in;
}

static int load(const char *name, char **errors, config **c)
{
    size_t size = 0;
    FILE *stream = open_memstream(errors, &size);
    const int status = config_load(name, stream, c);
    fclose(stream);
    return status;
}

/* ---- bad spellings ---- */

enum { WHOLE = 1, REAL = 2, ANY = WHOLE | REAL };

static const struct {
    const char *yaml;
    size_t length; /* 0: up to its NUL */
    unsigned kinds;
    const char *value, *remedy; /* what the message shows and says; "": nothing in particular */
} bad[] = {
    {"2,5", 0, ANY, "'2,5'", ""},
    {"'2,5'", 0, REAL, "'2,5'", "write 2.5"},
    {"'-9,81'", 0, REAL, "'-9,81'", "write -9.81"},
    {"1e9", 0, WHOLE, "'1e9'", "write 1000000000"},
    {"1.5", 0, WHOLE, "'1.5'", ""},
    {"2.0", 0, WHOLE, "'2.0'", "write 2"},
    {"010", 0, ANY, "'010'", "write 10"},
    {"0x10", 0, ANY, "'0x10'", "write 16"},
    {"0o17", 0, ANY, "'0o17'", ""},
    {"0b11", 0, ANY, "'0b11'", ""},
    {"+5", 0, WHOLE, "'+5'", "write 5"},
    {"1_000", 0, ANY, "'1_000'", "write 1000"},
    {"5 kg", 0, ANY, "'5 kg'", "write 5"},
    {"5kg", 0, ANY, "'5kg'", "write 5"},
    {"1:30", 0, ANY, "'1:30'", ""},
    {"\"\"", 0, ANY, "''", ""},
    {"", 0, ANY, "", ""},
    {"~", 0, ANY, "'~'", ""},
    {"null", 0, ANY, "'null'", ""},
    {"nan", 0, ANY, "'nan'", ""},
    {".nan", 0, ANY, "'.nan'", ""},
    {".inf", 0, ANY, "'.inf'", ""},
    {"inf", 0, ANY, "'inf'", ""},
    {"1e400", 0, ANY, "'1e400'", ""},
    {"1e-400", 0, ANY, "'1e-400'", ""},
    {"-1", 0, WHOLE, "'-1'", ""},
    {"4294967296", 0, WHOLE, "'4294967296'", ""},
    {"4294967297", 0, WHOLE, "'4294967297'", ""},
    {"18446744073709551617", 0, WHOLE, "'18446744073709551617'", ""},
    {"1 2", 0, ANY, "'1 2'", ""},
    {"\"1 \"", 0, ANY, "'1 '", "write 1"},
    {"\"1\\n\"", 0, ANY, "'1", "write 1"},
    {"\"1\\0\"", 0, ANY, "'1", ""},
    {"--1", 0, ANY, "'--1'", ""},
    {"1e", 0, ANY, "'1e'", ""},
    {"1e+", 0, ANY, "'1e+'", ""},
    {"one", 0, ANY, "'one'", ""},
    {"true", 0, ANY, "'true'", ""},
    {"[1]", 0, ANY, "", "a list"},
    {"{a: 1}", 0, ANY, "", "keys"},
};

static const char *expected_kind(const numeric_key *key)
{
    return key->kind == CONFIG_COUNT ? "whole number" : "number";
}

/* In a list without quotes "2,5" is two entries, and "" none: the list is wrong, not the number. */
static bool is_of_list(const numeric_key *key, size_t i)
{
    return key->rows[key->depth - 1]->kind == CONFIG_LIST &&
           (strcmp(bad[i].yaml, "2,5") == 0 || bad[i].yaml[0] == 0);
}

/* The message stands at the value, names key and value, and says what is expected. */
static void check_message(const numeric_key *key, const written *w, size_t i, const char *errors)
{
    char location[256], range[80] = "";
    const char *remedy = bad[i].remedy, *kind = expected_kind(key);
    snprintf(location, sizeof location, "%s:%zu:%zu: %s: ", w->name, w->line, w->column, key->path);
    if (bad[i].yaml[0] == 0) /* an empty value stands where its key ends */
        snprintf(location, sizeof location, "%s:%zu:%zu: %s: ", w->name, w->line, w->column - 1,
                 key->path);
    if (isfinite(key->high))
        snprintf(range, sizeof range, "from %.10g to %.10g", key->low, key->high);
    if (strncmp(remedy, "write ", 6) == 0 &&
        !(atof(remedy + 6) >= key->low && atof(remedy + 6) <= key->high))
        remedy = ""; /* what was meant is out of range, too */
    if (strncmp(errors, location, strlen(location)) != 0 || !strstr(errors, bad[i].value) ||
        !strstr(errors, remedy) || !strstr(errors, kind) || !strstr(errors, range))
        fail_msg("%s: %s: %s    should be at %s, show %s, and say '%s', '%s' and '%s'", key->path,
                 bad[i].yaml, errors, location, bad[i].value, kind, range, remedy);
}

static void refuse_bad(const numeric_key *key)
{
    const unsigned kind = key->kind == CONFIG_COUNT ? WHOLE : REAL;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        config *c = NULL;
        char *errors = NULL;
        if (!(bad[i].kinds & kind) || is_of_list(key, i))
            continue;
        const written w = write_file(key, bad[i].yaml, strlen(bad[i].yaml));
        const int status = load(w.name, &errors, &c);
        unlink(w.name);
        if (status != TFA_E_PARSE)
            fail_msg("%s: %s is read as %.17g", key->path, bad[i].yaml, number_at(c, key));
        check_message(key, &w, i, errors);
        free(errors);
    }
}

TEST(bad_spellings_are_refused)
{
    visit_all(refuse_bad, 27);
}

/* ---- out of range ---- */

static void refuse_beyond(const numeric_key *key)
{
    const double step = key->kind == CONFIG_COUNT ? 1 : 1e-3;
    const double values[] = {key->low - step, key->high + step};
    for (size_t i = 0; i < 2 && isfinite(key->high); i++) {
        char text[40], *errors;
        config *c = NULL;
        snprintf(text, sizeof text, "%.17g", values[i]);
        const written w = write_file(key, text, strlen(text));
        const int status = load(w.name, &errors, &c);
        unlink(w.name);
        if (status != TFA_E_PARSE)
            fail_msg("%s: %s is taken", key->path, text);
        free(errors);
    }
}

TEST(out_of_range_is_refused)
{
    visit_all(refuse_beyond, 27);
}

/* ---- good spellings ---- */

static const struct {
    const char *yaml;
    double value;
    unsigned kinds;
} good[] = {
    {"0", 0, ANY},
    {"1", 1, ANY},
    {"7", 7, ANY},
    {"64", 64, ANY},
    {"\"64\"", 64, ANY},
    {"'2'", 2, ANY},
    {"50000", 50000, ANY},
    {"1000", 1000, ANY},
    {"4294967295", 4294967295.0, WHOLE},
    {"0.1", 0.1, REAL},
    {"-0.25", -0.25, REAL},
    {"1e-3", 1e-3, REAL},
    {"2.5E+2", 250, REAL},
    {".5", 0.5, REAL},
    {"5.", 5, REAL},
    {"+5", 5, REAL},
    {"-9.80665", -9.80665, REAL},
    {"0.00000000000000000001", 1e-20, REAL},
    {"3.1415926535897932384626433832795", 3.1415926535897932384626433832795, REAL},
};

/* What is read is the value that is written, and so is what --dump-config prints of it. */
static void take_good(const numeric_key *key)
{
    const unsigned kind = key->kind == CONFIG_COUNT ? WHOLE : REAL;
    unsigned taken = 0;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        config *c = NULL;
        char *errors;
        if (!(good[i].kinds & kind) || good[i].value < key->low || good[i].value > key->high)
            continue;
        written w = write_file(key, good[i].yaml, strlen(good[i].yaml));
        const int status = load(w.name, &errors, &c);
        unlink(w.name);
        /* such as a processor that this machine has not, or slots that are no power of two */
        if (status != TFA_OK && (strstr(errors, "processor") || strstr(errors, "power of two") ||
                                 strstr(errors, "nothing else would run"))) {
            free(errors);
            continue;
        }
        if (status != TFA_OK || number_at(c, key) != good[i].value)
            fail_msg("%s: %s: %s", key->path, good[i].yaml, errors);
        free(errors);
        FILE *out = fopen(w.name, "we");
        config_dump(c, out);
        fclose(out);
        config_free(c);
        assert_int_equal(load(w.name, &errors, &c), TFA_OK);
        unlink(w.name);
        assert_true(number_at(c, key) == good[i].value);
        config_free(c);
        free(errors);
        taken++;
    }
    if (!taken)
        fail_msg("%s: nothing good was tried", key->path);
}

TEST(good_spellings_are_exact)
{
    visit_all(take_good, 26);
}

/* ---- totalforced --check ---- */

static int check_with_daemon(const char *name)
{
    char *const argv[] = {TFA_BINARY_DIR "/bin/totalforced", "--check", (char *)(uintptr_t)name,
                          NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int status;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", 1, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", 1, 0);
    assert_int_equal(posix_spawn(&pid, argv[0], &actions, NULL, argv, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void verdict(const numeric_key *key)
{
    static const char *const spellings[] = {"'2,5'", "1_0", "5 kg"};
    for (size_t i = 0; i < sizeof spellings / sizeof *spellings; i++) {
        const written w = write_file(key, spellings[i], strlen(spellings[i]));
        const int status = check_with_daemon(w.name);
        unlink(w.name);
        if (status != 2)
            fail_msg("%s: %s: totalforced --check ends with %d", key->path, spellings[i], status);
    }
}

TEST(check_says_so)
{
    visit_all(verdict, 26);
}

/* ---- units behind numbers ---- */

/* The remedy is the number in the unit of the key, not the digits that stand there. */
static const struct {
    const char *path, *yaml, *remedy;
} with_units[] = {
    {"spin_ns", "50us", "write 50000"},
    {"spin_ns", "0.05 ms", "write 50000"},
    {"spin_ns", "3\u00b5s", "write 3000"},
    {"turn_us", "2ms", "write 2000"},
    {"turn_us", "250us", "write 250"},
    {"turn_us", "500ns", "in decimal digits"},
    {"limits.memory_mib_per_user", "1GiB", "write 1024"},
    {"dds.lease_ms", "1 s", "write 1000"},
    {"dds.lease_ms", "50 kg", "write 50"},
    {"robots[0].scenes[0].payload[0].mass", "500g", "write 0.5"},
    {"robots[0].snap", "0.5deg", "write 0.008726646"},
};
static unsigned converted;

static void convert(const numeric_key *key)
{
    for (size_t i = 0; i < sizeof with_units / sizeof *with_units; i++) {
        config *c = NULL;
        char *errors = NULL;
        if (strcmp(key->path, with_units[i].path) != 0)
            continue;
        const written w = write_file(key, with_units[i].yaml, strlen(with_units[i].yaml));
        const int status = load(w.name, &errors, &c);
        unlink(w.name);
        if (status != TFA_E_PARSE || !strstr(errors, with_units[i].remedy))
            fail_msg("%s: %s should say '%s', says: %s", key->path, with_units[i].yaml,
                     with_units[i].remedy, errors);
        free(errors);
        converted++;
    }
}

TEST(units_are_converted)
{
    visit_all(convert, 26);
    assert_int_equal(converted, sizeof with_units / sizeof *with_units);
}
