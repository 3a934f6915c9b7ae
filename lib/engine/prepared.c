/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prepared requests.
 */
#include <stdlib.h>
#include <string.h>

#include "engine/form.h"
#include "engine/methods.h"

struct tfa_prepared {
    tfa_workspace *workspace;
    struct tfa_form form;
    tfa_request request; /* of the last run; what it names is in the arrays behind */
    double payloads[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    uint32_t locked[];
};

/* Arrays of a request that a run takes from its caller: from q to the last one, but payloads */
#define ARRAYS_AT offsetof(tfa_request, q)
#define ARRAYS_BYTES (sizeof(tfa_request) - ARRAYS_AT)

int tfa_prepare(tfa_workspace *w, const tfa_request *r, tfa_reply *reply, tfa_prepared **prepared)
{
    *prepared = NULL;
    int status = tfa_request_check(w->model, r, reply);
    if (status == TFA_OK)
        status = tfa_reserved_check(w, r, reply);
    if (status != TFA_OK)
        return status;
    tfa_prepared *p = calloc(1, sizeof *p + r->locked_count * sizeof *p->locked);
    if (!p)
        return reply->status = TFA_E_MEMORY;
    p->workspace = w;
    p->request = *r;
    p->request.payloads = p->payloads;
    p->request.locked = p->locked;
    if (r->payload_count)
        memcpy(p->payloads, r->payloads,
               r->payload_count * TFA_PAYLOAD_NUMBERS * sizeof *r->payloads);
    if (r->locked_count)
        memcpy(p->locked, r->locked, r->locked_count * sizeof *r->locked);
    tfa_form_init(&p->form, w, &p->request);
    *prepared = p;
    return TFA_OK;
}

int tfa_run(tfa_prepared *p, const tfa_request *r, tfa_reply *reply)
{
    memcpy((char *)&p->request + ARRAYS_AT, (const char *)r + ARRAYS_AT, ARRAYS_BYTES);
    p->request.payloads = p->payloads;
    p->request.count = r->count;
    return tfa_compute_form(p->workspace, &p->form, &p->request, reply);
}

void tfa_prepared_free(tfa_prepared *prepared)
{
    free(prepared);
}
