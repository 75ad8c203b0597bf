"""The hand-kept stub _core.pyi says what the compiled module has: same names, same parameters."""

import ast
import re
from pathlib import Path

import genus
from genus import _core

STUB = Path(genus.__file__).with_name("_core.pyi")


def stub_parameters(function: ast.FunctionDef) -> list[tuple[str, str | None]]:
    """Names with their defaults as text; None where there is none."""
    a = function.args
    positional = a.posonlyargs + a.args
    defaults = [None] * (len(positional) - len(a.defaults)) + list(a.defaults)
    pairs = list(zip(positional, defaults, strict=True))
    pairs += list(zip(a.kwonlyargs, a.kw_defaults, strict=True))
    if a.vararg:
        pairs.insert(len(positional), (a.vararg, None))
    return [(arg.arg, None if d is None else ast.unparse(d)) for arg, d in pairs]


def built_parameters(function) -> list[tuple[str, str | None]]:
    """The same from the first line of the docstring that the bindings write."""
    line = function.__doc__.splitlines()[0]
    text = line[line.index("(") : line.rindex(") ->") + 1]
    # Types are in the project's words there; only names and defaults count here.
    text = re.sub(r"genus\._core\.", "", text)
    arguments = ast.parse(f"def f{text}: ...").body[0]
    return stub_parameters(arguments)


def members(body: list[ast.stmt]) -> dict[str, list[ast.stmt]]:
    found: dict[str, list[ast.stmt]] = {}
    for item in body:
        if isinstance(item, (ast.FunctionDef, ast.ClassDef)):
            found.setdefault(item.name, []).append(item)
        elif isinstance(item, ast.AnnAssign) and ast.unparse(item.annotation) != "TypeAlias":
            found.setdefault(item.target.id, []).append(item)
    return found


def public(names) -> set[str]:
    return {name for name in names if not name.startswith("_")}


TOP = members(ast.parse(STUB.read_text()).body)


def test_module_has_the_names_of_the_stub():
    assert public(TOP) == public(vars(_core))


def test_classes_have_the_members_of_the_stub():
    classes = {n: items[0] for n, items in TOP.items() if isinstance(items[0], ast.ClassDef)}
    for name, item in classes.items():
        built = getattr(_core, name)
        if issubclass(built, Exception):
            assert [ast.unparse(b) for b in item.bases] == [b.__name__ for b in built.__bases__]
            continue
        assert public(members(item.body)) == public(vars(built)), name


def test_functions_have_the_parameters_of_the_stub():
    checked = 0
    for name, items in TOP.items():
        if isinstance(items[0], ast.FunctionDef) and len(items) == 1:
            assert stub_parameters(items[0]) == built_parameters(getattr(_core, name)), name
            checked += 1
        if isinstance(items[0], ast.ClassDef):
            for method, overloads in members(items[0].body).items():
                is_method = (
                    isinstance(overloads[0], ast.FunctionDef) and not overloads[0].decorator_list
                )
                if is_method and not method.startswith("_"):
                    built = built_parameters(getattr(getattr(_core, name), method))
                    ours = stub_parameters(overloads[0])
                    assert ours[1:] == built[1:], f"{name}.{method}"  # without self
                    checked += 1
    assert checked > 30


def test_everything_public_has_a_docstring():
    bare = [n for n in public(vars(_core)) if not (getattr(_core, n).__doc__ or "").strip()]
    assert bare == []
