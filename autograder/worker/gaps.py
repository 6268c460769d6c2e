"""What a definition looks like that nobody has touched."""

import ast


def is_gap(definition: ast.stmt) -> bool:
    """Whether a function is as it was handed out: a docstring at most, then NotImplementedError."""
    if not isinstance(definition, ast.FunctionDef):
        return False
    body = definition.body[1:] if ast.get_docstring(definition, clean=False) is not None else definition.body
    match body:
        case [ast.Raise(exc=ast.Name(id="NotImplementedError") | ast.Call(func=ast.Name(id="NotImplementedError")))]:
            return True
    return False
