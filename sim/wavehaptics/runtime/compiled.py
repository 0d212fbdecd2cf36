# SPDX-License-Identifier: Apache-2.0
"""How the simulation's loops are compiled: by numba, kept on disk, without reference counts.

A loop's arrays belong to its caller, who keeps them until it returns. To count references to them
in each tick would take four fifths of the integer model's time, as every count may write to memory
and so stands in the way of keeping numbers in registers. A function that makes arrays of its own
can't do without, and takes :data:`compiled_counting`; one that draws from a generator takes
:func:`compiled_drawing`.

numba by itself keeps a function for as long as its file stays as it is, whatever those that it
calls, in other files, have become. Here what is kept bears the digest of all that was compiled: the
function's own bytecode, the constants that it reads and the functions that it calls, and so on to
the last. A comment or a function that it doesn't use costs nothing, and two processes with other
word lengths don't get in each other's way.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import sys
import types
from collections.abc import Callable, Iterable, Iterator
from typing import Any, ParamSpec, Protocol, TypeVar, cast

import numba
import numpy as np
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

from wavehaptics.runtime.files import digest_of
from wavehaptics.runtime.repository import PACKAGE

_PYTHON = sys.implementation.cache_tag

_P = ParamSpec("_P")
_R = TypeVar("_R", covariant=True)


class Compiled(Protocol[_P, _R]):
    """A function that is compiled where it is first called."""

    @property
    def py_func(self) -> Callable[_P, _R]:
        """The same as ordinary Python."""

    def __call__(self, *args: _P.args, **kwargs: _P.kwargs) -> _R: ...


class _Compiler(Protocol):
    def __call__(self, **options: Any) -> Callable[[Callable[_P, _R]], Compiled[_P, _R]]: ...


class _KeptBySources(FunctionCache):
    """numba's cache of one function, in files named after :func:`sources_digest`."""

    # numba's own class has no types.

    def __init__(self, function: Callable[..., Any], dispatcher: Dispatcher) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._dispatcher = dispatcher
        self._found = False

    def _find(self) -> None:
        """Choose the files: at the first use, when all that is called is there."""
        if not self._found:
            digest = sources_digest(self._dispatcher)
            name = self._py_func.__qualname__.replace("<", "").replace(">", "")
            self._cache_file = IndexDataCacheFile(
                self._cache_path, f"{self._py_func.__module__}.{name}-{digest}", digest
            )
            self._found = True

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        self._find()
        return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]

    def save_overload(self, sig: Any, data: Any) -> None:
        self._find()
        super().save_overload(sig, data)  # type: ignore[no-untyped-call]


def sources_digest(dispatcher: Dispatcher) -> str:
    """Digest of all that a compiled function is made of."""
    return digest_of(list(_parts(dispatcher, {})))[:24]


def _parts(value: Any, seen: dict[int, Any]) -> Iterator[Any]:
    """What ``value`` means to a compiled function, as text and bytes; ``seen`` are those before."""
    if isinstance(value, bool | int | float | complex | str | bytes | None | np.generic):
        yield repr(value)
    elif isinstance(value, tuple | list):
        yield type(value).__name__, len(value)
        for item in value:
            yield from _parts(item, seen)
    elif isinstance(value, set | frozenset):
        yield sorted(map(repr, value))
    elif isinstance(value, dict):
        for key in sorted(value):
            yield key
            yield from _parts(value[key], seen)
    elif isinstance(value, np.ndarray):
        yield str(value.dtype), value.shape, value.tobytes()
    elif isinstance(value, enum.EnumMeta):
        members: Iterable[enum.Enum] = value
        yield [(member.name, member.value) for member in members]
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__
        properties = [k for k, v in vars(type(value)).items() if isinstance(v, property)]
        fields = [field.name for field in dataclasses.fields(value)]
        yield from _parts({name: getattr(value, name) for name in fields + properties}, seen)
    elif id(value) in seen:
        yield "as before", list(seen).index(id(value))
    elif isinstance(value, Dispatcher):
        seen[id(value)] = value
        yield from _parts(value.targetoptions, seen)
        yield from _parts(value.py_func, seen)
    elif isinstance(value, _Intrinsic):
        yield from _parts(value._defn, seen)
    elif isinstance(value, types.FunctionType):
        seen[id(value)] = value
        yield from _function_parts(value, seen)
    elif isinstance(value, types.ModuleType | types.BuiltinFunctionType | type | np.ufunc):
        yield getattr(value, "__module__", ""), value.__name__
    else:
        yield type(value).__name__, _whole_package()


def _function_parts(function: types.FunctionType, seen: dict[int, Any]) -> Iterator[Any]:
    names: set[str] = set()
    yield from _code_parts(function.__code__, names, seen)
    yield from _parts([function.__defaults__, function.__kwdefaults__ or {}], seen)
    for cell in function.__closure__ or ():
        yield from _parts(cell.cell_contents, seen)
    if not _is_ours(function.__module__):
        return
    for name in sorted(names & set(function.__globals__)):
        yield name
        value = function.__globals__[name]
        if isinstance(value, types.ModuleType):
            yield from _module_parts(value, names, seen)
        else:
            yield from _parts(value, seen)


def _code_parts(code: types.CodeType, names: set[str], seen: dict[int, Any]) -> Iterator[Any]:
    """Of a function's code all but where it stands and what it says of itself."""
    names.update(code.co_names)
    yield code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_flags
    yield getattr(code, "co_exceptiontable", b""), _PYTHON
    for place, constant in enumerate(code.co_consts):
        if isinstance(constant, types.CodeType):
            yield from _code_parts(constant, names, seen)
        elif place > 0 or not isinstance(constant, str):  # a docstring is the first
            yield from _parts(constant, seen)


def _module_parts(module: types.ModuleType, names: set[str], seen: dict[int, Any]) -> Iterator[Any]:
    """What code with these ``names`` may mean by an attribute of a module."""
    yield module.__name__
    if _is_ours(module.__name__):
        for name in sorted(names & set(vars(module))):
            yield name
            value = vars(module)[name]
            if isinstance(value, types.ModuleType) and id(value) not in seen:
                seen[id(value)] = value
                yield from _module_parts(value, names, seen)
            else:
                yield from _parts(value, seen)


def _is_ours(module: str) -> bool:
    """Whether a module's code may change without numba's or numpy's version."""
    return module.partition(".")[0] not in ("numba", "numpy", "llvmlite", "math", "builtins")


@functools.cache
def _whole_package() -> str:
    """For what can't be looked into: everything."""
    return digest_of("package", sorted(PACKAGE.rglob("*.py")), PACKAGE)


def _compile(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """``numba.njit`` with these options, kept by sources."""
    if function is None:
        return functools.partial(_compile, **options)
    dispatcher: Any = numba.njit(function, **options)
    if isinstance(dispatcher, Dispatcher):
        dispatcher._cache = _KeptBySources(function, dispatcher)  # type: ignore[attr-defined]
    else:  # NUMBA_DISABLE_JIT=1 leaves the function as it is
        dispatcher.py_func = function
    return dispatcher


compiled: _Compiler = functools.partial(_compile, _nrt=False)
"""``numba.njit`` for functions that make no arrays; ``@compiled()`` takes its options too."""

compiled_counting: _Compiler = _compile
"""The same for functions that make arrays of their own."""


def compiled_drawing(function: Callable[_P, _R]) -> Compiled[_P, _R]:
    """The same for a loop that draws from a generator.

    A generator comes in from Python with a count of its own, which would be lost without. So what
    Python calls counts, once, and the loop itself doesn't.
    """
    loop: Any = compiled()(function)

    def enter(*arguments: Any) -> Any:
        return loop(*arguments)

    for name in ("__doc__", "__module__", "__name__", "__qualname__"):
        setattr(enter, name, getattr(function, name))
    return compiled_counting()(cast(Callable[_P, _R], enter))
