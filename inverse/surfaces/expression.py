"""Expressions such as ``0.45 - 0.3*(x^2 + y^2)``: parsed to CasADi, never evaluated as code.

The grammar::

    sum     = product { ("+" | "-") product }
    product = signed { ("*" | "/") signed }
    signed  = { "+" | "-" } power
    power   = atom [ ("^" | "**") signed ]
    atom    = number | constant | variable | function "(" sum { "," sum } ")" | "(" sum ")"
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

import casadi

from inverse.errors import InputError
from inverse.words import did_you_mean

MAX_CHARACTERS = 2000
MAX_DEPTH = 50

PLAN, SPACE = ("x", "y"), ("x", "y", "z")  # variables of heights and of implicit surfaces
CONSTANTS = {"pi": math.pi, "e": math.e}
# Name -> function, smallest and largest number of arguments (None: any).
FUNCTIONS: dict[str, tuple[Callable[..., casadi.SX], int, int | None]] = {
    **{name: (getattr(casadi, name), 1, 1) for name in ("sqrt", "exp", "log", "sin", "cos", "tan")},
    **{name: (getattr(casadi, name), 1, 1) for name in ("asin", "acos", "atan", "sinh", "cosh", "tanh")},
    "abs": (casadi.fabs, 1, 1),
    "atan2": (casadi.atan2, 2, 2),
    "hypot": (casadi.hypot, 2, 2),
    "pow": (lambda base, exponent: base**exponent, 2, 2),
    "min": (lambda *values: functools.reduce(casadi.fmin, values), 2, None),
    "max": (lambda *values: functools.reduce(casadi.fmax, values), 2, None),
}
_TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>\*\*|[-+*/^(),])",
    re.ASCII,
)
_EXAMPLE = "For example 0.45 - 0.3*(x^2 + y^2)."
_MULTIPLY = "Write multiplication with a sign: 2*x, 3*(x + y)."


def parse(text: str, variables: tuple[str, ...] = PLAN, what: str = "height expression") -> casadi.Function:
    """The function that an expression stands for, differentiable.

    Args:
        text: an expression in the variables with numbers, ``pi``, ``e``, ``+ - * /``, ``^`` or ``**`` for
            powers, parentheses and the functions of :data:`FUNCTIONS`; angles in radians.
        variables: :data:`PLAN` or :data:`SPACE`.
        what: what the text is called in messages.

    Returns:
        A CasADi function with the variables as scalar inputs and a scalar output.

    Raises:
        InputError: the text is no such expression; the message names the part and its position in the text.
    """
    if len(text) > MAX_CHARACTERS:
        raise InputError(
            f"the {what} has {len(text)} characters: at most {MAX_CHARACTERS} are allowed",
            hint="Give a mesh as the target instead.",
        )
    if not text.strip():
        raise InputError(f"the {what} is empty", hint=_EXAMPLE)
    parser = _Parser(text, variables, what)
    value = casadi.densify(parser.whole())
    return casadi.Function("value", list(parser.symbols.values()), [value], list(variables), ["value"])


class _Token(NamedTuple):
    kind: str  # number, name, sign or end
    text: str
    start: int
    end: int


class _Parser:
    """Recursive descent over the grammar above; each method reads one rule and returns its value."""

    def __init__(self, text: str, variables: tuple[str, ...], what: str) -> None:
        self.text, self.what = text, what
        self.symbols = {name: casadi.SX.sym(name) for name in variables}
        self.values = self.symbols | {name: casadi.SX(value) for name, value in CONSTANTS.items()}
        self.tokens = self._tokens()
        self.at = 0
        self.depth = 0

    def _tokens(self) -> list[_Token]:
        tokens, at = [], 0
        while at < len(self.text):
            match = _TOKEN.match(self.text, at)
            if match is not None:
                tokens.append(_Token(str(match.lastgroup), match[0], at, match.end()))
                at = match.end()
            elif self.text[at].isspace():
                at += 1
            else:
                tokens.append(_Token("unknown", self.text[at], at, at + 1))
                at += 1
        return [*tokens, _Token("end", "", len(self.text), len(self.text))]

    def whole(self) -> casadi.SX:
        value = self._sum()
        token = self.tokens[self.at]
        if token.kind != "end":
            raise self._unexpected(token)
        return value

    def _sum(self) -> casadi.SX:
        start = self.at
        value = self._product()
        while sign := self._take("+", "-"):
            other = self._product()
            value = self._finite(value + other if sign == "+" else value - other, start)
        return value

    def _product(self) -> casadi.SX:
        start = self.at
        value = self._signed()
        while sign := self._take("*", "/"):
            other = self._signed()
            value = self._finite(value * other if sign == "*" else value / other, start)
        return value

    def _signed(self) -> casadi.SX:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            token = self.tokens[self.at]
            raise self._error(token, f"is nested more than {MAX_DEPTH} deep")
        sign = self._take("+", "-")
        value = self._signed() if sign else self._power()
        self.depth -= 1
        return -value if sign == "-" else value

    def _power(self) -> casadi.SX:
        start = self.at
        base = self._atom()
        return self._finite(base ** self._signed(), start) if self._take("^", "**") else base

    def _atom(self) -> casadi.SX:
        start, token = self.at, self.tokens[self.at]
        self.at += 1
        if token.kind == "number":
            return self._finite(casadi.SX(float(token.text)), start)
        if token.kind == "name" and self.tokens[self.at].text == "(":
            return self._call(start, token)
        if token.kind == "name":
            if token.text in FUNCTIONS:
                raise self._error(token, "is a function and needs parentheses", f"For example {token.text}(x).")
            if token.text not in self.values:
                raise self._misnomer(token, "no variable or constant", self.values)
            return self.values[token.text]
        if token.text == "(":
            value = self._sum()
            self._close(token)
            return value
        if token.kind == "end" and start > 0:
            raise self._error(self.tokens[start - 1], "is the end of the expression: something is missing after it")
        if token.kind == "unknown":
            raise self._unexpected(token)
        raise self._error(token, "stands where a number, a name or ( should be", _EXAMPLE)

    def _call(self, start: int, name: _Token) -> casadi.SX:
        if name.text in self.values:
            raise self._error(name, "is no mathematical function", _MULTIPLY)
        if name.text not in FUNCTIONS:
            raise self._misnomer(name, "no mathematical function", FUNCTIONS)
        function, least, most = FUNCTIONS[name.text]
        bracket = self.tokens[self.at]
        self.at += 1
        arguments = [] if self.tokens[self.at].text == ")" else [self._sum()]
        while arguments and self._take(","):
            arguments.append(self._sum())
        self._close(bracket)
        if not least <= len(arguments) <= (most or len(arguments)):
            needs = f"{least}{'' if most else ' or more'} argument{'s' if least > 1 else ''}"
            raise self._error(name, f"needs {needs}, given {len(arguments)}")
        return self._finite(function(*arguments), start)

    def _take(self, *signs: str) -> str:
        """The next token's text if it is one of the signs, which is then read, else nothing."""
        text = self.tokens[self.at].text
        if text not in signs:
            return ""
        self.at += 1
        return text

    def _close(self, bracket: _Token) -> None:
        token = self.tokens[self.at]
        if token.kind == "end":
            raise self._error(bracket, "is never closed")
        if not self._take(")"):
            raise self._unexpected(token)

    def _finite(self, value: casadi.SX, start: int) -> casadi.SX:
        """The value of the tokens from ``start`` to the last one read."""
        if value.is_constant() and not math.isfinite(float(value)):
            first = self.tokens[start].start
            end = self.tokens[self.at - 1].end
            raise self._error(_Token("part", self.text[first:end], first, end), "is no finite number")
        return value

    def _unexpected(self, token: _Token) -> InputError:
        if token.kind in ("number", "name") or token.text == "(":
            return self._error(token, "needs +, -, * or / before it", _MULTIPLY)
        if token.text == ")":
            return self._error(token, "closes a parenthesis that was never opened")
        return self._error(token, "has no place here", _EXAMPLE)

    def _misnomer(self, token: _Token, what: str, allowed: Iterable[str]) -> InputError:
        names = tuple(allowed)
        return self._error(token, f"is {what}: allowed are {', '.join(names)}.{did_you_mean(token.text, names)}")

    def _error(self, token: _Token, what: str, hint: str | None = None) -> InputError:
        part = token.text if len(token.text) <= 40 else f"{token.text[:37]}..."
        return InputError(f"`{part}` at position {token.start + 1} of the {self.what} {what}", hint=hint)
