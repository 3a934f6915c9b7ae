# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Rigid-body dynamics of robots.

    model = totalforce.Model("arm.urdf")
    workspace = totalforce.Workspace(model)
    reply = workspace.forward_dynamics(q, v, tau)
    reply.qdd                                   # rad/s^2, (n_v,)

Model       a robot of a URDF file, compiled once; constant, shared by all threads
Workspace   answers requests in this process, one thread at a time
Pool        answers requests on several cores
Client      answers requests of a robot that a daemon serves, over shared memory
Observer    external joint torques from q, v and tau of one of them
Statistics  counters, clients and histograms of a running daemon

Workspace, Pool and Client have the same methods, one for each op: forward_dynamics,
inverse_dynamics, operational_inertia, mass_matrix, kinematics, bias, task_torques, derivatives,
inverse_dynamics_derivatives, constrained_dynamics, impact,
constrained_inverse_dynamics, regressor.
Each takes numpy arrays of one state, (n,), or of a batch, (count, n), and returns a Reply, whose
attributes are arrays. All give the same bits as the library in C.

SI units; six-vectors linear first, angular second; quaternions x y z w; matrices row major. Joints
are named and ordered as Model.joint_names. With a floating base, q, v, tau, qdd and the forces of
bias hold the joints only, and the base has fields of its own (base_pose, base_gravity, ...);
matrices have its six freedoms first.

Errors are exceptions of totalforce.errors, all derived from Error.
"""
from __future__ import annotations

import os
from typing import Iterable, Optional

try:
    from . import _totalforce  # noqa: F401
except (ImportError, RuntimeError) as _error:
    from .import_error import explain as _explain

    raise ImportError(_explain(_error)) from _error

from ._totalforce import (
    ANSWER_ESTIMATED,
    ANSWER_FALLBACK,
    ANSWER_INACCURATE,
    ANSWER_MODE_LIMIT,
    ANSWER_NOT_FINITE,
    ANSWER_PULLS,
    ANSWER_RANK_LOSS,
    ANSWER_RESIDUAL_PRECISION,
    ANSWER_SENTINEL,
    ANSWER_STALLED,
    MAX_PAYLOADS,
    MAX_REFINE,
    MAX_TIPS,
    MAX_WRENCHES,
    OPS,
    STATUSES,
    Advice,
    Body,
    BuildResult,
    Client,
    Configuration,
    DeclaredJoint,
    Exchange,
    Histogram,
    Joint,
    JointLimits,
    Message,
    Method,
    Model,
    Pool,
    Posture,
    Reply,
    Specialised,
    SpecialisedInfo,
    Statistics,
    Summary,
    ThreadPool,
    Velocity,
    Workspace,
    __version__,
    _joint_limits,
    daemon_command,
    isa,
    methods,
)
from .errors import (
    BusyError,
    DisconnectedError,
    Error,
    FileError,
    InputError,
    InputTypeError,
    LoadError,
    MissingFileError,
    NotComputedError,
    OutOfMemoryError,
    RefusedError,
    SystemCallError,
    TimedOutError,
    UnsupportedError,
)
from .observer import Observer


def joint_limits(
    path: str | os.PathLike[str], names: Optional[Iterable[str]] = None
) -> dict[str, JointLimits]:
    """Limits of joints, as a URDF file states them: lower, upper, velocity, effort.

    inf: the file has none. No answer uses limits. names: joints, None: those of Model(path).
    """
    if names is None:
        names = Model(path).joint_names
    return _joint_limits(path, tuple(names))


__all__ = [
    "ANSWER_ESTIMATED",
    "ANSWER_FALLBACK",
    "ANSWER_INACCURATE",
    "ANSWER_MODE_LIMIT",
    "ANSWER_NOT_FINITE",
    "ANSWER_PULLS",
    "ANSWER_RANK_LOSS",
    "ANSWER_RESIDUAL_PRECISION",
    "ANSWER_SENTINEL",
    "ANSWER_STALLED",
    "Advice",
    "Body",
    "BuildResult",
    "BusyError",
    "Client",
    "Configuration",
    "DeclaredJoint",
    "DisconnectedError",
    "Error",
    "Exchange",
    "FileError",
    "Histogram",
    "InputError",
    "InputTypeError",
    "Joint",
    "JointLimits",
    "LoadError",
    "MAX_PAYLOADS",
    "MAX_REFINE",
    "MAX_TIPS",
    "MAX_WRENCHES",
    "Message",
    "Method",
    "MissingFileError",
    "Model",
    "NotComputedError",
    "OPS",
    "Observer",
    "OutOfMemoryError",
    "Pool",
    "Posture",
    "RefusedError",
    "Reply",
    "STATUSES",
    "Specialised",
    "SpecialisedInfo",
    "Statistics",
    "Summary",
    "SystemCallError",
    "ThreadPool",
    "TimedOutError",
    "UnsupportedError",
    "Velocity",
    "Workspace",
    "__version__",
    "daemon_command",
    "isa",
    "joint_limits",
    "methods",
]
