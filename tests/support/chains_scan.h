/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Chains that are hard for some method: unit links, each hung on the tip of the one before.
 */
#ifndef TESTS_SUPPORT_CHAINS_SCAN_H
#define TESTS_SUPPORT_CHAINS_SCAN_H

#include <stdint.h>
#include <totalforce/description.h>

typedef enum chain_mechanism {
    CHAIN_STRAIGHT,     /**< joints about y and z in turn, all at 0 */
    CHAIN_HELIX,        /**< every joint alike */
    CHAIN_RANDOM,       /**< links turned at random, joints at any angle */
    CHAIN_TAPER,        /**< random; mass falls a hundredfold, root to tip */
    CHAIN_SWELLING,     /**< random; mass grows a millionfold, root to tip */
    CHAIN_HEAVY_TIP,    /**< random; the last link weighs 1e6 */
    CHAIN_HEAVY_SPOTS,  /**< random; every 40th link weighs 1e6 */
    CHAIN_ALTERNATING,  /**< random; every second link weighs 1e-6 */
    CHAIN_ALTERNATING9, /**< the same with 1e-9 */
    CHAIN_THIN,         /**< random; radius 1e-4 */
    CHAIN_COMPACT,      /**< random; links a thousandth as long as what joins them */
    CHAIN_POINTS,       /**< random; two links of three are points */
    CHAIN_MIXED,        /**< random; all types of joints, armature */
    CHAIN_ZIGZAG,       /**< bent by 1 rad to and fro, joints by turns in and across its plane */
    CHAIN_PLANAR,       /**< random bends in one plane, all joints across it */
    CHAIN_LIGHT_HEAVY,  /**< random; the outboard half weighs 1e6 a link */
    CHAIN_MASSLESS,     /**< random; every second link, never the tip, weighs nothing */
    CHAIN_BRANCHES,     /**< random; every second link of the chain carries two more as a branch */
    CHAIN_MECHANISMS
} chain_mechanism;

extern const char *const chain_mechanism_names[CHAIN_MECHANISMS];

/** n moving links behind a fixed root. Release with chain_free. */
tfa_description *chain_create(chain_mechanism mechanism, uint32_t n, uint64_t seed);
void chain_free(tfa_description *description);

/** Coordinates of the joints: the mechanism's own, or at random. Writes at most 7 n numbers. */
void chain_coordinates(chain_mechanism mechanism, const tfa_description *description, uint64_t seed,
                       double *q);

#endif
