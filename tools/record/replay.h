/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Replay of a recording. Grouped by the file that defines it.
 */
#ifndef TOOLS_RECORD_REPLAY_H
#define TOOLS_RECORD_REPLAY_H

#include <totalforce/dynamics.h>
#include <totalforce/histogram.h>
#include <totalforce/specialised.h>

#include "common/daemon.h"
#include "record/compare.h"
#include "record/recorded_robot.h"
#include "record/recording.h"

#define REPLAY_BITS 8 /* of histograms */
#define REPLAY_BUCKETS TFA_HISTOGRAM_BUCKETS(REPLAY_BITS, 64)

typedef struct replay_options {
    const char *file, *urdf, *kernel;
    const char *robot, *runtime_dir; /**< of a daemon; robot NULL: in process */
    double tolerance;                /**< 0: the same bits */
    double hz;                       /**< 0: as fast as it goes; negative: at the recorded times */
    int any_model, json;
} replay_options;

/** A difference, and its record by number from 0. */
typedef struct replay_difference {
    uint64_t record;
    difference at;
} replay_difference;

typedef struct replay {
    const replay_options *options;
    recording file;
    size_t mapped;
    recorded_robot robot;
    char hash[65]; /**< of the model that replays */

    /* what answers */
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_specialised *specialised;
    daemon_link *daemon;

    size_t *records; /**< offsets, in the order of the replay */
    uint64_t *numbers;
    uint64_t count;
    uint32_t max_batch, max_tips; /**< of the records that are played */
    void *reply;                  /**< a slot */
    size_t reply_bytes;

    /* what came of it */
    uint64_t same, within, differing; /**< requests */
    uint64_t of_time;                 /**< not played: late, no room, or estimated by chance */
    uint64_t refused;                 /**< not played: by the configuration of the daemon */
    uint64_t differences;             /**< numbers */
    replay_difference first, largest; /**< largest.at.field NULL: none */
    tfa_histogram recorded, replayed; /**< ns from start to answer */
    uint64_t buckets[2][REPLAY_BUCKETS];
    char cut_off[80]; /**< the last record is incomplete; "": it is not */
} replay;

/* ---- replay_open.c ---- */

/** Reads the file and makes what answers. @return an exit status, after a message if not good */
int replay_open(replay *r, const replay_options *options);
void replay_close(replay *r);

/* ---- replay_run.c ---- */

/** A record as it is played. */
typedef struct replay_request {
    recorded from;
    tfa_wire_shape shape;
    tfa_wire_reply_shape reply_shape;
    tfa_request request;
    int status; /**< of its decoding: other than TFA_OK is the answer */
    tfa_field field;
} replay_request;

typedef enum replay_kind {
    REPLAY_PLAYED,
    REPLAY_OF_TIME,
    REPLAY_REFUSED,
    REPLAY_DAMAGED, /**< sizes that do not fit the robot */
} replay_kind;

/** Decodes a record. */
replay_kind replay_decode(const replay *r, const recorded *from, replay_request *out);

/** Plays all records and compares. @return an exit status, after a message if it failed */
int replay_run(replay *r);

/* ---- replay_print.c ---- */

void replay_print(const replay *r);
/** @return an exit status */
int replay_print_json(const replay *r);

#endif
