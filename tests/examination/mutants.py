"""Small changes of a function's source, one at a time: what a slip of the pen, or of the mind, would have made of it.

An operator takes a node of the syntax tree and gives what may stand in its place. The signature and the docstring are
the task's, and are left alone; a message loses all its values at once, since its words are the student's own.
"""

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Mutant:
    """A function with one change.

    Attributes
    ----------
    operator : the kind of change.
    line : line within the function, from one.
    before, after : the node that is changed, as source.
    source : the whole function.
    """

    operator: str
    line: int
    before: str
    after: str
    source: str

    def __str__(self) -> str:
        return f"{self.operator}, line {self.line}: {self.before} -> {self.after}"


Change = tuple[str, ast.AST]  # name of the operator, and what stands in the node's place

ARITHMETIC = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.BitOr: (ast.BitAnd,),
    ast.BitAnd: (ast.BitOr,),
}
COMPARISON = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
}
FELLOWS = [("sin", "cos"), ("min", "max"), ("argmin", "argmax"), ("any", "all"), ("arcsin", "arccos")]
FELLOWS += [("zeros", "ones"), ("zeros_like", "ones_like"), ("stack", "hstack")]
CONTAINERS = {"array", "asarray", "float", "list", "int"}  # a list is as right as an array
FELLOW = {a: b for pair in FELLOWS for a, b in (pair, pair[::-1])} | {"column_stack": "vstack", "log": "log10"}


def mutants(source: str) -> list[Mutant]:
    """Every function that is one change away from the given one, in the order of its text.

    Parameters
    ----------
    source : str
        One function; what else a cell has may not stand in it.
    """
    tree = ast.parse(source)
    (function,) = tree.body
    assert isinstance(function, ast.FunctionDef)
    found: dict[str, Mutant] = {}
    original = ast.unparse(tree)
    for node, put in list(_slots(function)):
        for operator, change in _changes(node, _variables(function)):
            put(change)
            text = ast.unparse(ast.fix_missing_locations(tree))
            put(node)
            if text != original and text not in found:  # two operators may agree
                found[text] = Mutant(operator, node.lineno, _words(node), _words(change), text)
    return sorted(found.values(), key=lambda mutant: mutant.line)


def _slots(parent: ast.AST) -> Iterator[tuple[ast.AST, Callable[[ast.AST], None]]]:
    """Every node of a body that may be changed, and how another is put in its place."""
    for field, value in ast.iter_fields(parent):
        if isinstance(parent, ast.FunctionDef) and field != "body":
            continue
        if isinstance(value, list):
            for i, node in enumerate(value):
                if isinstance(node, (ast.expr, ast.stmt)):
                    yield node, lambda new, value=value, i=i: value.__setitem__(i, new)
                if isinstance(node, ast.AST) and not _is_text(node) and not isinstance(node, ast.JoinedStr):
                    yield from _slots(node)
        elif isinstance(value, ast.AST):
            if isinstance(value, ast.expr):
                yield value, lambda new, field=field: setattr(parent, field, new)
            if not isinstance(value, ast.JoinedStr):
                yield from _slots(value)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _words(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) < 70 else f"{text[:67]}..."


def _variables(function: ast.FunctionDef) -> list[str]:
    """What a name may be mistaken for: the arguments and what is assigned, in order of appearance."""
    args = [node.arg for node in ast.walk(function) if isinstance(node, ast.arg)]
    stored = [n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return list(dict.fromkeys(args + [name for name in stored if name != "_"]))


def _changes(node: ast.AST, variables: list[str]) -> Iterator[Change]:
    match node:
        case ast.BinOp(left, op, right):
            for other in ARITHMETIC.get(type(op), ()):
                yield "operator", ast.BinOp(left, other(), right)
            yield "term dropped", left
            yield "term dropped", right
            if isinstance(op, (ast.Sub, ast.Div, ast.Pow, ast.MatMult)):
                yield "sides swapped", ast.BinOp(right, op, left)
        case ast.Compare(left, [op], [right]):
            for other in COMPARISON.get(type(op), ()):
                yield "comparison", ast.Compare(left, [other()], [right])
        case ast.BoolOp(op, values):
            yield "and, or", ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), values)
            yield from (("condition dropped", value) for value in values)
        case ast.UnaryOp(_, operand):
            yield "sign dropped", operand
        case ast.Constant(value):
            yield from (("constant", ast.Constant(other)) for other in _others(value))
        case ast.Name(name, ast.Load()) if name in variables:
            at = variables.index(name)
            near = dict.fromkeys((variables[at - 1], variables[(at + 1) % len(variables)]))
            yield from (("variable", ast.Name(other, ast.Load())) for other in near if other != name)
        case ast.Attribute(value, name, ast.Load()):
            if name == "T":
                yield "transposition", value
            if name in FELLOW:
                yield "function", ast.Attribute(value, FELLOW[name], ast.Load())
        case ast.Subscript(value, index, ast.Load()):
            yield "index dropped", value
            if isinstance(index, ast.Slice):
                yield from (("slice", ast.Subscript(value, s, ast.Load())) for s in _slices(index))
        case ast.Call(function, args, keywords):
            if not (isinstance(function, ast.Name) and function.id.endswith("Error")):
                yield from _calls(function, args, keywords)
        case ast.JoinedStr():
            yield "message", ast.Constant("wrong")
        case ast.If(test, body, orelse):
            yield "negated", ast.If(ast.UnaryOp(ast.Not(), test), body, orelse)
            yield "statement dropped", ast.Pass()
        case ast.IfExp(test, body, orelse):
            yield "negated", ast.IfExp(test, orelse, body)
            yield from (("branch dropped", branch) for branch in (body, orelse))
        case ast.Break():
            yield "break, continue", ast.Continue()
        case ast.Continue():
            yield "break, continue", ast.Break()
        case ast.AugAssign(target, op, value):
            yield "update", ast.Assign([target], value)
            for other in ARITHMETIC.get(type(op), ()):
                yield "update", ast.AugAssign(target, other(), value)
            yield "statement dropped", ast.Pass()
        case ast.Return(value) if value:
            yield "transposition", ast.Return(ast.Attribute(value, "T", ast.Load()))
            yield "nothing returned", ast.Return(None)
        case ast.Try(body, handlers):
            yield "caught no more", ast.If(ast.Constant(True), body, [])
            yield (
                "swallowed",
                ast.Try(body, [ast.ExceptHandler(h.type, h.name, [ast.Pass()]) for h in handlers], [], []),
            )
        case ast.For(target, source, body, orelse):
            yield "first left out", ast.For(target, _list(source, 1), body, orelse)
            yield "last left out", ast.For(target, _list(source, None, -1), body, orelse)
        case ast.Assign() | ast.Expr() | ast.Raise() if not _is_text(node):
            yield "statement dropped", ast.Pass()


def _others(value) -> Iterator:
    """What a constant may be mistaken for."""
    match value:
        case bool():
            yield not value
        case int():
            yield value + 1
            yield value - 1
        case float():
            yield value * (1 + 1e-3) if value else 1.0
            yield value * 1e3 if value < 1e-2 else value + 1
        case complex():
            yield -value
        case str():
            yield f"{value}?"


def _slices(index: ast.Slice) -> Iterator[ast.Slice]:
    lower, upper, step = index.lower, index.upper, index.step
    if not step and bool(lower) != bool(upper):
        yield ast.Slice(upper, lower)  # x[:-1] for x[-1:]
        yield ast.Slice(ast.Constant(1)) if not upper else ast.Slice(ast.Constant(1), None)


def _calls(function: ast.expr, args: list[ast.expr], keywords: list[ast.keyword]) -> Iterator[Change]:
    for i in range(len(args) - 1):
        swapped = [*args[:i], args[i + 1], args[i], *args[i + 2 :]]
        yield "arguments swapped", ast.Call(function, swapped, keywords)
    for i in range(len(keywords)):
        yield "keyword dropped", ast.Call(function, args, keywords[:i] + keywords[i + 1 :])
    name = (
        function.id if isinstance(function, ast.Name) else function.attr if isinstance(function, ast.Attribute) else ""
    )
    if len(args) == 1:
        if name not in CONTAINERS:
            yield "call dropped", args[0]
    elif not args and isinstance(function, ast.Attribute):
        yield "call dropped", function.value
    elif len(args) > 1:
        yield "argument dropped", ast.Call(function, args[:-1], keywords)
    if isinstance(function, ast.Name) and name in FELLOW:
        yield "function", ast.Call(ast.Name(FELLOW[name], ast.Load()), args, keywords)
    if name == "range":
        for op in (ast.Add, ast.Sub):
            yield "range", ast.Call(function, [*args[:-1], ast.BinOp(args[-1], op(), ast.Constant(1))], keywords)
    elif name not in ("enumerate", "zip", "len"):
        yield "minus", ast.UnaryOp(ast.USub(), ast.Call(function, args, keywords))


def _list(source: ast.expr, lower: int | None, upper: int | None = None) -> ast.expr:
    bounds = [ast.Constant(n) if n is not None else None for n in (lower, upper)]
    return ast.Subscript(ast.Call(ast.Name("list", ast.Load()), [source], []), ast.Slice(*bounds), ast.Load())
