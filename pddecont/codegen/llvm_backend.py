"""Generated source to machine code by LLVM: assignments of arithmetic to places in arrays, case by case.

The source is the Python that :mod:`machine_code` writes and nothing else: assignments, loops of one assignment, one
chain of cases, arithmetic, comparisons, conditional expressions and the functions of ``math``. Both sides of a
conditional expression are worked out and one is taken; what cannot be evaluated is infinite or no number.
"""

from __future__ import annotations

import ast
import math
from dataclasses import dataclass, field
from typing import Any

from llvmlite import binding, ir

DOUBLE, LONG, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
POINTER = DOUBLE.as_pointer()
# void f(which, t, x, xd, p, out): ``which`` numbers the mode, event or reset.
SIGNATURE = ir.FunctionType(ir.VoidType(), [LONG, DOUBLE, *[POINTER] * 4])
NAME = "generated"
CONSTANTS = {"pi": math.pi, "e": math.e}
# LLVM's own names where it has one: it knows what these functions do; else the mathematical library's, the same.
INTRINSICS = {"sqrt": "llvm.sqrt.f64", "abs": "llvm.fabs.f64", "pow": "llvm.pow.f64"}
LIBRARY = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log")
FUNCTIONS = {name: name for name in LIBRARY} | INTRINSICS
COMPARISONS: dict[type[ast.cmpop], str] = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}
# Whole powers up to this are products; numbers of instructions for more would only grow.
LARGEST_PRODUCT = 16
# Functions longer than this gain nothing from a second look: they have no loops, and common parts are written once.
SPEED, LONG_FUNCTION, SPEED_OF_LONG = 2, 20_000, 1


@dataclass
class Code:
    """A compiled function; its address is valid as long as this object is."""

    engine: Any
    address: int


def compile_source(text: str) -> Code:
    """Return the machine code of a generated source.

    Raises
    ------
    AssertionError
        If the source holds what no printer of this program writes.
    """
    tree = ast.parse(text)
    function = next(node for node in tree.body if isinstance(node, ast.FunctionDef))
    module = ir.Module(name=NAME)
    writer = _Writer(module, ir.Function(module, SIGNATURE, name=NAME))
    writer.write(function.body)
    return _link(str(module), writer.size)


def _link(text: str, size: int) -> Code:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    module = binding.parse_assembly(text)
    level = SPEED if size < LONG_FUNCTION else SPEED_OF_LONG
    machine = binding.Target.from_default_triple().create_target_machine(opt=level, jit=True)
    options = binding.create_pipeline_tuning_options(speed_level=level)
    passes = binding.create_pass_builder(machine, options)
    passes.getModulePassManager().run(module, passes)
    engine = binding.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return Code(engine, engine.get_function_address(NAME))


def _make_error(part: ast.AST) -> AssertionError:
    return AssertionError(f"no printer writes this, and no code is made of it: {ast.unparse(part)}")


@dataclass
class _Writer:
    """Writes statements and expressions as LLVM's instructions."""

    module: ir.Module
    function: ir.Function
    names: dict[str, ir.Value] = field(default_factory=dict)
    size: int = 0

    def __post_init__(self) -> None:
        self.names = dict(zip(("which", "t", "x", "xd", "p", "out"), self.function.args, strict=True))
        # What is written is read nowhere else: numbers may be kept meanwhile.
        self.names["out"].add_attribute("noalias")
        self.builder = ir.IRBuilder(self.function.append_basic_block())

    def write(self, body: list[ast.stmt]) -> None:
        """Write a function's statements."""
        for statement in body:
            if isinstance(statement, ast.If):
                self._write_cases(statement)
            else:
                self._write_statement(statement)
        if not self.builder.block.is_terminated:
            self.builder.ret_void()

    def _write_cases(self, chain: ast.If) -> None:
        """Write a chain of ``if which == 0: .. elif which == 1: ..`` as a jump to one of its cases."""
        end = self.function.append_basic_block()
        jump = self.builder.switch(self.names["which"], end)
        known = dict(self.names)
        rest: list[ast.stmt] = [chain]
        while rest:
            case = rest[0]
            if not isinstance(case, ast.If) or not isinstance(case.test, ast.Compare):
                raise _make_error(case)
            number = case.test.comparators[0]
            assert isinstance(number, ast.Constant)
            block = self.function.append_basic_block()
            jump.add_case(ir.Constant(LONG, number.value), block)
            self.builder.position_at_end(block)
            self.names = dict(known)
            for statement in case.body:
                self._write_statement(statement)
            self.builder.branch(end)
            rest = case.orelse
        self.names = known
        self.builder.position_at_end(end)

    def _write_statement(self, statement: ast.stmt) -> None:
        match statement:
            case ast.Pass() | ast.Return(value=None):
                pass
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                self.names[name] = self._evaluate(value)
            case ast.Assign(targets=[ast.Subscript() as place], value=value):
                self.builder.store(self._evaluate(value), self._find_place(place))
            case ast.For(
                target=ast.Name(id=name),
                iter=ast.Call(
                    func=ast.Name(id="range"),
                    args=[ast.Constant(value=int(first)), ast.Constant(value=int(end)), ast.Constant(value=int(step))],
                ),
                body=[ast.Assign() as turn],
            ):
                self._write_loop(name, range(first, end, step), turn)
            case ast.AugAssign(target=ast.Name(id="which"), op=ast.RShift(), value=ast.Constant(value=bits)):
                self.names["which"] = self.builder.ashr(self.names["which"], ir.Constant(LONG, bits))
            case _:
                raise _make_error(statement)

    def _write_loop(self, name: str, turns: range, turn: ast.Assign) -> None:
        """Write a loop of one assignment, which is made once at least."""
        before, inside, after = self.builder.block, *(self.function.append_basic_block() for _ in range(2))
        self.builder.branch(inside)
        self.builder.position_at_end(inside)
        number = self.names[name] = self.builder.phi(LONG)
        number.add_incoming(ir.Constant(LONG, turns.start), before)
        self._write_statement(turn)
        following = self.builder.add(number, ir.Constant(LONG, turns.step))
        number.add_incoming(following, inside)
        self.builder.cbranch(self.builder.icmp_signed("<", following, ir.Constant(LONG, turns.stop)), inside, after)
        self.builder.position_at_end(after)

    def _find_place(self, place: ast.Subscript) -> ir.Value:
        assert isinstance(place.value, ast.Name)
        return self.builder.gep(self.names[place.value.id], [self._find_number(place.slice)])

    def _find_number(self, number: ast.expr) -> ir.Value:
        """Return the number of a place: one that is written, or that of a loop's turn, moved or not."""
        match number:
            case ast.Constant(value=int(value)):
                return ir.Constant(LONG, value)
            case ast.Name(id=name):
                return self.names[name]
            case ast.BinOp(left=ast.Name(id=name), op=ast.Add(), right=ast.Constant(value=int(moved))):
                return self.builder.add(self.names[name], ir.Constant(LONG, moved))
            case ast.BinOp(left=ast.Name(id=name), op=ast.Sub(), right=ast.Constant(value=int(moved))):
                return self.builder.sub(self.names[name], ir.Constant(LONG, moved))
        raise _make_error(number)

    def _evaluate(self, expr: ast.expr) -> ir.Value:
        """Return the value of an expression: a number, or the truth of a comparison."""
        self.size += 1
        match expr:
            case ast.Constant(value=bool(value)):
                return ir.Constant(TRUTH, value)
            case ast.Constant(value=int(value) | float(value)):
                return ir.Constant(DOUBLE, float(value))
            case ast.Name(id=name):
                return ir.Constant(DOUBLE, CONSTANTS[name]) if name in CONSTANTS else self.names[name]
            case ast.Subscript():
                return self.builder.load(self._find_place(expr))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.builder.fneg(self._evaluate(operand))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._raise(left, right)
            case ast.BinOp(left=left, op=operation, right=right):
                return self._combine(operation, self._evaluate(left), self._evaluate(right))
            case ast.Compare(left=left, ops=[operation], comparators=[right]):
                return self.builder.fcmp_ordered(
                    COMPARISONS[type(operation)], self._evaluate(left), self._evaluate(right)
                )
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self.builder.select(self._evaluate(test), self._evaluate(body), self._evaluate(orelse))
            case ast.Call(func=ast.Name(id="float"), args=[ast.BinOp() as bit]):
                return self._read_digit(bit)
            case ast.Call(func=ast.Name(id=name), args=arguments) if name in FUNCTIONS:
                return self._call(name, [self._evaluate(argument) for argument in arguments])
        raise _make_error(expr)

    def _combine(self, operation: ast.operator, left: ir.Value, right: ir.Value) -> ir.Value:
        write = {
            ast.Add: self.builder.fadd,
            ast.Sub: self.builder.fsub,
            ast.Mult: self.builder.fmul,
            ast.Div: self.builder.fdiv,
            ast.BitAnd: self.builder.and_,
            ast.BitOr: self.builder.or_,
            ast.BitXor: self.builder.xor,
        }
        return write[type(operation)](left, right)

    def _read_digit(self, bit: ast.BinOp) -> ir.Value:
        """Return ``float((which >> k) & 1)``."""
        match bit:
            case ast.BinOp(left=ast.BinOp(left=ast.Name(id="which"), right=ast.Constant(value=k)), op=ast.BitAnd()):
                one = ir.Constant(LONG, 1)
                shifted = self.builder.ashr(self.names["which"], ir.Constant(LONG, k))
                return self.builder.sitofp(self.builder.and_(shifted, one), DOUBLE)
        raise _make_error(bit)

    def _raise(self, base: ast.expr, power: ast.expr) -> ir.Value:
        """Return a power: a product where it is small and whole."""
        value, sign = self._evaluate(base), 1
        if isinstance(power, ast.UnaryOp) and isinstance(power.op, ast.USub):
            power, sign = power.operand, -1
        if isinstance(power, ast.Constant) and isinstance(power.value, int) and 0 < power.value <= LARGEST_PRODUCT:
            product = self._multiply(value, power.value)
            return product if sign > 0 else self.builder.fdiv(ir.Constant(DOUBLE, 1.0), product)
        exponent = self._evaluate(power)
        return self._call("pow", [value, exponent if sign > 0 else self.builder.fneg(exponent)])

    def _multiply(self, value: ir.Value, n: int) -> ir.Value:
        """Return ``value`` to the power n > 0, by squares."""
        product: ir.Value | None = None
        while True:
            if n % 2:
                product = value if product is None else self.builder.fmul(product, value)
            n //= 2
            if n == 0:
                assert product is not None
                return product
            value = self.builder.fmul(value, value)

    def _call(self, name: str, arguments: list[ir.Value]) -> ir.Value:
        symbol = FUNCTIONS[name]
        function = self.module.globals.get(symbol)
        if function is None:
            function = ir.Function(self.module, ir.FunctionType(DOUBLE, [DOUBLE] * len(arguments)), name=symbol)
        return self.builder.call(function, arguments)
