"""Pointers: to a model's compiled functions, and to the numbers that the integrator works on.

One integrator serves every model because it calls the model's functions by their addresses. All have the signature
``void f(which, t, x, xd, p, out)``: ``which`` numbers the mode, event or reset. Inside the integrator arrays are plain
pointers: nothing counts their references, which would cost more than the arithmetic.
"""

from __future__ import annotations

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic, register_jitable

from pddecont.codegen import DOUBLE_POINTER, compile_when_called
from pddecont.simulate.integrator.machine_code_folder import find_machine_code


# For what Python calls: it is kept on disk with all that it calls in turn. It returns numbers or tuples of them only.
# To make an array or a named tuple for Python, machine code runs Python on its way back, and does not notice an
# exception that a signal handler raises there.
def entry(function):
    """Compile a function that Python calls when it is first called, or read it from disk."""
    return compile_when_called(function, find_machine_code())


# For what only machine code calls.
internal = njit(nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
# For what only machine code calls, in one place.
inlined = njit(nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, inline="always")
# For what both call: machine code where machine code calls it, Python where Python does.
either = register_jitable


@intrinsic
def call(typing, address, which, t, x, xd, p, out):
    """Call the function of a model at ``address``; it writes to ``out``."""

    def generate(context, builder, signature, args):
        pointer = ir.DoubleType().as_pointer()
        function = ir.FunctionType(ir.VoidType(), [ir.IntType(64), ir.DoubleType(), *[pointer] * 4])
        builder.call(builder.inttoptr(args[0], function.as_pointer()), args[1:])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.float64, *[DOUBLE_POINTER] * 4), generate


@intrinsic
def pointer(typing, array):
    """Return a pointer to the first number of an array; the array has to outlive it."""

    def generate(context, builder, signature, args):
        return context.make_array(signature.args[0])(context, builder, args[0]).data

    return types.CPointer(array.dtype)(array), generate


@intrinsic
def offset(typing, pointer, count):
    """Return the pointer ``count`` numbers further on."""

    def generate(context, builder, signature, args):
        return builder.gep(args[0], [args[1]])

    return pointer(pointer, types.int64), generate
