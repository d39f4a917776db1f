"""The solver of the rendered page: LMIs in plain JavaScript, no other file.

`source` joins the modules of this folder into one function, `sosKernel`, which a
page runs as it stands or hands to a worker as text.
"""

import re
from importlib.resources import files

__all__ = ["MODULES", "lean", "source"]

#: In the order in which they need each other.
MODULES = (
    "matrices",
    "spectrum",
    "blocks",
    "solver",
    "descriptor",
    "request",
    "exact",
    "proof",
    "refusal",
    "design",
    "truth",
)
#: What stands apart for the eye only. Signs and brackets of comparison don't: "- -1",
#: and what a page would take for the ends of a comment.
SPACED = re.compile(r"(,) | (=>|[=!]==|&&|\|\||[=*]) ")
EXPORTS = (
    "design, prove, refusalFile, truth, descriptors, coupledPairs, assembled, frameOf, "
    "plainFrame, "
    "stateSpace, solve, matrix, rowsOf, eigenvalues, norm, decimal, sector, "
    "twiceAtLeast, weightFactors, sha256"
)


def source():
    """The kernel as a script that defines ``window.sosKernel``, a function.

    Calling it returns an object whose ``design(request)`` solves a request. Readers
    load neither indentation nor comments: they are in this folder's files. Nor do
    they load spaces behind commas and around most operators, but where a line may
    have a text or a pattern.
    """
    modules = [
        (files(__package__) / f"{name}.js").read_text("utf8") for name in MODULES
    ]
    text, lines = set("\"'`/"), "\n".join(map(lean, modules)).splitlines()
    body = "\n".join(x if text & set(x) else SPACED.sub(r"\1\2", x) for x in lines)
    return (
        'globalThis.sosKernel ??= function sosKernel() {\n"use strict";\n'
        f"{body}\nreturn {{{EXPORTS}}};\n}};"
    )


def lean(script):
    """A ``script``, JavaScript, without indentation and comments, as readers load it.

    A comment is a line of its own, or stands three spaces behind the code. Where
    a text spans lines, the script stays as it is.

    Examples
    --------
    >>> lean("  // why\\n  f();   // how\\n")
    'f();'
    """
    lines = script.strip().splitlines()
    if any(line.count("`") % 2 for line in lines):
        return script.strip()
    lines = (line.split("   //")[0].strip() for line in lines)
    return "\n".join(line for line in lines if line and not line.startswith("//"))
