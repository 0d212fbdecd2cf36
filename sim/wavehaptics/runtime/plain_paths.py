# SPDX-License-Identifier: Apache-2.0
"""Paths that make, a shell and a linker's command line take as one word.

Verilator's makefiles reject a folder with a space, parentheses end their shell commands, and they
write an umlaut as its bytes' numbers. Where the project stands in such a folder, tools get its
files through a symbolic link whose path is plain (:func:`plain`), and Verilator builds in a folder
that really has a plain path (:func:`workplace`).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
from pathlib import Path

_PLAIN = re.compile(r"[\w./+@~-]+", re.ASCII)


_BESIDE = Path(f"/var/tmp/wavehaptics-{os.getuid()}")


def is_plain(path: Path) -> bool:
    """Whether every character of a path is a letter or digit of ASCII or one of ``_./+@~-``."""
    return _PLAIN.fullmatch(str(path)) is not None


def cache() -> Path:
    """Folder of this user, with a plain path, for what can't be built beside the sources.

    ``wavehaptics`` in XDG_CACHE_HOME or ``~/.cache``; where that path isn't plain, can't be made or
    belongs to somebody else, a folder in ``/var/tmp``, which isn't there if the same holds for it.
    """
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    for folder in (Path(home, "wavehaptics"), _BESIDE):
        if folder.is_absolute() and is_plain(folder):
            with contextlib.suppress(OSError):
                folder.mkdir(mode=0o700, parents=True, exist_ok=True)
                if folder.stat().st_uid == os.getuid() and os.access(folder, os.W_OK):
                    return folder
    return _BESIDE


def plain(path: Path) -> Path:
    """``path``, an absolute one, or the same file through a link in :func:`cache`.

    The link points to the last folder of the path whose name isn't plain, so that all files of a
    tree have the same. Where none can be made it is ``path`` all the same.
    """
    if is_plain(path):
        return path
    folder = next(p for p in (path, *path.parents) if not is_plain(Path(p.name or "/")))
    try:
        link = _linked(cache() / _name(folder), folder)
    except OSError:
        return path
    return link / path.relative_to(folder)


def workplace(folder: Path) -> Path:
    """``folder``, made, or a folder in :func:`cache` in its place, to which it is a link then.

    A process that works in it finds a plain path when it asks where it is. ``OSError`` where it
    can't be made.
    """
    real = folder.resolve()
    if not is_plain(real):
        real = cache() / f"{_name(real)}-{real.name}"
        if folder.is_dir():  # of a tree that has been moved
            shutil.copytree(folder, real, symlinks=True, dirs_exist_ok=True)
            shutil.rmtree(folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        _linked(folder, real)
    real.mkdir(parents=True, exist_ok=True)
    return folder


def _name(folder: Path) -> str:
    return hashlib.sha256(os.fsencode(folder)).hexdigest()[:16]


def _linked(link: Path, target: Path) -> Path:
    """``link``, made or found as a symbolic link to ``target``; another process may be as fast."""
    if not link.is_symlink() or os.readlink(link) != str(target):
        part = link.with_name(f".{link.name}.{os.getpid()}.part")
        part.symlink_to(target)
        part.replace(link)
    return link
