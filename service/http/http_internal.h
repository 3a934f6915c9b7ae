/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parts of the HTTP server. Grouped by the file that defines them.
 */
#ifndef TFA_SERVICE_HTTP_HTTP_INTERNAL_H
#define TFA_SERVICE_HTTP_HTTP_INTERNAL_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <totalforce/statistics.h>

#include "http/http.h"

struct MHD_Connection;
struct MHD_Daemon;

#define HTTP_PERIOD_NS 50000000u /* copies of the statistics and figures are at least so old */
#define HTTP_SECONDS 60          /* of history */
#define HTTP_CONNECTIONS 48      /* at once; one more closes the one that is silent for longest */
#define HTTP_IDLE_NS 5000000000u /* a connection without a complete request or reply is closed */

/* ---- figure.c: poses and operational-space inertia of a robot ---- */

#define FIGURE_TIPS 8

/* Linear block of Lambda^-1 at a tip, axes of the world, 1/kg: a force f accelerates the tip by
 * the block times f. */
typedef struct figure_tip {
    uint32_t frame;
    int status;
    double block[9];
    double values[3];     /* eigenvalues, largest first */
    double vectors[3][3]; /* their unit eigenvectors */
} figure_tip;

/* A robot's figure. Guarded by the mutex: the control thread exchanges model and solver. */
typedef struct figure {
    pthread_mutex_t mutex;
    const tfa_model *model;
    tfa_worker_robot solver;
    uint32_t frame_count, tip_count;
    int32_t *parents;    /* by frame; -1: none */
    double *poses;       /* frame_count x 7 */
    double *q, *inertia; /* q_count; 6 x 6 */
    figure_tip tips[FIGURE_TIPS];
    uint64_t computed; /* CLOCK_MONOTONIC ns; 0: not yet */
    int status;        /* of the poses */
} figure;

/* @param solver  NULL: the figure cannot be computed */
TFA_CHECKED int figure_open(figure *f, const tfa_model *model, const tfa_worker_robot *solver);
void figure_close(figure *f);
void figure_exchange(figure *f, const tfa_model *model, const tfa_worker_robot *solver);
/* Computes it for this state, unless that was done less than a period ago; the mutex is held. */
void figure_update(figure *f, const tfa_robot_state *state, uint64_t now);

/* ---- eigen.c ---- */

/* Eigenvalues, largest first, and unit eigenvectors of a symmetric matrix */
void eigen_symmetric3(const double matrix[9], double values[3], double vectors[3][3]);

/* ---- sampler.c: the last minute ---- */

enum { QUANTILE_50, QUANTILE_99, QUANTILE_999, QUANTILE_COUNT };
enum { TIME_QUEUE, TIME_COMPUTE, TIME_TOTAL, TIME_COUNT };

/* Figures of one second of a robot. */
typedef struct http_second {
    float requests, states, rejected, fallbacks; /* in a second */
    float times[TIME_COUNT][QUANTILE_COUNT];     /* us; negative: none */
} http_second;

typedef struct http_rate {
    tfa_served_client client;
    uint32_t slot;
    float requests; /* in a second */
} http_rate;

typedef struct sampler {
    tfa_statistics *statistics;
    tfa_snapshot *now, *before; /* at most a period old; at the beginning of this second */
    uint64_t read, second;      /* CLOCK_MONOTONIC ns: of now; of the last second's end */
    uint64_t seconds;           /* number of complete seconds */
    http_second *history;       /* robot x HTTP_SECONDS, number modulo HTTP_SECONDS */
    http_rate *rates;           /* of the last second's clients */
    uint32_t rate_count, rate_room;
    uint64_t *buckets; /* of one histogram */
} sampler;

TFA_CHECKED int sampler_open(sampler *s, int statistics);
void sampler_close(sampler *s);
/* Reads the statistics unless that was done less than a period ago. */
void sampler_update(sampler *s, uint64_t now);
/* Ends a second if one is over. @return ns until the next end */
uint64_t sampler_tick(sampler *s, uint64_t now);
/* Figures of a complete second, 0 the last one; NULL: it is not known. */
const http_second *sampler_second(const sampler *s, uint32_t robot, uint32_t ago);
/* Requests in a second of a client; negative: not known yet. */
double sampler_rate(const sampler *s, const tfa_client_statistics *client);

/* ---- the server ---- */

typedef struct http_connection {
    int socket; /* -1: free */
    bool metrics;
    uint64_t since; /* of the last reply's end, or of the beginning */
} http_connection;

struct tfa_http {
    char *address;
    uint32_t port;
    bool page;
    uint32_t *avoid; /* processors of workers and pool */
    size_t avoid_count;
    int listener;             /* -1: no page */
    int metrics_listener;     /* the thread's; -1: none */
    atomic_int next_listener; /* for the thread; HTTP_NO_CHANGE */
    int wake;                 /* eventfd */
    atomic_bool stop;
    bool running;
    pthread_t thread;
    struct MHD_Daemon *parser;
    http_connection connections[HTTP_CONNECTIONS];
    sampler sampler;
    figure *figures; /* one for each robot */
    uint32_t robot_count;
};

/* A reply's body, for free, and how to send it. */
typedef struct http_reply {
    unsigned code;
    const char *type; /* Content-Type */
    char *text;
    size_t size;
    char nonce[33]; /* of the page's script and style; "": it has none */
} http_reply;

uint64_t http_clock(void);

/* ---- routes.c ---- */

/* The reply to GET path?robot=.. @param robot  NULL: none named */
void route_answer(tfa_http *http, bool metrics, const char *path, const char *robot, http_reply *r);

/* ---- request.c: requests as MHD hands them on ---- */

/* May this value of the Host header be served? Pages of other names that point here may not read
 * us (DNS rebinding). @param host  NULL: there is none */
bool request_host_is_ours(const char *host, const char *address);

/* ---- state.c: JSON ---- */

void state_write_model(tfa_http *http, uint32_t robot, FILE *out);
void state_write_motion(tfa_http *http, uint32_t robot, FILE *out);
void state_write(tfa_http *http, uint32_t robot, FILE *out);

/* ---- json.c ---- */

void json_string(FILE *out, const char *text);
/* With six digits; null if it is not finite. */
void json_number(FILE *out, double number);
void json_numbers(FILE *out, const double *numbers, size_t count);

/* ---- page.c ---- */

/* The page with the numbers of the moment. */
void page_write(tfa_http *http, const char *nonce, FILE *out);

#endif
