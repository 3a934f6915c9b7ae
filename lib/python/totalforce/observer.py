# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Generalised-momentum observer: joint torques that nothing in the model explains."""
from __future__ import annotations

from typing import Any

import numpy as np

from ._totalforce import _Observer

_REST = (0.0, 0.0, 0.0)


class Observer:
    """External joint torques r of one robot, without accelerations.

        dr/dt = gain (tau_ext - r),   tau_ext = d(M v)/dt - tau - momentum_rate

    solver: Workspace, Pool or Client that answers for the robot. gain: 1/s, the inverse of the
    time constant. max_gap: s, samples further apart restart it; 0: 5 / gain. Exact for torques
    that are constant between samples, whatever their distance (totalforce/observer.h).
    """

    def __init__(self, solver: Any, gain: float, *, max_gap: float = 0.0) -> None:
        robot = getattr(solver, "model", solver)
        self._solver = solver
        self._base = robot.base_freedoms
        self._filter = _Observer(robot.base_freedoms, robot.v_count, gain, max_gap)

    def update(
        self,
        time: float,
        q: Any,
        v: Any = None,
        tau: Any = None,
        *,
        base_wrench: Any = None,
        **state: Any,
    ) -> str:
        """Takes a sample: time in s, tau as measured or commanded; `state` as of kinematics.

        Returns 'updated', or why it restarted: 'started', 'gap', 'time' (not later than the sample
        before), 'model' (another one answered), 'invalid' (the sample is not finite).
        """
        try:
            reply = self._solver.kinematics(q, v, want="generalised_momentum", **state)
        except Exception:
            self._filter.restart()
            raise
        momentum = [reply.generalised_momentum, reply.momentum_rate]
        if self._base:
            base = (reply.base_generalised_momentum, reply.base_momentum_rate)
            momentum = [np.concatenate(parts) for parts in zip(base, momentum)]
        return self._filter.step(time, int(reply.model, 16), *momentum, tau, base_wrench)

    def restart(self) -> None:
        """Forgets all samples."""
        self._filter.restart()

    @property
    def torques(self) -> np.ndarray:
        """r: six of a floating base, then those of the joints, N m or N; 0 after a restart."""
        return self._filter.torques

    def wrench(self, link: Any, q: Any, *, base_pose: Any = None, **state: Any) -> np.ndarray:
        """Wrench on the robot at a link that explains r: F = Lambda J M^-1 r, N and N m.

        `state`: frame, payload, rank_loss, ... as of forward_dynamics.
        """
        r = self.torques
        base = {} if not self._base else {"base_pose": base_pose, "base_wrench": r[:6]}
        state.update(base, tau=r[self._base :], gravity=_REST, tips=link)
        reply = self._solver.forward_dynamics(q, want=("lambda", "jacobian"), **state)
        a = reply.qdd
        if self._base:
            a = np.concatenate((reply.base_acceleration, a))
        return reply.lambda_ @ (reply.jacobian @ a)
