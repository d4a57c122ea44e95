"""Compilation: how a function becomes a kernel.

`kernel` compiles a function over arrays and keeps the result on disk; `part` and `inline` do so for its parts.

The methods of closures, walls and limiters, and formulas, are taught to the compiler here: `hydro.methods` notes them.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import infer_getattr, make_overload_method_template
from numba.extending import intrinsic, overload, register_jitable

from hydro.kernel_cache import KernelCache
from hydro.methods import teach_all

# Without "nnan" and "ninf": a NaN must stay a NaN, for it is how an inadmissible state shows itself.
FASTMATH = {"contract", "arcp", "nsz", "reassoc", "afn"}
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": FASTMATH}
# Without fastmath at all: an expression then has the same bits wherever it is compiled.
EXACT: dict[str, Any] = {"error_model": "numpy", "_nrt": False}
# Loops that say `prange` run in parallel, and nothing else: array expressions are not worth the compile time.
PRANGE_ONLY = {
    name: name == "prange"
    for name in ("prange", "numpy", "reduction", "setitem", "comprehension", "inplace_binop", "stencil", "fusion")
}


def kernel(function: Callable | None = None, *, parallel: bool = False, exact: bool = False) -> Any:
    """Compile `function` for arrays, cached on disk; `parallel=True` runs its `prange` loops on all cores.

    `exact=True`, here and below, forbids the compiler to rearrange arithmetic.
    """
    if function is None:
        return lambda wrapped: kernel(wrapped, parallel=parallel, exact=exact)
    return _cached(function, exact, nogil=True, parallel=PRANGE_ONLY if parallel else False)


def part(function: Callable | None = None, *, exact: bool = False) -> Any:
    """Compile a part of a kernel, that only kernels call: cheaper than `kernel`, for Python cannot call it.

    It is inlined, unless it is exact. A call would reach the part's own machine code from a kernel that has just been
    compiled, and a private copy, with other last bits, from one that comes from disk.
    """
    if function is None:
        return lambda wrapped: part(wrapped, exact=exact)
    return _cached(function, exact, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=not exact)


def inline(function: Callable | None = None, *, exact: bool = False) -> Any:
    """Compile a small scalar function that is always inlined into the kernels that call it."""
    if function is None:
        return lambda wrapped: inline(wrapped, exact=exact)
    return numba.njit(forceinline=True, **(EXACT if exact else OPTIONS))(function)


def _cached(function: Callable, exact: bool, **options: Any) -> Any:
    dispatcher = numba.njit(**(EXACT if exact else OPTIONS), **options)(function)
    dispatcher._cache = KernelCache(function)
    return dispatcher


def _compile_methods(cls: Any, exact: bool) -> None:
    """Teach the compiler the public methods of a NamedTuple class."""
    inherited = set(dir(tuple)) | set(cls._fields)
    for name in dir(cls):
        if not name.startswith("_") and name not in inherited:
            _overload(name, inspect.signature(getattr(cls, name)), exact)


@cache
def _overload(name: str, signature: inspect.Signature, exact: bool) -> None:
    """Teach the compiler the method `name` of any NamedTuple whose class defines it.

    As numba's `overload_method` does, which however would hide fields of the same name in other NamedTuples.
    """

    def implementation(self, *arguments):
        method = getattr(self.instance_class, name, None)
        return method if method is not None and inspect.signature(method) == signature else None

    implementation.__signature__ = signature  # type: ignore[attr-defined]
    overload(implementation, jit_options={"forceinline": True, **(EXACT if exact else OPTIONS)})(implementation)
    template = make_overload_method_template(types.BaseNamedTuple, name, implementation, inline="never")

    class Method(template):  # type: ignore[misc, valid-type]
        def _resolve(self, typ, attr):
            return super()._resolve(typ, attr) if callable(getattr(typ.instance_class, name, None)) else None

    infer_getattr(Method)


@intrinsic
def fetch(typing_context, array, row):
    """Have the line of the cache in which a row of an array begins brought near, before it is needed.

    A row that is not there does no harm.
    """

    def generate(context, builder, signature, arguments):
        kind, of_row = signature.args
        view = context.make_array(kind)(context, builder, arguments[0])
        first = context.cast(builder, arguments[1], of_row, types.intp)
        place = [first, *[context.get_constant(types.intp, 0)] * (kind.ndim - 1)]
        address = cgutils.get_item_pointer(context, builder, kind, view, place, wraparound=False)
        address = builder.bitcast(address, cgutils.voidptr_t)
        word = ir.IntType(32)
        takes = ir.FunctionType(ir.VoidType(), [address.type, word, word, word])
        prefetch = builder.module.declare_intrinsic("llvm.prefetch", [address.type], takes)
        builder.call(prefetch, [address, word(0), word(3), word(1)])  # to read, to stay, data
        return context.get_dummy_value()

    return types.void(array, row), generate


def _teach(thing: Any, exact: bool) -> None:
    """Teach the compiler a class or a formula that `hydro.methods` notes."""
    if isinstance(thing, type):
        _compile_methods(thing, exact)
    else:
        register_jitable(forceinline=True, **EXACT)(thing)  # numba's own inlining may lose statements behind a loop


teach_all(_teach)
