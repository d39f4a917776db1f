"""Check a proof file of sosbook: ``python checker proof.json``, for this folder.

``--plant plant.json`` and ``--gain gain.json`` refuse a proof about another plant or
another gain; ``--time-limit SECONDS`` bounds the time. It needs Python 3.9 or newer and
nothing else, and all arithmetic is exact.

A file is a text with data. Its text must be the one that `KINDS` writes for what is
asked, to the letter; then the kernel decides whether the text is true, and the words
that stand beside it are said.

Exit code: 0 proven, 1 refused, 2 no file or not readable, 3 beyond this checker
(it says why; ``python -m sosbook verify`` decides), 4 not decided within the time or
memory that there is, 5 proven, where an author says what his own blocks mean.
"""

import argparse
import json
import os
import sys
from contextlib import contextmanager
from importlib import import_module
from threading import Lock, Timer

from . import kernel
from .arithmetic import MOST_DIGITS, Beyond, Refused, need, zeros_of
from .families import keys, part_of
from .fields import ANY, fits, in_form, well_formed
from .kernel import MALFORMED, MOST_BYTES
from .subject import about, digest, subject, wanted_gain, wanted_plant
from .text import sane

SECONDS = 600.0  # unless told otherwise
AUTHOR = 5  # the exit code of what is proven of an author's blocks
MOST_VERTICES, DEEPEST = 4096, 200  # pairs of more vertices fill the memory
FORMAT, VERSION = "sosbook proof", 2

LOOP = "plant U K_A K "
PLAIN = {"format", "version", "kind", "about", "asks"}  # keys where no text says it
KINDS = {  # whose text its class writes, by its module, and what it asks
    "design": ("designs.Design", LOOP + "coupling epsilon E0 requirements"),
    "known gain": ("known.Known", LOOP + "law requirements corners cells"),
    "delay": ("delays.Delay", LOOP + "tau mu delta alpha method order misprints "
              "analysis coordinates exponentials"),
    "delay modes": ("modes.Modes", LOOP + "tau mu delta alpha method order misprints "
                    "analysis coordinates exponentials vertex spectrum rows columns "
                    "push gap room"),
    "regularization": ("mass.Mass", "plant K beta"),
    "observer": ("observer.Observer", "plant K C Q_F R_F noises model coordinates L "
                 "bound"),
    "any order": ("any_order.AnyOrder", "plant U K_A law requirement vertex units "
                  "sides"),
    "lmi": ("own.Own", "shapes expressions statement digits"),
}  # fmt: skip
SINGLE = {  # without unknowns
    "sampled": ("sampled.Sampled", "plant U T delay K rate centre norm corners frames "
                "cells"),
    "fixed mode": ("fixed_mode.FixedMode", LOOP + "requirement place polynomial rows "
                   "point witness"),
    "growing": ("growing.Growing", LOOP + "requirement place witness level form start"),
    "sum of poles": ("any_order.SumOfPoles", "plant U K_A law gains requirement "
                     "vertex"),
    "singular mass": ("mass.SingularMass", "plant U K_A between"),
    "unreached response": ("unreached.UnreachedResponse", LOOP + "bound vertex s v y"),
    "small input": ("small_input.SmallInput", LOOP + "coupling epsilon E0 requirements "
                    "vertex rows columns spread blur multipliers share price"),
}  # fmt: skip
ITS_NAME = ", "  # before the name of a kind of somebody's own LMIs
OF_AUTHOR = "lmi" + ITS_NAME
PART = "delay modes"  # that refuses the whole, and never proves it
AS_WRITTEN = "statement", "claim", "blocks"  # an author's words and texts
LESS = {"observer": "L bound", "lmi": "statement digits"}  # only with a point
FOLDED = "sampled"  # whose text a file replaces by its digest: it is ten times longer


class Proven(list):
    """The claims; for an author's LMIs also the author's words for their meaning."""

    author = None

    def __str__(self):
        whose = ":" if self.author is None else " of an author's LMIs:"
        lines = "\n- ".join(["proven" + whose, *map(printed, self)])
        said = "\n  which say, by their author's word alone: "
        return lines + "".join(said + json.dumps(words) for words in self.author or ())


def printed(text):
    """One line: what isn't printed is escaped, so that no text moves the cursor."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(text))


def text_of(asked):
    """(the text of ``asked``, a kind and its keys; the words that it proves)."""
    whole = str(asked["kind"])
    if whole == FOLDED and "frames" not in asked:
        raise Beyond("its cells have no frames, so the package's balls decide alone")
    well_formed(asked)
    *refused, kind = whole.rsplit("infeasible ", 1)
    if kind.startswith(OF_AUTHOR):
        kind = sane(whole) and "lmi"
    if kind in SINGLE and not refused:
        writer, names = SINGLE[kind]
    elif kind in KINDS and refused in ([""], [] if kind != PART else [""]):
        writer, names = KINDS[kind]
        names += " multipliers" if refused else " unknowns"
        names += " coordinates" * bool(refused and kind == "design")
    else:
        raise Beyond(f"a proof of the kind {whole!r:.80} isn't known here")
    names += " box" * ("box" in asked and kind in ("design", "small input"))
    names += " law free" * ("law" in asked and kind == "fixed mode")
    if kind == "unreached response" and "requirement" in asked:
        names = names.replace("bound", "requirement")
    less = LESS.get(kind, "").split() if refused else []
    names = [x for x in dict.fromkeys(names.split()) if x not in less]
    keys(asked, " ".join(["kind", *names]))
    many = asked.get("plant") or {}
    if len(many.get("vertices", ())) > MOST_VERTICES:
        raise Beyond(f"the plant has more than {MOST_VERTICES} vertices")
    problem = made_by(writer, whole)(asked)
    claims = Proven(problem.claims)
    claims.author = asked.get("statement", []) if kind == "lmi" else None
    need(not (refused and kind == "known gain"), "no multipliers exclude that")
    if refused and kind in ("design", "delay", "delay modes", "regularization"):
        free = asked["K"] is None
        how = "no gain and no matrices prove" if free else "no matrices prove"
        how = "no gain proves" if kind == "regularization" else how
        which = "by these LMIs" + getattr(problem, "condition", "")
        which += getattr(problem, "where", "")
        claims = Proven([f"{how} {which}: " + "; ".join(claims)])
    claims[:] = of_part(claims, asked)
    return problem.t, claims


def made_by(writer, kind):
    """The class that writes a kind's text, whose module is imported now."""
    home, name = writer.split(".")
    try:
        module = import_module(f".{home}", __package__)
    except ModuleNotFoundError:
        words = f"{home}.py, which writes proofs of the kind {kind!r:.80}"
        raise Beyond(f"{words}, isn't in this checker") from None
    return getattr(module, name)


def of_part(claims, asked):
    """The claims, each of the reduced model that is asked, if it is one."""
    part = part_of(asked.get("plant") or {})
    return [c if c.startswith(part) else part + c for c in claims]


def written(asked):
    """(the file of what is asked, its words, the keys of its blocks)."""
    text, claims = text_of(asked)
    asks = {k: skeleton(v, (asked, k), text) for k, v in asked.items() if k != "kind"}
    return head(asked) | {"asks": asks} | text.file(), claims, text.keys()


def stored(whole):
    """The keys and values of a file as it is stored."""
    if whole["kind"] == FOLDED and "text" in whole:
        whole = whole | {"text": f"sha256:{digest(whole['text'])}"}
    return whole


def head(asked):
    """How a file begins."""
    named = {"format": FORMAT, "version": VERSION, "kind": asked["kind"]}
    return named | {"about": about(asked)}


def skeleton(x, place, text):
    """The request with references in the place of what the data hold."""
    holder, key = place
    found = text.places.get((id(holder), key))
    if found is not None:
        return found
    if key == "multipliers" and text.labels:
        return [[name, "*" + text.label(name)] for name, _ in x]
    if isinstance(x, dict):
        return {k: skeleton(v, (x, k), text) for k, v in x.items()}
    if isinstance(x, list):
        return [skeleton(v, (x, k), text) for k, v in enumerate(x)]
    return x


def asked_of(file):
    """The request of a file, with its kind; `text_of` decides if it is allowed."""
    in_form(file)
    if "text" not in file:
        need(file.keys() == PLAIN, "a file without a text has other keys")
        return file["asks"] | {"kind": file["kind"]}
    given = {"=": file["data"] | file.get("point", {}), "#": file.get("point", {}),
             "|": file["data"], "*": file.get("multipliers", {})}  # fmt: skip

    def value(x, at):
        """Put the numbers of the text in the places of their names."""
        if isinstance(x, str) and x[:1] in given:
            need(x[1:] in given[x[0]], f"{at}: there is no {x:.40}")
            y = given[x[0]][x[1:]]
            if isinstance(y, dict):
                none = zeros_of(y)
                return [[] for _ in range(none.r)] if none.c == 0 else []
            if x[0] == "|":
                fits(y, [(ANY,)], at)
                return [e for (e,) in y]
            return [[y]] if x[0] == "#" else y
        if isinstance(x, dict):
            return {
                k: v if k in AS_WRITTEN else value(v, f"{at}.{k:.40}")
                for k, v in x.items()
            }
        if isinstance(x, list):
            return [value(v, f"{at}.{k}") for k, v in enumerate(x)]
        return x

    return {"kind": file["kind"], **value(file["asks"], "asks")}


def check(text):
    """The claims that the text of a proof file proves; else Refused or Beyond."""
    file, claims, _ = opened(text)
    kernel.check(file)
    return claims


def opened(text):
    """The kernel's decision on a file, which must be the one that is `written`."""
    file = contents(text)
    good = isinstance(file, dict) and file.get("format") == FORMAT
    need(good, "no proof file")
    need(type(file.get("version")) is int, "there is no version")
    if file["version"] != VERSION:
        raise Beyond(f"this checker reads the version {VERSION} of the format")
    asked = asked_of(file)
    need(file.get("about") == about(asked), "the digests are of other data")
    again, *said = written(asked)
    shown = stored(again)
    for key in shown.keys() | file.keys():
        same = key in file and file[key] == shown.get(key)
        need(same, f"{key!r:.40} isn't what is written for what is asked")
    return again, *said


def contents(text):
    """The content of a text in JSON, within the limits."""
    value = kernel.contents(text)
    level = [value]
    for _ in range(DEEPEST):
        longest = max((len(x) for x in level if isinstance(x, str)), default=0)
        if longest > 2 * MOST_DIGITS + 2:
            raise Beyond(f"a text has {longest} characters")
        level = [x for v in level if isinstance(v, (dict, list))
                 for x in (v.values() if isinstance(v, dict) else v)]  # fmt: skip
        if not level:
            return value
    raise Refused("its lists are nested too deeply")


def by_author(asked):
    """True if somebody's own theorem is among what is asked, or the kind is his own."""
    own = str(asked.get("kind")).removeprefix("infeasible ").startswith(OF_AUTHOR)
    return own or any("theorem" in r for r in asked.get("requirements", ()))


def read(name):
    """The text of a file."""
    with open(name, "rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise Beyond(f"the file has more than {MOST_BYTES} bytes")
    return content.decode("utf-8")


def say(*lines):
    try:
        print(*map(printed, lines), sep="\n", flush=True)
    except BrokenPipeError:  # nobody reads any more
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def main(arguments):
    """Say what the file that ``arguments`` name proves; return the exit code."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("proof")
    parser.add_argument("--plant", help="a file of `python -m sosbook design`")
    parser.add_argument("--gain", help='a matrix in JSON, or {"K": [[..]]}')
    parser.add_argument("--text", action="store_true", help="print the text, too")
    parser.add_argument("--time-limit", type=float, default=SECONDS, metavar="SECONDS")
    asked = parser.parse_args(arguments)
    if not 0 < asked.time_limit < 1e9:
        parser.error("--time-limit must be positive, a number of seconds")
    with at_most(asked.time_limit):
        code, lines = verdict(asked)
    say(*lines)
    return code


@contextmanager
def at_most(seconds, words=""):
    """End the program after some seconds: nothing else stops one long call."""
    last_word = Lock()

    def give_up():
        last_word.acquire()
        try:
            say(f"not decided within {seconds:g} s: {words}give more by --time-limit")
        finally:
            os._exit(4)

    watch = Timer(seconds, give_up)
    watch.daemon = True
    watch.start()
    try:
        yield
    finally:
        last_word.acquire()
        watch.cancel()


def verdict(asked):
    """The exit code, and what is said."""
    wanted = {}
    for name, form in ((asked.plant, wanted_plant), (asked.gain, wanted_gain)):
        try:
            wanted.update(form(contents(read(name))) if name else {})
        except (OSError, Refused, Beyond, *MALFORMED) as fault:
            return 2, [f"not read: {name}: {fault}"]
    try:
        text = read(asked.proof)
        whole, claims, _ = opened(text)
        kernel.check(whole)
        file = asked_of(contents(text))
        about = subject(file)
        for name, value in wanted.items():
            if name in file or name in ("plant", "K"):
                need(file.get(name) == value, f"it is about another {name}")
    except Refused as refusal:
        return 1, [f"refused: {refusal}"]
    except MALFORMED as fault:
        return 1, [f"refused: not a well-formed proof file ({fault!r:.200})"]
    except Beyond as limit:
        return 3, [f"not checked: {limit}"]
    except OSError as fault:
        return 2, [f"not read: {fault}"]
    except MemoryError:
        return 4, ["not decided: it takes more memory than there is"]
    first, *lines = str(claims).splitlines()
    return AUTHOR if by_author(file) else 0, [
        *(whole["text"] if asked.text else ()),
        f"{first[:-1]}, of {about}:" if about else first,
        *lines,
    ]
