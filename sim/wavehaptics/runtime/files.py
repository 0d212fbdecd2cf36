# SPDX-License-Identifier: Apache-2.0
"""Files that are written whole or not at all, and the digest that tells whether any has changed."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


def replaced(path: Path) -> Path:
    """The file that a write to ``path`` replaces: of a symbolic link what it points to."""
    return Path(os.path.realpath(path))


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file beside ``path``, to be written; it takes its place unless something is raised.

    Its directory is made. Nobody ever sees a part of it, and no two processes share it. A
    symbolic link stays one.
    """
    path = replaced(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> Path:
    """Write ``text`` as UTF-8, whole or not at all; returns ``path``."""
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def try_file(path: Path) -> None:
    """Write a file beside ``path`` and remove it: ``OSError`` where it couldn't be written."""
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}."):
        pass


def write_json(path: Path, data: Any, indent: int = 2) -> Path:
    """Write ``data`` as JSON, whole or not at all; returns ``path``. ``ValueError`` on NaN."""
    text = json.dumps(data, indent=indent, allow_nan=False, ensure_ascii=False)
    return write_text(path, text + "\n")


def digest_of(told: object, files: Iterable[Path] = (), root: Path | None = None) -> str:
    """Digest, 64 hexadecimal digits, of what ``repr(told)`` says and of ``files``.

    A file counts by its bytes and its name, or by its path from ``root``.
    """
    digest = hashlib.sha256(repr(told).encode())
    for path in files:
        name = path.name if root is None else path.relative_to(root).as_posix()
        digest.update(name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
