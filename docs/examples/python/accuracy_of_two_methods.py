# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Accuracy of two methods and two precisions on one chain, against quadruple precision.

    python3 accuracy_of_two_methods.py [config/robots/snake64.urdf]
"""
# %% A long chain, and states of it
import sys

import numpy as np

import totalforce as tf

path = sys.argv[1] if len(sys.argv) > 1 else "config/robots/snake64.urdf"
model = tf.Model(path)
random = np.random.default_rng(0)
count = 20
q = random.uniform(-0.5, 0.5, (count, model.q_count))
v = random.uniform(-1, 1, (count, model.v_count))
tau = random.uniform(-1, 1, (count, model.v_count))
print(f"{model.name}: {model.v_count} freedoms, {count} states")

# %% The reference: quadruple precision, rounded once
reference = tf.Workspace(model, precision="f128").forward_dynamics(q, v, tau).qdd


# %% Each method's own answer: no estimate, no refinement, no fallback
def errors(precision, method):
    workspace = tf.Workspace(model, precision=precision)
    qdd = workspace.forward_dynamics(q, v, tau, method=method, estimate="never", refine=0).qdd
    return np.linalg.norm(qdd - reference, axis=1) / np.linalg.norm(reference, axis=1)


names = {"f64": "double", "f32": "single"}
for precision in ("f64", "f32"):
    for method in ("aba", "crba"):
        error = errors(precision, method)
        print(f"median error of {method}, {names[precision]}: {np.median(error):.1e}")
        print(f"worst error of {method}, {names[precision]}: {error.max():.1e}")

# %% The library's own estimate of the error
reply = tf.Workspace(model).forward_dynamics(q, v, tau, estimate="always")
true = np.linalg.norm(reply.qdd - reference, axis=1) / np.linalg.norm(reference, axis=1)
print(f"estimated {reply.error_estimate.max():.1e}, true {true.max():.1e}")

# %% Float factors refined with double residuals
mixed = tf.Workspace(model, precision="f32", residual="f64").forward_dynamics(q, v, tau).qdd
error = np.linalg.norm(mixed - reference, axis=1) / np.linalg.norm(reference, axis=1)
print(f"worst error of single factors, double residuals: {error.max():.1e}")
