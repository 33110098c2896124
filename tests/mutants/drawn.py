"""Small changes of the source, one at a time: a comparison, an operator, a number, a branch."""

import ast
import copy
import random
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

COMPARISONS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq}
COMPARISONS |= {ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is}
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.BitOr: ast.BitAnd}
OPERATORS |= {ast.BitAnd: ast.BitOr, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.LShift: ast.RShift}
OPERATORS |= {ast.RShift: ast.LShift, ast.Pow: ast.Mult, ast.BitXor: ast.BitOr}
CALLS = {"min": "max", "max": "min", "any": "all", "all": "any", "minimum": "maximum", "maximum": "minimum"}
CALLS |= {"floor": "ceil", "ceil": "floor", "argmin": "argmax", "argmax": "argmin", "median": "mean"}


class Mutant(NamedTuple):
    """One change.

    Attributes
    ----------
    file : str
        Relative to the repository.
    line : int
    before, after : str
        What is replaced, and by what.
    source : str
        The whole changed file.
    """

    file: str
    line: int
    before: str
    after: str
    source: str


def mutants_of(root: Path, file: Path) -> list[Mutant]:
    """All mutants of one file."""
    text = file.read_text(encoding="utf-8")
    tree = ast.parse(text)
    return [
        Mutant(str(file.relative_to(root)), node.lineno, ast.unparse(node), after, _replaced(text, node, after))
        for node in _sites(tree)
        for after in _changes(node)
    ]


def drawn(root: Path, folder: str, count: int, seed: int) -> list[Mutant]:
    """Mutants of a folder, every place in the code with the same chance, in a random order."""
    files = [file for file in sorted((root / folder).rglob("*.py")) if file.name != "__init__.py"]
    found = [mutant for file in files for mutant in mutants_of(root, file)]
    return random.Random(seed).sample(found, min(count, len(found)))


def _sites(node: ast.AST) -> Iterator[ast.expr | ast.stmt]:
    """Expressions and statements that may be changed: no annotations, no decorators, no messages, no documentation."""
    if isinstance(node, ast.Raise | ast.Import | ast.ImportFrom | ast.JoinedStr) or _is_documentation(node):
        return
    if isinstance(node, ast.expr | ast.stmt):
        yield node
    for part in _parts(node):
        yield from _sites(part)


def _parts(node: ast.AST) -> Iterator[ast.AST]:
    match node:
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            yield from (one for one in (*node.args.defaults, *node.args.kw_defaults, *node.body) if one is not None)
        case ast.ClassDef():
            yield from node.body
        case ast.AnnAssign():
            yield from (node.value,) if node.value is not None else ()
        case ast.If() if _is_for_types(node):
            pass
        case _:
            yield from ast.iter_child_nodes(node)


def _is_documentation(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_for_types(node: ast.If) -> bool:
    return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _changes(node: ast.expr | ast.stmt) -> list[str]:
    """Other code for a node; empty where it cannot be changed."""
    changed = _other_operation(node) or _other_value(node)
    return [] if changed is None else [ast.unparse(changed)]


def _other_operation(node: ast.AST) -> ast.AST | None:
    match node:
        case ast.Compare() if type(node.ops[0]) in COMPARISONS:
            return _with(node, ops=[COMPARISONS[type(node.ops[0])](), *node.ops[1:]])
        case ast.BinOp() | ast.AugAssign() if type(node.op) in OPERATORS and not _is_text(node):
            return _with(node, op=OPERATORS[type(node.op)]())
        case ast.BoolOp():
            return _with(node, op=ast.And() if isinstance(node.op, ast.Or) else ast.Or())
        case ast.UnaryOp(op=ast.Not() | ast.USub()):
            return node.operand
        case ast.IfExp():
            return _with(node, test=ast.UnaryOp(ast.Not(), node.test))
        case _:
            return None


def _other_value(node: ast.AST) -> ast.AST | None:
    match node:
        case ast.Constant(value=bool()):
            return ast.Constant(not node.value)
        case ast.Constant(value=int() | float() as number):
            return ast.Constant(number + 1 if isinstance(number, int) else number * 1.5 + 0.1)
        case ast.Call(func=ast.Name(id="abs"), args=[only]):
            return only
        case ast.Call(func=ast.Name(id=name)) if name in CALLS:
            return _with(node, func=ast.Name(CALLS[name]))
        case ast.Call(func=ast.Attribute(attr=name)) if name in CALLS:
            return _with(node, func=_with(node.func, attr=CALLS[name]))
        case _:
            return None


def _is_text(node: ast.BinOp | ast.AugAssign) -> bool:
    sides = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.value,)
    return any(isinstance(side, ast.JoinedStr | ast.Constant) and not _is_number(side) for side in sides)


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def _with(node: ast.AST, **fields: object) -> ast.AST:
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other


def _replaced(text: str, node: ast.expr | ast.stmt, after: str) -> str:
    """The text with a node replaced; positions of `ast` count bytes."""
    lines = text.encode().splitlines(keepends=True)
    start = sum(map(len, lines[: node.lineno - 1])) + node.col_offset
    end = sum(map(len, lines[: (node.end_lineno or node.lineno) - 1])) + (node.end_col_offset or 0)
    code = after if isinstance(node, ast.stmt) else f"({after})"
    data = text.encode()
    return (data[:start] + code.encode() + data[end:]).decode()
