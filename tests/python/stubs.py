# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""The type stubs name what the module has, with the same arguments; everything has a docstring."""
import ast
import inspect
import pathlib

import support
import totalforce as tf
from totalforce import _totalforce, errors

STUB = pathlib.Path(tf.__file__).with_name("_totalforce.pyi")
HIDDEN = {"__enter__", "__exit__", "__iter__", "__len__", "__contains__", "__getitem__"}


def stub_classes():
    tree = ast.parse(STUB.read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    names = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}
    return classes, functions, names


def members(classes, node):
    """Functions of a class with those of its bases in the stub."""
    own = {entry.name: entry for entry in node.body if isinstance(entry, ast.FunctionDef)}
    for base in node.bases:
        if isinstance(base, ast.Name) and base.id in classes:
            own = {**members(classes, classes[base.id]), **own}
    return own


def is_property(node):
    return any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)


def arguments(node):
    """(name, kind, default) of a function of the stub, as inspect has them."""
    a, kinds = node.args, inspect.Parameter
    positional = a.posonlyargs + a.args
    defaults = [kinds.empty] * (len(positional) - len(a.defaults)) + [
        ast.literal_eval(d) for d in a.defaults
    ]
    for k, (arg, default) in enumerate(zip(positional, defaults)):
        only = k < len(a.posonlyargs)
        yield arg.arg, kinds.POSITIONAL_ONLY if only else kinds.POSITIONAL_OR_KEYWORD, default
    if a.vararg:
        yield a.vararg.arg, kinds.VAR_POSITIONAL, kinds.empty
    for arg, default in zip(a.kwonlyargs, a.kw_defaults):
        yield arg.arg, kinds.KEYWORD_ONLY, (
            kinds.empty if default is None else ast.literal_eval(default)
        )
    if a.kwarg:
        yield a.kwarg.arg, kinds.VAR_KEYWORD, kinds.empty


def without_self(listed):
    return [entry for entry in listed if entry[0] not in ("self", "cls")]


class Stubs(support.Case):
    def same_arguments(self, function, node, what):
        real = [
            (p.name, p.kind, p.default) for p in inspect.signature(function).parameters.values()
        ]
        self.assertEqual(without_self(real), without_self(list(arguments(node))), what)

    def test_module(self):
        classes, functions, names = stub_classes()
        real = {n for n in vars(_totalforce) if not n.startswith("__")} | {"__version__"}
        self.assertEqual(real, (set(classes) - {"_Solver"}) | set(functions) | names)
        for name, node in functions.items():
            if not name.startswith("_"):
                self.same_arguments(getattr(_totalforce, name), node, name)

    def test_classes(self):
        classes, _, _ = stub_classes()
        for name, node in classes.items():
            if name == "_Solver":
                continue
            kind = getattr(_totalforce, name)
            if issubclass(kind, tuple):
                fields = [e.target.id for e in node.body if isinstance(e, ast.AnnAssign)]
                self.assertEqual(list(kind.__match_args__), fields, name)
                continue
            stub = members(classes, node)
            real = {n: m for n, m in vars(kind).items() if not n.startswith("_") or n in HIDDEN}
            self.assertEqual(set(real), set(stub) - {"__init__"}, name)
            if "__init__" in stub:
                self.same_arguments(kind, stub["__init__"], name)
            for member, value in real.items():
                what = f"{name}.{member}"
                self.assertEqual(inspect.isgetsetdescriptor(value), is_property(stub[member]), what)
                if not is_property(stub[member]) and not member.startswith("__"):
                    self.same_arguments(getattr(kind, member), stub[member], what)

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
