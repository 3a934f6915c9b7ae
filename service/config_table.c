/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every key of the configuration, once.
 */
#include "config_table.h"

#include "worker.h"

#define AT(type, member) .at = offsetof(type, member)
#define LIST_AT(type, member)                                                                      \
    .at = offsetof(type, member), .count_at = offsetof(type, member##_count)

static const char *const base_words[] = {"fixed", "floating", NULL};
static const char *const scene_base_words[] = {"fixed", "floating", "same", NULL};
/* in the order of the enums in model.h */
static const char *const inertia_words[] = {"strict", "warn", "repair", "strict-physical", NULL};
static const char *const mimic_words[] = {"free", "project", "lock", NULL};
static const char *const estimate_words[] = {"default", "never", "sampled", "always", NULL};
static const char *const precision_words[] = {"f64", "f32", NULL};
/* in the order of tfa_residual */
static const char *const residual_words[] = {"same", "f64", "f128", NULL};
/* in the order of config_methods */
static const char *const methods_words[] = {"auto", "all", NULL};
/* in the order of config_specialise */
static const char *const specialise_words[] = {"off", "load", NULL};
static const char *const backend_words[] = {"shm", "memfd", NULL};
/* the index is tfa_wait; nobody configures "default" */
static const char *const wait_words[] = {"default", "spin", "hybrid", "block", NULL};
static const char *const log_words[] = {"error", "warning", "info", "debug", NULL};

/* clang-format off */

static const config_row armature_rows[] = {
    {"joint", CONFIG_TEXT, AT(config_armature, joint), .required = true, .live = true,
     .help = "Name of the joint"},
    {"value", CONFIG_NUMBER, AT(config_armature, value), .required = true, .live = true, .low = 0,
     .high = 1e6, .help = "Reflected rotor inertia, kg m^2 (revolute) or kg (prismatic)"},
    {0}};
static const config_table armature_table = {armature_rows, sizeof(config_armature)};

static const config_row lock_rows[] = {
    {"joint", CONFIG_TEXT, AT(config_lock, joint), .required = true, .live = true,
     .help = "Name of the joint"},
    {"q", CONFIG_NUMBER, AT(config_lock, q), .live = true, .low = -1e6, .high = 1e6,
     .help = "Where it stands, rad or m"},
    {"pose", CONFIG_LIST, LIST_AT(config_lock, pose), .live = true, .low = 3, .high = 7,
     .entry = CONFIG_NUMBER,
     .help = "In place of q: planar x y theta; floating x y z and quaternion x y z w"},
    {0}};
static const config_table lock_table = {lock_rows, sizeof(config_lock)};

static const config_row payload_rows[] = {
    {"link", CONFIG_TEXT, AT(config_payload, link), .required = true, .live = true,
     .help = "Link that carries it, rigidly"},
    {"mass", CONFIG_NUMBER, AT(config_payload, mass), .required = true, .live = true, .low = 0,
     .high = 1e9, .help = "kg"},
    {"com", CONFIG_LIST, LIST_AT(config_payload, com), .live = true, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .help = "Centre of mass, m, link frame; its origin when absent"},
    {"inertia", CONFIG_LIST, LIST_AT(config_payload, inertia), .live = true, .low = 6, .high = 6,
     .entry = CONFIG_NUMBER,
     .help = "ixx ixy ixz iyy iyz izz about the centre of mass, kg m^2; a point when absent"},
    {0}};
static const config_table payload_table = {payload_rows, sizeof(config_payload)};

static const config_row scene_rows[] = {
    {"name", CONFIG_TEXT, AT(config_scene, name), .required = true,
     .help = "Served as ROBOT.SCENE, with a socket of its own"},
    {"root", CONFIG_TEXT, AT(config_scene, root), .live = true,
     .help = "Only what hangs from this link, which takes the root's place; all when absent"},
    {"tips", CONFIG_LIST, LIST_AT(config_scene, tips), .live = true, .low = 0, .high = 1000,
     .entry = CONFIG_TEXT,
     .help = "Fixed base: only the trees that carry one of these links; all when absent"},
    {"locked", CONFIG_LIST, LIST_AT(config_scene, locked), .live = true, .low = 0, .high = 100000,
     .table = &lock_table, .help = "Joints that do not move: absent from q, v, tau and qdd"},
    {"payload", CONFIG_LIST, LIST_AT(config_scene, payload), .live = true, .low = 0, .high = 1000,
     .table = &payload_table, .help = "Loads on links"},
    {"base", CONFIG_WORD, AT(config_scene, base), .live = true, .standard = CONFIG_BASE_SAME,
     .words = scene_base_words, .help = "fixed, floating, or same: as the robot"},
    {"gravity", CONFIG_LIST, LIST_AT(config_scene, gravity), .live = true, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .help = "m/s^2, world frame; the robot's when absent"},
    {0}};
static const config_table scene_table = {scene_rows, sizeof(config_scene)};

static const config_row robot_rows[] = {
    {"name", CONFIG_TEXT, AT(config_robot, name), .required = true,
     .help = "What clients ask for; names the socket: letters, digits, '-', '_', '.'"},
    {"urdf", CONFIG_TEXT, AT(config_robot, urdf), .required = true, .live = true,
     .help = "The robot's file; a relative path starts at this configuration file"},
    {"base", CONFIG_WORD, AT(config_robot, base), .live = true, .standard = TFA_BASE_FIXED,
     .words = base_words, .help = "fixed or floating"},
    {"gravity", CONFIG_LIST, LIST_AT(config_robot, gravity), .live = true, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .help = "m/s^2, world frame; 0 0 -9.80665 when absent"},
    {"armature", CONFIG_LIST, LIST_AT(config_robot, armature), .live = true, .low = 0,
     .high = 100000, .table = &armature_table,
     .help = "Rotor inertias by joint; URDF cannot say them"},
    {"rotor_inertia", CONFIG_BOOL, AT(config_robot, rotor_inertia), .live = true, .standard = false,
     .help = "Apply drake:rotor_inertia of the file"},
    {"inertia", CONFIG_WORD, AT(config_robot, inertia), .live = true,
     .standard = TFA_INERTIA_STRICT, .words = inertia_words,
     .help = "Inertias that no body can have: strict, warn, repair, strict-physical"},
    {"mimic", CONFIG_WORD, AT(config_robot, mimic), .live = true, .standard = TFA_MIMIC_FREE,
     .words = mimic_words,
     .help = "Joints that mimic others: free (ordinary joints), project (exact), lock"},
    {"damping", CONFIG_BOOL, AT(config_robot, damping), .live = true, .standard = false,
     .help = "Subtract the file's joint damping times velocity from tau"},
    {"lock_massless_leaves", CONFIG_BOOL, AT(config_robot, lock_massless_leaves), .live = true,
     .standard = false,
     .help = "Joints that move nothing with mass become fixed at 0; otherwise they are an error"},
    {"snap", CONFIG_NUMBER, AT(config_robot, snap), .live = true, .standard = 0, .low = 0,
     .high = TFA_SNAP_MAX,
     .help = "Rotations within this angle (rad) of right angles become exactly that; 0: as written"},
    {"scenes", CONFIG_LIST, LIST_AT(config_robot, scenes), .low = 0, .high = 1000,
     .table = &scene_table, .help = "Parts or loads of the robot, each served as ROBOT.SCENE"},
    {"estimate", CONFIG_WORD, AT(config_robot, estimate), .live = true,
     .standard = CONFIG_ESTIMATE_DEFAULT, .words = estimate_words,
     .help = "Error estimate where a request leaves it open: default (sentinel), never, sampled, always"},
    {"estimate_every", CONFIG_COUNT, AT(config_robot, estimate_every), .live = true,
     .standard = 100, .low = 1, .high = 1e9, .help = "sampled: one request in so many"},
    {"precision", CONFIG_WORD, AT(config_robot, precision), .live = true,
     .standard = CONFIG_PRECISION_F64, .words = precision_words,
     .help = "Arithmetic of the factors: f64, f32 (docs/methods.md)"},
    {"residual", CONFIG_WORD, AT(config_robot, residual), .live = true,
     .standard = TFA_RESIDUAL_SAME, .words = residual_words,
     .help = "Arithmetic in which accelerations are refined and all else is answered: same, f64, f128"},
    {"wait", CONFIG_WORD, AT(config_robot, wait), .standard = TFA_WAIT_HYBRID,
     .words = wait_words, .low = TFA_WAIT_SPIN,
     .help = "For clients that leave it open: spin, hybrid, block"},
    {"slots", CONFIG_COUNT, AT(config_robot, slots), .live = true, .standard = 64, .low = 1,
     .high = TFA_RING_SLOTS_MAX, .help = "Most requests a client may have outstanding"},
    {"max_batch", CONFIG_COUNT, AT(config_robot, max_batch), .standard = 64, .low = 1,
     .high = 65536, .help = "Most states of one request"},
    {"cut", CONFIG_COUNT, AT(config_robot, cut), .live = true, .standard = 32, .low = 1,
     .high = 65536,
     .help = "Longer batches are solved so many states at a time; others' short requests come between"},
    {"methods", CONFIG_WORD, AT(config_robot, methods), .live = true,
     .standard = CONFIG_METHODS_AUTO, .words = methods_words,
     .help = "Room for all methods, or, beyond 256 bodies, only for what auto takes: auto, all"},
    {"dds", CONFIG_BOOL, AT(config_robot, dds), .standard = true,
     .help = "Answer for this robot over DDS, if dds is enabled"},
    {0}};
static const config_table robot_table = {robot_rows, sizeof(config_robot)};

static const config_row limit_rows[] = {
    {"clients", CONFIG_COUNT, AT(config_limits, clients), .live = true, .standard = 64, .low = 1,
     .high = TFA_WORKER_SEATS - 32, .help = "Most clients at once"},
    {"clients_per_user", CONFIG_COUNT, AT(config_limits, clients_per_user), .live = true,
     .standard = 32, .low = 1, .high = TFA_WORKER_SEATS - 32, .help = "Most clients of one user at once"},
    {"memory_mib", CONFIG_COUNT, AT(config_limits, memory_mib), .live = true, .standard = 512, .low = 1,
     .high = 1048576, .help = "Most shared memory for all clients together, MiB"},
    {0}};
static const config_table limit_table = {limit_rows, sizeof(config_limits)};

static const config_row realtime_rows[] = {
    {"priority", CONFIG_COUNT, AT(config_realtime, priority), .standard = 0, .low = 0, .high = 99,
     .help = "SCHED_FIFO priority of the workers; 0: the ordinary scheduler"},
    {"affinity", CONFIG_LIST, LIST_AT(config_realtime, affinity), .low = 0, .high = 1024,
     .entry = CONFIG_COUNT, .help = "Processor of each worker, in order; none: any"},
    {"mlock", CONFIG_BOOL, AT(config_realtime, mlock), .standard = false,
     .help = "Lock all memory of the daemon"},
    {0}};
static const config_table realtime_table = {realtime_rows, sizeof(config_realtime)};

static const config_row pool_rows[] = {
    {"threads", CONFIG_COUNT, AT(config_pool, threads), .standard = 0, .low = 0, .high = 256,
     .help = "Threads that work on one large request, the worker's own included; 0: no pool"},
    {"from", CONFIG_COUNT, AT(config_pool, from), .standard = 1000, .low = 1, .high = 1e9,
     .help = "Large: so many bodies times states"},
    {"spin_ns", CONFIG_COUNT, AT(config_pool, spin_ns), .standard = 50000, .low = 1, .high = 4e9,
     .help = "An idle thread spins so long before it sleeps; waking it is a system call"},
    {"priority", CONFIG_COUNT, AT(config_pool, priority), .standard = 0, .low = 0, .high = 99,
     .help = "SCHED_FIFO priority of its threads; 0: the ordinary scheduler"},
    {"affinity", CONFIG_LIST, LIST_AT(config_pool, affinity), .low = 0, .high = 256,
     .entry = CONFIG_COUNT,
     .help = "Processor of each thread besides the workers, in order; none: any"},
    {0}};
static const config_table pool_table = {pool_rows, sizeof(config_pool)};

static const config_row dds_rows[] = {
    {"enabled", CONFIG_BOOL, AT(config_dds, enabled), .standard = false,
     .help = "Join a DDS domain and answer there, too"},
    {"domain", CONFIG_COUNT, AT(config_dds, domain), .standard = 0, .low = 0, .high = 230,
     .help = "DDS domain id"},
    {0}};
static const config_table dds_table = {dds_rows, sizeof(config_dds)};

static const config_row top_rows[] = {
    {"runtime_dir", CONFIG_TEXT, AT(config, runtime_dir),
     .help = "Sockets and lock; $TOTALFORCE_RUNTIME_DIR, else /run/totalforce ($XDG_RUNTIME_DIR/"
             "totalforce if not root)"},
    {"group", CONFIG_TEXT, AT(config, group), .help = "Group that may connect (sockets are 0660)"},
    {"user", CONFIG_TEXT, AT(config, user),
     .help = "Started by root: becomes this user when priorities and locks are held"},
    {"log", CONFIG_WORD, AT(config, log_level), .standard = 2, .words = log_words,
     .help = "error, warning, info, debug"},
    {"workers", CONFIG_COUNT, AT(config, workers), .standard = 1, .low = 1, .high = 64,
     .help = "Threads that answer; a client belongs to one"},
    {"spin_ns", CONFIG_COUNT, AT(config, spin_ns), .standard = 50000, .low = 0, .high = 1e9,
     .help = "hybrid: spins so long before it sleeps; longer than the worst computation"},
    {"allow_spin", CONFIG_BOOL, AT(config, allow_spin), .standard = true,
     .help = "Clients may ask for spin, which takes the worker's core while they are connected"},
    {"backend", CONFIG_WORD, AT(config, backend), .standard = CONFIG_BACKEND_SHM,
     .words = backend_words, .help = "Memory shared with clients: shm or memfd"},
    {"specialise", CONFIG_WORD, AT(config, specialise), .standard = CONFIG_SPECIALISE_OFF,
     .words = specialise_words, .live = true,
     .help = "Specialised kernels of totalforce specialise: off, load"},
    {"specialise_directory", CONFIG_TEXT, AT(config, specialise_directory), .live = true,
     .help = "Where they are; only root and the daemon's user may write there and above"},
    {"limits", CONFIG_GROUP, AT(config, limits), .table = &limit_table,
     .help = "What clients may take"},
    {"realtime", CONFIG_GROUP, AT(config, realtime), .table = &realtime_table,
     .help = "Each needs a permission; what could not be had is reported"},
    {"pool", CONFIG_GROUP, AT(config, pool), .table = &pool_table,
     .help = "Several cores for large requests; whichever worker has one may use it"},
    {"dds", CONFIG_GROUP, AT(config, dds), .table = &dds_table, .help = "The DDS door"},
    {"robots", CONFIG_LIST, LIST_AT(config, robots), .required = true, .low = 1, .high = 1000,
     .table = &robot_table, .help = "The robots that are served"},
    {0}};
const config_table config_top = {top_rows, sizeof(config)};

/* clang-format on */

_Static_assert(sizeof top_rows / sizeof *top_rows <= CONFIG_ROWS_MAX, "more keys: raise the limit");
_Static_assert(sizeof robot_rows / sizeof *robot_rows <= CONFIG_ROWS_MAX, "as above");

size_t config_entry_size(const config_row *row)
{
    if (row->table)
        return row->table->size;
    switch (row->entry) {
    case CONFIG_COUNT:
        return sizeof(uint32_t);
    case CONFIG_TEXT:
        return sizeof(const char *);
    default:
        return sizeof(double);
    }
}
