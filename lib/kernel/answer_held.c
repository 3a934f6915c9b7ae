/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of one state with joints held as an approximation, and what that costs.
 */
#include <math.h>

#include "kernel/hold.h"
#include "kernel/kernel.h"

static void unload_held(const struct state *s, uint8_t *out)
{
    const struct tfa_model *m = s->m;
    for (uint32_t j = m->base_freedoms; j < m->freedoms; j++)
        out[m->freedom[j - m->base_freedoms].from] = (s->stop[j] & STOP_HELD) != 0;
}

int TFA_V(answer_held)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                       tfa_answer *out)
{
    tfa_certificate c = {.error = NAN, .relative = NAN, .held = r->held_count};
    if (r->hold == TFA_HOLD_AUTO)
        c = TFA_V(hold_auto)(s, r->tolerance);
    else
        (void)TFA_V(forward_dynamics)(s, TFA_METHOD_ABA);
    out->method = TFA_METHOD_ABA;
    if (c.held)
        out->flags |= TFA_ANSWER_HELD;
    const int finite = TFA_V(unload_qdd)(s, k, reply);
    if (r->flags & TFA_WANT_CERTIFICATE && r->hold == TFA_HOLD_GIVEN)
        c = TFA_V(hold_certificate)(s);
    if (reply->certificate)
        reply->certificate[k] = c;
    if (reply->held)
        unload_held(s, reply->held + (size_t)s->m->v_count * k);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
