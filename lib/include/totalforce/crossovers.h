/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From which size on which way is the faster one: what `auto` goes by. Measured on a machine by
 * `totalforce chart --calibrate`, which writes the file that the daemon and the tools read.
 */
#ifndef TOTALFORCE_CROSSOVERS_H
#define TOTALFORCE_CROSSOVERS_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** From no size on. In files: never. */
#define TFA_NEVER UINT32_MAX

/* One row for each crossover:
 * X(name, shipped default, lowest value, unit, from how many of that unit on, what is done)
 * A number of threads between two of the rows goes by the smaller one, so do all above the last. The
 * shipped numbers stand with machine, date and command in config/crossovers.conf. */
#define TFA_CROSSOVER_LIST(X)                                                                      \
    X(lanes_from, 2, 2, "states", "a batch goes side by side in the lanes of a processor")         \
    X(pool_from, 2, 2, "bodies x states", "a batch is spread over the threads of a pool")          \
    X(scan_from_1, TFA_NEVER, 2, "bodies on a chain", "auto takes scan, one thread")               \
    X(scan_from_2, TFA_NEVER, 2, "bodies on a chain", "auto takes scan, two threads")              \
    X(scan_from_4, TFA_NEVER, 2, "bodies on a chain", "auto takes scan, four threads and more")    \
    X(lambda_scan_from_1, TFA_NEVER, 2, "bodies on a chain", "lambda_inv by scan, one thread")     \
    X(lambda_scan_from_2, TFA_NEVER, 2, "bodies on a chain", "lambda_inv by scan, two threads")    \
    X(lambda_scan_from_4, TFA_NEVER, 2, "bodies on a chain", "lambda_inv by scan, four and more")  \
    X(pv_from, 2, 2, "tips", "lambda_inv by pv-osimr, not propagation")

/** The method that `auto` takes depends on these, so an answer's last bits may: tfa_answer.method
 * says which it was. */
typedef struct tfa_crossovers {
#define TFA_CROSSOVER_MEMBER(name, standard, lowest, unit, what)                                   \
    uint32_t name; /**< lowest .. UINT32_MAX - 1, or TFA_NEVER */
    TFA_CROSSOVER_LIST(TFA_CROSSOVER_MEMBER)
#undef TFA_CROSSOVER_MEMBER
} tfa_crossovers;

/** Those shipped with the library, static storage. Any thread. */
TFA_API const tfa_crossovers *tfa_crossovers_default(void);

/**
 * Reads a file: `version: 1` first, then one `name: number` (or `never`) a line; `#` begins a
 * comment. What the file does not name is as shipped.
 *
 * @param error  gets "FILE:LINE: name: what; remedy", empty if nothing is wrong; may be NULL
 * @return TFA_OK; TFA_E_FILE (it cannot be read); TFA_E_PARSE (a line that is no such pair, a name
 *         that is not known or given twice, a number out of range, another version). *out is
 *         written with TFA_OK only.
 */
TFA_API TFA_CHECKED int tfa_crossovers_read(const char *path, tfa_crossovers *out, char *error,
                                            size_t error_size);

/**
 * What tfa_crossovers_read reads, as text, every number with its meaning.
 * @param remark  lines for its head (machine, date, command), each becomes a comment; NULL: none
 * @return its length without the final NUL; when that is not below `size` it was cut short
 */
TFA_API size_t tfa_crossovers_text(const tfa_crossovers *crossovers, const char *remark, char *text,
                                   size_t size);

#ifdef __cplusplus
}
#endif
#endif
