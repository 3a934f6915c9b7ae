/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Status codes: one list of name, number, short text, and cause with remedy. TFA_OK is 0, errors
 * are negative. A function documents the statuses that it returns and what each means there.
 */
#ifndef TOTALFORCE_STATUS_H
#define TOTALFORCE_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#ifndef TFA_API
/** Exported by the shared library. */
#define TFA_API __attribute__((visibility("default")))
#endif
/** The compiler warns if the caller ignores the result. */
#define TFA_CHECKED __attribute__((warn_unused_result))

/** Rows of tfa_status: X(NAME, number, short text, cause and remedy) */
#define TFA_STATUS_LIST(X)                                                                         \
    X(OK, 0, "ok", "")                                                                             \
    X(E_ARGUMENT, -1, "invalid argument", "a required pointer is NULL or an enum is out of range") \
    X(E_SIZE, -2, "wrong size", "an array or a count does not fit the robot")                      \
    X(E_VALUE, -3, "not a finite number", "an input value is NaN or infinite")                     \
    X(E_QUATERNION, -4, "quaternion not normalised", "its norm is off from 1 by more than 1e-3")   \
    X(E_ROBOT, -5, "unknown robot", "no robot of that name is configured")                         \
    X(E_LINK, -6, "unknown link", "no link of that name or index in the robot")                    \
    X(E_JOINT, -7, "unknown joint", "no moving joint of that name in the robot")                   \
    X(E_METHOD, -8, "unknown method", "the method does not exist or does not answer this request") \
    X(E_SINGULAR, -9, "singular inertia",                                                          \
      "the method needs the inverse of a body's inertia; use aba or give the body an inertia")     \
    X(E_NO_MASS, -10, "massless moving part",                                                      \
      "nothing with mass moves with the joint: lock it, or give it mass or armature")              \
    X(E_MEMORY, -11, "out of memory", "an allocation at initialisation failed or is too small")    \
    X(E_FILE, -12, "file cannot be read", "see errno")                                             \
    X(E_PARSE, -13, "malformed file", "the report names file, line, element and value")            \
    X(E_MODEL, -14, "model cannot be built", "the report names link or joint and the remedy")      \
    X(E_NOT_COMPUTED, -15, "no reliable answer",                                                   \
      "the problem is singular at this configuration, or nearly, or a number overflows")           \
    X(E_AGAIN, -16, "ring full", "as many requests are outstanding as there are slots: wait one")  \
    X(E_TIMEOUT, -17, "timed out", "no reply within the given time; the id is reported later")     \
    X(E_DISCONNECTED, -18, "no daemon",                                                            \
      "none listens at the robot's socket, or it ended: start totalforced, then reconnect")        \
    X(E_PROTOCOL, -19, "protocol error", "the peer broke the protocol or speaks another version")  \
    X(E_REFUSED, -20, "refused",                                                                   \
      "the group of the socket, allow_*, refuse or a quota keeps this user or request out")        \
    X(E_SYSTEM, -21, "system call failed", "see errno")                                            \
    X(E_UNSUPPORTED, -22, "not supported", "this build or this robot cannot do that")              \
    X(E_LOST, -23, "request lost", "the daemon restarted while the request was under way: repeat") \
    X(E_BUSY, -24, "busy", "another thread is using it: compute without it, or ask again")         \
    X(E_LATE, -25, "too late", "the deadline passed before the work began: nothing was computed")  \
    X(E_RANK, -26, "rank lost",                                                                    \
      "lambda_inv has no inverse at this configuration: let rank_loss truncate or damp")           \
    X(E_OPEN, -27, "loops stay open",                                                              \
      "no posture near the start meets the constraints: start nearer, or measure fewer joints")

/** TFA_OK = 0, TFA_E_ARGUMENT = -1, ...: one constant for each row of TFA_STATUS_LIST. */
typedef enum tfa_status {
#define TFA_STATUS_ENUM(name, number, text, cause) TFA_##name = number,
    TFA_STATUS_LIST(TFA_STATUS_ENUM)
#undef TFA_STATUS_ENUM
} tfa_status;

/**
 * Short English text of a status, for instance "ring full"; "unknown status" for any other number.
 * Never NULL, static storage. Any thread.
 */
TFA_API const char *tfa_status_text(int status);

/** Cause of a status and its remedy; "" for TFA_OK. Never NULL, static storage. Any thread. */
TFA_API const char *tfa_status_cause(int status);

/** Name of a status without its prefix, for instance "E_AGAIN"; "E_UNKNOWN" for any other number.
 *  Never NULL, static storage. Any thread. */
TFA_API const char *tfa_status_name(int status);

#ifdef __cplusplus
}
#endif
#endif
