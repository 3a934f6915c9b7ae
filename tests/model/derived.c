/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Massless bodies fused with what hangs from them, what is told of bodies, and derived models,
 * which are what compiling with the same gravity and payloads gives, to the last bit.
 */
#include "hand.h"
#include "model/payload.h"
#include "test.h"

/* base -j0- m0 -j1- m1 ... -j<count - 1>- end, with masses at the end only; `count` up to 8 */
static void make_chain(hand *h, uint32_t count)
{
    static const char *const links[] = {"m0", "m1", "m2", "m3", "m4", "m5", "m6", "m7"};
    static const char *const joints[] = {"j0", "j1", "j2", "j3", "j4", "j5", "j6", "j7"};
    hand_begin(h);
    hand_link(h, "base", 1, 0, 0, 0);
    for (uint32_t k = 0; k < count; k++) {
        hand_link(h, links[k], k + 1 < count ? 0 : 2, 0.1, 0.2, 0.3);
        tfa_joint *j = hand_joint(h, joints[k],
                                  k % 3 == 2 ? TFA_JOINT_PRISMATIC : TFA_JOINT_REVOLUTE, k, k + 1);
        j->axis[1] = k % 2;
        j->axis[2] = 1 - k % 2;
        j->xyz[0] = 0.1;
        j->armature = 0.001 * k;
    }
}

TEST(test_fused)
{
    hand h;
    make_chain(&h, 4);
    tfa_model *m = hand_model(&h, NULL);
    tfa_model_summary s = tfa_model_summarise(m);
    assert_int_equal(s.bodies, 1);
    assert_int_equal(s.fused, 4);
    assert_int_equal(s.v_count, 4);
    assert_int_equal(s.singular_body, -1);
    assert_int_equal(m->body[0].kind, TFA_KIND_FUSED);
    assert_int_equal(m->body[0].n, 4);
    assert_string_equal(tfa_model_body_name(m, 0), "m3");
    for (uint32_t k = 0; k < 4; k++) {
        tfa_joint_info j = tfa_model_joint(m, k);
        assert_int_equal(j.body, 0);
        assert_int_equal(j.v_index, k);
        assert_true(j.armature == 0.001 * k && m->armature[k] == 0.001 * k);
        assert_int_equal(tfa_model_declared(m, k).fate, TFA_FATE_FUSED);
        assert_int_equal(m->part[k].kind, k == 2 ? TFA_KIND_PRISMATIC : TFA_KIND_REVOLUTE);
        assert_int_equal(m->frame[k + 1].body, 0);
        assert_int_equal(m->frame[k + 1].part, k == 3 ? 0 : k + 1);
    }
    tfa_model_free(m);
}

/* What stays a body of its own: one with a payload, a branch, a joint with several freedoms. */
TEST(test_not_fused)
{
    hand h;
    const tfa_payload on_m1[] = {{.link = "m1", .mass = 0.1}};
    const tfa_scene loaded = {.payloads = on_m1, .payload_count = 1};
    const tfa_model_options options = {.scene = &loaded};
    make_chain(&h, 4);
    tfa_model *m = hand_model(&h, &options);
    assert_int_equal(tfa_model_summarise(m).bodies, 2);
    assert_int_equal(tfa_model_body(m, 0).freedoms, 2);
    hand_near(tfa_model_body(m, 0).mass, 0.1, 0);
    tfa_model_free(m);
    hand_joint(&h, "branch", TFA_JOINT_REVOLUTE, 2, hand_link(&h, "branch", 1, 0.1, 0, 0))
        ->axis[0] = 1;
    m = hand_model(&h, NULL);
    assert_int_equal(tfa_model_summarise(m).bodies, 3); /* j0 j1, j2 j3, branch */
    assert_int_equal(tfa_model_body(m, 0).freedoms, 2);
    assert_true(isnan(tfa_model_body(m, 0).condition));
    tfa_model_free(m);
    make_chain(&h, 3);
    h.joint[1].type = TFA_JOINT_PLANAR;
    m = hand_model(&h, NULL);
    assert_int_equal(tfa_model_summarise(m).bodies, 3);
    assert_int_equal(tfa_model_summarise(m).fused, 0);
    tfa_model_free(m);
}

TEST(test_six_parts_at_most)
{
    hand h;
    make_chain(&h, 6);
    tfa_model *m = hand_model(&h, NULL);
    assert_int_equal(m->body[0].n, 6);
    tfa_model_free(m);
    make_chain(&h, 8);
    tfa_report report = {0};
    assert_int_equal(tfa_model_create(&h.d, NULL, &report, &m), TFA_E_MODEL);
    assert_int_equal(report.errors, 1);
    assert_string_equal(report.messages[0].code, "massless-chain");
    assert_string_equal(report.messages[0].text,
                        "joint 'j6': more than 6 joints in a row with nothing but massless links "
                        "between them; give link 'm5' mass, or lock some of the joints");
    tfa_report_free(&report);
}

/* A part may follow, and may lead. */
TEST(test_fused_followers)
{
    const tfa_model_options project = {.mimic = TFA_MIMIC_PROJECT};
    hand h;
    make_chain(&h, 4);
    h.joint[0].mimic = 3;
    h.joint[0].multiplier = 0.5;
    h.joint[0].offset = 0.25;
    tfa_model *m = hand_model(&h, &project);
    assert_int_equal(m->body[0].n, 4);
    assert_int_equal(m->v_count, 3);
    assert_int_equal(m->mimics, 1);
    assert_int_equal(m->mimic[0].follower, 0);
    assert_int_equal(m->mimic[0].leader, 3);
    assert_int_equal(m->coordinate[0].from, 2);
    assert_true(m->coordinate[0].multiplier == 0.5 && m->coordinate[0].offset == 0.25);
    assert_int_equal(m->freedom[3].from, 2);
    tfa_model_free(m);
}

/* A brick of 12 kg with edges 1, 2, 3 and its joint's axis along y; and a point. */
TEST(test_body_info)
{
    hand h;
    hand_begin(&h);
    hand_link(&h, "base", 1, 0, 0, 0);
    hand_link(&h, "brick", 12, 0.5, 1, 1.5);
    hand_link(&h, "point", 2, 0.3, 0, 0);
    const double moments[6] = {13, 0, 0, 10, 0, 5};
    memcpy(h.link[1].inertia, moments, sizeof moments);
    memset(h.link[2].inertia, 0, sizeof h.link[2].inertia);
    hand_joint(&h, "a", TFA_JOINT_REVOLUTE, 0, 1);
    hand_joint(&h, "b", TFA_JOINT_REVOLUTE, 1, 2);
    tfa_model *m = hand_model(&h, NULL);
    tfa_body_info brick = tfa_model_body(m, 0), point = tfa_model_body(m, 1);
    assert_string_equal(brick.name, "brick");
    hand_near(brick.mass, 12, 0);
    hand_near(brick.com[0], 0.5, 1e-16);
    hand_near(brick.com[1], 1, 1e-15);
    hand_near(brick.com[2], 1.5, 1e-15);
    hand_near(brick.gyration_min, sqrt(5.0 / 12), 1e-15);
    hand_near(brick.gyration_max, sqrt(13.0 / 12), 1e-15);
    hand_near(brick.condition, 13.0 / 5, 1e-14);
    assert_int_equal(brick.regular, 1);
    assert_int_equal(point.parent, 0);
    assert_int_equal(point.regular, 0);
    assert_true(isinf(point.condition) && point.gyration_max == 0);
    assert_null(tfa_model_body(m, 2).name);
    tfa_model_summary s = tfa_model_summarise(m);
    hand_near(s.com[0], (12 * 0.5 + 2 * 0.3) / 15, 1e-15);
    hand_near(s.com[1], 12.0 / 15, 1e-15);
    uint64_t tag = tfa_model_tag(m);
    char text[17];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)tag);
    assert_memory_equal(text, tfa_model_hash_text(m), 16);
    tfa_model_free(m);
}

static const double moon[3] = {0, 0, -1.62};
static const tfa_payload loads[] = {
    {.link = "tool", .mass = 0.7, .com = {0.1, 0.2, -0.1}, .inertia = {1, 0.1, 0, 1, 0.2, 1}},
    {.link = "upper", .mass = 0.3, .com = {0, 0.3, 0}},
    {.link = "base", .mass = 5, .com = {0.3, 0, 1}},
    {.link = "tool", .mass = 0.1, .com = {0.5, 0, 0}},
};

static void expect_same(const tfa_model *a, const tfa_model *b)
{
    assert_string_equal(tfa_model_hash_text(a), tfa_model_hash_text(b));
    const tfa_model_summary s = tfa_model_summarise(a), t = tfa_model_summarise(b);
    assert_memory_equal(&s, &t, sizeof s);
    for (uint32_t i = 0; i < s.bodies; i++) {
        const tfa_body_info x = tfa_model_body(a, i), y = tfa_model_body(b, i);
        assert_memory_equal(x.com, y.com, sizeof x.com);
        assert_true(x.condition == y.condition && x.gyration_max == y.gyration_max);
    }
}

TEST(test_derived_is_compiled)
{
    for (int base = 0; base < 2; base++) {
        hand h;
        hand_arm(&h);
        h.joint[1].quat[0] = 0.3;
        const tfa_scene first = {.payloads = loads, .payload_count = 2};
        const tfa_scene second = {.payloads = loads, .payload_count = 4};
        const tfa_model_options plain = {.base = base ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
        tfa_model_options want = plain, other = plain;
        other.scene = &first;
        want.scene = &second;
        want.gravity = moon;
        tfa_model *compiled = hand_model(&h, &want), *unestimated = hand_model(&h, &plain);
        tfa_model *loaded = hand_model(&h, &other), *derived = NULL, *again = NULL;
        assert_int_equal(tfa_model_derive(unestimated, moon, loads, 4, NULL, &derived), TFA_OK);
        expect_same(derived, compiled);
        tfa_model_free(derived);
        assert_int_equal(tfa_model_derive(loaded, moon, loads, 4, NULL, &derived), TFA_OK);
        expect_same(derived, compiled); /* in place of its own */
        assert_int_equal(tfa_model_derive(derived, loaded->gravity, loads, 2, NULL, &again),
                         TFA_OK);
        expect_same(again, loaded);
        tfa_model_free(again);
        tfa_model_free(derived);
        assert_int_equal(tfa_model_derive(loaded, moon, NULL, 0, NULL, &derived), TFA_OK);
        assert_true(derived->body == loaded->body && derived->gravity[2] == moon[2]);
        assert_string_not_equal(tfa_model_hash_text(derived), tfa_model_hash_text(loaded));
        tfa_model_free(derived);
        tfa_model_free(loaded);
        tfa_model_free(unestimated);
        tfa_model_free(compiled);
    }
}

TEST(test_derive_refused)
{
    static const double bad_gravity[3] = {0, (double)NAN, 0};
    static const struct {
        tfa_payload payload;
        int status;
        const char *text;
    } rows[] = {
        {{.link = "none", .mass = 1},
         TFA_E_LINK,
         "link 'none': the payload is on a link that the model does not have; name one of its "
         "links"},
        {{.link = "m3", .mass = -1},
         TFA_E_VALUE,
         "link 'm3': the payload has a negative mass; correct it"},
        {{.link = "m3", .mass = 1, .inertia = {-1, 0, 0, 1, 0, 1}},
         TFA_E_MODEL,
         "link 'm3': the payload has an inertia with a negative eigenvalue, which no body has; "
         "correct it"},
        {{.link = "m1", .mass = 1},
         TFA_E_MODEL,
         "link 'm1': the payload is on a massless link that was fused with the next one; give the "
         "payload in the scene, so that the robot is compiled with it"},
    };
    hand h;
    make_chain(&h, 4);
    tfa_model *m = hand_model(&h, NULL), *derived = m;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        tfa_report report = {0};
        assert_int_equal(tfa_model_derive(m, NULL, &rows[k].payload, 1, &report, &derived),
                         rows[k].status);
        assert_null(derived);
        assert_string_equal(report.messages[0].text, rows[k].text);
        tfa_report_free(&report);
    }
    assert_int_equal(tfa_model_derive(m, bad_gravity, NULL, 0, NULL, &derived), TFA_E_VALUE);
    assert_int_equal(tfa_model_derive(NULL, NULL, NULL, 0, NULL, &derived), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_derive(m, NULL, NULL, 1, NULL, &derived), TFA_E_ARGUMENT);
    assert_int_equal(tfa_model_derive(m, NULL, NULL, 0, NULL, NULL), TFA_E_ARGUMENT);
    tfa_model_free(m);
}

/* The payload was all that moved with a joint: it may be replaced, but not moved elsewhere. */
TEST(test_derive_keeps_mass)
{
    hand h;
    make_chain(&h, 2);
    h.link[2].mass = 0;
    memset(h.link[2].inertia, 0, sizeof h.link[2].inertia);
    h.joint[1].armature = 0;
    const tfa_payload at_end = {.link = "m1", .mass = 1, .com = {1, 1, 1}},
                      at_base = {.link = "base", .mass = 1};
    const tfa_scene scene = {.payloads = &at_end, .payload_count = 1};
    const tfa_model_options options = {.scene = &scene};
    tfa_model *m = hand_model(&h, &options), *derived = NULL;
    assert_int_equal(tfa_model_derive(m, NULL, &at_end, 1, NULL, &derived), TFA_OK);
    tfa_model_free(derived);
    tfa_report report = {0};
    assert_int_equal(tfa_model_derive(m, NULL, &at_base, 1, &report, &derived), TFA_E_NO_MASS);
    assert_string_equal(report.messages[0].text,
                        "link 'm1': without the payloads of the model that this one is derived "
                        "from, nothing with mass moves with it; keep them");
    tfa_report_free(&report);
    tfa_model_free(m);
}

/* A request's payload and a scene's give the same constants but for rounding. */
TEST(test_body_payload)
{
    hand h;
    hand_arm(&h);
    const tfa_payload *p = &loads[0];
    const tfa_scene scene = {.payloads = p, .payload_count = 1};
    const tfa_model_options options = {.scene = &scene};
    tfa_model *plain = hand_model(&h, NULL), *loaded = hand_model(&h, &options);
    const double numbers[10] = {p->mass,       p->com[0],     p->com[1],     p->com[2],
                                p->inertia[0], p->inertia[1], p->inertia[2], p->inertia[3],
                                p->inertia[4], p->inertia[5]};
    const struct tfa_frame *f = &plain->frame[3];
    struct tfa_body body = plain->body[f->body];
    const struct tfa_body *want = &loaded->body[f->body];
    tfa_body_add_payload(&body, f, numbers);
    hand_near(body.mass, want->mass, 1e-15);
    for (int k = 0; k < 3; k++)
        hand_near(body.h[k], want->h[k], 1e-15);
    for (int k = 0; k < 6; k++)
        hand_near(body.I[k], want->I[k], 1e-15);
    assert_int_equal(body.regular, 1);
    memset(body.I, 0, sizeof body.I);
    assert_int_equal(tfa_inertia_is_regular(&body), 0);
    tfa_model_free(loaded);
    tfa_model_free(plain);
}
