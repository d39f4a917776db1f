"""Inputs that tests give the checker, and whether a changed checker answers alike."""

import json
import sys
import time
from contextlib import contextmanager
from functools import cache
from types import ModuleType

import pytest

from benchmarks.robustness import at_most
from sosbook.exact.checker import CHECKER, MODULES, kernel, verdict

FILES = (
    *("test_every_need", "test_proof_files", "test_kernel", "test_known_gain_files"),
    *("test_near_box", "test_small_input", "test_infeasible", "test_statements"),
    *("test_false_proofs", "test_tampering", "test_law_files", "test_own_theorem"),
    *("test_sampled_text", "test_sampled_box", "test_page_kernel"),
    *("test_parts_of_the_checker", "test_modes_text"),
)
TO_THE_WORD = (
    "test_every_need",
    "test_parts_of_the_checker",
)  # what they ask, refuses so
LONGEST = 0.5  # seconds of an input that is asked
NO = "refused"


@cache
def plain(name):
    """A module of the checker as it is, compiled."""
    return compile((CHECKER / f"{name}.py").read_text("utf-8"), f"<{name}>", "exec")


class Checker:
    """The checker's modules, run from their sources; of one another may be given."""

    def __init__(self, module=None, tree=None):
        self.name = f"changed_{id(self)}"
        package = self._made("", None)
        package.__path__ = []
        for name in MODULES:
            changed = name == module
            code = compile(tree, f"<{name}>", "exec") if changed else plain(name)
            self._made(name, code)

    def _made(self, name, code):
        full = f"{self.name}.{name}" if name else self.name
        module = sys.modules[full] = ModuleType(full)
        module.__package__ = self.name
        if name:
            exec(code, module.__dict__)
            setattr(sys.modules[self.name], name, module)
        return module

    def forget(self):
        """Take its modules out of Python's table."""
        for name in [x for x in sys.modules if x.split(".")[0] == self.name]:
            del sys.modules[name]

    def fresh(self):
        """Forget what its functions keep, so that an input enters all that it needs."""
        for name in MODULES:
            for x in vars(sys.modules[f"{self.name}.{name}"]).values():
                getattr(x, "cache_clear", bool)()

    def answer(self, kind, given):
        """What it says of an input, as JSON, or why it refuses it."""
        said, core = (sys.modules[f"{self.name}.{x}"] for x in ("verdict", "kernel"))
        try:
            if kind in ("file", "opened"):
                whole, claims, _ = said.opened(given)
                if kind == "file":
                    core.check(whole)
                return [*claims]
            if kind in ("kernel", "words"):
                return [*core.check(json.loads(given))]
            text, claims = said.text_of(json.loads(given))
            core.check(text.file())
            return [*claims]
        except core.Refused as fault:
            return str(fault)
        except said.Beyond:
            return "beyond"
        except said.MALFORMED:
            return "malformed"


def verdict_of(kind, said):
    """What tests notice of an answer: in refusals of `TO_THE_WORD` the words."""
    if kind not in ("asked", "words") and isinstance(said, str) and said != "beyond":
        return NO
    return said


class Recorder:
    """A plugin of pytest that keeps what is asked of the checker."""

    def __init__(self):
        self.inputs, self.file = {}, ""

    @pytest.hookimpl
    def pytest_runtest_setup(self, item):
        """Whose inputs these are."""
        self.file = item.path.stem

    def keep(self, kind, given):
        """An input, once."""
        self.inputs.setdefault((kind, given), self.file)


@contextmanager
def recorded(recorder):
    """What is given to the checker's two doors is kept."""
    doors = verdict.check, verdict.opened, kernel.check, verdict.text_of

    def file(door):
        def asked(text):
            if isinstance(text, str) and len(text) < 300_000:
                recorder.keep("file", text)
            return door(text)

        return asked

    def text_of(asked):
        if recorder.file in TO_THE_WORD:
            recorder.keep("asked", json.dumps(asked))
        return doors[3](asked)

    def core(whole, *more):
        if recorder.file in ("test_kernel", "test_every_need"):
            kind = "words" if recorder.file == "test_every_need" else "kernel"
            try:
                recorder.keep(kind, json.dumps(whole))
            except (TypeError, ValueError):
                pass
        return doors[2](whole, *more)

    verdict.check, verdict.opened = file(doors[0]), file(doors[1])
    kernel.check, verdict.text_of = core, text_of
    try:
        yield
    finally:
        verdict.check, verdict.opened, kernel.check, verdict.text_of = doors


class Inputs:
    """Recorded inputs with their answers, their seconds, and the lines they enter."""

    def __init__(self, inputs):
        self.all, entered = [], {}
        honest = Checker()
        for kind, given in inputs:
            start = time.process_time()
            said = verdict_of(kind, honest.answer(kind, given))
            seconds = time.process_time() - start
            if seconds > LONGEST and kind == "file":  # what the kernel decides is long
                kind = "opened"
                said = verdict_of(kind, honest.answer(kind, given))
                seconds = time.process_time() - start - seconds
            if seconds > LONGEST:
                continue
            honest.fresh()
            for place in traced(honest.answer, kind, given):
                entered.setdefault(place, []).append(len(self.all))
            self.all.append((kind, given, said, seconds))
        honest.forget()
        self.seconds = [x[3] for x in self.all]
        self.entered = {k: sorted(v, key=self.seconds.__getitem__)
                        for k, v in entered.items()}  # fmt: skip
        self.last = {}  # what noticed the last change of a function

    def near(self, module, owner, lines):
        """The inputs that enter some lines, those that noticed most lately first."""
        entered = self.entered
        some = {k for x in lines for k in entered.get((module, x), ())}
        some = some or entered.get((module, owner), ())
        first = [k for k in self.last.get((module, owner), ()) if k in some]
        rest = sorted({*some}.difference(first), key=self.seconds.__getitem__)
        return [*first, *rest]

    def notices(self, module, owner, lines, changed, most):
        """Whether an answer differs: True, False, or None if ``most`` seconds end."""
        end = time.process_time() + most
        with at_most(most + 1):
            try:
                other = Checker(module, changed)
            except (Exception, SystemExit):  # it doesn't even begin
                return True
            k, heard = None, self.last.setdefault((module, owner), [])
            try:
                for k in self.near(module, owner, lines):
                    kind, given, said, _ = self.all[k]
                    if verdict_of(kind, other.answer(kind, given)) != said:
                        break
                    if time.process_time() > end:
                        return None
                else:
                    return False
            except (Exception, SystemExit):  # no test expects it
                pass
            finally:
                other.forget()
            if k is not None:
                self.last[module, owner] = [k, *(x for x in heard if x != k)][:20]
        return True


def traced(do, *given):
    """The lines, and the functions, of the checker that a call enters."""
    found = set()

    def line(frame, event, _):
        found.add((frame.f_code, frame.f_lineno))
        return line

    def call(frame, event, _):
        if frame.f_code.co_filename.startswith("<"):
            return line(frame, event, _)

    sys.settrace(call)
    try:
        do(*given)
    finally:
        sys.settrace(None)
    places = set()
    for code, number in found:
        module = code.co_filename[1:-1]
        name = code.co_qualname.replace(".<locals>", "").split(".<")[0]
        places |= {(module, number), (module, name), (module, "module")}
    return places
