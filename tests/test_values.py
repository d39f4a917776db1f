"""Outputs of the book and their texts: which changes count and which don't."""

import json
import os
import random
import shutil
import sys
from decimal import Decimal
from pathlib import Path

import nbformat.v4 as v4
import pytest
from jupyter_client.manager import KernelManager
from jupyter_client.provisioning import local_provisioner

from sosbook.book import notebooks
from tests import values
from tests.processes import process
from tests.values import cells, words
from tests.values.forks import forked

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted((ROOT / "book").glob("*.ipynb"))


def stored(path):
    """The outputs of each code cell of a notebook."""
    notebook = json.loads(path.read_text("utf-8"))
    return [
        cell["outputs"] for cell in notebook["cells"] if cell["cell_type"] == "code"
    ]


def contents(kind):
    """All stored contents of a stream or media type, with where they stand."""
    return [
        (f"{path.stem} cell {number}", content)
        for path in FILES
        for number, outputs in enumerate(stored(path))
        for content in values.folded(outputs).get(kind, ())
    ]


PRINTED = contents("stdout")
PAGES = contents("text/html")


def printed(text):
    return [{"output_type": "stream", "name": "stdout", "text": text}]


def moved(number, units):
    """A printed number, so many units of its last digit away."""
    mantissa, e, power = number.replace("−", "-").replace(" ", "").partition("e")
    decimals = len(mantissa.partition(".")[2])
    text = f"{Decimal(mantissa) + units * Decimal(10) ** -decimals:f}{e}{power}"
    sign = "+" if number[0] == "+" and text[0] != "-" else ""
    return sign + text + "." * mantissa.endswith(".")


@pytest.mark.parametrize(
    "old, new",
    [
        ("0.75", "0.76"),
        ("1.0", "0.99999"),
        ("9.9e-06", "1.0e-05"),
        ("phase -0 degrees", "phase 0 degrees"),
        ("[-0.  1.5]", "[0.  1.5]"),
        ("-0.00", "0.00"),
        ("1.00-0.00j", "1.00+0.00j"),
        ("−0.00", "0.01"),
        ("[ 0.5 -0.   1. ]", "[0.5 0.  1. ]"),
        ("[1. 2.\n 3.]", "[ 1. 2. 3.]"),
        ("46515 N", "46516 N"),
        ("99.9 %", "100 %"),
        ("a  b\n", "a b"),
    ],
)
def test_a_rounding_is_forgiven(old, new):
    assert values.differences(printed(old), printed(new)) == []
    assert values.differences(printed(new), printed(old)) == []


@pytest.mark.parametrize(
    "old, new",
    [
        ("0.75", "0.77"),
        ("0.75", "0.8"),
        ("1.0e-05", "1.2e-05"),
        ("1e-14", "3e-14"),
        ("12 blocks", "13 blocks"),
        ("[1. 4.]", "[1. 5.]"),
        ("z1 = 1", "z2 = 1"),
        ("x_3", "x_4"),
        ("1.00+0.50j", "1.00-0.50j"),
        ("+3", "3"),
        ("x - 0.5", "x + 0.5"),
        ("in 1938", "in 1939"),
        ("2026-11-21", "2026-11-22"),
        ("#1e5e8a", "#2e5e8a"),
        ("(2.15)", "(2.16)"),
        ("Table 4.3", "Table 4.4"),
        ("0x1.8p+3", "0x1.9p+3"),
        ("version 1.2.3", "version 1.2.4"),
        ("feasible", "infeasible"),
        ("✓", "✗"),
        ("a\nb", "a b"),
        ("a", "a b"),
        ("a", "a\nb"),
        ("0.5 s", "0.5 ms"),
        ("[0.5 1.5]", "[1.5 0.5]"),
    ],
)
def test_a_change_is_found(old, new):
    assert values.differences(printed(old), printed(new))
    assert values.differences(printed(new), printed(old))


def test_messages_say_what_differs():
    assert words.differences("a 0.75 b 2.5", "a 0.77 b 2.5") == [
        "line 1, number 1: stored 0.75, now 0.77 (tolerance 0.01)"
    ]
    assert words.differences("x\nfeasible", "x\ninfeasible") == [
        "line 2: word 'feasible' became 'infeasible'"
    ]
    many = words.differences(*("\n".join([str(n)] * 9) for n in (1, 2)))
    assert len(many) == 6 and many[-1] == "... and 4 more"


def test_two_units_of_any_printed_number_are_found():
    """Of the number in its line, and for one number of each output in all."""
    choose = random.Random(0)
    for name, text in PRINTED:
        numbers = [t for t in words.TOKEN.finditer(text) if t.lastgroup == "number"]
        for token in numbers:
            assert not words.agree(token[0], moved(token[0], 2)), (name, token[0])
        if numbers:
            token = choose.choice(numbers)
            start, end = token.span()
            other = text[:start] + moved(token[0], 2) + text[end:]
            assert values.differences(printed(text), printed(other)), (name, other)


def test_pytest_uses_the_comparison_for_notebooks(tmp_path):
    """With the conftest.py of the checkout and no more words than --nbval."""
    shutil.copy(ROOT / "conftest.py", tmp_path)
    path = tmp_path / "red_on_purpose.ipynb"
    code = "print('phase', -0.0, 0.75, '<b>')"
    texts = "phase 0.0 0.76 <b>", "phase 0.0 0.77 <b>"
    made = [
        v4.new_code_cell(
            code, execution_count=k, outputs=[v4.new_output("stream", text=f"{text}\n")]
        )
        for k, text in enumerate(texts, 1)
    ]
    path.write_text(notebooks.text(v4.new_notebook(cells=made)), "utf-8")
    words = "--nbval", "-q", "-pno:cacheprovider", f"--rootdir={tmp_path}"
    command = sys.executable, "-m", "pytest", *words, path
    done = process(*command, cwd=ROOT)
    red = sorted(cells.FOLDER.glob("red_on_purpose-*.html"))
    now, then = (page.read_text("utf-8") for page in red)
    assert "0.75 &lt;b>" in now and "0.77 &lt;b>" in then
    for page in red:
        page.unlink()
        assert str(page) in done.stdout
    assert "1 failed, 1 passed" in done.stdout
    assert "number 2: stored 0.77, now 0.75 (tolerance 0.01)" in done.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="kernels are programs there")
def test_a_fork_is_a_kernel_as_any_other(monkeypatch, tmp_path):
    """Nothing defined, a place and a session of its own; its end is seen."""
    launch = forked(lambda command, **options: pytest.fail("not forked"))
    monkeypatch.setattr(local_provisioner, "launch_kernel", launch)
    monkeypatch.setenv("WORD", "x")
    asked = {
        "empty": "[x for x in ('sos', 'np', 'plt') if x in dir()]",
        "package": "any(x.startswith('sosbook') for x in __import__('sys').modules)",
        "place": "__import__('os').getcwd()",
        "word": "__import__('os').environ['WORD']",
        "backend": "__import__('matplotlib').get_backend()",
        "session": "__import__('os').getsid(0)",
        "child": "__import__('subprocess').run('exit 3', shell=True).returncode",
    }
    manager, spent = KernelManager(kernel_name="python3"), sum(os.times()[2:4])
    manager.start_kernel(cwd=tmp_path)
    client, pid = manager.client(), manager.provisioner.pid
    try:
        client.start_channels()
        client.wait_for_ready(60)
        endless = "print(1, flush=True)\nwhile True: pass"
        asking = client.execute(endless, stop_on_error=False)  # or drops what follows
        while client.get_iopub_msg(60)["msg_type"] != "stream":
            pass
        manager.interrupt_kernel()
        while (reply := client.get_shell_msg(60))["parent_header"]["msg_id"] != asking:
            pass  # of the questions whether it is ready
        assert reply["content"]["ename"] == "KeyboardInterrupt"
        reply = client.execute("", user_expressions=asked, reply=True, timeout=60)
        said = reply["content"]["user_expressions"]
        assert {key: said[key]["data"]["text/plain"] for key in said} == {
            "empty": "[]",
            "package": "False",
            "place": repr(str(tmp_path)),
            "word": "'x'",
            "backend": "'module://matplotlib_inline.backend_inline'",
            "session": str(pid),
            "child": "3",
        }
        assert manager.is_alive()
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    assert not manager.is_alive() and sum(os.times()[2:4]) > spent
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    launch = forked(lambda command, **options: (command, options))
    for command in ["python2", "-m", "ipykernel_launcher"], [sys.executable, "-m", "x"]:
        assert launch(command, cwd="a", env={}) == (command, {"cwd": "a", "env": {}})
