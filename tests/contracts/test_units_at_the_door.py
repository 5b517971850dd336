"""Only `nutamill.base.units` knows another unit: no other file converts a number by hand."""

import ast
import pathlib

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent

FACTORS = {1e3, 1e-3, 1e6, 1e9, 60.0, 3600.0}
"""Numbers that turn a unit into another; as floats, so that counts stay allowed."""

ANGLES = {"degrees", "rad2deg", "radians", "deg2rad"}
"""Functions of NumPy and of `math` that convert an angle; of a constant they are plain text."""

OTHERWISE = {
    "base/atomic_file.py": "bytes",
    "base/files.py": "bytes",
    "design/forecast.py": "bytes",
    "analysis/bearings.py": "millions of revolutions",
}
"""Files that convert what is no quantity of a case."""


def conversions(tree: ast.AST) -> list[tuple[int, str]]:
    """Return line and text of each product, ratio or call that converts a number by hand."""
    lines = []
    for node in ast.walk(tree):
        by_factor = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div)
        if by_factor and any(
            isinstance(side, ast.Constant) and isinstance(side.value, float) and side.value in FACTORS
            for side in (node.left, node.right)
        ):
            lines.append((node.lineno, ast.unparse(node)))
        is_call = isinstance(node, ast.Call) and getattr(node.func, "attr", "") in ANGLES
        if is_call and not isinstance(node.args[0], ast.Constant):
            lines.append((node.lineno, ast.unparse(node)))
    return lines


def test_units_are_converted_by_the_one_module():
    wrong = []
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).as_posix()
        if name == "base/units.py" or name in OTHERWISE:
            continue
        for line, text in conversions(ast.parse(path.read_text(encoding="utf-8"))):
            wrong.append(f"{name}:{line}: {text}")
    assert not wrong, "\n".join(["use `units.in_unit`, `units.shown` or `units.si_value`:", *wrong])
