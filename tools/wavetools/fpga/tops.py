# SPDX-License-Identifier: Apache-2.0
"""A design's top as its text says it, before any tool has run: pins, parameters and PLLs.

What is found has the form of Yosys' netlists, so that one check judges both. A text that only an
elaboration understands (a conditional part, a macro or a function in a width) is left to Yosys:
what isn't known for sure is None here.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from wavetools.fpga import pll

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/|\(\*(?!\)).*?\*\)", re.DOTALL)
_DEFINE = re.compile(r"^[ \t]*`define[ \t]+(\w+)[ \t]+(\S+)", re.MULTILINE)
_MODULE = re.compile(r"\bmodule\s+(\w+)\s*(#\s*)?\(")
_CONDITIONAL = re.compile(r"\bgenerate\b|`ifn?def\b")
_PORT = re.compile(r"(?:(?:input|output|inout)\b|wire\b|reg\b|signed\b|\s)*(\[[^\]]*\])?\s*(\w+)")
_PARAMETER = re.compile(r"[^=]*?(\w+)\s*=\s*(.*)", re.DOTALL)
_INSIDE = re.compile(r"\bparameter\b([^;]*);")
_NUMBER = re.compile(r"(?:\d+\s*)?'[sS]?([bodhBODH])([\da-fA-F_]+)")
_BASES = {"b": 2, "o": 8, "d": 10, "h": 16}
_OPERATORS = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.floordiv, ast.LShift: operator.lshift, ast.RShift: operator.rshift,
}  # fmt: skip

Value = int | str | None
"""Of a parameter: a number, a text, or what only an elaboration knows."""


class TopError(ValueError):
    """A parameter that a module hasn't got. The message is one line."""


@dataclass(frozen=True)
class Module:
    """A module's text: what is between its parentheses, and its body."""

    name: str
    path: str
    parameters: dict[str, str]
    ports: list[str]
    body: str
    line: int
    """Of the body's beginning."""


def netlist(top: str, sources: Mapping[str, str], headers: Mapping[str, str]) -> dict[str, Any]:
    """``ports`` and PLL ``cells`` of a top, each None where the text doesn't say.

    ``sources`` and ``headers`` are texts by the paths of their files; :class:`TopError`.
    """
    macros = {name: value for text in headers.values() for name, value in _DEFINE.findall(text)}
    modules = {m.name: m for path, text in sources.items() for m in _modules(path, text)}
    if top not in modules:
        return {"ports": None, "cells": None}
    try:
        ports: dict[str, Any] | None = _ports(modules[top], macros)
    except _UnknownError:
        ports = None
    cells = list(_cells(modules[top], {}, modules, macros))
    known = None if None in cells else {str(n): cell for n, cell in enumerate(cells)}
    return {"ports": ports, "cells": known}


class _UnknownError(Exception):
    """Only an elaboration knows."""


def _modules(path: str, text: str) -> Iterator[Module]:
    # Comments go, their lines stay.
    text = _COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    for found in _MODULE.finditer(text):
        end = _closing(text, found.end())
        first, second = text[found.end() : end], ""
        if found[2]:
            opening = text.find("(", end + 1)
            end = _closing(text, opening + 1)
            second, first = first, text[opening + 1 : end]
        stop = text.find("endmodule", end)
        body = text[end + 1 : stop]
        declared = [*_parts(second), *(p for part in _INSIDE.findall(body) for p in _parts(part))]
        parameters = {
            given[1]: given[2].strip() for given in map(_PARAMETER.match, declared) if given
        }
        line = text.count("\n", 0, end) + 1
        yield Module(found[1], path, parameters, _parts(first), body, line)


def _closing(text: str, start: int) -> int:
    """Where the parenthesis closes that was opened before ``start``."""
    depth = 1
    for place in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        if depth == 0:
            return place
    return len(text)


def _parts(text: str) -> list[str]:
    """A list in parentheses, at the commas that are in no other pair of them."""
    parts, depth, start = [], 0, 0
    for place, letter in enumerate(text):
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            parts.append(text[start:place])
            start = place + 1
    parts.append(text[start:])
    return [part.strip() for part in parts if part.strip()]


def _value(text: str, known: Mapping[str, Value], macros: Mapping[str, str]) -> Value:
    """What an expression of numbers, parameters and macros is."""
    if re.fullmatch(r'"[^"]*"', text):
        return text[1:-1]
    text = re.sub(r"`(\w+)", lambda found: macros.get(found[1], "unknown"), text)
    text = _NUMBER.sub(
        lambda found: str(int(found[2].replace("_", ""), _BASES[found[1].lower()])), text
    )
    try:
        return _evaluate(ast.parse(text.strip(), mode="eval").body, known)
    except (SyntaxError, ValueError, ZeroDivisionError, _UnknownError):
        return None


def _evaluate(node: ast.expr, known: Mapping[str, Value]) -> int:
    if isinstance(node, ast.Constant) and isinstance(node.value, int):
        return node.value
    if isinstance(node, ast.Name):
        value = known.get(node.id)
        if isinstance(value, int):
            return value
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        return _OPERATORS[type(node.op)](_evaluate(node.left, known), _evaluate(node.right, known))
    raise _UnknownError


def _ports(module: Module, macros: Mapping[str, str]) -> dict[str, Any]:
    """Ports with as many bits as they are wide."""
    known = {name: _value(text, {}, macros) for name, text in module.parameters.items()}
    ports, width = {}, 1
    for part in module.ports:
        found = _PORT.fullmatch(part)
        if found is None:
            raise _UnknownError
        if found[1] or re.match(r"input|output|inout", part):
            width = 1
        if found[1]:
            ends = [_value(text, known, macros) for text in found[1][1:-1].split(":")]
            if len(ends) != 2 or not (isinstance(ends[0], int) and isinstance(ends[1], int)):
                raise _UnknownError
            width = abs(ends[0] - ends[1]) + 1
        ports[found[2]] = {"bits": [None] * width}
    return ports


def _cells(
    module: Module,
    given: Mapping[str, Value],
    modules: Mapping[str, Module],
    macros: Mapping[str, str],
) -> Iterator[dict[str, Any] | None]:
    """PLLs in a module with its ``given`` parameters, and in those below it."""
    known: dict[str, Value] = {}
    for name, text in module.parameters.items():
        known[name] = given[name] if name in given else _value(text, known, macros)
    sure = _CONDITIONAL.search(module.body) is None
    names = "|".join(map(re.escape, modules))
    instance = rf"\b(?P<type>{names}|(?:{'|'.join(pll.CELLS)})\w*)\b\s*(?P<over>#\s*\()?"
    for found in re.finditer(instance, module.body):
        overrides, place = "", found.end()
        if found["over"]:
            end = _closing(module.body, place)
            overrides, place = module.body[place:end], end + 1
        called = re.compile(r"\s*\w+\s*(?:\[[^\]]*\])?\s*\(").match(module.body, place)
        if called is None:
            continue
        pins = module.body[called.end() : _closing(module.body, called.end())]
        own = {name: _value(text, known, macros) for name, text in _named(overrides)}
        below = modules.get(found["type"])
        if below is None:
            cell = _cell(found["type"], own, dict(_named(pins)))
            yield cell if sure and None not in own.values() and pll.is_whole(cell) else None
            continue
        for name in own:
            if name not in below.parameters:
                line = module.line + module.body.count("\n", 0, found.start())
                has = ", ".join(below.parameters) or "none"
                raise TopError(
                    f"{module.path}:{line}: {below.name} has no parameter {name}; it has {has}"
                )
        cells = list(_cells(below, own, modules, macros))
        yield from cells if sure else [None] * len(cells)


def _named(text: str) -> Iterator[tuple[str, str]]:
    """Names and expressions of ``.NAME (EXPRESSION), ...``."""
    for part in _parts(text):
        found = re.fullmatch(r"\.(\w+)\s*\((.*)\)", part, re.DOTALL)
        if found:
            yield found[1], found[2].strip()


def _cell(kind: str, parameters: Mapping[str, Value], pins: Mapping[str, str]) -> dict[str, Any]:
    """A PLL as a netlist of Yosys has it."""
    written = {
        name: format(value, "b") if isinstance(value, int) else str(value)
        for name, value in parameters.items()
    }
    return {
        "type": kind,
        "parameters": written,
        "connections": {name: [net] for name, net in pins.items() if net},
    }
