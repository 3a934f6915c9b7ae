/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The configuration: defaults, errors with line and column, and the printed form.
 */
#include "config/config.h"

#include "test.h"

#include <unistd.h>

#define ARM_URDF TFA_SOURCE_DIR "/config/robots/arm7.urdf"
#define ROBOT "robots:\n  - name: arm\n    urdf: " ARM_URDF "\n"

/* Loads a text. @return the errors, with the file's name cut off; release with free */
static char *load(const char *text, int expected, config **out)
{
    char name[] = "/tmp/tfa-config-XXXXXX", *errors = NULL;
    size_t size = 0;
    int fd = mkstemp(name);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), strlen(text));
    close(fd);
    FILE *stream = open_memstream(&errors, &size);
    assert_non_null(stream);
    int status = config_load(name, stream, out);
    fclose(stream);
    unlink(name);
    if (status != expected)
        print_error("%s", errors);
    assert_int_equal(status, expected);
    if (status != TFA_OK) {
        assert_null(*out);
        assert_int_equal(strncmp(errors, name, strlen(name)), 0);
        memmove(errors, errors + strlen(name), strlen(errors + strlen(name)) + 1);
    }
    return errors;
}

SCOPED_POINTER(scoped_config_free, config, config_free)
#define SCOPED_CONFIG SCOPED(scoped_config_free) config

static config *loaded(const char *text)
{
    config *c;
    free(load(text, TFA_OK, &c));
    return c;
}

static char *errors_of(const char *text)
{
    config *c;
    return load(text, TFA_E_PARSE, &c);
}

TEST(defaults_hold)
{
    SCOPED_CONFIG *c = loaded(ROBOT);
    assert_int_equal(c->workers, 1);
    assert_int_equal(c->spin_ns, 50000);
    assert_true(c->allow_spin);
    assert_false(c->realtime.mlock || c->dds.enabled);
    assert_int_equal(c->realtime.cpu_dma_latency, CONFIG_ANY_LATENCY);
    assert_int_equal(c->limits.clients, 64);
    assert_int_equal(c->robots_count, 1);
    assert_string_equal(c->robots[0].name, "arm");
    assert_int_equal(c->robots[0].estimate, CONFIG_ESTIMATE_DEFAULT);
    assert_int_equal(c->robots[0].estimate_every, 100);
    assert_int_equal(c->robots[0].precision, CONFIG_PRECISION_F64);
    assert_int_equal(c->robots[0].residual, TFA_RESIDUAL_SAME);
    assert_int_equal(c->robots[0].wait, TFA_WAIT_HYBRID);
    assert_int_equal(c->robots[0].gravity_count, 0);
}

/* Names that the library expands, and relative ones, which start at the configuration file */
TEST(robots_are_found)
{
    static const char *const names[] = {"~/robots/arm7.urdf", "$(find robots)/arm7.urdf",
                                        "package://robots/arm7.urdf",
                                        "file://" TFA_SOURCE_DIR "/config/robots/arm7.urdf"};
    char text[512];
    assert_int_equal(setenv("HOME", TFA_SOURCE_DIR "/config", 1), 0);
    assert_int_equal(setenv("ROS_PACKAGE_PATH", TFA_SOURCE_DIR "/config", 1), 0);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        snprintf(text, sizeof text, "robots: [{name: arm, urdf: \"%s\"}]\n", names[k]);
        SCOPED_CONFIG *c = loaded(text);
        char *path = config_file_path(c, c->robots[0].urdf);
        assert_string_equal(path, TFA_SOURCE_DIR "/config/robots/arm7.urdf");
        free(path);
        path = config_file_path(c, "kernels");
        assert_string_equal(path, "/tmp/kernels");
        free(path);
    }
    assert_int_equal(unsetenv("ROS_PACKAGE_PATH"), 0);
}

/* A hundred thousand brackets are refused as soon as it is clear what they are. */
TEST(deep_nesting_is_refused)
{
    static const char *const parts[] = {"[", "{a: ", "- ", "? "};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        const size_t length = strlen(parts[k]), count = 100000;
        SCOPED_TEXT *text = malloc(length * count + 1);
        assert_non_null(text);
        for (size_t i = 0; i < count; i++)
            memcpy(text + i * length, parts[k], length);
        text[length * count] = 0;
        SCOPED_TEXT *errors = errors_of(text);
        assert_non_null(strstr(errors, "levels deep"));
    }
}

TEST(values_arrive)
{
    SCOPED_CONFIG *c =
        loaded("workers: 2\nallow_spin: off\nrealtime:\n  affinity: [0, 0]\n  mlock: yes\n"
               "  cpu_dma_latency: 0\nlimits: {clients: 7}\n" ROBOT
               "    base: floating\n    gravity: [0, 0, -1.62]\n    wait: block\n"
               "    precision: f32\n    residual: f128\n"
               "    armature:\n      - {joint: j1, value: 0.25}\n      - {joint: j2, value: 1}\n"
               "    rotors: [{joint: j3, value: 1e-4}]\n    friction: yes\n"
               "    friction_velocity: 0.05\n");
    assert_int_equal(c->workers, 2);
    assert_false(c->allow_spin);
    assert_true(c->realtime.mlock);
    assert_int_equal(c->realtime.cpu_dma_latency, 0);
    assert_int_equal(c->realtime.affinity_count, 2);
    assert_int_equal(c->realtime.affinity[1], 0);
    assert_int_equal(c->limits.clients, 7);
    assert_int_equal(c->limits.clients_per_user, 32);
    assert_int_equal(c->robots[0].base, TFA_BASE_FLOATING);
    assert_true(c->robots[0].gravity[2] == -1.62);
    assert_int_equal(c->robots[0].wait, TFA_WAIT_BLOCK);
    assert_int_equal(c->robots[0].precision, CONFIG_PRECISION_F32);
    assert_int_equal(c->robots[0].residual, TFA_RESIDUAL_F128);
    assert_int_equal(c->robots[0].armature_count, 2);
    assert_string_equal(c->robots[0].armature[1].joint, "j2");
    assert_true(c->robots[0].armature[0].value == 0.25);
    assert_int_equal(c->robots[0].rotors_count, 1);
    assert_string_equal(c->robots[0].rotors[0].joint, "j3");
    assert_true(c->robots[0].rotors[0].value == 1e-4);
    assert_true(c->robots[0].friction && c->robots[0].friction_velocity == 0.05);
}

#define CONSTRAINT(keys) ROBOT "    scenes: [{name: s, constraints: [{" keys "}]}]\n"

TEST(errors_name_line_and_column)
{
    static const struct {
        const char *text, *location, *what;
    } cases[] = {
        {"workerz: 2\n" ROBOT, ":1:1: ", "no key 'workerz'; nearest: 'workers'"},
        {"workers: 0\n" ROBOT, ":1:10: ", "'0' is not a whole number from 1 to 64"},
        {"workers: many\n" ROBOT, ":1:10: ", "many"},
        {"workers: -1\n" ROBOT, ":1:10: ", "-1"},
        {"workers: 1\nworkers: 2\n" ROBOT, ":2:1: ", "workers: it is there twice"},
        {"limits:\n  clients: 5\n  clientz: 5\n" ROBOT,
         ":3:3: ", "limits: there is no key 'clientz'; nearest: 'clients'"},
        {"limits:\n  clients: 9999\n" ROBOT, ":2:12: ", "limits.clients"},
        {"backend: disk\n" ROBOT, ":1:10: ", "'disk' is not one of shm, memfd"},
        {"http: {enabled: yes}\n" ROBOT, ":1:1: ",
         "http: totalforced has no HTTP server: the live "
         "page and metrics are a program, totalforce web"},
        {"limits: {http: 1}\n" ROBOT, ":1:10: ", "limits: there is no key 'http'"},
        {"allow_spin: perhaps\n" ROBOT, ":1:13: ", "'perhaps' is not one of true, false, yes"},
        {"workers: [\n" ROBOT, ":", "this is not YAML: "},
        {"workers: 1\n", ":1:1: ", "the key 'robots' is missing"},
        {"robots: []\n", ":1:9: ", "robots: 0 given, a list of 1 to 1000 entries"},
        {"", ":1:1: ", "no keys; the file is empty"},
        {"~\n", ":1:1: ", "keys are expected"},
        {"- a\n", ":1:1: ", "not a list"},
        {ROBOT "---\n" ROBOT, ":5:1: ", "a second document"},
        {"workers:\n\t- 1\n" ROBOT, ":2:1: ", "indent by spaces"},
        {"limits: 5\n" ROBOT, ":1:9: ", "limits: keys are expected here ('clients: ...')"},
        {"user: ~\n" ROBOT, ":1:7: ", "user: '~' where a text is expected; or leave the key out"},
        {"robots: {name: a, urdf: b}\n", ":1:9: ", "begin each entry with '- '"},
        {ROBOT "    gravity: 0 0 -9.81\n", ":4:14: ", "'0 0 -9.81' where a list of 3 numbers"},
        {ROBOT "    gravity: [0, 0, -9,81]\n", ":4:14: ", "4 given, a list of 3 numbers"},
        {ROBOT "    armature: {joint: a}\n", ":4:15: ", "a list of up to 100000 entries"},
        {ROBOT "    name: b\n", ":4:5: ", "robots[0]: name: it is there twice, first in line 2"},
        {"robots: &a [*a]\n", ":1:9: ", "keys are expected here ('name: ...'), not a list"},
        {"robots: *a\n", ":1:9: ", "this is not YAML: found undefined alias"},
        {ROBOT "  - {<<: {name: b}, urdf: x}\n", ":4:6: ", "there is no key '<<'"},
        {"[1, 2]: x\n" ROBOT, ":1:1: ", "there is no key ''"},
        {"robots:\n  - name: arm\n",
         ":2:5: ", "robots[0]: the key 'urdf' is missing: The robot's file"},
        {"robots:\n  - name: a/b\n    urdf: x\n", ":2:11: ", "a/b"},
        {"robots:\n  - name: arm\n    urdf: nowhere.urdf\n", ":3:11: ", "nowhere.urdf"},
        {"robots:\n  - name: arm\n    urdf: ..\n",
         ":3:11: ", "'/tmp/..' cannot be read: Is a directory"},
        {"robots:\n  - name: arm\n    urdf: package://no_arm/arm.urdf\n",
         ":3:11: ", "'package://no_arm/arm.urdf': no package 'no_arm' in AMENT_PREFIX_PATH ("},
        {"robots:\n  - name: arm\n    urdf: $(env HOME)/arm.urdf\n",
         ":3:11: ", "'$(env HOME)...' is not expanded"},
        {ROBOT "    slots: 3\n", ":4:12: ", "power of two"},
        {ROBOT "    gravity: [0, 0]\n", ":4:14: ", "2 given, a list of 3 numbers is expected"},
        {ROBOT "    wait: default\n", ":4:11: ", "'default' is not one of spin, hybrid, block"},
        {ROBOT "    estimate: often\n",
         ":4:15: ", "'often' is not one of default, never, sampled, always"},
        {ROBOT "    precision: f128\n", ":4:16: ", "f128"},
        {ROBOT "    residual: double\n", ":4:15: ", "double"},
        {ROBOT "    armature: [{joint: a}]\n", ":4:16: ", "the key 'value' is missing"},
        {ROBOT "    armature: [{joint: a, value: -1}]\n", ":4:34: ", "armature[0].value"},
        {ROBOT "    rotors: [{joint: a, value: -1}]\n", ":4:32: ", "rotors[0].value"},
        {ROBOT "    friction_velocity: -1\n", ":4:24: ", "friction_velocity"},
        {ROBOT "  - name: arm\n    urdf: " TFA_SOURCE_DIR "/config/robots/arm7.urdf\n",
         ":4:11: ", "already"},
        {"realtime: {affinity: [0, 0], priority: 9}\nworkers: 2\nallow_spin: no\n" ROBOT,
         ":1:22: ", "never run"},
        {"realtime: {affinity: [9999]}\n" ROBOT, ":1:22: ", "no processor 9999"},
        {"realtime: {affinity: [0]}\nworkers: 2\n" ROBOT, ":1:22: ", "one for each"},
        {"realtime: {cpu_dma_latency: -1}\n" ROBOT,
         ":1:29: ", "'-1' is not a whole number from 0 to 2000000000"},
        {"realtime: {cpu_dma_latency: 2000000001}\n" ROBOT, ":1:29: ", "from 0 to 2000000000"},
        {"realtime: {cpu_dma_latency: 1.5}\n" ROBOT, ":1:29: ", "'1.5' is not a whole number"},
        {"realtime: {cpu_dma_latancy: 0}\n" ROBOT, ":1:12: ", "nearest: 'cpu_dma_latency'"},
        {"workers: 64\nrealtime: {priority: 9}\n" ROBOT, ":2:22: ", "nothing else would run"},
        {"allow_spin: no\n" ROBOT "    wait: spin\n", ":5:11: ", "allow_spin"},
        {ROBOT "    mimic: perhaps\n", ":4:12: ", "perhaps"},
        {ROBOT "    inertia: strictly\n", ":4:14: ", "strictly"},
        {ROBOT "    scenes: [{root: a}]\n", ":4:14: ", "the key 'name' is missing"},
        {ROBOT "    scenes: [{name: a/b}]\n", ":4:21: ", "'arm.a/b' is not a name"},
        {ROBOT "    scenes: [{name: s}, {name: s}]\n", ":4:32: ", "already the name of robots[0]"},
        {ROBOT "    scenes: [{name: s, tipps: [a]}]\n", ":4:24: ", "tipps"},
        {ROBOT "    scenes: [{name: s, payload: [{link: a}]}]\n",
         ":4:34: ", "the key 'mass' is missing"},
        {ROBOT "    scenes: [{name: s, payload: [{link: a, mass: -1}]}]\n",
         ":4:50: ", "robots[0].scenes[0].payload[0].mass"},
        {ROBOT "    scenes: [{name: s, payload: [{link: a, mass: 1, com: [1]}]}]\n", ":4:", "3"},
        {ROBOT "    scenes: [{name: s, locked: [{joint: a, pose: [1, 2, 3, 4]}]}]\n",
         ":4:50: ", "planar joints take 3"},
        {CONSTRAINT("second: {link: a}, hold: x"),
         ":4:38: ", "constraints[0]: the key 'name' is missing: Name, by which requests call it"},
        {CONSTRAINT("name: c, hold: x"), ":4:38: ", "the key 'second' is missing"},
        {CONSTRAINT("name: c, second: {}"), ":4:38: ", "the key 'hold' is missing"},
        {CONSTRAINT("name: c, second: {}, holds: x"), ":4:60: ", "no key 'holds'; nearest: 'hold'"},
        {CONSTRAINT("name: c, second: {}, hold: points"), ":4:66: ",
         "robots[0].scenes[0].constraints[0].hold: 'points' is not one of point, hinge, weld, x, "
         "y, z, rx, ry, rz"},
        {CONSTRAINT("name: c, second: {}, hold: [x, w]"), ":4:70: ", "hold[1]: 'w' is not one of"},
        {CONSTRAINT("name: c, second: {}, hold: []"), ":4:66: ", "a list of 1 to 6 words"},
        {CONSTRAINT("name: c, second: {}, hold: {x: y}"), ":4:66: ", "a list of 1 to 6 words"},
        {CONSTRAINT("name: c, second: {xyz: [1, 2]}, hold: x"),
         ":4:62: ", "second.xyz: 2 given, a list of 3 numbers is expected"},
        {CONSTRAINT("name: c, second: {rpy: [1, 2, x]}, hold: x"),
         ":4:69: ", "second.rpy[2]: 'x' is not a finite number"},
        {CONSTRAINT("name: c, second: a, hold: x"),
         ":4:56: ", "keys are expected here ('link: ..."},
        {CONSTRAINT("name: c, second: {links: a}, hold: x"), ":4:57: ", "nearest: 'link'"},
        {CONSTRAINT("name: c, second: {}, hold: x, unilateral: 1"),
         ":4:81: ", "unilateral: '1' is not one of true, false"},
        {ROBOT "    scenes: [{name: s, actuated: j}]\n", ":4:34: ", "a list of up to 100000 texts"},
        {ROBOT "    scenes: [{name: s, actuated: [j, ~]}]\n",
         ":4:38: ", "where a text is expected"},
        {ROBOT "    scenes: [{name: s}]\n  - name: arm.s\n    urdf: " TFA_SOURCE_DIR
               "/config/robots/arm7.urdf\n",
         ":5:11: ", "'arm.s' is already the name of robots[0].scenes[0]"},
        /* a text that ends at a NUL inside it would be another one */
        {"robots: [{name: \"arm\\0x\", urdf: " ARM_URDF "}]\n", ":1:17: robots[0].name: ", "NUL"},
        {"robots: [{name: arm, urdf: \"" ARM_URDF "\\0x\"}]\n", ":1:28: robots[0].urdf: ", "NUL"},
        {"robots: [{\"name\\0x\": arm, urdf: x}]\n", ":1:11: ", "NUL"},
        {"backend: \"shm\\0x\"\n" ROBOT, ":1:10: backend: ", "NUL"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_TEXT *errors = errors_of(cases[i].text);
        if (strncmp(errors, cases[i].location, strlen(cases[i].location)) != 0 ||
            !strstr(errors, cases[i].what))
            fail_msg("case %zu: '%s' should be at '%s' and name '%s'", i, errors, cases[i].location,
                     cases[i].what);
        if (strstr(errors, "CYAML") || strstr(errors, "mapping field"))
            fail_msg("case %zu: '%s' is in the words of a library", i, errors);
    }
}

TEST(several_errors_in_one_go)
{
    char *errors = errors_of("workers: 0\nspin_ns: 2000000000\n" ROBOT "    slots: 5\n");
    assert_non_null(strstr(errors, "workers"));
    assert_non_null(strstr(errors, "spin_ns"));
    assert_non_null(strstr(errors, "slots"));
    free(errors);
}

/* A list that is wrong, and fifteen times an alias of it: a hundred errors are listed. */
TEST(errors_of_aliases_are_bounded)
{
    SCOPED_TEXT *errors = errors_of(
        "robots: &r [{name: arm, urdf: " ARM_URDF ", scenes: &s [{x: 1}, {x: 1}, {x: 1}, {x: 1}, "
        "{x: 1}, {x: 1}, {x: 1}, {x: 1}, {x: 1}, {x: 1}]}, {scenes: *s}, {scenes: *s}, "
        "{scenes: *s}, {scenes: *s}, {scenes: *s}, {scenes: *s}, {scenes: *s}, {scenes: *s}, "
        "{scenes: *s}, {scenes: *s}, {scenes: *s}, {scenes: *s}, {scenes: *s}, {scenes: *s}]\n");
    size_t lines = 0;
    for (const char *c = errors; *c; c++)
        lines += *c == '\n';
    assert_int_equal(lines, 101);
    assert_non_null(strstr(errors, "more errors are not listed"));
}

TEST(missing_file)
{
    config *c;
    char *errors = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&errors, &size);
    assert_int_equal(config_load("/nowhere/c.yaml", stream, &c), TFA_E_FILE);
    fclose(stream);
    assert_non_null(strstr(errors, "/nowhere/c.yaml"));
    free(errors);
}

/* ---- the paths of sockets: at most 107 characters ---- */

static const char *directory_of(size_t length)
{
    static char path[128];
    snprintf(path, sizeof path, "/tmp/%0*d", (int)length - 5, 0);
    return path;
}

/* As long as fits: the longest socket may be the one of commands, of a robot or of a scene. */
TEST(a_runtime_directory_that_is_too_long)
{
    static const struct {
        const char *robots, *what;
        size_t fits;
    } cases[] = {
        {ROBOT, "'/.control.sock' 108; the path of a socket has at most 107:", 93},
        {ROBOT "    scenes: [{name: with_a_cup}]\n", "'/arm.with_a_cup.sock'", 87},
        {ROBOT "  - name: a_longer_name\n    urdf: " TFA_SOURCE_DIR "/config/robots/arm7.urdf\n",
         "'/a_longer_name.sock'", 88},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1024], remedy[64];
        snprintf(text, sizeof text, "workers: 1\nruntime_dir: %s\n%s", directory_of(cases[i].fits),
                 cases[i].robots);
        config_free(loaded(text));
        snprintf(text, sizeof text, "workers: 1\nruntime_dir: %s\n%s",
                 directory_of(cases[i].fits + 1), cases[i].robots);
        SCOPED_TEXT *errors = errors_of(text);
        snprintf(remedy, sizeof remedy, "choose a runtime_dir of at most %zu", cases[i].fits);
        assert_int_equal(strncmp(errors, ":2:14: runtime_dir: ", 20), 0);
        assert_non_null(strstr(errors, cases[i].what));
        assert_non_null(strstr(errors, remedy));
    }
}

TEST(a_relative_runtime_directory)
{
    SCOPED_TEXT *errors = errors_of("workers: 1\nruntime_dir: run\n" ROBOT);
    assert_int_equal(strncmp(errors, ":2:14: runtime_dir: 'run' is not absolute", 41), 0);
}

TEST(a_runtime_directory_of_the_environment_that_is_too_long)
{
    const char *before = getenv("TOTALFORCE_RUNTIME_DIR");
    char *kept = before ? strdup(before) : NULL;
    assert_int_equal(setenv("TOTALFORCE_RUNTIME_DIR", directory_of(94), 1), 0);
    char *errors = errors_of(ROBOT);
    assert_int_equal(strncmp(errors, ": TOTALFORCE_RUNTIME_DIR: 94 characters", 39), 0);
    assert_non_null(strstr(errors, "choose a runtime_dir of at most 93"));
    free(errors);
    config_free(loaded("runtime_dir: /run/short\n" ROBOT)); /* the file decides */
    assert_int_equal(
        kept ? setenv("TOTALFORCE_RUNTIME_DIR", kept, 1) : unsetenv("TOTALFORCE_RUNTIME_DIR"), 0);
    free(kept);
}

static char *dump(const config *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    config_dump(c, stream);
    fclose(stream);
    return text;
}

/* What is printed can be read again and prints the same. */
TEST(dump_is_a_fixed_point)
{
    SCOPED_CONFIG *read = loaded(
        "dds:\n  domain: 3\ngroup: \"a \\\"b\\\"\\n\\t\"\n" ROBOT "    gravity: [0.1, 0, -9.81]\n"
        "    armature:\n      - {joint: j1, value: 0.1}\n      - {joint: j2, value: 3}\n");
    SCOPED_TEXT *first = dump(read);
    SCOPED_CONFIG *c = loaded(first);
    assert_int_equal(c->dds.domain, 3);
    assert_string_equal(c->group, "a \"b\"\n\t");
    assert_true(c->robots[0].gravity[0] == 0.1);
    assert_int_equal(c->robots[0].armature_count, 2);
    SCOPED_TEXT *second = dump(c);
    assert_string_equal(first, second);
}

#define SCENES                                                                                     \
    ROBOT "    mimic: project\n    damping: yes\n    scenes:\n"                                    \
          "      - {name: whole}\n"                                                                \
          "      - name: part\n        root: a\n        tips: [b, \"c d\"]\n        base: "        \
          "floating\n"                                                                             \
          "        gravity: [0, 0, 1]\n"                                                           \
          "        locked: [{joint: j, q: 0.5}, {joint: k, pose: [1, 2, 3]}]\n"                    \
          "        payload: [{link: l, mass: 2, com: [1, 2, 3], inertia: [1, 0, 0, 1, 0, 1]}]\n"   \
          "        constraints:\n"                                                                 \
          "          - {name: foot, second: {link: l, xyz: [0, 0, 0.1]}, hold: point,\n"           \
          "             unilateral: true}\n"                                                       \
          "          - {name: grip, first: {link: a, rpy: [0, 1, 0]}, second: {link: world},\n"    \
          "             hold: [z, hinge, rx]}\n"                                                   \
          "        actuated: [j, \"k k\"]\n"

TEST(scenes_arrive)
{
    SCOPED_CONFIG *c = loaded(SCENES);
    const config_robot *robot = &c->robots[0];
    assert_int_equal(robot->mimic, TFA_MIMIC_PROJECT);
    assert_int_equal(robot->inertia, TFA_INERTIA_STRICT);
    assert_true(robot->damping && !robot->lock_massless_leaves);
    assert_int_equal(robot->scenes_count, 2);
    const config_scene *whole = &robot->scenes[0], *part = &robot->scenes[1];
    assert_int_equal(whole->base, CONFIG_BASE_SAME);
    assert_null(whole->root);
    assert_int_equal(whole->tips_count + whole->locked_count + whole->payload_count, 0);
    assert_int_equal(part->base, TFA_BASE_FLOATING);
    assert_string_equal(part->tips[1], "c d");
    assert_true(part->locked[0].q == 0.5 && part->locked[0].pose_count == 0);
    assert_true(part->locked[1].pose[2] == 3);
    assert_true(part->payload[0].mass == 2 && part->payload[0].com[1] == 2);
    assert_int_equal(part->payload[0].inertia_count, 6);
    const config_constraint *foot = &part->constraints[0], *grip = &part->constraints[1];
    assert_int_equal(part->constraints_count, 2);
    assert_string_equal(foot->name, "foot");
    assert_null(foot->first.link);
    assert_string_equal(foot->second.link, "l");
    assert_int_equal(foot->first.xyz_count + foot->first.rpy_count + foot->second.rpy_count, 0);
    assert_true(foot->second.xyz[2] == 0.1 && foot->unilateral && !grip->unilateral);
    assert_int_equal(config_constraint_rows(foot), TFA_CONSTRAINT_POINT);
    assert_true(grip->first.rpy[1] == 1);
    assert_int_equal(config_constraint_rows(grip), TFA_CONSTRAINT_HINGE);
    assert_string_equal(part->actuated[1], "k k");
    SCOPED_TEXT *first = dump(c);
    SCOPED_CONFIG *again = loaded(first);
    SCOPED_TEXT *second = dump(again);
    assert_string_equal(first, second);
}

/* What a reload may change is not named, what it may not is. */
TEST(restart_is_asked_for)
{
    static const struct {
        const char *now, *next, *text;
    } cases[] = {
        {ROBOT, ROBOT, NULL},
        {ROBOT,
         ROBOT "    gravity: [0, 0, 1]\n    mimic: lock\n    armature: [{joint: a, value: 1}]\n",
         NULL},
        {ROBOT, "limits: {clients: 3}\n" ROBOT "    slots: 8\n    estimate: never\n", NULL},
        {ROBOT, "dds: {domain: 3}\n" ROBOT, "dds.domain is another"},
        {ROBOT, ROBOT "    precision: f32\n    residual: f64\n", NULL},
        {SCENES, ROBOT "    scenes: [{name: whole, root: b}, {name: part}]\n", NULL},
        {SCENES, ROBOT "    scenes: [{name: whole}, {name: other}]\n",
         "robots[0].scenes[1].name is another"},
        {SCENES, ROBOT, "robots[0].scenes has 0 entries, it had 2"},
        {ROBOT, ROBOT "    dds: no\n", "robots[0].dds is another"},
        {ROBOT, ROBOT "    max_batch: 3\n", "robots[0].max_batch is another"},
        {ROBOT, "backend: memfd\n" ROBOT, "backend is another"},
        {ROBOT, "group: users\n" ROBOT, "group is another"},
        {"dds: {domain: 1}\n" ROBOT, "dds: {domain: 2}\n" ROBOT, "dds.domain is another"},
        {"workers: 2\nrealtime: {affinity: [0, 0]}\n" ROBOT,
         "workers: 2\nrealtime: {affinity: [0, 1]}\n" ROBOT, "realtime.affinity[1] is another"},
        {ROBOT, "realtime: {cpu_dma_latency: 0}\n" ROBOT, "realtime.cpu_dma_latency is another"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_CONFIG *now = loaded(cases[i].now), *next = loaded(cases[i].next);
        char text[200] = "";
        assert_int_equal(config_needs_restart(now, next, text, sizeof text), cases[i].text != NULL);
        const char *said = strstr(text, ": "); /* behind FILE:LINE:COLUMN */
        assert_string_equal(said ? said + 2 : "", cases[i].text ? cases[i].text : "");
    }
}

static config *example(const char *name)
{
    char path[256];
    config *c;
    snprintf(path, sizeof path, TFA_SOURCE_DIR "/config/%s.yaml", name);
    assert_int_equal(config_load(path, stderr, &c), TFA_OK);
    return c;
}

/* The shipped examples are good, and full.yaml shows every key at its default. */
TEST(examples_are_true)
{
    SCOPED_CONFIG *minimal = example("minimal"), *full = example("full"), *arm = example("arm"),
                  *scenes = example("scenes"), *ros2 = example("ros2");
    assert_true(arm && scenes);
    assert_true(ros2->ros2.enabled && ros2->robots[0].ros2.enabled);
    assert_true(minimal->dds.enabled && !full->dds.enabled);
    minimal->dds.enabled = false; /* everything else of minimal.yaml is a default */
    SCOPED_TEXT *a = dump(minimal), *b = dump(full);
    assert_string_equal(a, b);
    FILE *file = fopen(TFA_SOURCE_DIR "/config/full.yaml", "r");
    char text[32768];
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    for (char *line = strtok(a, "\n"); line; line = strtok(NULL, "\n")) {
        char *colon = strchr(line, ':');
        if (!colon || line[strspn(line, " ")] == '#')
            continue;
        *colon = 0;
        if (!strstr(text, line + strspn(line, " -")))
            fail_msg("config/full.yaml does not show '%s'", line);
    }
}
