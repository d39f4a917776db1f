"""Each small change of a module: its words, its lines, and the tree with it."""

import ast
import copy
import re

OTHER = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
THEOREM = re.compile(r"[>=]|\[.*\]|'|he\(", re.S)  # a text in the kernel's language


def mutants(source):
    """(function, words, lines, changed tree) of each change of a module's ``source``.

    The lines are those that Python enters before what is changed; none where the
    function is made.
    """
    tree = ast.parse(source)
    seen = {}
    for owner, path, node in nodes(tree):
        for what, other in changed(node):
            words = f"{what[0]} -> {what[1]}"
            words = f"{owner}: {words} in {about(tree, path)}"
            seen[words] = seen.get(words, 0) + 1
            if seen[words] > 1:
                words += f", the {seen[words]}th"
            yield owner, words, lines(tree, path), replaced(tree, path, other)


def nodes(tree):
    """(function, path, node) of each node; docstrings are none."""
    waiting = [("module", (), tree)]
    while waiting:
        owner, path, node = waiting.pop(0)
        yield owner, path, node
        for name, value in ast.iter_fields(node):
            parts = (
                list(enumerate(value)) if isinstance(value, list) else [(None, value)]
            )
            for k, part in parts:
                if not isinstance(part, ast.AST) or said(node, name, k, part):
                    continue
                own = owner
                if isinstance(part, (ast.FunctionDef, ast.ClassDef)):
                    own = part.name if owner == "module" else f"{owner}.{part.name}"
                waiting.append((own, (*path, (name, k)), part))


def said(node, name, k, part):
    """Whether it is a docstring, or what a refusal says."""
    words = isinstance(part, ast.Expr) and isinstance(part.value, ast.Constant)
    need = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "need"
    return (name == "body" and words) or (need and name == "args" and k)


def changed(node):
    """((what it was, what it becomes), another node) for each change of a node."""
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "need":
        yield ("need(...)", "nothing"), with_field(node, "args", [ast.Constant(True)])
    if isinstance(node, ast.Compare):
        for k, op in enumerate(node.ops):
            if type(op) in OTHER:
                ops = [*node.ops]
                ops[k] = OTHER[type(op)]()
                yield sign(op, ops[k]), with_field(node, "ops", ops)
    if isinstance(node, (ast.BinOp, ast.BoolOp)) and type(node.op) in OTHER:
        other = OTHER[type(node.op)]()
        yield sign(node.op, other), with_field(node, "op", other)
    if isinstance(node, ast.UnaryOp) and not isinstance(node.operand, ast.Constant):
        yield (type(node.op).__name__, "nothing"), node.operand
    if isinstance(node, ast.Constant):
        yield from constants(node.value)


def constants(value):
    if isinstance(value, bool):
        yield (value, not value), ast.Constant(not value)
    elif isinstance(value, int):
        yield (value, value + 1), ast.Constant(value + 1)
    elif isinstance(value, str) and THEOREM.search(value):
        for m in re.finditer(r"(?<= )[-+](?= )|(?<![\w.])-(?=\w)|(?<![\w.{])\d", value):
            new = {"-": "+", "+": "-"}.get(m[0]) or str(int(m[0]) + 1)
            new = " " if m[0] == "-" and value[m.end() : m.end() + 1] != " " else new
            other = value[: m.start()] + new + value[m.end() :]
            near = value[max(0, m.start() - 8) : m.end() + 8].replace("\n", " ")
            yield (f"{m[0]!r} of {near!r}", new), ast.Constant(other)


def sign(a, b):
    return type(a).__name__, type(b).__name__


def with_field(node, name, value):
    other = copy.copy(node)
    setattr(other, name, value)
    return other


def replaced(node, path, other):
    """The tree with another node at a path; only what is above it is copied."""
    if not path:
        return ast.fix_missing_locations(other) if not path else other
    (name, k), *rest = path
    value = getattr(node, name)
    if k is None:
        return with_field(node, name, replaced(value, rest, other))
    return with_field(
        node, name, [*value[:k], replaced(value[k], rest, other), *value[k + 1 :]]
    )


def way(tree, path):
    """The nodes from a tree to the end of a path."""
    node = tree
    for name, k in path:
        node = getattr(node, name) if k is None else getattr(node, name)[k]
        yield node


def about(tree, path):
    """The statement around a node, in one line."""
    here = None
    for x in way(tree, path):
        made = isinstance(x, (ast.FunctionDef, ast.ClassDef))
        if isinstance(x, (ast.stmt, ast.match_case)) and not made:
            here = x
    return " ".join(ast.unparse(here).split())[:100] if here else ""


def lines(tree, path):
    """The first and last line of the statement around a node, or of its head's part."""
    nodes = [x for x in way(tree, path) if hasattr(x, "lineno")]
    last = max((k for k, x in enumerate(nodes) if isinstance(x, ast.stmt)), default=0)
    made = isinstance(nodes[last], (ast.FunctionDef, ast.ClassDef))
    if hasattr(nodes[last], "body"):
        last += 1
    here = nodes[last] if last < len(nodes) and not made else None
    return range(here.lineno, here.end_lineno + 1) if here else ()
