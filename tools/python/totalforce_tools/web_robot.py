# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A served robot: its model, made of the daemon's description, and its figure: where its links are
and what a force at its tips does."""
import json
import mmap
import os
import socket
import struct

import numpy as np
import totalforce as tf
from totalforce_tools.cases import depths_of
from totalforce_tools.scene import POLICIES

TIPS = 8


def describe(robot, directory):
    """(settings, URDF) of a robot, as the daemon gives them to recorders (ipc/recording.h)."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as s:
        s.settimeout(10)
        s.connect(os.path.join(directory, ".control.sock"))
        s.send(f"describe {robot}".encode())
        answer, descriptors, _, _ = socket.recv_fds(s, 4096, 1)
    if not descriptors:
        raise OSError(answer.decode(errors="replace") or "the daemon is busy with other commands")
    try:
        with mmap.mmap(descriptors[0], 0, prot=mmap.PROT_READ) as block:
            settings, urdf = struct.unpack_from("=QQ", block)
            text = block[16:16 + settings].decode(errors="replace")
            start = 16 + (settings + 7) // 8 * 8
            return json.loads(text), block[start:start + urdf]
    finally:
        os.close(descriptors[0])


def compile_model(settings, urdf):
    o, scene = settings["options"], settings["options"]["scene"] or {}
    flags = {name: bool(o[name]) for name in ("rotor_inertia", "damping", "friction",
                                            "lock_massless_leaves")}
    return tf.Model.parse(
        urdf, gravity=o["gravity"], snap=o["snap"], root=scene.get("root"),
        tips=scene.get("tips"), payload=scene.get("payloads"),
        locked={lock["joint"]: lock["q"] for lock in scene.get("locks", ())},
        friction_velocity=o["friction_velocity"],
        **{name: {entry["joint"]: entry["value"] for entry in o[name]}
           for name in ("armature", "rotors")},
        **{name: json.dumps(scene[name]).encode() for name in ("modes", "constraints")
           if name in scene},
        **flags, **{name: words.split("|")[o[name]] for name, words in POLICIES.items()})


def find_lines(model):
    """The link where the line to each link begins, -1: it has none. A line begins at the frame of
    the link's body, that of a body at the previous body."""
    bodies, carriers, frames = model.bodies, model.link_bodies, {}
    for frame, name in enumerate(model.links):
        frames.setdefault(name, frame)
    frame_of, lines = [frames[body.name] for body in bodies], []
    for frame, body in enumerate(carriers):
        if body >= 0 and frame_of[body] == frame:
            body = bodies[body].parent
            lines.append(frame_of[body] if body >= 0 else 0 if carriers[0] < 0 else -1)
        else:
            lines.append(frame_of[body] if body >= 0 else 0 if frame else -1)
    return lines


def find_tips(model):
    """The last link of each body that carries no other; the deepest, if there are many."""
    depth, last = depths_of(model), {body: frame for frame, body in enumerate(model.link_bodies)}
    leaves = set(range(len(depth))) & set(last) - {body.parent for body in model.bodies}
    return [last[body] for body in sorted(leaves, key=lambda body: (-depth[body], body))[:TIPS]]


class Figure:
    """Poses of links, and Lambda^-1 at the tips, in a workspace of its own."""

    def __init__(self, model):
        self.model, self.workspace = model, tf.Workspace(model, max_tips=1)
        self.parents, self.tips = find_lines(model), find_tips(model)
        self.drawn = self.drawn_at = None
        self.neutral = np.zeros(model.q_count)
        for joint in model.joints:
            if joint.type == "floating":
                self.neutral[joint.q_index + 6] = 1

    def motion(self, state):
        """Positions and ellipsoids at this state; at q = 0 where it is of another robot or None."""
        floating = bool(self.model.base_freedoms)
        known = state is not None and len(state["q"]) == self.model.q_count and (
            not floating or state["base_pose"] is not None)
        q = state["q"] if known else self.neutral
        base = {}
        if floating:
            base["base_pose"] = state["base_pose"] if known else [0, 0, 0, 0, 0, 0, 1]
        try:
            poses = self.workspace.kinematics(q, want="poses", **base).poses
        except tf.Error as error:
            return {"error": error.summary}
        return {"q": q, "positions": poses[:, :3].reshape(-1),
                "tips": [self._tip(frame, q, base) for frame in self.tips]}

    def _tip(self, frame, q, base):
        """Linear block of Lambda^-1, axes of the world, 1/kg: a force f accelerates the tip by the
        block times f."""
        tip = {"frame": frame, "name": self.model.links[frame]}
        try:
            block = self.workspace.operational_inertia(
                q, tips=[frame], rows="point", estimate="never", **base).lambda_inv
            values, vectors = np.linalg.eigh(block)
        except tf.Error as error:
            return tip | {"error": error.summary}
        except np.linalg.LinAlgError:  # not finite
            return tip | {"error": tf.STATUSES["E_NOT_COMPUTED"][0]}
        return tip | {"lambda_inv": block.reshape(-1), "values": values[::-1],
                      "vectors": vectors.T[::-1].reshape(-1)}


def load_figure(robot, served, directory):
    """The figure of a robot whose model has the hash `served`."""
    model = compile_model(*describe(robot, directory))
    if model.hash != served:
        raise tf.Error(f"the daemon serves model {served[:16]}, its description gives "
                       f"{model.hash[:16]} here")
    return Figure(model)
