/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of the ROS 2 gateway, grouped by the file that defines them.
 *
 * The gateway's thread does all the work; the mutex of a robot lets the control thread exchange its
 * model between two messages. Cyclone's receiving threads run the filters only.
 */
#ifndef TFA_SERVICE_DDS_ROS2_INTERNAL_H
#define TFA_SERVICE_DDS_ROS2_INTERNAL_H

#include "dds/ros2/ros2.h"

#include "dds/common/dds_domain.h"
#include "dds/common/gateway_solve.h"
#include "dds/ros2/joint_inputs.h"
#include "dds/ros2/ros2_names.h"
#include "worker/worker.h"

#include <dds/dds.h>
#include <idl/ros2.h>
#include <idl/unitree.h>
#include <pthread.h>
#include <stdatomic.h>
#include <totalforce/observer.h>

#define ROS2_MOTORS_MAX 35 /* of a Unitree robot: unitree_hg */
#define ROS2_FRAME_MAX 127 /* bytes of a frame_id that is echoed; longer ones are cut */

/* Kinds of inputs, in the order in which the messages of one wake-up are read: states before the
 * commands that need them. */
typedef enum ros2_input_kind {
    ROS2_ROBOT_DESCRIPTION,
    ROS2_JOINT_STATES,
    ROS2_LOW_STATE_GO,
    ROS2_LOW_STATE_HG,
    ROS2_ODOMETRY,
    ROS2_WRENCH,
    ROS2_CONSTRAINTS,
    ROS2_EFFORT_COMMANDS,
    ROS2_JOINT_EFFORTS,
    ROS2_TRAJECTORY,
    ROS2_FORWARD_DYNAMICS, /* requests of the service */
    ROS2_INPUT_KINDS
} ros2_input_kind;

static inline bool ros2_is_command(ros2_input_kind kind)
{
    return kind >= ROS2_EFFORT_COMMANDS;
}

/* Answers, below the node; names in the order of the kinds. */
#define ROS2_OUTPUT_NAMES                                                                          \
    "accelerations", "constraint_wrenches", "gravity_torques", "external_torques",                 \
        "external_base_wrench", "external_wrench", "lambda_inv", "jacobian", "bias_acceleration"
typedef enum ros2_output_kind {
    ROS2_ACCELERATIONS,
    ROS2_CONSTRAINT_WRENCHES,
    ROS2_GRAVITY_TORQUES,
    ROS2_EXTERNAL_TORQUES,
    ROS2_EXTERNAL_BASE_WRENCH,
    ROS2_EXTERNAL_WRENCH,
    ROS2_LAMBDA_INV,
    ROS2_JACOBIAN,
    ROS2_BIAS_ACCELERATION,
    ROS2_OUTPUT_KINDS
} ros2_output_kind;

typedef struct ros2_robot ros2_robot;
typedef struct tfa_ros2 tfa_ros2;

/* A list of names. */
typedef struct ros2_texts {
    char **text;
    uint32_t count;
} ros2_texts;

/* A topic that is read. */
typedef struct ros2_input {
    ros2_input_kind kind;
    uint32_t index;                   /* of a wrench */
    char name[TFA_ROS2_NAME_MAX + 1]; /* in ROS */
    dds_entity_t reader;
    void *sample; /* its sequences are reused by the next message */
    ros2_robot *robot;
    /* Of the filter, in Cyclone's receiving threads; relaxed: they order nothing, and a limit that
     * is seen late lets a message pass or drops it. */
    _Atomic uint32_t name_limit; /* names and numbers of a message at most; set_arrays writes it */
    _Atomic uint64_t oversized;  /* dropped; diagnostics read it */
    uint64_t received, refused;  /* messages */
    uint32_t publishers;         /* at the last diagnostics */
    uint64_t received_before, refused_before, oversized_before; /* at the last diagnostics */
    int64_t last;    /* receipt of the last message, ns; 0: none */
    char error[160]; /* why the last one was refused */
} ros2_input;

/* Up to one of each kind, but several wrenches. */
#define ROS2_INPUTS_MAX (ROS2_INPUT_KINDS + TFA_MAX_WRENCHES)

/* Stamp and frame of a message, for correlation. */
typedef struct ros2_header {
    int32_t sec;
    uint32_t nanosec;
    char frame[ROS2_FRAME_MAX + 1];
} ros2_header;

/* A value with the time of its receipt. */
typedef struct ros2_wrench {
    double value[6];
    int64_t received; /* ns; 0: never */
} ros2_wrench;

/* Pose and twist of a floating base. */
typedef struct ros2_base {
    double pose[7], twist[6];
    int64_t received; /* ns; 0: never */
} ros2_base;

/* Constraints that are active: bits of tfa_model_constraint. */
typedef struct ros2_active {
    uint32_t bits;
    int64_t received; /* ns; 0: never */
} ros2_active;

/* What the observer has seen; diagnostics log and publish it, for the path of a state prints
 * nothing. */
typedef struct ros2_observed {
    uint64_t states;          /* that came; those that lack values are among them */
    uint64_t samples;         /* that the observer took */
    uint64_t restarts;        /* the first sample included */
    const char *start;        /* why the next sample is the first; NULL: an invalid one before */
    const char *reason;       /* of the last restart */
    tfa_observer_event event; /* of the last restart */
    double gap;               /* s, from the sample before to the last restart; 0: none before */
    int64_t stamp;            /* ns, of the last sample; of joint states, else of receipt */
    double time;              /* s, of the last sample, as the observer has it */
    bool lacking;             /* states come without what it needs, and the log says so */
} ros2_observed;

/* Everything whose size depends on the model, and the messages that point at it. */
typedef struct ros2_arrays {
    const tfa_model *model;
    uint32_t joints, base; /* base: 6 or 0 */
    uint32_t tip_count, tips[TFA_MAX_TIPS];
    uint32_t wrench_frames[TFA_MAX_WRENCHES];
    const char **names;         /* of the joints, in the model */
    const char **command_names; /* of effort_commands */
    uint32_t command_count;
    tfa_joint_inputs *state, *command;
    tfa_joint_inputs *call;               /* of a service */
    int32_t motor_joint[ROS2_MOTORS_MAX]; /* joint of each motor; -1: none */
    double *numbers;                      /* the memory of the following */
    double *q, *v, *tau, *qdd, *gravity, *lambda_inv, *jacobian, *bias;
    double base_acceleration[6];
    uint32_t default_constraints, constraints; /* without a message; of the last answer: bits */
    double constraint_wrench[TFA_MAX_CONSTRAINTS][6];
    char *constraint_name[TFA_MAX_CONSTRAINTS]; /* of the last answer */
    sensor_msgs_msg_dds__MultiDOFJointState_ constraint_wrenches;
    tfa_answer answer;
    char *row_label, *column_label; /* of the tips' rows; of the freedoms */
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ point;
    trajectory_msgs_msg_dds__JointTrajectory_ accelerations;
    sensor_msgs_msg_dds__JointState_ gravity_torques;
    tfa_observer *observer; /* NULL: none */
    uint32_t observer_tip;
    sensor_msgs_msg_dds__JointState_ external_torques;
    geometry_msgs_msg_dds__WrenchStamped_ external_base_wrench, external_wrench;
    std_msgs_msg_dds__MultiArrayDimension_ dimensions[ROS2_OUTPUT_KINDS][3];
    std_msgs_msg_dds__Float64MultiArray_ array[ROS2_OUTPUT_KINDS];
    char stamp_label[ROS2_FRAME_MAX + 64];
} ros2_arrays;

/* What the answers were, since the start. */
typedef struct ros2_counts {
    uint64_t answers; /* to commands */
    uint64_t states;  /* answered */
    uint64_t refused; /* answers that could not be given */
    uint64_t fallbacks, estimates, dropped;
    double largest_estimate;
    uint16_t method;   /* that answered last */
    char refusal[160]; /* why the last one was refused */
} ros2_counts;

struct ros2_robot {
    char name[64], node_namespace[TFA_ROS2_NAME_MAX + 1], node[TFA_ROS2_NAME_MAX + 1];
    uint32_t index;       /* in the robot set */
    size_t config_number; /* of the robot in the configuration */
    struct tfa_ros2 *gateway;
    int64_t state_age, command_age; /* ns */
    bool constrained;               /* its commands are answered by constrained_dynamics */
    tfa_observer_options observer;  /* gain 0: none */
    uint32_t state_values;          /* of joint states: bits 1 << tfa_joint_value */
    /* of the configuration, copied */
    ros2_texts joints, tips, motors, wrench_links, constraints, observer_tip;
    ros2_input inputs[ROS2_INPUTS_MAX];
    uint32_t input_count;
    dds_entity_t writers[ROS2_OUTPUT_KINDS];
    dds_entity_t reply_writer; /* of the service; 0: none */
    uint32_t subscribers;      /* of all outputs, at the last diagnostics */

    pthread_mutex_t mutex; /* guards what follows */
    ros2_arrays *arrays;   /* NULL: no memory at the last exchange */
    gateway_robot own;
    ros2_header state_header;
    uint32_t tick;         /* ms, of the last LowState */
    int64_t tick_received; /* ns; 0: never */
    bool state_is_new;
    ros2_base base;
    ros2_wrench wrenches[TFA_MAX_WRENCHES];
    ros2_active active;
    ros2_counts counts, counts_before;       /* before: at the last diagnostics */
    ros2_observed observed, observed_before; /* as above */
    char description_error[200];
    uint64_t descriptions, descriptions_refused;
};

/* The robots of one domain. */
struct tfa_ros2 {
    ros2_robot *robots;
    uint32_t robot_count;
    uint32_t id;             /* of the domain */
    bool humble;             /* release of its nodes */
    gateway_context context; /* without its settings */
    dds_member member;
    dds_entity_t waitset, stop;
    dds_entity_t graph_writer, diagnostics_writer;
    dds_entity_t publications;  /* reader of what is published in the domain */
    struct ros2_report *report; /* diagnostics.c */
    pthread_t thread;
    bool running;
};

/* ---- gateway.c: robots of one domain ---- */

typedef struct tfa_ros2_options {
    const gateway_context *context;
    uint32_t domain, common; /* robots of this domain; that of section "ros2" or the environment */
    const char *settings;    /* Cyclone's XML for the domain, before CYCLONEDDS_URI; NULL: the
                                domain was made already */
} tfa_ros2_options;

/* Joins the domain and creates every entity, but nothing is read yet. @return TFA_OK;
 * TFA_E_MEMORY; TFA_E_SYSTEM: see tfa_dds_error. On error *gateway is NULL. */
TFA_CHECKED int tfa_ros2_create(const tfa_ros2_options *options, tfa_ros2 **gateway);
/* Begins to read and answer. `solvers` (copied), by robot of the set, are the gateway's own.
 * @return TFA_OK; TFA_E_SYSTEM */
TFA_CHECKED int tfa_ros2_start(tfa_ros2 *gateway, const tfa_worker_robot *solvers);
/* Another model, which was checked. @return TFA_OK; TFA_E_MEMORY: the robot is silent until the
 * next exchange */
TFA_CHECKED int ros2_exchange(ros2_robot *robot, const tfa_model *model,
                              const tfa_worker_robot *solver);
/* NULL is allowed, and a gateway that never started. */
void tfa_ros2_stop(tfa_ros2 *gateway);
/* False: a standby, which leaves the answer to the leader. */
static inline bool ros2_leads(const ros2_robot *robot)
{
    const gateway_context *c = &robot->gateway->context;
    return !c->leads || c->leads(c->self, robot->index);
}

/* ---- endpoints.c: readers and writers as those of rmw_cyclonedds ---- */

/* Reader of an input; its filter drops messages that are too long for the robot. */
dds_entity_t ros2_make_reader(dds_entity_t participant, ros2_input *input);
/* Writer of an output with this full name. */
dds_entity_t ros2_make_writer(dds_entity_t participant, ros2_output_kind kind, const char *name);
/* Writer of a service's replies. */
dds_entity_t ros2_make_reply_writer(dds_entity_t participant, const char *name);
dds_entity_t ros2_make_diagnostics_writer(dds_entity_t participant);
dds_entity_t ros2_make_graph_writer(dds_entity_t participant, bool humble);
/* Messages of a robot with so many joints may have so many names. */
uint32_t ros2_name_limit(uint32_t joints);
/* Type of the input's messages. */
const dds_topic_descriptor_t *ros2_input_type(ros2_input_kind kind);

/* ---- arrays.c ---- */

/* NULL: no memory. */
ros2_arrays *ros2_arrays_create(const ros2_robot *robot, const tfa_model *model);
void ros2_arrays_free(ros2_arrays *a);

/* ---- inputs.c: from messages to values; the robot is locked ---- */

/* Takes what has come. */
void ros2_read_inputs(ros2_robot *robot, int64_t now);
/* A state is there, with this header. */
void ros2_take_state(ros2_robot *robot, const ros2_header *header, int64_t now);
/* Reads one message of the input. */
void ros2_read_message(ros2_input *in, const void *sample, int64_t now);
/* The arrays of a JointState. */
tfa_joint_message ros2_message_of(const sensor_msgs_msg_dds__JointState_ *m);
/* Refuses a message of the input. */
__attribute__((format(printf, 2, 3))) void ros2_refuse(ros2_input *input, const char *format, ...);
/* Merges a message into joint values, and refuses it if all or a joint of it is bad. @return false:
 * all of it is */
bool ros2_merge(ros2_input *in, tfa_joint_inputs *into, const tfa_joint_message *m, uint32_t values,
                int64_t now);
#define ROS2_STATE_VALUES (1u << TFA_JOINT_POSITION | 1u << TFA_JOINT_VELOCITY)
#define ROS2_OBSERVED_VALUES (ROS2_STATE_VALUES | 1u << TFA_JOINT_EFFORT)
/* Why the last merge or read was refused. */
void ros2_fault_text(const tfa_joint_inputs *inputs, char *text, size_t size);

/* ---- unitree.c ---- */

void ros2_read_low_state_go(ros2_input *in, const void *sample, int64_t now);
void ros2_read_low_state_hg(ros2_input *in, const void *sample, int64_t now);

/* ---- answers.c: from values to answers; the robot is locked ---- */

/* Forward or constrained dynamics of the state and the commands as they are; their header is
 * echoed. */
void ros2_answer_command(ros2_robot *robot, const ros2_header *header, int64_t now);
/* Answers a call of the service. */
void ros2_answer_call(ros2_input *in, const void *sample, int64_t now);
/* Operational space and gravity torques of the state, for those that read them. */
void ros2_answer_state(ros2_robot *robot, int64_t now);
/* Takes the state into the observer, and publishes what it says. */
void ros2_observe(ros2_robot *robot, int64_t now);

/* ---- diagnostics.c ---- */

/* A report with room for all robots; NULL: no memory. */
struct ros2_report *ros2_report_create(const tfa_ros2 *gateway);
void ros2_report_free(struct ros2_report *report);
/* Publishes the condition of all robots that this daemon answers for. */
void ros2_publish_diagnostics(tfa_ros2 *gateway, int64_t now);

/* ---- statistics.c; the robot is locked ---- */

/* Publishes the counts of inputs and outputs. */
void ros2_publish_statistics(const ros2_robot *robot);

/* ---- graph.c: presence in `ros2 node list` ---- */

/* @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM */
TFA_CHECKED int ros2_publish_graph(const tfa_ros2 *gateway);

#endif
