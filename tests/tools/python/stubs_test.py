"""The type stubs name what the package has, with the same parameters, and everything is documented."""

import ast
import inspect
import os
import unittest

import hpdm
import hpdm.gym

SCENE = hpdm.Scene(hpdm.scene_path("two_hands.toml"))


def stub_of(module):
    """Returns the stub's nodes by name."""
    with open(os.path.splitext(module.__file__)[0] + ".pyi", encoding="utf-8") as file:
        body = ast.parse(file.read()).body
    return {node.name: node for node in body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


def parameters(node):
    arguments = node.args
    return [a.arg for a in arguments.posonlyargs + arguments.args + arguments.kwonlyargs]


def parameters_of(function):
    return [p.name for p in inspect.signature(function).parameters.values()
            if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]


def members(node, stub):
    """Functions and attributes of a stub's class, also of the bases that the stub has."""
    functions, attributes = {}, set()
    for base in node.bases:
        if isinstance(base, ast.Name) and base.id in stub:
            inherited, more = members(stub[base.id], stub)
            functions.update(inherited)
            attributes |= more
    for item in node.body:
        if isinstance(item, ast.FunctionDef):
            functions[item.name] = item
        elif isinstance(item, ast.AnnAssign):
            attributes.add(item.target.id)
    return functions, attributes


class StubsTest(unittest.TestCase):
    def instances(self):
        env = hpdm.gym.make("Reach")
        vector = hpdm.gym.VectorEnv(hpdm.gym.Reach, 2, threads=1)
        session = hpdm.Session(SCENE)
        return {"Scene": SCENE, "Session": session, "Organ": session.organs["liver"],
                "Batch": hpdm.Batch(SCENE, 2, threads=1), "State": session.save(),
                "InputError": hpdm.InputError("x"), "Env": env, "VectorEnv": vector,
                "Task": env.task, "Box": env.action_space,
                "Dict": hpdm.gym.Dict({"a": env.action_space})}

    def test_they_have_every_public_name(self):
        for module in (hpdm, hpdm.gym):
            self.assertEqual(set(module.__all__) - {"TASKS"},
                             {name for name in stub_of(module) if not name.startswith("_")})

    def test_functions_have_the_same_parameters(self):
        compared = 0
        for module in (hpdm, hpdm.gym):
            stub = stub_of(module)
            for name in set(module.__all__) & set(stub):
                own = getattr(module, name)
                if not inspect.isclass(own):
                    self.assertEqual(parameters(stub[name]), parameters_of(own), name)
                    continue
                for method, node in members(stub[name], stub)[0].items():
                    function = inspect.getattr_static(own, method, None)
                    function = getattr(function, "__func__", function)
                    if not inspect.isfunction(function):
                        continue
                    self.assertEqual(parameters(node), parameters_of(function), f"{name}.{method}")
                    compared += 1
        self.assertGreater(compared, 40)

    def test_classes_have_these_members_and_no_other(self):
        compared = self.instances()
        for module in (hpdm, hpdm.gym):
            stub = stub_of(module)
            for name in set(compared) & set(stub):
                functions, attributes = members(stub[name], stub)
                for member in (set(functions) | attributes) - {"__init__"}:
                    self.assertTrue(hasattr(compared[name], member), f"{name}.{member}")
                if name in ("State", "Task"):  # the rest is for the package itself
                    continue
                shown = {member for member in dir(compared[name]) if not member.startswith("_")}
                shown -= set(dir(ValueError))
                self.assertEqual(shown - set(functions) - attributes, set(), name)

    def test_everything_is_documented(self):
        instances = self.instances()
        for module in (hpdm, hpdm.gym):
            stub = stub_of(module)
            for name in set(module.__all__) & set(stub):
                own = getattr(module, name)
                self.assertTrue(inspect.getdoc(own), name)
                if not inspect.isclass(own):
                    continue
                for method in members(stub[name], stub)[0]:
                    own_one = inspect.getattr_static(own, method, None)
                    if method.startswith("_") or isinstance(own_one, property):
                        continue  # properties: in the class's docstring
                    # step() is of the instance.
                    function = getattr(own, method, None) or getattr(instances[name], method)
                    self.assertTrue(inspect.getdoc(function), f"{name}.{method}")


if __name__ == "__main__":
    unittest.main()
