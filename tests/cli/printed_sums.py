"""Evaluates the sums that `isolux explain` prints, knowing how far printed digits can be off."""

import itertools
import math
import re
from typing import NamedTuple

from closed_form import srgb

DIGITS = 9  # significant ones, as printed


class Number(NamedTuple):
    """A value, and how far the number that was printed as it may lie from it."""

    value: float
    error: float


def printed(text):
    value = float(text)
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1) if value else 0
    return Number(value, unit / 2)


def spread(function, *numbers):
    """function(numbers), with the error found at the corners of theirs."""
    value = function(*(n.value for n in numbers))
    corners = itertools.product(*((n.value - n.error, n.value + n.error) for n in numbers))
    return Number(value, max(abs(function(*corner) - value) for corner in corners))


def power(base, exponent):
    if exponent.value == round(exponent.value):  # 2, or a whole shininess: printed exactly
        return spread(lambda b: b ** round(exponent.value), base)
    return spread(lambda b, x: max(0.0, b) ** x, base, exponent)


FUNCTIONS = {
    "sqrt": lambda x: math.sqrt(max(0.0, x)),
    "acos": lambda x: math.degrees(math.acos(min(1.0, max(-1.0, x)))),
    "srgb": srgb,
    "max": max,
    "min": min,
}


class Parser:
    """sum: product {(+|-) product}; product: sign {(*|/) sign}; sign: [-] sign | power;
    power: atom [^ sign]; atom: number | function(sum, ...) | (sum, ...), a tuple where several."""

    TOKEN = re.compile(r"\s*(\d[\d.]*(?:e[+-]?\d+)?|[a-z]+|[-+*/^(),])")

    def __init__(self, text):
        self.tokens, at = [], 0
        text = text.strip()
        while at < len(text):
            token = self.TOKEN.match(text, at)
            if not token:
                raise ValueError(f"not understood: {text[at:]!r}")
            self.tokens.append(token[1])
            at = token.end()
        self.tokens.append("")

    def taken(self, *wanted):
        """The next token, if it is one of the wanted."""
        if self.tokens[0] in wanted:
            return self.tokens.pop(0)
        return None

    def needed(self, token):
        if not self.taken(token):
            raise ValueError(f"{token!r} is missing before {self.tokens[0]!r}")

    def whole(self):
        value = self.sum()
        if self.tokens[0]:
            raise ValueError(f"{self.tokens[0]!r} is too much")
        return value

    def sum(self):
        value = self.product()
        while sign := self.taken("+", "-"):
            value = spread((lambda a, b: a + b) if sign == "+" else (lambda a, b: a - b),
                           value, self.product())
        return value

    def product(self):
        value = self.sign()
        while sign := self.taken("*", "/"):
            value = spread((lambda a, b: a * b) if sign == "*" else (lambda a, b: a / b),
                           value, self.sign())
        return value

    def sign(self):
        return spread(lambda a: -a, self.sign()) if self.taken("-") else self.power()

    def power(self):
        base = self.atom()
        return power(base, self.sign()) if self.taken("^") else base

    def atom(self):
        token = self.tokens.pop(0)
        if token[:1].isdigit():
            return printed(token)
        if token in FUNCTIONS:
            return spread(FUNCTIONS[token], *self.listed())
        if token != "(":
            raise ValueError(f"{token!r} is no number")
        self.tokens.insert(0, token)
        items = self.listed()
        return items[0] if len(items) == 1 else tuple(items)

    def listed(self):
        self.needed("(")
        items = [self.sum()]
        while self.taken(","):
            items.append(self.sum())
        self.needed(")")
        return items


def evaluate(text):
    """A Number, or a tuple of them."""
    return Parser(text).whole()


class Step(NamedTuple):
    """A line `name = ... = numbers = result`. `numbers` is None where the result is given and not
    computed; `byte` is what stands after "->" in a line on display."""

    name: str
    numbers: str
    result: tuple
    byte: int


def as_tuple(value):
    return (value,) if isinstance(value, Number) else value


def steps_of(text):
    steps = []
    for line in text.splitlines():
        if not line.startswith("  ") or " = " not in line:
            continue
        line, _, byte = line.strip().split("   ")[0].partition(" -> ")  # a remark follows 3 blanks
        *names, numbers, result = line.rstrip("°").split(" = ")
        try:
            evaluate(numbers)
        except ValueError:
            names, numbers = [*names, numbers], None
        steps.append(Step(names[0], numbers, as_tuple(evaluate(result)),
                          int(byte) if byte else None))
    return steps
