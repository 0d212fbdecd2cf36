# SPDX-License-Identifier: Apache-2.0
"""A TOML document together with the line on which each of its keys stands.

The standard parser decides what is valid and what the values are; the syntax tree adds positions.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import tree_sitter
import tree_sitter_toml

if sys.version_info >= (3, 11):
    import tomllib as tomllib  # the tools have it from here
else:
    import tomli

    tomllib = tomli

KeyPath = tuple[str | int, ...]
"""Where a value stands: names of keys, and indices of array elements."""

LONGEST_LINE = 4000
"""Characters in a line. Keeps every integer below the length at which Python refuses to read it."""

_PARSER = tree_sitter.Parser(tree_sitter.Language(tree_sitter_toml.language()))

_PLACE = re.compile(r"\s*\(at (?:line (?P<line>\d+), column \d+|end of document)\)$")
_REPEATED = re.compile(r"overwrite|twice|duplicate|redefine|mutate", re.IGNORECASE)
_FORM = "a line is key = value, [table] or # comment"
_HINTS = (
    (r"=\s*(#.*)?$", "a value stands after the ="),
    (r"=\s*[-+]?(\.\d|\d+\.(?!\d))", "a number has digits on both sides of its point"),
    (r"=\s*[-+]?[\d._]+([eE][-+]?\d+)?\s*[^\W\d_]", "write the number alone, without a unit"),
    (r"=\s*[-+]?\d+,\d", "the decimal sign is a point"),
    (r"=\s*[^\W\d_]", 'a string stands in quotes, as in key = "value"'),
    (r"""=\s*(["'])(?!.*\1)""", "a string ends with its quote on the same line"),
    (r"^\s*\[[^\]]*$", "a table is [name] on a line of its own"),
    (r"^\s*[\w-]+\s*:", "a line is key = value, with = in place of :"),
)


class TomlError(ValueError):
    """A document that can't be read; ``line`` counts from 1, ``problem`` is one line of text."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(f"line {line}: {problem}")
        self.line = line
        self.problem = problem


def parse_value(text: str) -> Any:
    """The value that ``text`` stands for on the right of an equals sign.

    ``ValueError`` where it is not one TOML value on one line.
    """
    if "\n" in text or len(text) > LONGEST_LINE:
        raise ValueError("a value stands on one line")
    try:
        data = tomllib.loads(f"value = {text}")
    except RecursionError:
        raise ValueError("nested too deeply") from None
    return data["value"]


def parse(content: bytes) -> tuple[dict[str, Any], dict[KeyPath, int]]:
    """Values of a document, and the line of each table, key and array element, from 1.

    ``TomlError`` where it is not UTF-8 or not TOML.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = content[error.start]
        raise TomlError(line, f"byte 0x{byte:02x} is not UTF-8; save the file as UTF-8") from None
    for number, line_text in enumerate(text.split("\n"), start=1):
        if len(line_text) > LONGEST_LINE:
            raise TomlError(
                number,
                f"the line has {len(line_text)} characters; it may have at most {LONGEST_LINE}",
            )
    try:
        try:
            data = tomllib.loads(text)
        except ValueError as error:
            raise _syntax_error(text, error) from None
        return data, _index(text).lines
    except RecursionError:
        raise TomlError(
            1, "arrays or tables are nested too deeply; a scene needs three levels"
        ) from None


@dataclass
class _Index:
    lines: dict[KeyPath, int] = field(default_factory=dict)
    explicit: set[KeyPath] = field(default_factory=set)
    repeated: list[tuple[int, str]] = field(default_factory=list)
    elements: dict[KeyPath, int] = field(default_factory=dict)
    """Number of the newest table of each array of tables."""

    def add(self, prefix: KeyPath, parts: list[str], line: int, form: str = "{}") -> KeyPath:
        """Note a key below ``prefix``; what its dots make on the way is noted as implied."""
        path = prefix
        for part in parts:
            path = (*self._newest(path), part)
            self.lines.setdefault(path, line)
        if path in self.explicit:
            name = form.format(dotted(path))
            problem = f"{name} is given twice, first on line {self.lines[path]}; keep one of them"
            self.repeated.append((line, problem))
        else:
            self.explicit.add(path)
            self.lines[path] = line
        return path

    def add_element(self, parts: list[str], line: int) -> KeyPath:
        """Note a further table of the array of tables that ``parts`` name."""
        path: KeyPath = ()
        for part in parts:
            path = (*self._newest(path), part)
            self.lines.setdefault(path, line)
        self.elements[path] = self.elements.get(path, -1) + 1
        path = self._newest(path)
        self.lines[path] = line
        return path

    def _newest(self, path: KeyPath) -> KeyPath:
        """The path below which the keys of an array of tables go on."""
        return (*path, self.elements[path]) if path in self.elements else path


def _line(node: tree_sitter.Node) -> int:
    return node.start_point[0] + 1


def _key_names(node: tree_sitter.Node) -> Iterator[str]:
    """Names of a key from left to right, with quotes and escapes resolved."""
    waiting = [node]
    while waiting:
        part = waiting.pop()
        text = (part.text or b"").decode("utf-8", "replace")
        if part.type == "dotted_key":
            waiting.extend(reversed(part.named_children))
        elif part.type == "quoted_key":
            try:
                yield next(iter(tomllib.loads(f"{text} = 0")))
            except ValueError:
                yield text
        elif part.type == "bare_key":
            yield text


def _index_value(index: _Index, path: KeyPath, node: tree_sitter.Node) -> None:
    if node.type == "array":
        elements = [child for child in node.named_children if child.type != "comment"]
        for number, element in enumerate(elements):
            index.lines[(*path, number)] = _line(element)
            _index_value(index, (*path, number), element)
    elif node.type == "inline_table":
        _index_pairs(index, path, node)


def _index_pairs(index: _Index, prefix: KeyPath, node: tree_sitter.Node) -> None:
    for pair in node.named_children:
        if pair.type == "pair" and pair.named_children:
            key, *values = pair.named_children
            path = index.add(prefix, list(_key_names(key)), _line(key))
            for value in values:
                _index_value(index, path, value)


def _index(text: str) -> _Index:
    index = _Index()
    root = _PARSER.parse(text.encode()).root_node
    _index_pairs(index, (), root)
    for table in root.named_children:
        if table.type == "table" and table.named_children:
            path = index.add(
                (), list(_key_names(table.named_children[0])), _line(table), "table [{}]"
            )
            _index_pairs(index, path, table)
        elif table.type == "table_array_element" and table.named_children:
            path = index.add_element(list(_key_names(table.named_children[0])), _line(table))
            _index_pairs(index, path, table)
    return index


def dotted(path: KeyPath) -> str:
    """A path as it is written in a message: ``controller.walls[0][1]``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            bare = re.fullmatch(r"[A-Za-z0-9_-]+", part)
            shown = part if bare else f'"{part}"'
            text += f".{shown}" if text else shown
    return text if len(text) <= 80 else f"{text[:77]}..."


def _syntax_error(text: str, error: ValueError) -> TomlError:
    message = str(error)
    place = _PLACE.search(message)
    if place is None:  # a value that TOML allows and Python can't hold, such as 30 February
        return TomlError(1, f"{message}; {_FORM}")
    lines = text.split("\n")
    line = int(place["line"]) if place["line"] else max(1, len(text.rstrip().split("\n")))
    message = message[: place.start()]
    if _REPEATED.search(message):
        for second, problem in sorted(_index(text).repeated):
            if second <= line:
                return TomlError(second, problem)
    offending = lines[line - 1] if line <= len(lines) else ""
    hint = next((hint for form, hint in _HINTS if re.search(form, offending)), _FORM)
    return TomlError(line, f"not valid TOML: {message[:1].lower()}{message[1:]}; {hint}")
