# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The type stubs name what the module has, with its arguments; everything has a docstring."""
import ast
import inspect
import pathlib

import support
import totalforce as tf
from totalforce import _totalforce, errors

STUB = pathlib.Path(tf.__file__).with_name("_totalforce.pyi")


class Stubs(support.Case):
    def test_names(self):
        tree = ast.parse(STUB.read_text())
        named = {node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        named |= {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}
        self.assertEqual(named, {n for n in vars(_totalforce) if not n.startswith("__")} | {"__version__"})

    def test_signatures(self):
        for text in (
            "def __init__(self, path: Path, model: Model, /) -> None: ...",
            "    @classmethod\n    def parse(\n        cls,\n        text: Union[str, bytes],\n        /,\n        *,",
            "        v: Optional[Union[Joints, Velocity]] = None,\n        *,\n        base_pose: Optional[ArrayLike]",
            "class JointLimits(NamedTuple):\n    lower: float\n    upper: float\n    velocity: float\n",
            "    @property\n    def answers(self) -> NDArray[np.void]: ...",
            "    def send(self, op: str, /, *args: Any, **fields: Any) -> int: ...",
        ):
            self.assertIn(text, STUB.read_text())

    def test_package(self):
        self.assertTrue(STUB.with_name("py.typed").exists())
        for name in tf.__all__:
            self.assertTrue(hasattr(tf, name), name)
        public = {n for n in vars(_totalforce) if not n.startswith("_")}
        self.assertTrue(public <= set(tf.__all__), public - set(tf.__all__))
        raised = {
            n for n, v in vars(errors).items() if inspect.isclass(v) and issubclass(v, tf.Error)
        }
        self.assertTrue(raised <= set(tf.__all__), raised - set(tf.__all__))

    def test_docstrings(self):
        for name in tf.__all__:
            value = getattr(tf, name)
            if inspect.isclass(value) or callable(value):
                self.assertTrue(value.__doc__, name)
        for kind in (tf.Model, tf.Workspace, tf.Pool, tf.Client, tf.Reply, tf.Specialised):
            for name, value in vars(kind).items():
                if not name.startswith("_"):
                    self.assertTrue(value.__doc__, f"{kind.__name__}.{name}")
        for op in tf.OPS:
            text = getattr(tf.Workspace, op).__doc__
            for part in ("Parameters", "Returns", "q : (n_q,) or (count, n_q)", "rad"):
                self.assertIn(part, text, op)
            for name in inspect.signature(getattr(tf.Workspace, op)).parameters:
                if name != "self":
                    self.assertIn(f"\n{name} : ", text, op)
            self.assertEqual(max(map(len, text.splitlines())) <= 100, True, op)


if __name__ == "__main__":
    support.main()
