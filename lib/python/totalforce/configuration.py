# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Random configurations. Called by Model.random_configuration."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from ._totalforce import Model


def _ranges(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds of q: of the file, followers included, or pi and 1 m."""
    low, high = np.full((2, model.q_count), [[-np.inf], [np.inf]])
    limits = model.joint_limits(joint.name for joint in model.declared)
    for joint in model.declared:
        leads = joint.joint >= 0
        k, scale = (joint.joint, 1.0) if leads else (joint.leader, joint.multiplier)
        if k < 0 or scale == 0 or joint.type not in ("revolute", "prismatic"):
            continue
        at = model.joints[k].q_index
        ends = (np.array(limits[joint.name][:2]) - (0 if leads else joint.offset)) / scale
        low[at], high[at] = max(low[at], ends.min()), min(high[at], ends.max())
    for joint in model.joints:
        turns = {"revolute": [0], "continuous": [0], "planar": [2]}.get(joint.type, [])
        for k in range(joint.q_count):
            at, free = joint.q_index + k, np.pi if k in turns else 1.0
            if not np.isfinite(low[at]) or not np.isfinite(high[at]):
                low[at], high[at] = -free, free
    return low, high


def draw(model: Model, seed: Any, count: Optional[int]) -> tuple[Any, Any]:
    """q and base_pose, which is None with a fixed base."""
    rng = np.random.default_rng(seed)
    lead = () if count is None else (count,)
    low, high = _ranges(model)
    q = low + (high - low) * rng.random(lead + low.shape)
    pose = rng.uniform(-1, 1, lead + (7,)) if model.base_freedoms else None
    poses = [q[..., j.q_index : j.q_index + 7] for j in model.joints if j.type == "floating"]
    for part in poses if pose is None else [*poses, pose]:
        part[..., 3:] = rng.standard_normal(lead + (4,))
        part[..., 3:] /= np.linalg.norm(part[..., 3:], axis=-1, keepdims=True)
    return q, pose
