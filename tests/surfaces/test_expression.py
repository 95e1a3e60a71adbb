import math

import casadi
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from inverse.errors import InputError
from inverse.surfaces.expression import CONSTANTS, FUNCTIONS, MAX_CHARACTERS, MAX_DEPTH, parse


def value(text: str, x: float = 0.3, y: float = -0.7) -> float:
    return float(parse(text)(x, y))


def refusal(text: str) -> str:
    with pytest.raises(InputError) as caught:
        parse(text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.45 - 0.3*(x^2 + y^2)", 0.45 - 0.3 * (2.0**2 + 3.0**2)),
        ("-x^2", -4.0),
        ("(-x)^2", 4.0),
        ("2^-x", 0.25),
        ("2^y^x", 512.0),
        ("2**y**x", 512.0),
        ("x - y - 1", -2.0),
        ("8/x/2", 2.0),
        ("8/x*2", 8.0),
        ("--x", 2.0),
        ("x*-y", -6.0),
        ("+x", 2.0),
        (".5 + 1. + 1e1 + 2.5E-1", 11.75),
        ("\n x\n + y\n", 5.0),
        ("sin (x)", math.sin(2)),
        ("007", 7.0),
        ("0*x", 0.0),
        ("+".join(["x"] * 900), 1800.0),
        ("(" * (MAX_DEPTH - 1) + "x" + ")" * (MAX_DEPTH - 1), 2.0),
    ],
)
def test_values(text: str, expected: float) -> None:
    assert value(text, 2.0, 3.0) == pytest.approx(expected, rel=1e-15)


ORACLE = {
    **{name: getattr(np, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")},
    **{name: getattr(np, f"arc{name[1:]}") for name in ("asin", "acos", "atan", "atan2")},
    "abs": np.abs,
    "hypot": np.hypot,
    "pow": np.power,
    "min": np.minimum,
    "max": np.maximum,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_agrees_with_numpy(name: str) -> None:
    least = FUNCTIONS[name][1]
    text, arguments = (f"{name}(x)", [0.3]) if least == 1 else (f"{name}(x, y + 2)", [0.3, 1.3])
    assert value(text) == pytest.approx(float(ORACLE[name](*arguments)), rel=1e-14)


def test_constants_and_many_arguments() -> None:
    assert value("pi") == np.pi
    assert value("e") == np.e
    assert value("max(x, 2, y)") == 2.0
    assert value("min(x, 2, y)") == -0.7
    assert set(CONSTANTS) == {"pi", "e"}


literals = st.sampled_from(["0.5", "1.0", "2.0", "3.25", "1e-1"])
leaves = st.one_of(literals, st.sampled_from(["x", "y", "pi"]))


def longer(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    space = st.sampled_from(["", " "])
    sums = st.builds("{0}{3}{2}{3}{1}".format, inner, inner, st.sampled_from("+-*"), space)
    quotients = st.builds("{}/{}".format, inner, literals)
    signs = st.builds("{}{}".format, st.sampled_from(["-", "+", "--"]), inner)
    powers = st.builds("({})^{}".format, inner, st.sampled_from(["2.0", "3.0"]))
    inverse_powers = st.builds("{}^-{}".format, literals, leaves)
    towers = st.builds("{}^{}^2.0".format, literals, literals)
    brackets = st.builds("({})".format, inner)
    calls = st.builds("{}({})".format, st.sampled_from(["sin", "cos", "atan", "tanh", "abs"]), inner)
    pairs = st.builds("{}({}, {})".format, st.sampled_from(["min", "max", "hypot"]), inner, inner)
    return st.one_of(sums, quotients, signs, powers, inverse_powers, towers, brackets, calls, pairs)


@settings(max_examples=300, deadline=None)
@given(st.recursive(leaves, longer, max_leaves=12), st.floats(-2, 2), st.floats(-2, 2))
def test_random_expressions_agree_with_numpy(text: str, x: float, y: float) -> None:
    """Python's grammar and NumPy judge precedence and values; only ``^`` is spelt otherwise."""
    names = {**ORACLE, "x": np.float64(x), "y": np.float64(y), "pi": np.float64(np.pi), "__builtins__": {}}
    with np.errstate(all="ignore"):
        expected = float(eval(text.replace("^", "**"), names))
    assume(abs(expected) < 1e12)
    assert value(text, x, y) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "0.45 - 0.3*(x^2 + y^2)",
        "sqrt(2 - x^2 - y^2)",
        "cosh(x)*exp(-y^2) + log(3 + x*y)",
        "atan2(y, x + 2)*hypot(x, y) + tan(x/2)",
        "max(x, y)^3 + abs(x - 1)^1.5 + 2^(x*y)",
    ],
)
def test_derivatives_converge_as_taylor_says(text: str) -> None:
    z = parse(text)
    point, direction = casadi.SX.sym("p", 2), np.array([0.6, 0.8])
    height = casadi.Function("z", [point], [z(point[0], point[1])])
    slope = casadi.Function("dz", [point], [casadi.gradient(height(point), point)])
    start = np.array([0.3, -0.4])
    exact = float(direction @ np.asarray(slope(start)).ravel())
    steps = 1e-2 * 0.5 ** np.arange(5)
    errors = [abs(float(height(start + h * direction)) - float(height(start)) - h * exact) for h in steps]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.1)


def test_the_function_has_scalar_inputs_and_a_dense_output() -> None:
    for text in ("x", "0", "x*0", "3"):
        z = parse(text)
        assert [z.size_in(k) for k in range(z.n_in())] == [(1, 1), (1, 1)]
        assert z.name_in() == ["x", "y"]
        assert z.nnz_out(0) == 1


NO_FUNCTION = f"is no mathematical function: allowed are {', '.join(FUNCTIONS)}."
NO_NAME = "is no variable or constant: allowed are x, y, pi, e."


@pytest.mark.parametrize(
    ("text", "part", "position", "what"),
    [
        ("__import__('os').system('ls')", "__import__", 1, NO_FUNCTION),
        ("1 + sine(x)", "sine", 5, f"{NO_FUNCTION} Did you mean sin?"),
        ("x + X", "X", 5, f"{NO_NAME} Did you mean x?"),
        ("2*z", "z", 3, NO_NAME),
        ("lambda: x", "lambda", 1, NO_NAME),
        ("1 + 2x", "x", 6, "needs +, -, * or / before it"),
        ("2(x)", "(", 2, "needs +, -, * or / before it"),
        ("e(x)", "e", 1, "is no mathematical function"),
        ("(x + (y)", "(", 1, "is never closed"),
        ("x) + 1", ")", 2, "closes a parenthesis that was never opened"),
        ("x +", "+", 3, "is the end of the expression: something is missing after it"),
        ("x//2", "/", 3, "stands where a number, a name or ( should be"),
        ("sin(x,)", ")", 7, "stands where a number, a name or ( should be"),
        ("sin(**x)", "**", 5, "stands where a number, a name or ( should be"),
        ("x, y", ",", 2, "has no place here"),
        ("x.real", ".", 2, "has no place here"),
        ("x[0]", "[", 2, "has no place here"),
        ("sin(x; y)", ";", 6, "has no place here"),
        ("é", "é", 1, "has no place here"),
        ("sin", "sin", 1, "is a function and needs parentheses"),
        ("1 - sin(x, y)", "sin", 5, "needs 1 argument, given 2"),
        ("min(x)", "min", 1, "needs 2 or more arguments, given 1"),
        ("hypot()", "hypot", 1, "needs 2 arguments, given 0"),
        ("x + 9**9**9", "9**9**9", 5, "is no finite number"),
        ("x*sqrt(-1)", "sqrt(-1)", 3, "is no finite number"),
        ("1/0", "1/0", 1, "is no finite number"),
        ("x + 1e999", "1e999", 5, "is no finite number"),
        ("-" * 300 + "x", "-", MAX_DEPTH + 1, f"is nested more than {MAX_DEPTH} deep"),
        ("(" * 300 + "x" + ")" * 300, "(", MAX_DEPTH + 1, f"is nested more than {MAX_DEPTH} deep"),
        ("2^" * 300 + "x", "2", 2 * MAX_DEPTH + 1, f"is nested more than {MAX_DEPTH} deep"),
    ],
)
def test_refusals_name_the_part_and_its_position(text: str, part: str, position: int, what: str) -> None:
    assert refusal(text).split("\n")[0] == f"`{part}` at position {position} of the height expression {what}"


def test_too_little_and_too_much_text() -> None:
    assert refusal(" ").startswith("the height expression is empty")
    too_long = "x" + "+x" * (MAX_CHARACTERS // 2)
    assert refusal(too_long).startswith("the height expression has 2001 characters: at most 2000 are allowed")


def test_the_suggestion_is_left_out_where_nothing_is_near() -> None:
    assert "Did you mean" not in refusal("__import__('os')")
    assert "Write multiplication with a sign" in refusal("2x")


pieces = [
    "x",
    "y",
    "2",
    "0.5",
    "1e3",
    "(",
    ")",
    "+",
    "-",
    "*",
    "/",
    "^",
    "**",
    ",",
    " ",
    "sin(",
    "min(",
    "e",
    "_",
    "é",
]


@settings(max_examples=300, deadline=None)
@given(st.one_of(st.text(max_size=60), st.lists(st.sampled_from(pieces), max_size=40).map("".join)))
def test_any_text_is_an_expression_or_refused(text: str) -> None:
    try:
        z = parse(text)
    except InputError:
        return
    assert z.size_out(0) == (1, 1)
