/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checks whether a robot can be specialised.
 */
#include "model/model.h"
#include "specialised/specialised_internal.h"

static const char *joint_of(const tfa_model *m, uint32_t body)
{
    for (uint32_t j = 0; j < m->declared_joints; j++)
        if (m->declared[j].body == (int32_t)body && m->declared[j].fate != TFA_FATE_FIXED &&
            m->declared[j].fate != TFA_FATE_LOCKED)
            return m->declared[j].name;
    return m->body_info[body].name;
}

static const char *follower(const tfa_model *m)
{
    for (uint32_t j = 0; j < m->declared_joints; j++)
        if (m->declared[j].fate == TFA_FATE_FOLLOWS)
            return m->declared[j].name;
    return "?";
}

static int check_body(const tfa_model *m, uint32_t i, struct error_text *err)
{
    const struct tfa_body *b = &m->body[i];
    if (b->base || joint_types[b->kind].freedoms == 1)
        return TFA_OK;
    return refuse(
        err, TFA_E_UNSUPPORTED,
        "unsupported: joint '%s' %s%s, only revolute and prismatic joints are specialised; "
        "the generic kernel answers",
        joint_of(m, i), is_fused(b->kind) ? "moves a massless link: it is " : "is ",
        joint_types[b->kind].name);
}

static int check_model(const tfa_model *m, struct error_text *err)
{
    if (m->mimics)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "unsupported: joint '%s' follows another one, mimics are not "
                      "specialised; the generic kernel answers",
                      follower(m));
    if (m->modes)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "unsupported: link '%s' is flexible, modes are not specialised; the generic "
                      "kernel answers",
                      tfa_model_mode(m, 0).link);
    if (!m->bodies || m->bodies > TFA_SPECIALISED_BODIES_MAX)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "unsupported: %u bodies, specialised are robots with 1 to %d; the "
                      "generic kernel answers",
                      m->bodies, TFA_SPECIALISED_BODIES_MAX);
    int status = TFA_OK;
    for (uint32_t i = 0; status == TFA_OK && i < m->bodies; i++)
        status = check_body(m, i, err);
    return status;
}

int tfa_specialised_check(const tfa_model *model, char *error_text, size_t size)
{
    struct error_text err = begin_error_text(error_text, size);
    return model ? check_model(model, &err) : TFA_E_ARGUMENT;
}
