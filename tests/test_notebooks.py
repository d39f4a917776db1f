"""What nbval cannot say about the notebooks: see sosbook.book.notebooks.problems."""

import ast
import re
from functools import cache
from pathlib import Path

import nbformat
import nbformat.v4 as v4
import pytest

from sosbook.book import notebooks
from tests.each import each

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted((ROOT / "book").glob("*.ipynb"))
read = cache(notebooks.read)  # to look at, not to change


@each("path", FILES)
def test_notebook_is_fit_for_the_book(path):
    notebook = notebooks.read(path)
    assert notebooks.problems(notebook) == []
    nbformat.validate(notebook)
    assert notebooks.text(notebooks.canonical(notebook)) == path.read_text("utf-8")


@each("path", FILES)
def test_a_notebook_imports_only_what_is_installed(path):
    """A reader's folder isn't the project's: `benchmarks` and `tests` aren't there."""
    aside = {p.stem for p in ROOT.glob("*") if p.is_dir() or p.suffix == ".py"}
    words = r"^\s*(?:from|import) (\w+)"
    cells = [c for c in read(path).cells if c.cell_type == "code"]
    found = {m for c in cells for m in re.findall(words, c.source, re.MULTILINE)}
    assert not found & (aside - {"sosbook"})


@each("path", FILES)
def test_no_module_of_a_notebook_is_hidden_by_a_value(path):
    """`from sosbook.studies import polytopes`, then `polytopes = {...}`."""
    cells = [c.source for c in read(path).cells if c.cell_type == "code"]
    lines = [x for c in cells for x in c.split("\n") if not x.startswith(("%", "!"))]
    nodes = list(ast.walk(ast.parse("\n".join(lines))))
    made = [x for x in nodes if isinstance(x, ast.ImportFrom) and "sosbook" in x.module]
    taken = {a.asname or a.name for x in made for a in x.names if a.name[0].islower()}
    stored = (x for x in nodes if isinstance(x, ast.Name))
    hidden = taken & {x.id for x in stored if isinstance(x.ctx, ast.Store)}
    assert not hidden - {"answers"}  # chapter 11's last cell imports it afterwards


def test_every_notebook_is_in_the_table_of_contents():
    contents = set(re.findall(r"book/(\w+)", (ROOT / "_toc.yml").read_text("utf-8")))
    assert {path.stem for path in FILES} <= contents


CHAPTER = re.compile(r"\[([^\]\n]*)\]\((\w+\.(?:ipynb|md)|\d\d_\w+)(#[\w-]+)?\)")
TEXTS = [*FILES, *sorted((ROOT / "book").glob("*.md"))]


def passages(path):
    """The prose of a page: its Markdown cells, or all of it."""
    if path.suffix == ".md":
        return [path.read_text("utf-8")]
    cells = read(path).cells
    return [cell.source for cell in cells if cell.cell_type == "markdown"]


def words(path):
    return "\n\n".join(passages(path))


@each("path", TEXTS)
def test_links_to_pages_have_words_a_file_and_its_number(path):
    """So a notebook reads well outside of the book, where nothing fills them."""
    text = words(path)
    assert "[](" not in text
    for label, target, _ in CHAPTER.findall(text):
        assert label.strip() and (ROOT / "book" / target).is_file(), target
        number = re.fullmatch(r"(?:[Cc]hapters? )?(\d+)(?:\. (.*))?", label)
        if not number:
            continue
        assert int(number[1]) == int(target[:2]), (label, target)
        if number[2]:
            title = re.search(r"^# (.*)", words(ROOT / "book" / target), re.MULTILINE)
            assert number[2] == title[1]


@each("path", FILES)
def test_each_figure_that_is_made_is_seen(path):
    """`plots.show` returns it; a line below would keep it from the reader."""
    for cell in read(path).cells:
        made = re.search(r"^(?:sos\.)?plots\.show\(", cell.source, re.MULTILINE)
        if cell.cell_type == "code" and made:
            outputs = [o.get("data", {}).get("text/html", "") for o in cell.outputs]
            assert any("<figure" in text for text in outputs), cell.source


#: What a page prints as False on purpose; all else would be a claim that failed
#: when its notebook was run again.
FALSE = {
    "04_lmi_regions": ("sign -1: Hermitian",),
    "05_h_infinity_norm": ("1.001 times the norm: on the axis",),
    "07_grasping_robot": ("1 False u_max",),
    "08_zero_mass": ("1 False", "k = 0.01:"),
    "10_a_p_for_each_plant": ("common P, affine:",),
    "11_integrators": ("True: 909, ",),
    "12_car_seat": ("two corners:",),
    "29_how_far_to_trust": (
        *("scalar: ", "matrix: True", "positive definite:", "scaling by the solver:"),
        *("all blocks positive: True", "iterations:", "above the rounding errors:"),
    ),
    "16_delay_theorem": ("kh = 1.01: some q proves it:", "ever grows:"),
    "18_least_cost": ("cost below 10: True | stable:", "middle's regulator stable:"),
    "19_observer": ("0.2: rightmost pole 4.8, proven",),
    "20_pendulum": (
        *("x_b with +:", "2 M_w V_w^2:", "T + U kept:", "natural form: True"),
    ),
    "23_gains_to_samples": ("R = 5: infeasible, proven:",),
    "25_program": ("/* False for", "good:", "bad:", "limit reached:"),
    "26_logs_to_c_file": ("one file:", "all three:", "anything written:"),
    "appendix_a": ("impulses", "diag(X, X):"),
}


@each("path", FILES)
def test_no_claim_of_a_page_has_become_false(path):
    cells = [c for c in read(path).cells if c.cell_type == "code"]
    texts = [o.get("text", "") for c in cells for o in c.outputs]
    lines = [x for text in texts for x in text.split("\n") if "False" in x]
    meant = FALSE.get(path.stem, ())
    assert [x for x in lines if not any(known in x for known in meant)] == []
    assert [x for x in meant if not any(x in line for line in lines)] == []


@each("path", TEXTS)
def test_figures_are_cited_by_their_number(path):
    vague = r"(?i)\b(?:figures? (?:above|below)|(?:above|below|next|last) figures?)\b"
    assert not re.search(vague, words(path))


@each("path", FILES)
def test_captions_mark_the_thesiss_figures_as_such(path):
    for cell in read(path).cells:
        for output in cell.get("outputs", []):
            html = output.get("data", {}).get("text/html", "")
            for caption in re.findall(r"<figcaption>(.*?)</figcaption>", html):
                assert not re.search(r"(?<!\[T )\bFigs?\. ?\d|redone", caption)


def test_viewers_that_convert_a_notebook_show_its_figures():
    """nbviewer does so. Beside HTML it would choose no other kind of picture."""
    exporter = pytest.importorskip("nbconvert").HTMLExporter()
    notebook = notebooks.read(ROOT / "book" / "04_lmi_regions.ipynb")
    figures, drawing = [], []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if output.get("data", {}).get("text/html", "").startswith("<figure"):
                figures.append(output.data["text/html"])
                output.data["image/png"] = "bmV2ZXI="
                drawing.append(cell)
    notebook.cells = drawing
    page, _ = exporter.from_notebook_node(notebook)
    assert len(figures) == page.count('class="sos-figure"') > 0
    assert page.count("<path") >= sum(figure.count("<path") for figure in figures)
    assert "bmV2ZXI=" not in page


def code(source="1", count=1, tags=(), outputs=()):
    cell = v4.new_code_cell(source, execution_count=count, outputs=list(outputs))
    cell.metadata["tags"] = list(tags)
    return v4.new_notebook(cells=[cell])


def page(source):
    return v4.new_notebook(cells=[v4.new_markdown_cell(source)])


def shown(kind, content):
    return v4.new_output("display_data", {kind: content})


FIGURE = '<figure><svg role="img" aria-label="Poles"></svg></figure>'


@pytest.mark.parametrize(
    "notebook, fault",
    [
        (code(count=None), "execution count None"),
        (code(count=7), "execution count 7"),
        (code("x" * 73), "line of 73 characters"),
        (code("\n".join("x" * 26)), "26 lines"),
        (code(""), "is empty"),
        (code("f();"), "semicolon"),
        (code("# NBVAL_SKIP\nx"), "by a comment"),
        (code(tags=["raises-exception"]), "raises-exception"),
        (code(tags=["nbval-skip"]), "nbval-skip"),
        (code(tags=["remove-cell"]), "remove-cell"),
        (code(outputs=[v4.new_output("stream", name="stderr", text="!")]), "stderr"),
        (code(outputs=[v4.new_output("error", ename="E", evalue="")]), "failed"),
        (code(outputs=[shown("image/png", "iVBO")]), "stores image/png"),
        (code(outputs=[shown("image/svg+xml", FIGURE)]), "stores image/svg"),
        (code(outputs=[shown("application/javascript", "1")]), "javascript"),
        (code(outputs=[shown("text/html", "<svg></svg>")]), "picture without"),
        (code(outputs=[shown("text/html", "<img src='a'>")]), "picture without"),
        (code(outputs=[shown("text/plain", "<f at 0x7f12ab34cd>")]), "one machine"),
        (code("open('/home/me/data')"), "one machine"),
        (code(outputs=[shown("text/plain", "0.12345678901")]), "digits"),
        (page("![](a.svg)"), "image without"),
        (page("See [](05_h_infinity_norm.ipynb)."), "link without words"),
        (page(":::{prf:proof}\nClear.\n:::"), "end with a square"),
    ],
)
def test_a_fault_is_named(notebook, fault):
    assert any(fault in problem for problem in notebooks.problems(notebook))


@pytest.mark.parametrize(
    "notebook",
    [
        code(outputs=[shown("text/html", FIGURE)]),
        page(":::{prf:proof}\nClear. $\\square$\n\n:::\n"),
        code(outputs=[shown("text/plain", "0x1F 1/2 and/or 3.5e-7")]),
    ],
)
def test_a_good_notebook_has_no_fault(notebook):
    assert notebooks.problems(notebook) == []


def test_running_twice_gives_the_same_bytes(tmp_path, capsys):
    source = v4.new_notebook(
        cells=[
            v4.new_markdown_cell("# Title"),
            v4.new_code_cell("print('one')\nprint('two')\n3"),
            v4.new_code_cell("4", metadata={"tags": [], "collapsed": False}),
        ]
    )
    path = tmp_path / "page.ipynb"
    path.write_text(notebooks.text(source), "utf-8")
    assert notebooks.main(["run", str(path)]) == 0
    first = path.read_bytes()
    assert notebooks.main(["run", str(path)]) == 0
    assert path.read_bytes() == first
    assert notebooks.main(["check", str(path)]) == 0
    assert capsys.readouterr().out == "page.ipynb: stored\npage.ipynb: unchanged\n"
    cells = notebooks.read(path).cells
    assert cells[1].outputs[0].text == "one\ntwo\n"
    assert cells[1].outputs[1].data == {"text/plain": "3"}
    assert cells[2].metadata == {}


def test_ids_follow_from_the_sources():
    def ids():
        cells = [v4.new_code_cell(source) for source in ("a", "b", "a")]
        return [c.id for c in notebooks.canonical(v4.new_notebook(cells=cells)).cells]

    assert ids() == ids()
    assert len(set(ids())) == 3


def test_a_failing_cell_stores_nothing(tmp_path, capsys):
    path = tmp_path / "page.ipynb"
    path.write_text(
        notebooks.text(v4.new_notebook(cells=[v4.new_code_cell("1 / 0")])), "utf-8"
    )
    before = path.read_bytes()
    assert notebooks.main(["run", str(path)]) == 1
    assert path.read_bytes() == before
    assert "ZeroDivisionError" in capsys.readouterr().err
    assert notebooks.main(["check", str(path)]) == 1


@each("path", FILES)
def test_a_prediction_asks_for_nothing_that_only_jupyter_can_do(path):
    """The answer is a run of the page, not of a cell that the reader changes."""
    cells = read(path).cells
    texts = [cell.source for cell in cells if cell.cell_type == "markdown"]
    boxes = re.findall(r"\*\*Predict, then run\.\*\*.*", "\n".join(texts))
    assert not [box for box in boxes if re.search(r"\bcell\b", box)]
    for k, cell in enumerate(cells):
        asks = cell.cell_type == "markdown" and "**Predict, then run.**" in cell.source
        assert not asks or any(later.get("outputs") for later in cells[k : k + 5]), k


# what draws, imports or tests is folded; what states and proves is in sight
DRAWN = ('<figure class="sos-figure"', "<sos-")
AGREES = re.compile(r"\b(allclose|isclose|array_equal|same)\(")
CONTROL = re.compile(r"\bsos\.design_\w+\(|\.(certify|prove|refuse)\(")


def cells(path):
    """The cells of code that are on the page, each with the text before it."""
    before = ""
    for cell in read(path).cells:
        if cell.cell_type == "markdown":
            before = cell.source
        elif "remove-input" not in cell.metadata.get("tags", []):
            yield cell, before


def folded(cell):
    return "hide-input" in cell.metadata.get("tags", [])


def draws(cell):
    """Whether the cell shows a figure or an element of the page."""
    shown = (output.get("data", {}).get("text/html", "") for output in cell.outputs)
    return any(html.startswith(DRAWN) for html in shown)


def imports(cell):
    """Whether the cell does nothing but import, and set the style of figures."""
    return all(
        isinstance(line, (ast.Import, ast.ImportFrom))
        or "use_book_style" in ast.unparse(line)
        for line in ast.parse(cell.source).body
    )


def agrees(cell):
    """Whether all that the cell shows is that two computations agree."""
    said = "".join(output.get("text", "") for output in cell.outputs).strip()
    true = all(line.endswith("True") for line in said.split("\n"))
    claims = CONTROL.search(cell.source) or "proven" in cell.source
    return bool(AGREES.search(cell.source)) and true and not claims


@each("path", FILES)
def test_what_draws_or_imports_is_folded_and_control_is_not(path):
    for cell, before in cells(path):
        solution = "{solution" in before
        said = "".join(output.get("text", "") for output in cell.outputs)
        assert said.strip() not in ("True", "False"), cell.source
        if draws(cell) or imports(cell) or (agrees(cell) and not solution):
            assert folded(cell), cell.source
        if folded(cell) and not solution and not cell.source.count("_atlas("):
            assert not CONTROL.search(cell.source), cell.source


ANNOUNCED = re.compile(r"[^:]:\s*(\Z|\n+#)")  # by a text's or a section's last sign
NOTHING = re.compile(r"#|\(|:::\{solution-|:::\{exercise|\Z")


def shows(cell):
    """Whether a cell is seen where it stands: text, code, or what the code shows."""
    if cell is None or cell.cell_type != "code":
        return cell is not None and not NOTHING.match(cell.source)
    tags = {*cell.metadata.get("tags", [])}
    if tags & {"opening", "remove-cell", "hide-cell"}:
        return False
    hidden = tags & {"hide-output", "remove-output"}
    return not tags & {"hide-input", "remove-input"} or bool(
        cell.outputs and not hidden
    )


@each("path", FILES)
def test_a_colon_is_followed_by_what_it_announces(path):
    """Visibly, and where it stands: an opening is shown at the top of the page."""
    every = read(path).cells
    for cell, after in zip(every, [*every[1:], None], strict=True):
        if cell.cell_type == "markdown" and (found := ANNOUNCED.search(cell.source)):
            assert not found[1].strip() and shows(after), cell.source[-200:]


# nothing is said twice in a row, and no row of a table stands twice
FORMULAS = re.compile(r"```.*?```|\$\$.*?\$\$|\$[^$]*\$|`[^`]*`", re.DOTALL)
AGAIN = re.compile(r"\b(\w[\w'’]*(?:[ \n]\w[\w'’]*){1,5})[\s:]+\1\b")
RULE = re.compile(r"\|[\s:|-]+\|")


def phrases(text):
    """Phrases of two words and more that follow themselves; letters may."""
    prose = FORMULAS.sub("\N{SECTION SIGN}", text)
    found = [match[1] for match in AGAIN.finditer(prose)]
    return [phrase for phrase in found if max(map(len, phrase.split())) > 1]


def rows(text):
    """Rows that a table has twice; each table begins with its own header."""
    found, table, lines = [], set(), text.split("\n")
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if not line.startswith("|") or RULE.fullmatch(below.strip()):
            table = set()
        elif line.strip("| ") and not RULE.fullmatch(line.strip()):
            found += [line] * (line in table)
            table.add(line)
    return found


@each("path", TEXTS)
def test_nothing_is_said_twice(path):
    for text in passages(path):
        assert not phrases(text)
        assert not rows(text)


@each("path", TEXTS)
def test_a_reference_to_an_exercise_says_exercise_once(path):
    """Its own text is "Exercise 9.3"."""
    for text in passages(path):
        assert not re.search(r"exercise\s+\{ref\}`ex-", text, re.IGNORECASE)


def parsed(path):
    return [ast.parse(c.source) for c in read(path).cells if "code" in c.cell_type]


def said(call):
    """The words that a call of print has typed, without those of its keys."""
    keys = {id(n.slice) for n in ast.walk(call) if isinstance(n, ast.Subscript)}
    typed = (n for n in ast.walk(call) if isinstance(n, ast.Constant))
    return " ".join(str(n.value) for n in typed if id(n) not in keys)


def keys_of_words(call):
    """Typed keys of two words and more whose value a call of print shows."""
    for node in ast.walk(call):
        key = getattr(getattr(node, "slice", None), "value", "")
        if isinstance(key, str) and " " in key:
            yield key


@each("path", [p for p in FILES if p.name > "31" and p.stem != "performance"])
def test_a_printed_label_says_what_its_value_is_the_value_of(path):
    """Chapter 34 once called a law with a tachometer a PD law with a filter."""
    for tree in parsed(path):
        for call in ast.walk(tree):
            if isinstance(call, ast.Call) and ast.unparse(call.func) == "print":
                for key in keys_of_words(call):
                    assert set(re.findall(r"\w+", key)) <= set(
                        re.findall(r"\w+", said(call))
                    ), ast.unparse(call)


@each("path", FILES)
def test_a_family_of_two_parameters_is_no_list_of_some_of_its_plants(path):
    """Between typed plants lie means of them: a trolley's m s² has no corners."""
    for tree in parsed(path):
        for call in ast.walk(tree):
            if isinstance(call, ast.Call) and "Polytope" in ast.unparse(call.func):
                assert varying(call) < 2, ast.unparse(call)


def varying(call):
    """How many arguments differ in a typed list of one function's plants."""
    plants = getattr(call.args[0], "elts", []) if call.args else []
    made = [p for p in plants if isinstance(p, ast.Call)]
    if len({ast.unparse(p.func) for p in made}) != 1:
        return 0
    places = zip(*([ast.unparse(x) for x in p.args] for p in made), strict=False)
    return sum(len(set(values)) > 1 for values in places)
