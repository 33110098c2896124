"""How CODESYS, TIA Portal and Studio 5000 write structured text (IEC 61131-3), where they differ."""

import re
from collections.abc import Sequence
from typing import Literal, NamedTuple

Dialect = Literal["codesys", "tia", "rockwell"]

INDENT = "    "


class Variable(NamedTuple):
    """One variable: its name, its type as CODESYS writes it, where it begins, and what it is for."""

    name: str
    type: str
    initial: str = ""
    text: str = ""


class Part(NamedTuple):
    """A function or a function block in the words of CODESYS; `result` is empty for a function block."""

    name: str
    result: str
    text: str
    inputs: Sequence[Variable]
    in_outs: Sequence[Variable]
    outputs: Sequence[Variable]
    inner: Sequence[Variable]
    body: Sequence[str]

    @property
    def kind(self) -> str:
        """Keyword of its kind."""
        return "FUNCTION" if self.result else "FUNCTION_BLOCK"

    @property
    def sections(self) -> list[tuple[str, Sequence[Variable]]]:
        """Sections of variables that are not empty, by keyword."""
        inner = "VAR_TEMP" if self.result else "VAR"
        named = (
            ("VAR_INPUT", self.inputs),
            ("VAR_IN_OUT", self.in_outs),
            ("VAR_OUTPUT", self.outputs),
            (inner, self.inner),
        )
        return [(keyword, variables) for keyword, variables in named if variables]


def write_part(part: Part, dialect: Dialect) -> str:
    """Text of a function or a function block.

    Parameters
    ----------
    part : Part
    dialect : {"codesys", "tia"}
    """
    return _for_tia(part) if dialect == "tia" else _for_codesys(part)


def _for_codesys(part: Part) -> str:
    lines = [f"(* {part.text} *)", f"{part.kind} {part.name}" + (f" : {part.result}" if part.result else "")]
    for keyword, variables in part.sections:
        lines += ["VAR" if keyword == "VAR_TEMP" else keyword, *map(_declared, variables), "END_VAR"]
    return "\n".join([*lines, *part.body, f"END_{part.kind}", ""])


def _declared(variable: Variable) -> str:
    initial = f" := {variable.initial}" if variable.initial else ""
    remark = f" (* {variable.text} *)" if variable.text else ""
    return f"{INDENT}{variable.name} : {variable.type}{initial};{remark}"


def _for_tia(part: Part) -> str:
    """The same as an external source of TIA Portal: quoted names, variables with #, timers of TIA's own type."""
    head = f'{part.kind} "{part.name}"' + (f" : {part.result}" if part.result else "")
    lines = [f"// {part.text}", head, "{ S7_Optimized_Access := 'TRUE' }", "VERSION : 0.1"]
    for keyword, variables in part.sections:
        lines += [keyword, *(_declared(variable._replace(type=_tia_type(variable.type))) for variable in variables)]
        lines += ["END_VAR"]
    own = [variable.name for _, variables in part.sections for variable in variables]
    body = [_hashed(line, own, part) for line in part.body]
    return "\n".join([*lines, "BEGIN", *body, f"END_{part.kind}", ""])


def _tia_type(name: str) -> str:
    return {"TON": "TON_TIME"}.get(name, re.sub(r"\bHOTGAUGE_\w+", r'"\g<0>"', name))


def _hashed(line: str, own: Sequence[str], part: Part) -> str:
    """A line of code with # before the block's own variables and quotes around other blocks."""
    code, mark, remark = line.partition("(*")
    names = "|".join(map(re.escape, own))
    code = re.sub(rf"(?<![\w#.])({names})\b", r"#\1", code)
    code = re.sub(r"\bHOTGAUGE_\w+(?=\()", r'"\g<0>"', code)
    if part.result:
        code = re.sub(rf"\b{part.name}(?=\s*:=)", rf"#{part.name}", code)
    return code + mark + remark
