/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The generated source: whatever the names of a robot are, its code is that of the same robot with
 * plain names; and robots that have no kernel of their own are refused by the name of the joint.
 */
#include "bench.h"
#include "models.h"
#include "test.h"

static const char *const hostile[] = {
    "plain",
    "\"); system(\"echo owned\"); (\"",
    "*/ int owned(void) { return 1; } /*",
    "ends with a backslash\\",
    "line\none\n#include \"/etc/passwd\"\n",
    "\r#error \r",
    "?\?/\n?\?>",
    "%s%n%d",
    "\x01\x7f\xc3\xa4\xff",
    "_Pragma(\"GCC poison robot_body\")",
};

/* The arm with such names: number `first` and the following, and one that is long */
static tfa_model *hostile_arm(size_t first, char *names)
{
    const size_t count = sizeof hostile / sizeof *hostile;
    tfa_description *d = bundled_description("arm7.urdf");
    for (size_t k = 0; k < d->link_count + d->joint_count; k++) {
        char *name = names + 400 * k;
        snprintf(name, 400, "%s%zu%0*d", hostile[(first + k) % count], k, k == 3 ? 200 : 1, 0);
        if (k < d->link_count)
            d->links[k].name = name;
        else
            d->joints[k - d->link_count].name = name;
    }
    d->name = hostile[first];
    tfa_model *model = compiled(d, NULL);
    tfa_description_free(d);
    return model;
}

/* Comments and the line with the hash go. */
static void strip(char *text)
{
    char *out = text;
    for (const char *in = text; *in;) {
        if (strncmp(in, "/*", 2) == 0) {
            in = strstr(in, "*/") + 2;
        } else if (strncmp(in, "#define ROBOT_HASH", 16) == 0) {
            in = strchr(in, '\n');
        } else {
            *out++ = *in++;
        }
    }
    *out = '\0';
}

static char *tables_of(const tfa_model *model)
{
    char *text;
    assert_int_equal(tfa_specialised_tables(model, &text), TFA_OK);
    return text;
}

TEST(names_change_comments_only)
{
    tfa_model *arm = bench_robot("arm7.urdf", TFA_BASE_FIXED);
    char *plain = tables_of(arm), *names = malloc(400 * 64);
    strip(plain);
    for (size_t k = 0; k < sizeof hostile / sizeof *hostile; k++) {
        tfa_model *model = hostile_arm(k, names);
        char *text = tables_of(model);
        for (const char *c = text; *c; c++)
            assert_true(*c == '\n' || (*c >= ' ' && *c < 0x7f && *c != '\\' && *c != '?'));
        assert_true(strlen(text) < 2 * strlen(plain) + 10000);
        strip(text);
        assert_string_equal(text, plain);
        free(text);
        tfa_model_free(model);
    }
    free(plain);
    free(names);
    tfa_model_free(arm);
}

TEST(hostile_names_build_and_load)
{
    bench b;
    char path[256], *names = malloc(400 * 64);
    tfa_specialised *kernel;
    bench_open(&b);
    tfa_model *model = hostile_arm(1, names);
    bench_build(&b, model, "SOUND", bench_path(&b, "kernel.so", path));
    assert_int_equal(tfa_specialised_load(path, model, &kernel, b.error_text, sizeof b.error_text),
                     TFA_OK);
    tfa_specialised_free(kernel);
    tfa_model_free(model);
    free(names);
    bench_close(&b);
}

/* ---- who is not taken ---- */

static void expect_refusal(const tfa_model *model, const char *joint)
{
    char error_text[512], *text = NULL;
    assert_int_equal(tfa_specialised_check(model, error_text, sizeof error_text),
                     TFA_E_UNSUPPORTED);
    if (!strstr(error_text, joint) || !strstr(error_text, "the generic kernel answers"))
        fail_msg("%s is not in: %s", joint, error_text);
    assert_int_equal(tfa_specialised_tables(model, &text), TFA_E_UNSUPPORTED);
    assert_null(text);
    assert_int_equal(tfa_specialised_build(model, NULL, "/tmp/never.so", NULL, error_text, 512),
                     TFA_E_UNSUPPORTED);
}

static void change_and_refuse(void (*change)(tfa_description *d), const char *joint)
{
    const tfa_model_options options = {.mimic = TFA_MIMIC_PROJECT};
    tfa_description *d = bundled_description("arm7.urdf");
    change(d);
    tfa_model *model = compiled(d, &options);
    expect_refusal(model, joint);
    tfa_model_free(model);
    tfa_description_free(d);
}

static void make_mimic(tfa_description *d)
{
    d->joints[4].mimic = 2;
    d->joints[4].multiplier = 0.5;
}

static void make_planar(tfa_description *d)
{
    d->joints[3].type = TFA_JOINT_PLANAR;
}

static void make_floating(tfa_description *d)
{
    d->joints[5].type = TFA_JOINT_FLOATING;
}

static void make_fused(tfa_description *d)
{
    tfa_link *link = &d->links[d->joints[2].child];
    link->mass = 0;
    memset(link->inertia, 0, sizeof link->inertia);
    memset(link->com, 0, sizeof link->com);
}

TEST(robots_without_kernel_are_named)
{
    change_and_refuse(make_mimic, "joint 'joint_4' follows");
    change_and_refuse(make_planar, "joint 'joint_3' is planar");
    change_and_refuse(make_floating, "joint 'joint_5' is free");
    change_and_refuse(make_fused, "joint 'joint_2' moves a massless link");
    assert_int_equal(tfa_specialised_check(NULL, NULL, 0), TFA_E_ARGUMENT);
}

/* Gravity is read from the model and from requests: tables hold none. */
TEST(gravity_is_in_no_table)
{
    static const double moon[3] = {0, 0, -1.62};
    const tfa_model_options options = {.gravity = moon};
    tfa_description *d = bundled_description("arm7.urdf");
    tfa_model *here = compiled(d, NULL), *there = compiled(d, &options);
    char *text = tables_of(here), *other = tables_of(there);
    assert_string_equal(text, other);
    assert_null(strstr(text, "gravity"));
    free(text);
    free(other);
    tfa_model_free(here);
    tfa_model_free(there);
    tfa_description_free(d);
}
