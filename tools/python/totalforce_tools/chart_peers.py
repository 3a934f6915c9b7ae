# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Other libraries in a chart: made from the same file as the model, asked for the same states. They
are the shared object of tools/peers (-DTFA_PEERS=ON); without it there are none."""
import ctypes
import os
import tempfile

import numpy as np

BODIES_MAX = 300  # PEER_BODIES_MAX of tools/peers/peer.h
TEXT = 64
DOUBLES = ctypes.POINTER(ctypes.c_double)


class Peer(ctypes.Structure):
    """struct peer of tools/peers/peer.h"""

    _fields_ = [
        ("name", ctypes.c_char_p),
        ("make", ctypes.c_void_p),
        ("forward", ctypes.CFUNCTYPE(None, ctypes.c_void_p, DOUBLES, DOUBLES, DOUBLES, DOUBLES)),
        ("release", ctypes.CFUNCTYPE(None, ctypes.c_void_p)),
    ]


def load():
    try:
        library = ctypes.CDLL(os.path.join(os.path.dirname(__file__), "libtotalforce_peers.so"))
    except OSError:
        return None
    library.peer_at.argtypes, library.peer_at.restype = [ctypes.c_uint32], ctypes.POINTER(Peer)
    library.peer_make.argtypes = [
        ctypes.POINTER(Peer), ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t]
    library.peer_make.restype = ctypes.c_void_p
    library.peer_lambda_of.argtypes = [ctypes.POINTER(Peer)]
    library.peer_lambda_of.restype = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.c_void_p, DOUBLES, ctypes.c_char_p, DOUBLES)
    return library


LIBRARY = load()
TABLE = {}
while LIBRARY and LIBRARY.peer_at(len(TABLE)):
    row = LIBRARY.peer_at(len(TABLE))
    TABLE[row.contents.name.decode()] = row


def has_lambda(name):
    return bool(LIBRARY.peer_lambda_of(TABLE[name]))


def pointer(array):
    return array.ctypes.data_as(DOUBLES)


class Peers:
    """Those that were asked for, as robots of one case"""

    def __init__(self, case, methods, threads):
        self.case, self.robots, self.why = case, {}, {}
        self.wanted = [name for name in methods if name in TABLE]
        if not self.wanted:
            return
        if isinstance(case.source, bytes):
            with tempfile.NamedTemporaryFile(prefix="totalforce-", suffix=".urdf") as file:
                file.write(case.source)
                file.flush()
                self._make_all(file.name, threads)
        else:
            self._make_all(case.source, threads)

    def _make_all(self, path, threads):
        for name in self.wanted:
            why = self._obstacle(threads)
            if not why:
                text = ctypes.create_string_buffer(TEXT)
                robot = LIBRARY.peer_make(TABLE[name], os.fsencode(path), text, TEXT)
                why = text.value.decode(errors="replace")
                if robot:
                    self.robots[name] = robot
            self.why[name] = "".join(" " if c in ',"' or c < " " else c for c in why)

    def _obstacle(self, threads):
        """A peer takes one number for each joint of the file, in that order: so must the model."""
        model = self.case.model
        if threads > 1 or model.base_freedoms:
            return "one thread" if threads > 1 else "fixed base"
        if self.case.bodies > BODIES_MAX:
            return f"more than {BODIES_MAX} bodies"
        declared = [j.name for j in model.declared if j.type != "fixed"]
        simple = all(j.q_index == k and j.q_count == 1 for k, j in enumerate(model.joints))
        if not simple or declared != list(model.joint_names):
            return "joints other than revolute and prismatic"
        return ""

    def refusal(self, name):
        """Status and subject: of one that does not answer for this robot"""
        if name in self.robots:
            return "", self.why[name]
        return "too_large" if self.case.bodies > BODIES_MAX else "refused", self.why[name]

    def answer(self, name, states, s):
        robot = self.robots[name]
        if states.op != "forward_dynamics":
            found = np.zeros(36)
            missing = LIBRARY.peer_lambda_of(TABLE[name])(
                robot, pointer(states.q[s]), self.case.tip.encode(), pointer(found))
            return np.full(36, np.nan) if missing else found
        found = np.zeros(states.v.shape[1])
        TABLE[name].contents.forward(robot, pointer(states.q[s]), pointer(states.v[s]),
                                     pointer(states.tau[s]), pointer(found))
        return found

    def contestant(self, name, states):
        """For _race: addresses of its function and its robot, the states, the link of Lambda^-1"""
        forward = states.op == "forward_dynamics"
        peer = TABLE[name]
        function = peer.contents.forward if forward else LIBRARY.peer_lambda_of(peer)
        numbers = np.ascontiguousarray(np.stack([states.q, states.v, states.tau], axis=1))
        return (ctypes.cast(function, ctypes.c_void_p).value, self.robots[name], numbers,
                None if forward else self.case.tip)

    def close(self):
        for name, robot in self.robots.items():
            TABLE[name].contents.release(robot)
        self.robots = {}
