# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Writes the type stubs of a built module, whose names, arguments and defaults they have.

    stubs.py MODULE STUBS

The types stand here; a name without one ends the build.
"""
import importlib.util
import inspect
import pathlib
import sys

HEAD = """# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
import os
from typing import Any, Iterable, Iterator, Literal, Mapping, NamedTuple, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Path = Union[str, bytes, os.PathLike[str]]
Link = Union[str, int]
JointName = Union[str, int]
Joints = Union[ArrayLike, Mapping[JointName, Any]]
Payload = Mapping[str, Any]
Constraint = Union[str, int]
SideFiles = Union[Path, Sequence[Path]]
Want = Literal[
    "pose", "twist", "jacobian", "bias_acceleration", "poses", "com", "momentum", "energy",
    "generalised_momentum", "lambda", "mu", "p", "spectrum", "joint_forces", "delassus"
]
"""  # fmt: skip

# Keys are "name", before it "Class.name" of a field or a property, "Class(name)" or
# "Class.function(name)" of an argument, and "function()" of what is returned. An argument whose
# default is None is optional.
TYPES = {
    "int": """
        q_index q_count v_index v_count body parent freedoms links bodies depth main_chain fixed
        locked fused follows absent singular_body mimics line occurrences id t_sent t_received
        t_start t_done t_reply lanes lanes_f32 bytes state iterations rank lost joint leader
        coordinates slots max_batch max_tips spin_ns priority threads seconds memory_mib file_mib
        retry_ms attempt_us base_freedoms daemon_pid outstanding lowest highest count refine
        Summary.joints Client.send() Histogram.quantile()""",
    "float": """armature damping friction mass gyration_min gyration_max condition multiplier offset
        moving_mass total_mass error error_f32 compile_s position velocity lower upper effort snap
        friction_velocity rank_threshold characteristic_length tolerance dt timeout deadline
        connect_timeout sum mean share""",
    "str": """name type fate base severity code text entity daemon cost summary path isa compiler
        algorithms hash tag method op robot sources command wait precision root __version__ isa()
        daemon_command() Specialised.file_name() Reply.op Reply.model""",
    "bool": "regular rotor_inertia lock_massless_leaves round_sincos base_is_free single",
    "bytes": "digest",
    "list[str]": "ops refuses joints warnings notes Workspace.methods",
    "list[Method]": "methods()",
    "tuple[str, ...]": """OPS joint_names Model.links Client.links Model.modes Client.modes
        Model.constraints Client.constraints""",
    "tuple[int, ...]": "link_bodies",
    "tuple[float, float, float]": "com Summary.gravity",
    "tuple[Joint, ...]": "Model.joints",
    "tuple[Body, ...]": "Model.bodies",
    "tuple[DeclaredJoint, ...]": "declared",
    "tuple[Message, ...]": "messages",
    "dict[str, tuple[str, str]]": "STATUSES",
    "dict[str, Any]": "Statistics.read()",
    "dict[str, JointLimits]": "Model.joint_limits()",
    "Any": """seed Reply.condition Reply.eig_max Reply.eig_min Reply.error_estimate Reply.flags
        Reply.lambda_error_estimate Reply.length Reply.mass Reply.rank Reply.threshold""",
    "Optional[str]": "file",
    "Optional[Exchange]": "Reply.exchange",
    "Optional[Model]": "Model.parent",
    "Optional[Array]": """Posture.base_pose Posture.base_twist Configuration.base_pose
        Velocity.base_twist""",
    "Union[str, list[str]]": "Reply.fallback Reply.method",
    "Array": """Advice.q single_error Posture.q Posture.v Configuration.q Velocity.v
        Model.parameters()""",
    "NDArray[np.void]": "Reply.answers",
    "NDArray[np.uint64]": "buckets tops",
    "Summary": "Model.summary",
    "SpecialisedInfo": "info",
    "BuildResult": "Specialised.build()",
    "Advice": "Model.advise()",
    "Posture": "Workspace.close_loops()",
    "Configuration": "Model.integrate() Model.neutral() Model.random_configuration()",
    "Velocity": "Model.difference()",
    "Histogram": "earlier Histogram.since()",
    "Model": "model Model.parse() Model.derive()",
    "Specialised": "specialised",
    "ThreadPool": "thread_pool",
    "Pool": "Pool.__enter__()",
    "Client": "Client.__enter__()",
    "None": """Model.check() ThreadPool.close() Pool.close() Client.close() Client.reconnect()
        Client.set_fallback() Pool.__exit__() Client.__exit__()""",
    "Path": "runtime_dir standby_dir Specialised(path)",
    "Union[Path, bytes]": "Model(path)",
    "Union[str, bytes]": "Model.parse(text)",
    "Union[bool, Mapping[str, float]]": "Model(damping) Model(friction)",
    "Mapping[str, float]": "Model(armature) rotors",
    "Union[Mapping[str, Any], Sequence[str]]": "Model(locked)",
    "SideFiles": "Model(modes)",
    "Union[Payload, Sequence[Payload], SideFiles]": "Model(constraints)",
    "Union[Joints, Configuration]": "to Model.integrate(q) Model.difference(q)",
    "Union[Joints, Velocity]": "Model.integrate(v)",
    "Joints": "q v tau qdd posture_torques torque_weights",
    "ArrayLike": """gravity base_pose base_twist base_wrench base_acceleration modes mode_velocities
        stabilisation base_pose_to""",
    "Union[JointName, Sequence[JointName]]": "Solver(locked)",
    "Union[Payload, Sequence[Payload]]": "payload",
    "Union[Constraint, Sequence[Constraint]]": "constraints",
    "Union[Mapping[Constraint, ArrayLike], ArrayLike]": "constraint_acceleration",
    "Union[ArrayLike, Mapping[Link, ArrayLike]]": "acceleration",
    "Union[Mapping[Link, ArrayLike], Sequence[tuple[Link, ArrayLike]]]": "wrench",
    "Union[Link, Sequence[Link]]": "tips",
    "Link": "link",
    "Union[str, Sequence[str]]": "methods actuated only Model(tips)",
    "Sequence[int]": "cpus",
    "Iterable[int]": "values",
    "Iterable[str]": "names",
    "Union[Want, Sequence[Want]]": "want",
    "Union[Reply, Mapping[str, Array], Array]": "out",
    'Literal["pose", "point"]': "rows",
    'Literal["local_world_aligned", "local", "world"]': "frame",
    'Literal["default", "truncate", "damp", "refuse"]': "rank_loss",
    'Literal["default", "always", "never"]': "estimate",
    'Literal["f64", "f32", "f128"]': "Workspace(precision) Pool(precision)",
    'Literal["same", "f64", "f128"]': "residual",
    'Literal["auto", "one"]': "states",
    'Literal["default", "spin", "hybrid", "block"]': "Client(wait)",
    'Literal["fixed", "floating"]': "Model(base)",
    'Literal["strict", "warn", "repair", "strict-physical"]': "inertia",
    'Literal["free", "project", "lock"]': "mimic",
    'Literal["fastest", "aba", "crba"]': "algorithm",
}
TYPE_OF = {key: kind for kind, keys in TYPES.items() for key in keys.split()}
SPECIAL = """    def __getitem__(self, name: str, /) -> Array: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def keys(self, /) -> list[str]: ...
"""


def type_of(*keys):
    """That of the first key that has one"""
    known = [TYPE_OF[key] for key in keys if key in TYPE_OF]
    return known[0] if known else sys.exit(f"stubs.py: no type of {keys[0]}")


def argument(p, place):
    owner = place.split(".")[0]
    if p.name == "self":
        return "self"
    if p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD):
        return f"{p}: Any"
    kind = type_of(f"{place}({p.name})", f"{owner}({p.name})", f"Solver({p.name})", p.name)
    if p.default is None:
        return f"{p.name}: Optional[{kind}] = None"
    return f"{p.name}: {kind}" + (f" = {p.default!r}" if p.default is not p.empty else "")


def function(place, signature, returns, indent="    ", first=()):
    """place: Class.name, or name of a function; first: cls or self, if the signature has none"""
    listed, kinds = list(first), inspect.Parameter
    before = kinds.POSITIONAL_ONLY if first else None
    for p in signature.parameters.values():
        if before == kinds.POSITIONAL_ONLY != p.kind:
            listed.append("/")
        if p.kind == kinds.KEYWORD_ONLY != before != kinds.VAR_POSITIONAL:
            listed.append("*")
        listed.append(argument(p, place))
        before = p.kind
    if before == kinds.POSITIONAL_ONLY and signature.parameters:
        listed.append("/")
    text = f"{indent}def {place.split('.')[-1]}({', '.join(listed)}) -> {returns}: ...\n"
    if len(text) > 100:
        inside = "".join(f"{indent}    {entry},\n" for entry in listed)
        text = f"{text.split('(')[0]}(\n{inside}{indent}) -> {returns}: ...\n"
    return text


def members(kind, ops):
    """Lines of a class's properties and functions"""
    name = kind.__name__
    for key, value in sorted(vars(kind).items()):
        place = f"{name}.{key}"
        if inspect.isgetsetdescriptor(value):
            kind_of = TYPE_OF.get(place, "Array") if name == "Reply" else type_of(place, key)
            yield f"    @property\n    def {key}(self) -> {kind_of}: ...\n"
        elif key in ("__enter__", "__exit__") or not key.startswith("_") and place != "Reply.keys":
            answers = key in (*ops, "compute", "receive")
            returns = "Reply" if answers else type_of(f"{place}()")
            of_class = type(value).__name__ == "classmethod_descriptor"
            if of_class or isinstance(value, staticmethod):
                yield f"    @{'classmethod' if of_class else 'staticmethod'}\n"
            signature = inspect.signature(getattr(kind, key))
            yield function(place, signature, returns, first=("cls",) if of_class else ())


def class_of(kind, ops):
    name = kind.__name__
    if issubclass(kind, tuple):
        fields = (f"    {f}: {type_of(f'{name}.{f}', f)}\n" for f in kind.__match_args__)
        return f"\nclass {name}(NamedTuple):\n{''.join(fields)}"
    if name == "Reply":
        return f"\nclass Reply:\n{''.join(members(kind, ops))}{SPECIAL}"
    made = function(f"{name}.__init__", inspect.signature(kind), "None", first=("self",))
    return f"\nclass {name}:\n{made}{''.join(members(kind, ops))}"


def write(module):
    classes, rest = [], []
    for name, value in vars(module).items():
        if inspect.isclass(value) and not name.startswith("_"):
            classes.append(class_of(value, module.OPS))
        elif name.startswith("_") and name != "__version__":
            rest.append("" if name.startswith("__") else f"{name}: Any\n")
        elif callable(value):
            rest.append(function(name, inspect.signature(value), type_of(f"{name}()"), indent=""))
        else:
            rest.append(f"{name}: {'int' if isinstance(value, int) else type_of(name)}\n")
    return HEAD + "\n" + "".join(rest) + "".join(classes)


if __name__ == "__main__":
    spec = importlib.util.spec_from_file_location("_totalforce", sys.argv[1])
    built = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(built)
    pathlib.Path(sys.argv[2]).write_text(write(built))
