"""Formulas in scene files: arithmetic and a few functions, read by a parser that executes nothing else."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import AfterValidator

from fenics_mech._arrays import Array

FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")
}
OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


LONGEST = 500  # characters
LARGEST_POWER = 20  # beyond it derivatives and intervals soon leave the range of numbers
LARGEST = 1e300  # number


@dataclass(frozen=True)
class Formula:
    """A formula of named variables; `ValueError` where the text is anything else."""

    text: str  # Python-like arithmetic: + - * / **, numbers, pi, the variables, and `FUNCTIONS`
    variables: tuple[str, ...]

    def __post_init__(self) -> None:
        if len(self.text) > LONGEST:
            raise ValueError(f"a formula has at most {LONGEST} characters, found {len(self.text)}")
        self._check(self._tree())

    def uses(self, variable: str) -> bool:
        """Whether a variable stands in it."""
        return any(isinstance(node, ast.Name) and node.id == variable for node in ast.walk(self._tree()))

    def __call__(self, functions: Mapping[str, Callable[[Any], Any]], **values: Any) -> Any:
        """Evaluate with the given values of the variables, of any type that `functions` and + - * / ** take."""
        return self._value(self._tree(), functions, values | {"pi": np.float64(math.pi)})

    def jet(self, variable: Jet, **parameters: float) -> Jet:
        """Value and two derivatives by the one variable that is not among the parameters, of any shape."""
        (name,) = set(self.variables) - set(parameters)
        found = self(
            JET_FUNCTIONS, **{name: variable}, **{key: Jet.constant(p, variable) for key, p in parameters.items()}
        )
        return found if isinstance(found, Jet) else Jet.constant(found, variable)

    def _tree(self) -> ast.expr:
        try:
            return ast.parse(self.text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise ValueError(f"cannot read the formula {self.text!r}") from error

    def _check(self, node: ast.expr) -> None:
        match node:
            case ast.Constant(value=value) if _is_number(value):
                return
            case ast.Name(id=name) if name in (*self.variables, "pi"):
                return
            case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
                self._check(operand)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
                self._check(left)
                self._check(right)
                if isinstance(op, ast.Pow):
                    self._check_power(right)
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
                self._check(argument)
            case _:
                known = ", ".join((*self.variables, "pi", *FUNCTIONS))
                raise ValueError(f"{ast.unparse(node)!r} may not stand in a formula; known are + - * / ** and {known}")

    def _check_power(self, node: ast.expr) -> None:
        power = node.operand if isinstance(node, ast.UnaryOp) else node
        if not isinstance(power, ast.Constant) or not abs(power.value) <= LARGEST_POWER:  # type: ignore[arg-type,operator]
            raise ValueError(f"{ast.unparse(node)!r}: an exponent is a number of at most {LARGEST_POWER}")

    def _value(self, node: ast.expr, functions: Mapping[str, Callable[[Any], Any]], values: Mapping[str, Any]) -> Any:
        match node:
            case ast.Constant(value=value):
                return np.float64(value)  # type: ignore[arg-type]  # a number that raises nothing where it overflows
            case ast.Name(id=name):
                return values[name]
            case ast.UnaryOp(op=op, operand=operand):
                inner = self._value(operand, functions, values)
                return -inner if isinstance(op, ast.USub) else inner
            case ast.BinOp(left=left, op=op, right=right):
                sides = (self._value(side, functions, values) for side in (left, right))
                return OPERATORS[type(op)](*sides)
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return functions[name](self._value(argument, functions, values))
        raise AssertionError(ast.dump(node))  # `_check` has let nothing else pass


def formula_of(*variables: str) -> AfterValidator:
    """Give what refuses texts that are no formula of some variables."""
    return AfterValidator(lambda text: Formula(text, variables).text)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


class Arithmetic:
    """Operations that follow from `+`, `-x`, `*` and `**` of a class whose `_other` takes numbers as well."""

    __array_ufunc__ = None  # numpy's numbers leave the arithmetic to this class

    def __sub__(self: Any, other: Any) -> Any:
        return self + -self._other(other)

    def __truediv__(self: Any, other: Any) -> Any:
        return self * self._other(other) ** -1

    def __radd__(self: Any, other: float) -> Any:
        return self + other

    def __rmul__(self: Any, other: float) -> Any:
        return self * other

    def __rsub__(self: Any, other: float) -> Any:
        return -self + other

    def __rtruediv__(self: Any, other: float) -> Any:
        return self._other(other) / self


@dataclass(frozen=True)
class Jet(Arithmetic):
    """A function's values with its first and second derivative, each an array of one shape."""

    value: Array
    first: Array
    second: Array

    @classmethod
    def variable(cls, value: Array) -> Jet:
        """Give the variable itself."""
        return cls(value, np.ones_like(value), np.zeros_like(value))

    @classmethod
    def constant(cls, value: float, like: Jet) -> Jet:
        """Give a constant of the shape of another jet."""
        zero = np.zeros_like(like.value)
        return cls(zero + value, zero, zero)

    def _through(self, f: Array, df: Array, ddf: Array) -> Jet:
        """Chain rule: an outer function f and its two derivatives at this one's values."""
        return Jet(f, df * self.first, ddf * self.first**2 + df * self.second)

    def _other(self, other: Jet | float) -> Jet:
        return other if isinstance(other, Jet) else Jet.constant(float(other), self)

    def __add__(self, other: Jet | float) -> Jet:
        o = self._other(other)
        return Jet(self.value + o.value, self.first + o.first, self.second + o.second)

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.first, -self.second)

    def __mul__(self, other: Jet | float) -> Jet:
        o = self._other(other)
        second = self.second * o.value + 2 * self.first * o.first + self.value * o.second
        return Jet(self.value * o.value, self.first * o.value + self.value * o.first, second)

    def __pow__(self, power: float) -> Jet:
        x, p = self.value, float(power)
        df = p * x ** (p - 1) if p else np.zeros_like(x)
        ddf = p * (p - 1) * x ** (p - 2) if p * (p - 1) else np.zeros_like(x)
        return self._through(x**p, df, ddf)

    def __rpow__(self, other: float) -> Jet:
        raise ValueError("an exponent is a number")


def slopes_of(law: Callable[..., Any], time: Array, place: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Give a law of time, place and rate, and its derivatives by place and rate, ``(times,)`` each."""
    none, one = np.zeros_like(time), np.ones_like(time)
    found = []
    for by in ((one, none), (none, one)):
        value = law(*(Jet(x, own, none) for x, own in zip((time, place, rate), (none, *by))))
        found.append(value if isinstance(value, Jet) else Jet(none + value, none, none))
    return found[0].value, found[0].first, found[1].first


def jet_functions(functions: Mapping[str, Callable[[Any], Any]]) -> dict[str, Callable[[Any], Any]]:
    """Extend functions to jets of what they take; what is no jet they take as before."""
    sin, cos, tan, exp, tanh, sqrt = (functions[name] for name in ("sin", "cos", "tan", "exp", "tanh", "sqrt"))
    derivatives: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
        "sin": (cos, lambda x: -sin(x)),
        "cos": (lambda x: -sin(x), lambda x: -cos(x)),
        "tan": (lambda x: 1 + tan(x) ** 2, lambda x: 2 * tan(x) * (1 + tan(x) ** 2)),
        "exp": (exp, exp),
        "log": (lambda x: x**-1, lambda x: -(x**-2)),
        "sqrt": (lambda x: 0.5 * sqrt(x) ** -1, lambda x: -0.25 * x**-1.5),
        "tanh": (lambda x: 1 - tanh(x) ** 2, lambda x: -2 * tanh(x) * (1 - tanh(x) ** 2)),
    }
    return {name: _of_jets(functions[name], *both) for name, both in derivatives.items()}


def _of_jets(f: Callable, df: Callable, ddf: Callable) -> Callable[[Any], Any]:
    return lambda x: x._through(f(x.value), df(x.value), ddf(x.value)) if isinstance(x, Jet) else f(x)


JET_FUNCTIONS = jet_functions(FUNCTIONS)
