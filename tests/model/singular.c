/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots whose mass matrix is singular at every q are refused by name when they are compiled; what
 * is only nearly so, or only somewhere, is not.
 */
#include "hand.h"
#include "test.h"

/* A link without mass on a joint along or about `axis`; returns the link. */
static uint32_t no_inertia(hand *h, const char *name, tfa_joint_type type, uint32_t parent,
                           const char *link, char axis)
{
    const uint32_t child = hand_link(h, link, 0, 0, 0, 0);
    tfa_joint *j = hand_joint(h, name, type, parent, child);
    for (int k = 0; k < 3; k++)
        j->axis[k] = axis == 'x' + k;
    return child;
}

static uint32_t full(hand *h, const char *name, tfa_joint_type type, uint32_t parent,
                     const char *link, char axis)
{
    const uint32_t child = no_inertia(h, name, type, parent, link, axis);
    h->link[child].mass = 2;
    h->link[child].inertia[0] = h->link[child].inertia[3] = h->link[child].inertia[5] = 0.02;
    h->link[child].com[0] = 0.1;
    return child;
}

static uint32_t begin(hand *h)
{
    hand_begin(h);
    return hand_link(h, "base", 1, 0, 0, 0);
}

/* "Rz turn hoop": a joint of a type (floating, revolute, prismatic, planar) along an axis, its name
 * and its link's; of a chain from the base on, where only the last link has mass. */
static void chain(hand *h, const char *parts)
{
    static const char types[] = "FRPL";
    static const tfa_joint_type type[] = {TFA_JOINT_FLOATING, TFA_JOINT_REVOLUTE,
                                          TFA_JOINT_PRISMATIC, TFA_JOINT_PLANAR};
    static char name[HAND_LINKS][2][16];
    uint32_t link = begin(h);
    char kind, axis;
    for (int used;
         sscanf(parts, " %c%c %15s %15s%n", &kind, &axis, name[link][0], name[link][1], &used) == 4;
         parts += used)
        link = (parts[used] ? no_inertia : full)(
            h, name[link][0], type[strchr(types, kind) - types], link, name[link][1], axis);
}

CHANGE(before_floating, chain(h, "Rz turn hoop Fz fly ball"))
CHANGE(before_planar, chain(h, "Rz turn hoop Lz slide puck"))
CHANGE(before_oblique_planar, chain(h, "Rx turn hoop Lz slide puck"))
CHANGE(two_slides, chain(h, "Px first carriage Px second arm"))
CHANGE(crossed_slides, chain(h, "Px first carriage Py second arm"))
CHANGE(two_coaxial, chain(h, "Rz first ring Rz second arm"); h->joint[1].xyz[2] = 0.7)
/* A spherical wrist and a fourth axis through its centre */
CHANGE(four_through_a_point, chain(h, "Rz j1 m1 Ry j2 m2 Rx j3 m3 Ry j4 hand"))
CHANGE(three_through_a_point, chain(h, "Rz j1 m1 Ry j2 m2 Rx j3 hand"))
CHANGE(four_slides, chain(h, "Px j1 m1 Py j2 m2 Pz j3 m3 Py j4 hand"))

/* The frames are turned by angles that no double holds. */
static void two_coaxial_turned(hand *h)
{
    two_coaxial(h);
    for (int k = 0; k < 2; k++) {
        h->joint[k].quat[0] = 0.3;
        h->joint[k].axis[1] = 1;
    }
    h->joint[1].quat[0] = 0;
    h->joint[1].xyz[1] = 0.7;
}

CHANGE(coaxial_with_armature, two_coaxial(h); h->joint[0].armature = 1e-3)
CHANGE(parallel_not_coaxial, two_coaxial(h); h->joint[1].xyz[0] = 1e-3)

/* A rod along z that turns about `axis` */
static void rod(hand *h, char axis)
{
    const uint32_t a = full(h, "swing", TFA_JOINT_REVOLUTE, begin(h), "rod", axis);
    h->link[a].com[0] = 0;
    h->link[a].com[2] = 0.5;
    h->link[a].inertia[5] = 0;
}

CHANGE(rod_about_itself, rod(h, 'z'))
CHANGE(rod_across, rod(h, 'y'))

/* The same rod along an oblique axis, its tensor stated with products and their rounding */
static void rod_about_itself_oblique(hand *h)
{
    const double n[3] = {0.48, 0.6, 0.64}; /* unit */
    rod(h, 'z');
    for (int k = 0; k < 3; k++) {
        h->joint[0].axis[k] = n[k];
        h->link[1].com[k] = 0.5 * n[k];
    }
    const double i[6] = {1 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2],
                         1 - n[1] * n[1], -n[1] * n[2], 1 - n[2] * n[2]};
    memcpy(h->link[1].inertia, i, sizeof i);
}

CHANGE(rod_with_a_hand, rod(h, 'z'); full(h, "grip", TFA_JOINT_REVOLUTE, 1, "hand", 'x'))

/* What turns with the rod's axis only does not help. */
CHANGE(rod_with_a_coaxial_disc, rod(h, 'z'); full(h, "spin", TFA_JOINT_REVOLUTE, 1, "disc", 'z'))

static void point_on_its_axis(hand *h)
{
    const uint32_t a = full(h, "swing", TFA_JOINT_REVOLUTE, begin(h), "bob", 'y');
    memset(h->link[a].com, 0, sizeof h->link[a].com);
    h->link[a].com[1] = 0.4;
    memset(h->link[a].inertia, 0, sizeof h->link[a].inertia);
}

CHANGE(point_beside_its_axis, point_on_its_axis(h); h->link[1].com[0] = 1e-4)

/* The follower of a coaxial pair turns with its leader: one freedom, which moves mass. */
static void coaxial_follower(hand *h)
{
    two_coaxial(h);
    h->joint[1].mimic = 0;
    h->joint[1].multiplier = 0.5;
}

CHANGE(payload_on_the_rod, rod(h, 'z'))
CHANGE(floating_point_mass, begin(h); memset(h->link[0].inertia, 0, sizeof h->link[0].inertia))

/* Two branches on a base without mass, their axes on one line: nothing holds the base about it. */
static void branches_on_a_line(hand *h)
{
    begin(h);
    h->link[0] = (tfa_link){.name = "base", .line = 10, .quat = {0, 0, 0, 1}};
    full(h, "left", TFA_JOINT_REVOLUTE, 0, "arm1", 'y');
    full(h, "right", TFA_JOINT_REVOLUTE, 0, "arm2", 'y');
    h->joint[1].xyz[1] = 0.5;
}

CHANGE(branches_on_two_lines, branches_on_a_line(h); h->joint[1].xyz[0] = 0.5)

static const tfa_payload spinning = {
    .link = "rod", .mass = 0.1, .inertia = {0.01, 0, 0, 0.01, 0, 0.01}};
static const tfa_scene with_payload = {.payloads = &spinning, .payload_count = 1};
static const tfa_lock lock_first = {.joint = "first"};
static const tfa_scene with_lock = {.locks = &lock_first, .lock_count = 1};

static const struct {
    const char *name;
    void (*make)(hand *h);
    tfa_model_options options;
    uint32_t line; /* 0: fine */
    const char *text;
} rows[] = {
    {"revolute, then floating",
     before_floating,
     {0},
     100,
     "joint 'turn': link 'hoop' has no mass, and joint 'fly' moves what hangs from it in the same "
     "way, so the mass matrix is singular at every q; give the link mass or the joint armature, or "
     "lock one of the joints"},
    {"revolute, then planar",
     before_planar,
     {0},
     100,
     "joint 'turn': link 'hoop' has no mass, and joint 'slide' moves what hangs from it in the "
     "same way, so the mass matrix is singular at every q; give the link mass or the joint "
     "armature, or lock one of the joints"},
    {"revolute across a planar", before_oblique_planar, {0}, 0, NULL},
    {"two slides",
     two_slides,
     {0},
     101,
     "joint 'second': between it and joint 'first' nothing has mass, and these 2 joints move in "
     "fewer ways, so the mass matrix is singular at every q; give a link between them mass or one "
     "of the joints armature, or lock one of them"},
    {"crossed slides", crossed_slides, {0}, 0, NULL},
    {"coaxial", two_coaxial, {0}, 101, NULL},
    {"coaxial, turned", two_coaxial_turned, {0}, 101, NULL},
    {"coaxial, armature", coaxial_with_armature, {0}, 0, NULL},
    {"coaxial, one locked", two_coaxial, {.scene = &with_lock}, 0, NULL},
    {"coaxial, floating base", two_coaxial, {.base = TFA_BASE_FLOATING}, 101, NULL},
    {"parallel", parallel_not_coaxial, {0}, 0, NULL},
    {"four through a point", four_through_a_point, {0}, 103, NULL},
    {"three through a point", three_through_a_point, {0}, 0, NULL},
    {"four slides", four_slides, {0}, 103, NULL},
    {"rod about itself",
     rod_about_itself,
     {0},
     100,
     "joint 'swing': link 'rod' and what hangs from it have no inertia that resists it, so the "
     "mass matrix is singular at every q; give the link an inertia about the axis or the joint "
     "armature, or lock the joint"},
    {"rod about itself, oblique", rod_about_itself_oblique, {0}, 100, NULL},
    {"rod about itself, floating base", rod_about_itself, {.base = TFA_BASE_FLOATING}, 100, NULL},
    {"rod across", rod_across, {0}, 0, NULL},
    {"rod with a hand", rod_with_a_hand, {0}, 0, NULL},
    {"rod with a coaxial disc", rod_with_a_coaxial_disc, {0}, 100, NULL},
    {"rod with a payload", payload_on_the_rod, {.scene = &with_payload}, 0, NULL},
    {"point on its axis", point_on_its_axis, {0}, 100, NULL},
    {"point beside its axis", point_beside_its_axis, {0}, 0, NULL},
    {"coaxial follower", coaxial_follower, {.mimic = TFA_MIMIC_PROJECT}, 0, NULL},
    {"coaxial follower, free", coaxial_follower, {.mimic = TFA_MIMIC_FREE}, 101, NULL},
    {"floating point mass",
     floating_point_mass,
     {.base = TFA_BASE_FLOATING},
     10,
     "link 'base': nothing resists one of the six freedoms of the floating base, so the mass "
     "matrix is singular at every q; give the link an inertia about all axes, or let another link "
     "be the root"},
    {"limbs on a line", branches_on_a_line, {.base = TFA_BASE_FLOATING}, 10, NULL},
    {"limbs on two lines", branches_on_two_lines, {.base = TFA_BASE_FLOATING}, 0, NULL},
};

TEST(test_rows)
{
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        hand h;
        tfa_report report = {0};
        tfa_model *model = NULL;
        const tfa_message *error = NULL;
        rows[k].make(&h);
        const int status = tfa_model_create(&h.d, &rows[k].options, &report, &model);
        for (size_t m = report.count; m-- > 0;)
            if (report.messages[m].severity == TFA_ERROR)
                error = &report.messages[m];
        if (status != (rows[k].line ? TFA_E_NO_MASS : TFA_OK))
            fail_msg("%s: %s: %s", rows[k].name, tfa_status_name(status),
                     error ? error->text : "no message");
        if (rows[k].line) {
            assert_non_null(error);
            assert_int_equal(report.errors, 1);
            if (strcmp(error->code, "singular-mass") != 0 || error->line != rows[k].line)
                fail_msg("%s: line %u: %s [%s]", rows[k].name, (unsigned)error->line, error->text,
                         error->code);
            if (rows[k].text)
                assert_string_equal(error->text, rows[k].text);
            assert_int_equal(tfa_model_size(&h.d, &rows[k].options), 0);
        }
        tfa_model_free(model);
        tfa_report_free(&report);
    }
}
