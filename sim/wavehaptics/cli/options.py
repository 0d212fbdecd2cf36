# SPDX-License-Identifier: Apache-2.0
"""Where an option belongs that a command doesn't know."""

from __future__ import annotations

import sys
from typing import Any


def home(error: Any) -> str:
    """Where the option of a usage error belongs, as the end of a sentence; "" if nowhere."""
    name, context = getattr(error, "option_name", None), error.ctx
    if name is None or context is None:
        return ""
    above = context.parent
    while above is not None:
        option = _option(above.command, name)
        if option is not None:
            path = " ".join(filter(None, (above.command_path, name, _value(option))))
            found = f"it belongs to `{path}`"
            if option.is_eager:
                return found
            reached = _option(context.command, "--port") is not None
            by = f"; `{context.info_name}` reaches it by --port" if reached else ""
            return f"{found}, which runs by itself in another terminal{by}"
        above = above.parent
    paths = list(_below(context.command, context.command_path, name))
    # That of the command which was typed, if it is one of them.
    typed = [path for path, command in paths if command in sys.argv]
    for path in typed or [path for path, _ in paths[:1]]:
        return f"write it behind the command, as in `{path} {name}`"
    return ""


def _below(command: Any, path: str, name: str) -> Any:
    """(path, name) of commands of a group, and of its groups, that have an option."""
    for child_name, child in getattr(command, "commands", {}).items():
        child_path = f"{path} {child_name}"
        if _option(child, name) is not None:
            yield child_path, child_name
        yield from _below(child, child_path, name)


def _option(command: Any, name: str) -> Any:
    return next((one for one in command.params if name in one.opts), None)


def _value(option: Any) -> str:
    """What stands behind an option."""
    return "" if option.is_flag else option.metavar or option.type.name.upper()
