"""Calls of MuJoCo's own C functions from compiled code, by address.

numba cannot cache a function that closes over a ctypes pointer; an address passed as an integer it can. So the whole
loop is compiled once, kept on disk, and runs without Python and without the GIL between two MuJoCo steps.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import mujoco
from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _library() -> ctypes.CDLL:
    folder = Path(mujoco.__file__).parent
    found = sorted([*folder.glob("libmujoco.so.*"), *folder.glob("libmujoco.*.dylib"), *folder.glob("mujoco.dll")])
    if not found:
        raise RuntimeError(f"no MuJoCo library in {folder}")
    return ctypes.CDLL(str(found[0]))


def address(name: str) -> int:
    """Address of an exported MuJoCo function, such as `mj_step1`."""
    return int(ctypes.cast(getattr(_library(), name), ctypes.c_void_p).value or 0)


@intrinsic
def call(typing_context, function, model, data):
    """function(model, data) for three addresses, as in `void mj_step1(const mjModel*, mjData*)`."""
    signature = types.void(types.int64, types.int64, types.int64)

    def generate(context, builder, signature, arguments):
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [word, word])
        pointer = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(pointer, list(arguments[1:]))
        return context.get_dummy_value()

    return signature, generate


def _without_owner(context, builder, kind, value):
    """The same value with every array in it, however deep in tuples, stripped of its owner."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value=value)
        array.meminfo = ir.Constant(array.meminfo.type, None)
        array.parent = ir.Constant(array.parent.type, None)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        parts = [_without_owner(context, builder, part, builder.extract_value(value, i)) for i, part in enumerate(kind)]
        return context.make_tuple(builder, kind, parts)
    return value


@intrinsic
def borrowed(typing_context, value):
    """`value` (an array, or a tuple of anything) whose arrays are not reference-counted.

    Reading an array out of a tuple costs two atomic operations otherwise, and the loop does it hundreds of times a
    step. The arrays must outlive the use: they do where they are arguments of the running function.
    """

    def generate(context, builder, signature, arguments):
        return _without_owner(context, builder, value, arguments[0])

    return value(value), generate
