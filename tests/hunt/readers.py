"""The three readers of a request or a proof: the package, its checker, the page."""

from sosbook.exact.checker import verdict as checker
from sosbook.exact.proof_file import load
from tests.page_requests import page_request

DESIGN = """request => {
  const {design, prove, refusalFile} = globalThis.kernel ??= sosKernel();
  const r = design(request), kept = {status: r.status, K: r.K};
  if (r.status === "feasible") kept.text = prove(request, r).text;
  if (r.status === "infeasible" && r.refusal)
    kept.text = refusalFile(request, r.refusal).text;
  return kept; }"""
LARGEST = 3  # degrees of freedom on a page: larger ones take seconds


def package(file):
    """What the package reads in a file: the claims that it proves, or None."""
    try:
        proof = load(file)
    except ValueError:
        return None
    return tuple(proof.claims) if proof.verify() else None


def alone(text):
    """What the checker reads in a text: claims, None, or "beyond"."""
    try:
        return tuple(checker.check(text))
    except checker.Beyond:
        return "beyond"
    except (checker.Refused, *checker.MALFORMED):
        return None


def on_pages(asked):
    """Whether a page can ask this: one `PoleRegion`, pairs, a few masses."""
    region = asked.keywords.get("region")
    return (
        asked.keywords.get("coupling", "pairs") == "pairs"
        and asked.vertices[0].n <= LARGEST
        and (region is None or hasattr(region, "rho"))
    )


class Page:
    """The solver of the rendered pages, in a browser's page of playwright."""

    def __init__(self, page):
        self.page = page

    def design(self, asked):
        """The status, the gain and the text of a proof: a dict."""
        return self.page.evaluate(DESIGN, page_request(asked.plant, **asked.keywords))
