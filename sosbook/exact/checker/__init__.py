"""The checker of proofs: a folder that needs standard Python and nothing else.

`sosbook.exact.checker.kernel` knows no control, nor do `arithmetic` and `language`.
`verdict` reads files: ``python checker proof.json``. What writes a text for the kernel,
beside the words that it proves, is found when a file names its kind (`verdict.KINDS`):
who takes such a module away has a checker of the other kinds. Every deployment has it
in one file.
"""

from pathlib import Path

__all__ = ["CHECKER", "in_one_file"]

CHECKER = Path(__file__).parent
ORDER = (
    *("arithmetic", "language", "kernel", "families", "payment", "outputs"),
    *("text", "plants", "regions", "requirements", "laws", "designs", "known"),
    *("delays", "modes", "mass", "observer", "own", "any_order", "fixed_mode"),
    *("growing", "unreached", "small_input", "ticks", "sampled", "fields"),
    *("subject", "verdict"),
)
MODULES = tuple(name for name in ORDER if (CHECKER / f"{name}.py").is_file())
ONE_FILE = """\
\"\"\"Check a proof file of sosbook: python check_proof.py proof.json, see --help.

The modules of sosbook.exact.checker one after the other; they need Python alone.
\"\"\"

import sys
from types import ModuleType

for name, source in {
    "checker": "",
%s}.items():
    module = sys.modules[name] = ModuleType(name)
    module.__package__, module.__path__ = "checker", []
    exec(compile(source, name, "exec"), module.__dict__)
    setattr(sys.modules["checker"], name.rpartition(".")[2], module)
sys.exit(module.main(sys.argv[1:]))
"""


def in_one_file():
    """The text of a program that is this folder in one file."""
    parts = ""
    for name in MODULES:
        source = (CHECKER / f"{name}.py").read_text("utf-8")
        parts += f"    \"checker.{name}\": r'''{source}''',\n"
    return ONE_FILE % parts
