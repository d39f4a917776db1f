"""Every typed number is tied, every quotation is the thesis's."""

import nbformat.v4 as v4
import pytest

from sosbook.book import notebooks
from tests.each import each
from tests.prose import check, numerals, pages, quoted


@each("path", pages.all_pages())
def test_typed_numbers_are_tied(path):
    loose, stale = check.loose(path)
    assert not loose, "\n" + "\n".join(map(str, loose))
    assert not stale, f"tests/given/{path.stem}.toml ties nothing with {stale}"


@each("path", quoted.sources())
def test_quotations_are_verbatim(path):
    assert not [str(phrase) for phrase in quoted.unknown(path)]


def test_no_phrase_is_kept_for_nothing():
    assert not quoted.unused()


def test_lists_of_given_data_belong_to_pages():
    names = {path.stem for path in pages.all_pages()} | {"phrases"}
    assert {path.stem for path in check.GIVEN.glob("*.toml")} <= names


@pytest.fixture
def page(tmp_path):
    """Write a notebook of two cells or more; return its loose numbers."""

    def write(prose, code="1", shown="", given=None, **more):
        cell = v4.new_code_cell(code, execution_count=1)
        if shown:
            cell.outputs = [v4.new_output("stream", text=shown)]
        path = tmp_path / f"page_{len(list(tmp_path.iterdir()))}.ipynb"
        notebook = v4.new_notebook(
            cells=[
                v4.new_markdown_cell("# A page"),
                cell,
                v4.new_markdown_cell("## Here\n\n" + prose),
            ]
        )
        path.write_text(notebooks.text(notebooks.canonical(notebook)), encoding="utf-8")
        loose, stale = check.loose(path, given or {})
        return [found.number.written for found in loose] + stale

    return write


@pytest.mark.parametrize(
    "prose, shown",
    [
        ("It peaks at 754.", "754.2"),
        ("It peaks at 0.11.", "0.1149"),
        ("It takes 16 % of it.", "share 0.158"),
        ("It takes 16 per cent of it.", "share: 15.8 %"),
        ("It moves by 2.4 mm.", "moved 0.00241 m"),
        ("It moves by $2.4$ mm.", "moved 0.00241 m"),
        (r"A force of 40\,500 N or $40\,500$ N.", "40500.0"),
        (r"Errors below $10^{-9}$.", "error 1e-09"),
        (r"Errors of $3.2 \cdot 10^{-7}$.", "error 3.24e-07"),
        ("The gain is −3.47.", "[-3.4689 1.2]"),
        ("Some 750 N at the most.", "748.1"),
        ("It takes three times as long.", "ratio 3.02"),
        ("A tilt of twenty degrees.", "20.3 degrees"),
        ("A tilt of 45°.", "0.785398 rad"),
    ],
)
def test_an_output_ties_what_is_rounded_as_written(page, prose, shown):
    assert page(prose, shown=shown) == []
    assert page(prose, shown="nothing") != []


@pytest.mark.parametrize(
    "prose, shown",
    [
        ("It peaks at 755.", "754.2"),
        ("It peaks at 0.12.", "0.1149"),
        ("It takes 17 % of it.", "share 0.158"),
        ("It moves by 2.4 m.", "moved 0.00241 m"),
        ("A force of 40 500 N.", "40600.0"),
        (r"Errors below $10^{-8}$.", "error 1e-09"),
        ("It takes four times as long.", "ratio 3.02"),
        ("A tilt of thirty degrees.", "20.3 degrees"),
        ("With $E = 750$ it is so.", "energy 754"),
        ("Whether 15.7 is remains open.", "15.6 is feasible, 15.5 is not"),
    ],
)
def test_a_number_that_drifted_is_loose(page, prose, shown):
    assert len(page(prose, shown=shown)) == 1


@pytest.mark.parametrize(
    "prose",
    [
        "Theorem 2.2, (2.15), (2.18)-(2.21), Figs 3.17, 3.19 and Table 4.1.",
        "See sections 3.1 and 4.3.2, chapter 17 and Appendix A.2 of 2023.",
        r"The two masses, $x \in \mathbb R^{12}$, $K_{P,44}$ and $\tfrac12 P$.",
        "The 1st of 3 tries; `x[25]`; C99; [here](27_what_gamma_measures).",
    ],
)
def test_structure_and_references_are_no_results(page, prose):
    assert page(prose) == []


def test_a_program_ties_what_it_sets_and_not_what_it_rounds(page):
    assert page("With the bound 150.", code="u_max = 150") == []
    assert page("With the bound 150.", code="u_max = 149.9") == ["150"]
    assert page("A spread of 20 %.", code="spread = 0.2") == []
    assert page("An angle of 45°.", code="theta = np.pi / 4") == []
    assert page("It is 25.", code="x[25].round(25)") == ["25"]
    assert page("It is 16 times as fast.", code="n = 16") == ["16"]


def test_what_a_program_merely_says_ties_nothing(page):
    shown = "The peak is 91.3 and 4.56\n"
    typed = 'print(f"The peak is 91.3 and {x}")'
    assert page("It peaks at 91.3.", code=typed, shown=shown) == ["91.3"]
    assert page("It peaks at 4.56.", code=typed, shown=shown) == []


def test_alternative_texts_and_captions_are_prose(page):
    code = 'show(fig, alt="It rises to 91.3.", caption=f"At {t:.1f} s, 4.56.")'
    assert page("Look.", code=code) == ["91.3", "4.56"]
    assert page("Look.", code=code, shown="91.31 4.5612") == []


def test_few_digits_need_a_witness_nearby(page):
    far = "Nothing.\n\n## There\n\n"
    assert page(far + "It is 0.3.", shown="0.31") == []  # the next cell
    text = far + "x.\n\n" + "It is 0.34 or 0.3412."
    assert page(text, shown="0.3412") == []


def test_given_data_have_a_reason_and_a_use(page):
    text = "The clock runs at 100 Hz."
    assert page(text) == ["100"]
    assert page(text, given={"at 100 Hz": "as the thesis has it"}) == []
    assert page(text, given={"at 100 Hz": "given"}) == ["100"]
    assert page(text, given={"at 200 Hz": "as the thesis has it"}) == [
        "100",
        "at 200 Hz",
    ]


@pytest.mark.parametrize(
    "reason, fault",
    [
        ("see 99_nowhere", "no page"),
        ("see bibliography", "doesn't print"),
        ("in sosbook/nothing.py", "no file"),
        ("in sosbook/book/ledger.py", "doesn't set"),
        ("cite nobody2099", "has no"),
        ("so", "where it comes from"),
    ],
)
def test_reasons_are_checked(reason, fault):
    (number,) = numerals.typed("12345.678")
    assert fault in check.unsupported(reason, number)


@pytest.mark.parametrize(
    "phrase, known",
    [
        ("neither exceeds the maximum voltage of 7.4 V", True),
        ("by varying $R$, noise and control effort decrease", True),
        ("above or close to this frequency [100 Hz] can generate", True),
        ("Poles close to the frequency can generate random results", False),
        ("the MIP moves to keep the body in balance", False),
        ("it suffices to check the vertices", False),
    ],
)
def test_a_changed_quotation_is_noticed(phrase, known):
    assert quoted.is_quotation(phrase) is known
