"""Runs structured text as a PLC does, cycle by cycle, on the syntax tree of blark, a parser that nobody here wrote.

It knows what the function block uses and nothing more: what it does not know, it refuses.
"""

import operator
import struct
from collections.abc import Callable
from typing import Any

from blark import transform as tree
from blark.parse import parse_source_code

RANGES = {"INT": (-0x8000, 0x7FFF), "UINT": (0, 0xFFFF), "WORD": (0, 0xFFFF), "UDINT": (0, 0xFFFFFFFF)}
OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}
SECONDS = {"MS": 0.001}


def float32(value: float) -> float:
    return struct.unpack(">f", struct.pack(">f", value))[0]


def boolean(expression: Any) -> bool:
    return str(expression.value).upper() == "TRUE"


def duration(expression: Any) -> float:
    return float(expression.milliseconds or 0) * SECONDS["MS"] + float(expression.seconds or 0)


LITERALS: dict[Any, Callable[[Any], Any]] = {
    tree.Boolean: boolean,
    tree.HexInteger: lambda expression: int(str(expression.value), 16),
    tree.Integer: lambda expression: int(str(expression.value)),
    tree.Real: lambda expression: float(expression.value),
    tree.Duration: duration,
}


class Ton:
    """Timer with on-delay of IEC 61131-3."""

    def __init__(self) -> None:
        self.Q = False
        self._since_s: float | None = None

    def call(self, now_s: float, *, IN: bool, PT: float) -> None:
        if not IN:
            self._since_s = None
        elif self._since_s is None:
            self._since_s = now_s
        self.Q = self._since_s is not None and now_s - self._since_s >= PT


class Source:
    """Function blocks and functions of a text."""

    def __init__(self, text: str) -> None:
        self._parts = {
            str(part.name): part for part in parse_source_code(text).transform().items if hasattr(part, "name")
        }

    def block(self, name: str) -> "Instance":
        return Instance(self, self._parts[name])

    def call(self, name: str, arguments: dict[str, Any]) -> Any:
        function = Instance(self, self._parts[name], result=name)
        function.set(**arguments)
        function.run(0.0)
        return function.values[name]


class Instance:
    """One function block, or one call of a function, with its variables."""

    def __init__(self, source: Source, part: Any, result: str = "") -> None:
        self.values: dict[str, Any] = {}
        self.types: dict[str, str] = {}
        self._source = source
        self._part = part
        self._now_s = 0.0
        self._kinds: dict[Any, Callable[[Any], Any]] = {
            tree.SimpleVariable: lambda expression: self.values[str(expression.name)],
            tree.MultiElementVariable: self._element,
            tree.UnaryOperation: lambda expression: self._unary(str(expression.op), self._value(expression.expr)),
            tree.BinaryOperation: lambda expression: self._binary(str(expression.op), expression),
            tree.ParenthesizedExpression: lambda expression: self._value(expression.expr),
            tree.FunctionCall: lambda expression: self._function(str(expression.name), expression.parameters),
        }
        if result:
            self._declare(
                result,
                str(part.return_type.type_name if hasattr(part.return_type, "type_name") else part.return_type),
                None,
            )
        for section in part.declarations:
            for item in section.items:
                spec = item.init.spec if hasattr(item.init, "spec") else item.init
                for variable in item.variables:
                    self._declare(str(variable.name), str(spec), getattr(item.init, "value", None))

    def _declare(self, name: str, type_: str, initial: Any) -> None:
        self.types[name] = type_
        if type_ == "TON":
            self.values[name] = Ton()
        elif type_.startswith("ARRAY"):
            self.values[name] = []
        else:
            zero = {"BOOL": False, "REAL": 0.0}.get(type_, 0)
            self.values[name] = zero if initial is None else self._value(initial)

    def set(self, **inputs: Any) -> None:
        assert inputs.keys() <= self.values.keys()
        self.values |= inputs

    def run(self, now_s: float, **inputs: Any) -> None:
        """One cycle."""
        self.set(**inputs)
        self._now_s = now_s
        self._statements(self._part.body)

    def _statements(self, statements: Any) -> None:
        for statement in statements.statements if statements is not None else ():
            self._statement(statement)

    def _statement(self, statement: Any) -> None:
        match statement:
            case tree.AssignmentStatement():
                (target,) = statement.variables
                self._assign(str(target.name), self._value(statement.expression))
            case tree.IfStatement():
                self._if(statement)
            case tree.WhileStatement():
                while self._value(statement.expression):
                    self._statements(statement.statements)
            case tree.FunctionCallStatement():
                timer = self.values[str(statement.name)]
                timer.call(self._now_s, **self._arguments(statement.parameters))
            case _:
                raise NotImplementedError(type(statement).__name__)

    def _if(self, statement: Any) -> None:
        assert not statement.else_ifs
        if self._value(statement.if_expression):
            self._statements(statement.statements)
        elif statement.else_clause is not None:
            self._statements(statement.else_clause.statements)

    def _assign(self, name: str, value: Any) -> None:
        type_ = self.types[name]
        if type_ == "REAL":
            value = float32(value)
        elif type_ == "BOOL":
            assert isinstance(value, bool), f"{name} := {value}"
        else:
            lowest, highest = RANGES[type_]
            assert not isinstance(value, bool)
            assert lowest <= value <= highest, f"{name} := {value}"
        self.values[name] = value

    def _arguments(self, parameters: Any) -> dict[str, Any]:
        return {str(one.name): self._value(one.value) for one in parameters}

    def _value(self, expression: Any) -> Any:
        for kind, value in (*LITERALS.items(), *self._kinds.items()):
            if isinstance(expression, kind):
                return value(expression)
        raise NotImplementedError(f"{type(expression).__name__}: {expression}")

    def _element(self, expression: Any) -> Any:
        value = self.values[str(expression.name)]
        (element,) = expression.elements
        if isinstance(element, tree.FieldSelector):
            return getattr(value, str(element.field))
        (index,) = element.subscripts
        place = self._value(index)
        assert place >= 0
        return value[place]

    def _unary(self, op: str, value: Any) -> Any:
        if op == "NOT":
            assert isinstance(value, bool)
            return not value
        return -value

    def _binary(self, op: str, expression: Any) -> Any:
        left, right = self._value(expression.left), self._value(expression.right)
        if op in {"AND", "OR"}:
            assert isinstance(left, bool) == isinstance(right, bool)
            return left & right if op == "AND" else left | right
        if op == "/":
            return float32(left / right)
        return OPERATORS[op](left, right)

    def _function(self, name: str, parameters: Any) -> Any:
        if name == "SHR":
            value, places = (self._value(one.value) for one in parameters)
            return value >> places
        if "_TO_" in name:
            (one,) = parameters
            value = self._value(one.value)
            return float32(value) if name.endswith("REAL") else value
        return self._source.call(name, self._arguments(parameters))
