# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
import os
from typing import Any, Iterable, Iterator, Literal, Mapping, NamedTuple, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Numbers = ArrayLike
Path = Union[str, bytes, os.PathLike[str]]
Link = Union[str, int]
JointName = Union[str, int]
Links = Union[Link, Sequence[Link]]
Joints = Union[ArrayLike, Mapping[JointName, Any]]
Wrenches = Union[Mapping[Link, Numbers], Sequence[tuple[Link, Numbers]]]
Payload = Mapping[str, Any]
Payloads = Union[Payload, Sequence[Payload]]
Constraint = Union[str, int]
Constraints = Union[Constraint, Sequence[Constraint]]
ConstraintAccelerations = Union[Mapping[Constraint, Numbers], Numbers]
Rows = Literal["pose", "point"]
Frame = Literal["local_world_aligned", "local", "world"]
RankLoss = Literal["default", "truncate", "damp", "refuse"]
Estimate = Literal["default", "always", "never"]
Precision = Literal["f64", "f32", "f128"]
Residual = Literal["same", "f64", "f128"]
SideFiles = Union[Path, Sequence[Path]]
HeldFrames = Mapping[str, Any]
Want = Literal[
    "pose",
    "twist",
    "jacobian",
    "bias_acceleration",
    "poses",
    "com",
    "momentum",
    "energy",
    "generalised_momentum",
    "lambda",
    "mu",
    "p",
    "spectrum",
    "joint_forces",
    "delassus",
]

__version__: str
OPS: tuple[str, ...]
STATUSES: dict[str, tuple[str, str]]
ANSWER_ESTIMATED: int
ANSWER_FALLBACK: int
ANSWER_INACCURATE: int
ANSWER_MODE_LIMIT: int
ANSWER_NOT_FINITE: int
ANSWER_PULLS: int
ANSWER_RANK_LOSS: int
ANSWER_RESIDUAL_PRECISION: int
ANSWER_SENTINEL: int
ANSWER_STALLED: int
MAX_PAYLOADS: int
MAX_REFINE: int
MAX_TIPS: int
MAX_WRENCHES: int

class Joint(NamedTuple):
    name: str
    type: str
    q_index: int
    q_count: int
    v_index: int
    v_count: int
    body: int
    armature: float
    damping: float
    friction: float

class Body(NamedTuple):
    name: str
    parent: int
    freedoms: int
    mass: float
    com: tuple[float, float, float]
    gyration_min: float
    gyration_max: float
    condition: float
    regular: bool

class DeclaredJoint(NamedTuple):
    name: str
    type: str
    fate: str
    body: int
    joint: int
    leader: int
    multiplier: float
    offset: float
    coordinates: int

class Summary(NamedTuple):
    links: int
    joints: int
    bodies: int
    q_count: int
    v_count: int
    depth: int
    main_chain: int
    moving_mass: float
    total_mass: float
    com: tuple[float, float, float]
    fixed: int
    locked: int
    fused: int
    follows: int
    absent: int
    base: str
    gravity: tuple[float, float, float]
    singular_body: int
    mimics: int

class Message(NamedTuple):
    severity: str
    file: Optional[str]
    line: int
    code: str
    text: str
    occurrences: int
    entity: str

class Exchange(NamedTuple):
    id: int
    t_sent: int
    t_received: int
    t_start: int
    t_done: int
    t_reply: int
    daemon: str

class Method(NamedTuple):
    name: str
    ops: list[str]
    cost: str
    refuses: list[str]
    summary: str

class SpecialisedInfo(NamedTuple):
    path: str
    isa: str
    compiler: str
    algorithms: str
    bodies: int
    lanes: int
    lanes_f32: int
    error: float
    error_f32: float
    digest: bytes

class BuildResult(NamedTuple):
    compile_s: float
    bytes: int
    compiler: str

class Advice(NamedTuple):
    joints: list[str]
    freedoms: int
    q: Array
    single_error: Array
    error: float
    state: int

class Posture(NamedTuple):
    q: Array
    v: Array
    base_pose: Optional[Array]
    base_twist: Optional[Array]
    iterations: int
    position: float
    velocity: float
    rank: int
    lost: int

class Configuration(NamedTuple):
    q: Array
    base_pose: Optional[Array]

class Velocity(NamedTuple):
    v: Array
    base_twist: Optional[Array]

class JointLimits(NamedTuple):
    lower: float
    upper: float
    velocity: float
    effort: float

class Reply:
    @property
    def M(self) -> Array: ...
    @property
    def answers(self) -> NDArray[np.void]: ...
    @property
    def armature(self) -> Array: ...
    @property
    def base_acceleration(self) -> Array: ...
    @property
    def base_armature(self) -> Array: ...
    @property
    def base_damping(self) -> Array: ...
    @property
    def base_external(self) -> Array: ...
    @property
    def base_friction(self) -> Array: ...
    @property
    def base_generalised_momentum(self) -> Array: ...
    @property
    def base_gravity(self) -> Array: ...
    @property
    def base_momentum_rate(self) -> Array: ...
    @property
    def base_twist(self) -> Array: ...
    @property
    def base_velocity(self) -> Array: ...
    @property
    def base_wrench(self) -> Array: ...
    @property
    def bias_acceleration(self) -> Array: ...
    @property
    def com(self) -> Array: ...
    @property
    def com_jacobian(self) -> Array: ...
    @property
    def com_velocity(self) -> Array: ...
    @property
    def condition(self) -> Any: ...
    @property
    def constraint_position(self) -> Array: ...
    @property
    def constraint_residual(self) -> Array: ...
    @property
    def constraint_velocity(self) -> Array: ...
    @property
    def constraint_wrenches(self) -> Array: ...
    @property
    def damping(self) -> Array: ...
    @property
    def delassus(self) -> Array: ...
    @property
    def dqdd_dq(self) -> Array: ...
    @property
    def dqdd_dtau(self) -> Array: ...
    @property
    def dqdd_dv(self) -> Array: ...
    @property
    def dtau_dq(self) -> Array: ...
    @property
    def dtau_dv(self) -> Array: ...
    @property
    def eig_max(self) -> Any: ...
    @property
    def eig_min(self) -> Any: ...
    @property
    def energy(self) -> Array: ...
    @property
    def error_estimate(self) -> Any: ...
    @property
    def exchange(self) -> Optional[Exchange]: ...
    @property
    def external(self) -> Array: ...
    @property
    def fallback(self) -> Union[str, list[str]]: ...
    @property
    def flags(self) -> Any: ...
    @property
    def friction(self) -> Array: ...
    @property
    def generalised_momentum(self) -> Array: ...
    @property
    def gravity(self) -> Array: ...
    @property
    def jacobian(self) -> Array: ...
    @property
    def joint_forces(self) -> Array: ...
    @property
    def joint_regressor(self) -> Array: ...
    @property
    def lambda_(self) -> Array: ...
    @property
    def lambda_error_estimate(self) -> Any: ...
    @property
    def lambda_inv(self) -> Array: ...
    @property
    def length(self) -> Any: ...
    @property
    def lost(self) -> Array: ...
    @property
    def mass(self) -> Any: ...
    @property
    def method(self) -> Union[str, list[str]]: ...
    @property
    def model(self) -> str: ...
    @property
    def modes(self) -> Array: ...
    @property
    def momentum(self) -> Array: ...
    @property
    def momentum_rate(self) -> Array: ...
    @property
    def mu(self) -> Array: ...
    @property
    def op(self) -> str: ...
    @property
    def p(self) -> Array: ...
    @property
    def pose(self) -> Array: ...
    @property
    def poses(self) -> Array: ...
    @property
    def qdd(self) -> Array: ...
    @property
    def rank(self) -> Any: ...
    @property
    def regressor(self) -> Array: ...
    @property
    def tau(self) -> Array: ...
    @property
    def threshold(self) -> Any: ...
    @property
    def twist(self) -> Array: ...
    @property
    def v(self) -> Array: ...
    @property
    def velocity(self) -> Array: ...
    def keys(self, /) -> list[str]: ...
    def __getitem__(self, name: str, /) -> Array: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...

class _Solver:
    def forward_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        tau: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        refine: Optional[int] = None,
        estimate: Optional[Estimate] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def inverse_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def operational_inertia(
        self,
        /,
        q: Joints,
        tips: Links,
        *,
        v: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        refine: Optional[int] = None,
        estimate: Optional[Estimate] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def mass_matrix(
        self,
        /,
        q: Joints,
        *,
        v: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def kinematics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def bias(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        qdd: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def task_torques(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        acceleration: Optional[Union[Numbers, Mapping[Link, Numbers]]] = None,
        *,
        posture_torques: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        refine: Optional[int] = None,
        estimate: Optional[Estimate] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def derivatives(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        tau: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def inverse_dynamics_derivatives(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def constrained_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        tau: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        constraints: Optional[Constraints] = None,
        constraint_acceleration: Optional[ConstraintAccelerations] = None,
        stabilisation: Optional[Numbers] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def impact(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        constraints: Optional[Constraints] = None,
        stabilisation: Optional[Numbers] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def constrained_inverse_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        constraints: Optional[Constraints] = None,
        constraint_acceleration: Optional[ConstraintAccelerations] = None,
        stabilisation: Optional[Numbers] = None,
        torque_weights: Optional[Joints] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def regressor(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
    ) -> Reply: ...
    def compute(self, op: object, /, *args: Any, **fields: Any) -> Reply: ...

class Model:
    def __init__(
        self,
        path: Union[Path, bytes],
        /,
        *,
        base: Optional[Literal["fixed", "floating"]] = None,
        gravity: Optional[Numbers] = None,
        rotor_inertia: Optional[bool] = None,
        damping: Optional[Union[bool, Mapping[str, float]]] = None,
        friction: Optional[Union[bool, Mapping[str, float]]] = None,
        friction_velocity: Optional[float] = None,
        lock_massless_leaves: Optional[bool] = None,
        inertia: Optional[Literal["strict", "warn", "repair", "strict-physical"]] = None,
        mimic: Optional[Literal["free", "project", "lock"]] = None,
        snap: Optional[float] = None,
        root: Optional[str] = None,
        tips: Optional[Union[str, Sequence[str]]] = None,
        locked: Optional[Union[Mapping[str, Any], Sequence[str]]] = None,
        payload: Optional[Payloads] = None,
        armature: Optional[Mapping[str, float]] = None,
        rotors: Optional[Mapping[str, float]] = None,
        modes: Optional[SideFiles] = None,
        constraints: Optional[Union[HeldFrames, Sequence[HeldFrames], SideFiles]] = None,
        actuated: Optional[Union[str, Sequence[str]]] = None,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def hash(self) -> str: ...
    @property
    def tag(self) -> str: ...
    @property
    def q_count(self) -> int: ...
    @property
    def v_count(self) -> int: ...
    @property
    def base_freedoms(self) -> int: ...
    @property
    def joint_names(self) -> tuple[str, ...]: ...
    @property
    def links(self) -> tuple[str, ...]: ...
    @property
    def modes(self) -> tuple[str, ...]: ...
    @property
    def constraints(self) -> tuple[str, ...]: ...
    @property
    def joints(self) -> tuple[Joint, ...]: ...
    @property
    def bodies(self) -> tuple[Body, ...]: ...
    @property
    def declared(self) -> tuple[DeclaredJoint, ...]: ...
    @property
    def link_bodies(self) -> tuple[int, ...]: ...
    @property
    def summary(self) -> Summary: ...
    @property
    def messages(self) -> tuple[Message, ...]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def parent(self) -> Optional[Model]: ...
    @classmethod
    def parse(
        cls,
        text: Union[str, bytes],
        /,
        *,
        base: Optional[Literal["fixed", "floating"]] = None,
        gravity: Optional[Numbers] = None,
        rotor_inertia: Optional[bool] = None,
        damping: Optional[Union[bool, Mapping[str, float]]] = None,
        friction: Optional[Union[bool, Mapping[str, float]]] = None,
        friction_velocity: Optional[float] = None,
        lock_massless_leaves: Optional[bool] = None,
        inertia: Optional[Literal["strict", "warn", "repair", "strict-physical"]] = None,
        mimic: Optional[Literal["free", "project", "lock"]] = None,
        snap: Optional[float] = None,
        root: Optional[str] = None,
        tips: Optional[Union[str, Sequence[str]]] = None,
        locked: Optional[Union[Mapping[str, Any], Sequence[str]]] = None,
        payload: Optional[Payloads] = None,
        armature: Optional[Mapping[str, float]] = None,
        rotors: Optional[Mapping[str, float]] = None,
        modes: Optional[SideFiles] = None,
        constraints: Optional[Union[HeldFrames, Sequence[HeldFrames], SideFiles]] = None,
        actuated: Optional[Union[str, Sequence[str]]] = None,
    ) -> Model: ...
    def derive(
        self,
        /,
        *,
        gravity: Optional[Numbers] = None,
        payload: Optional[Payloads] = None,
    ) -> Model: ...
    def check(self, op: str, /, *args: Any, **fields: Any) -> None: ...
    def advise(self, tolerance: float, /, *args: Any, **fields: Any) -> Advice: ...
    def parameters(self, link: Link, /) -> Array: ...
    def integrate(
        self,
        /,
        q: Union[Joints, Configuration],
        v: Optional[Union[Joints, Velocity]] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        dt: float = 1.0,
    ) -> Configuration: ...
    def difference(
        self,
        /,
        q: Union[Joints, Configuration],
        to: Union[Joints, Configuration],
        *,
        base_pose: Optional[Numbers] = None,
        base_pose_to: Optional[Numbers] = None,
    ) -> Velocity: ...
    def neutral(self, /) -> Configuration: ...
    def random_configuration(
        self, /, seed: Any = None, count: Optional[int] = None
    ) -> Configuration: ...
    def joint_limits(self, /, names: Optional[Iterable[str]] = None) -> dict[str, JointLimits]: ...

class Workspace(_Solver):
    def __init__(
        self,
        model: Model,
        /,
        *,
        precision: Optional[Precision] = None,
        residual: Optional[Residual] = None,
        states: Optional[Literal["auto", "one"]] = None,
        methods: Optional[Union[str, Sequence[str]]] = None,
        max_tips: int = 0,
        specialised: Optional[Specialised] = None,
        round_sincos: bool = False,
    ) -> None: ...
    @property
    def model(self) -> Model: ...
    @property
    def max_tips(self) -> int: ...
    @property
    def precision(self) -> str: ...
    @property
    def methods(self) -> list[str]: ...
    def close_loops(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        base_is_free: bool = False,
        iterations: int = 0,
        tolerance: float = 0.0,
        **fields: Any,
    ) -> Posture: ...

class ThreadPool:
    def __init__(
        self,
        threads: int = 0,
        *,
        spin_ns: int = 0,
        cpus: Optional[Sequence[int]] = None,
        priority: int = 0,
    ) -> None: ...
    def close(self, /) -> None: ...

class Pool(_Solver):
    def __init__(
        self,
        model: Model,
        /,
        threads: int = 0,
        *,
        spin_ns: int = 0,
        cpus: Optional[Sequence[int]] = None,
        precision: Optional[Precision] = None,
        residual: Optional[Residual] = None,
        methods: Optional[Union[str, Sequence[str]]] = None,
        max_tips: int = 0,
        priority: int = 0,
        thread_pool: Optional[ThreadPool] = None,
        specialised: Optional[Specialised] = None,
    ) -> None: ...
    @property
    def threads(self) -> int: ...
    @property
    def model(self) -> Model: ...
    def close(self, /) -> None: ...
    def __enter__(self, /) -> Pool: ...
    def __exit__(self, /, *unused: Any) -> None: ...

class Client:
    def __init__(
        self,
        robot: str,
        *,
        runtime_dir: Optional[Path] = None,
        slots: int = 0,
        max_batch: int = 0,
        max_tips: int = 0,
        wait: Optional[Literal["default", "spin", "hybrid", "block"]] = None,
        spin_ns: int = 0,
        deadline: float = 0.0,
        connect_timeout: float = 1.0,
        standby_dir: Optional[Path] = None,
    ) -> None: ...
    @property
    def joint_names(self) -> tuple[str, ...]: ...
    @property
    def links(self) -> tuple[str, ...]: ...
    @property
    def modes(self) -> tuple[str, ...]: ...
    @property
    def constraints(self) -> tuple[str, ...]: ...
    @property
    def hash(self) -> str: ...
    @property
    def q_count(self) -> int: ...
    @property
    def v_count(self) -> int: ...
    @property
    def base_freedoms(self) -> int: ...
    @property
    def slots(self) -> int: ...
    @property
    def max_batch(self) -> int: ...
    @property
    def max_tips(self) -> int: ...
    @property
    def wait(self) -> str: ...
    @property
    def daemon_pid(self) -> int: ...
    @property
    def outstanding(self) -> int: ...
    def forward_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        tau: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        refine: Optional[int] = None,
        estimate: Optional[Estimate] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def inverse_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def operational_inertia(
        self,
        /,
        q: Joints,
        tips: Links,
        *,
        v: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        refine: Optional[int] = None,
        estimate: Optional[Estimate] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def mass_matrix(
        self,
        /,
        q: Joints,
        *,
        v: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def kinematics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def bias(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        qdd: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def task_torques(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        acceleration: Optional[Union[Numbers, Mapping[Link, Numbers]]] = None,
        *,
        posture_torques: Optional[Joints] = None,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        refine: Optional[int] = None,
        estimate: Optional[Estimate] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def derivatives(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        tau: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def inverse_dynamics_derivatives(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def constrained_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        tau: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_wrench: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        constraints: Optional[Constraints] = None,
        constraint_acceleration: Optional[ConstraintAccelerations] = None,
        stabilisation: Optional[Numbers] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def impact(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        constraints: Optional[Constraints] = None,
        stabilisation: Optional[Numbers] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def constrained_inverse_dynamics(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        constraints: Optional[Constraints] = None,
        constraint_acceleration: Optional[ConstraintAccelerations] = None,
        stabilisation: Optional[Numbers] = None,
        torque_weights: Optional[Joints] = None,
        rank_loss: Optional[RankLoss] = None,
        rank_threshold: Optional[float] = None,
        characteristic_length: Optional[float] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def regressor(
        self,
        /,
        q: Joints,
        v: Optional[Joints] = None,
        qdd: Optional[Joints] = None,
        *,
        base_pose: Optional[Numbers] = None,
        base_twist: Optional[Numbers] = None,
        base_acceleration: Optional[Numbers] = None,
        modes: Optional[Numbers] = None,
        mode_velocities: Optional[Numbers] = None,
        gravity: Optional[Numbers] = None,
        wrench: Optional[Wrenches] = None,
        tips: Optional[Links] = None,
        rows: Optional[Rows] = None,
        frame: Optional[Frame] = None,
        method: Optional[str] = None,
        payload: Optional[Payloads] = None,
        locked: Optional[Union[JointName, Sequence[JointName]]] = None,
        want: Optional[Union[Want, Sequence[Want]]] = None,
        only: Optional[Union[str, Sequence[str]]] = None,
        out: Optional[Union[Reply, Mapping[str, Array], Array]] = None,
        timeout: Optional[float] = None,
    ) -> Reply: ...
    def compute(self, op: str, /, *args: Any, **fields: Any) -> Reply: ...
    def send(self, op: str, /, *args: Any, **fields: Any) -> int: ...
    def receive(self, /, *, timeout: Optional[float] = None) -> Reply: ...
    def reconnect(self, /) -> None: ...
    def set_fallback(self, /, model: Model, *, retry_ms: int = 0, attempt_us: int = 0) -> None: ...
    def close(self, /) -> None: ...
    def __enter__(self, /) -> Client: ...
    def __exit__(self, /, *unused: Any) -> None: ...

class Specialised:
    def __init__(self, path: Path, model: Model, /) -> None: ...
    @property
    def info(self) -> SpecialisedInfo: ...
    @staticmethod
    def build(
        model: Model,
        path: Path,
        /,
        *,
        single: bool = False,
        compiler: Optional[str] = None,
        sources: Optional[str] = None,
        seconds: int = 0,
        memory_mib: int = 0,
        file_mib: int = 0,
        algorithm: Optional[Literal["fastest", "aba", "crba"]] = None,
    ) -> BuildResult: ...
    @staticmethod
    def file_name(model: Model, /) -> str: ...

class _Observer:
    def __init__(self, base_freedoms: int, v_count: int, gain: float, max_gap: float) -> None: ...
    @property
    def torques(self) -> Array: ...
    def step(
        self, time: float, model: int, momentum: Any, rate: Any, tau: Any, base_wrench: Any, /
    ) -> str: ...
    def restart(self, /) -> None: ...

class _Sweep:
    def __init__(
        self,
        model: Model,
        op: str,
        /,
        *,
        method: str = "auto",
        precision: Optional[str] = None,
        residual: Optional[str] = None,
        estimate: Optional[str] = None,
        refine: int = 4294967295,
        tips: tuple[str, ...] = (),
        ranges: tuple[float, float, float] = (1.0, 1.0, 1.0),
        seed: int = 1,
        reference: int = 0,
        first: int = 0,
        specialised: Optional[Specialised] = None,
    ) -> None: ...
    @property
    def record(self) -> int: ...
    @property
    def answer(self) -> int: ...
    @property
    def ranges(self) -> tuple[bytes, bytes]: ...
    @property
    def seconds(self) -> list[float]: ...
    def open(self, workers: int, states: tuple[int, str], /) -> None: ...
    def block(
        self,
        worker: int,
        first: int,
        count: int,
        states: tuple[int, str],
        out: tuple[int, str],
        out_states: tuple[int, str],
        /,
    ) -> bytes: ...
    @staticmethod
    def checksum(data: bytes, /) -> int: ...
    @staticmethod
    def count(values: bytes, first: int, /) -> bytes: ...

class Histogram:
    def __init__(self, values: Iterable[int] = ()) -> None: ...
    @property
    def count(self) -> int: ...
    @property
    def lowest(self) -> int: ...
    @property
    def highest(self) -> int: ...
    @property
    def sum(self) -> float: ...
    @property
    def mean(self) -> float: ...
    @property
    def buckets(self) -> NDArray[np.uint64]: ...
    @property
    def tops(self) -> NDArray[np.uint64]: ...
    def quantile(self, share: float, /) -> int: ...
    def since(self, earlier: Histogram, /) -> Histogram: ...

class Statistics:
    def __init__(
        self, runtime_dir: Optional[Path] = None, *, timeout: float = 10.0
    ) -> None: ...
    def read(self, /, *, timeout: float = 1.0) -> dict[str, Any]: ...

def methods() -> list[Method]: ...
def isa() -> str: ...
def daemon_command(
    command: str,
    *,
    runtime_dir: Optional[Path] = None,
    timeout: float = 10.0,
) -> str: ...
def _speak_command_line() -> None: ...
def _joint_limits(
    source: Union[Path, bytes], names: tuple[str, ...], /
) -> dict[str, JointLimits]: ...
def _mechanism(
    name: str,
    bodies: int,
    /,
    *,
    radius: float = ...,
    ratio: float = ...,
    taper: float = ...,
    curl: float = ...,
    seed: int = 1,
) -> bytes: ...
def _mechanisms() -> tuple[str, ...]: ...
def _race(
    first: tuple[Any, ...], second: tuple[Any, ...], seconds: float, /, *, clock: str = "thread"
) -> Floats: ...
def _suggest(wrong: str, words: tuple[str, ...], /) -> str: ...
def _restore_reply(*state: Any) -> Reply: ...
