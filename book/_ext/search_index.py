"""The index of the book's own search: sections, theorems and names, with text.

It is a script, so that it works from the disk; ``_static/search.js`` ranks.
"""

import json
from pathlib import Path

from docutils import nodes
from sphinx import addnodes

FILE = "search-index.js"
#: What isn't part of a section's own text.
APART = (
    addnodes.desc,
    nodes.comment,
    nodes.math_block,
    nodes.raw,
    nodes.section,
    nodes.title,
)
#: A word of the book, and what engineers say for it.
SYNONYMS = {
    "controller program": ("plc",),
    "decay rate": ("rise time", "settling time"),
    "delay": ("dead time",),
    "filter law": ("derivative filter",),
    "frequency filter": ("mixed sensitivity", "notch", "weighting function"),
    "fixed mode": ("uncontrollable", "unobservable"),
    "friction": ("dead band", "dead zone", "deadband"),
    "identification": ("system identification",),
    "input shaper": ("command shaping", "input shaping", "zvd"),
    "two inputs": ("mimo",),
    "observer": ("kalman", "lqg"),
    "outputs bounds": ("multi objective", "multiobjective", "performance output"),
    "polytope": ("robust stability", "uncertainty"),
    "region poles": ("pole placement", "root locus"),
    "sampled": ("sample time",),
    "sensitivity": ("sensitivity function",),
    "sensors law": ("output feedback",),
    "set point": ("reference", "setpoint"),
    "entry free": ("set point weighting",),
    "norm frequency": ("bode",),
    "structured singular value": ("mu analysis", "mu synthesis"),
    "windup": ("anti windup", "antiwindup"),
}
#: What engineers call the subject of a page whose title has other words.
SUBJECTS = {
    "book/05_h_infinity_norm": "hinf",
    "book/06_control_signal": "saturation",
    "book/08_zero_mass": "singular mass",
    "book/13_chain": "singular mass chain",
    "book/15_delay": "input delay",
    "book/17_wing_and_two_masses": "delay examples",
    "book/18_least_cost": "lqr",
    "book/21_rig_to_model": "identification",
    "book/23_gains_to_samples": "discretisation",
    "book/24_on_the_desk": "friction gear play",
    "book/26_logs_to_c_file": "whole chain",
    "book/31_ranges": "chirp log",
    "book/34_sensors": "derivative filter drive",
    "book/42_step_ramp_move": "overshoot settling time trajectory motion profile "
    "input shaper",
}
GREEK = dict(
    zip(
        (
            *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta"),
            *("iota", "kappa", "lambda", "mu", "nu", "xi", "omicron", "pi", "rho"),
            *("varsigma", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
        ),
        "αβγδεζηθικλμνξοπρςστυφχψω",
    )
)


def plain(math):
    """A short formula as text: sigma for the Greek letter, no backslashes."""
    for name in sorted(GREEK, key=len, reverse=True):
        math = math.replace(f"\\{name}", GREEK[name])
    return math.replace("\\", " ").replace("{", "").replace("}", "")


def words(node):
    """The text of a node and its code, without what is a section of its own."""
    text, code = [], []

    def visit(node):
        if isinstance(node, nodes.literal_block):
            if "output" not in " ".join(_ancestors(node)):
                code.append(node.astext())
        elif isinstance(node, nodes.math):
            text.append(plain(node.astext()))
        elif isinstance(node, nodes.Text):
            text.append(node.astext())
        elif {"sos-names", "sos-used"} & set(node.get("classes", ())):
            return
        elif not isinstance(node, APART) or isinstance(node, _statement()):
            for child in node.children:
                visit(child)
            if isinstance(node, nodes.TextElement) and not isinstance(
                node, nodes.Inline
            ):
                text.append(" ")

    for child in node.children:
        visit(child)
    return " ".join("".join(text).split()), " ".join(" ".join(code).split())


def _ancestors(node):
    while node is not None:
        yield from node.get("classes", ()) if isinstance(node, nodes.Element) else ()
        node = node.parent


def _statement():
    from sphinx_proof import NODE_TYPES

    return tuple(NODE_TYPES.values())


def collect(app, doctree):
    """The sections of a page, kept with it: (id, title, kind, text, code)."""
    rows = []
    for section in doctree.findall(nodes.section):
        if not section["ids"] or section["ids"][0].endswith("-content"):
            continue
        title = section.next_node(nodes.title)
        if title is None or title.parent is not section:
            continue
        top = isinstance(section.parent, nodes.document)
        rows.append(
            [
                "" if top else section["ids"][0],
                plain(title.astext()),
                0,
                *words(section),
            ]
        )
    for statement in doctree.findall(lambda n: isinstance(n, _statement())):
        kind = statement["realtype"].capitalize()
        title = plain(statement["title"]).removeprefix("(").removesuffix(")")
        text = words(statement[-1])[0] if len(statement) else ""
        if statement["ids"]:
            name = f"{kind}: {title}" if title else kind
            rows.append([statement["ids"][0], name, 1, text, ""])
    for entry in doctree.findall(addnodes.desc):
        head = entry.next_node(addnodes.desc_signature)
        if head is not None and head["ids"]:
            body = entry.next_node(addnodes.desc_content)
            first = body.next_node(nodes.paragraph) if body is not None else None
            text = first.astext() if first is not None else ""
            rows.append([head["ids"][0], head["ids"][0], 2, text, ""])
    for row in doctree.findall(nodes.row):
        places = [i for node in row.findall(nodes.Element) for i in node.get("ids", ())]
        place = next((i for i in places if i.startswith("t-")), None)
        if place and len(row) > 1:
            title, *rest = (cell.astext() for cell in row)
            rows.append([place, f"T {title}", 4, " ".join(" ".join(rest).split()), ""])
    for term in doctree.findall(nodes.term):
        if term["ids"] and term["ids"][0].startswith("term-"):
            text = term.parent.children[-1].astext()
            rows.append([term["ids"][0], term.astext(), 3, text, ""])
    env = app.env
    if not hasattr(env, "sos_search"):
        env.sos_search = {}
    env.sos_search[env.docname] = rows


def purge(app, env, docname):
    """Forget a page that is read again."""
    getattr(env, "sos_search", {}).pop(docname, None)


def numbers(env, docname):
    """The number of a chapter, such as "4. ", if it has one."""
    number = env.toc_secnumbers.get(docname, {}).get("")
    return f"{number[0]}. " if number else ""


def finish(app, exception):
    """Write the index."""
    if exception or app.builder.name != "html":
        return
    env = app.env
    order = [env.config.root_doc, *env.toctree_includes.get(env.config.root_doc, ())]
    order += sorted(env.sos_search.keys() - set(order))
    pages, subjects, rows = [], [], []
    for docname in dict.fromkeys(order):
        if docname not in env.sos_search:
            continue
        title = plain(env.titles[docname].astext())
        uri = app.builder.get_target_uri(docname)
        pages.append([uri, numbers(env, docname) + title])
        subjects.append(SUBJECTS.get(docname, ""))
        rows += [[len(pages) - 1, *row] for row in env.sos_search[docname]]
    synonyms = [(word, meant) for meant, said in SYNONYMS.items() for word in said]
    found = {"pages": pages, "rows": rows, "synonyms": synonyms, "subjects": subjects}
    data = json.dumps(found, ensure_ascii=False)
    text = "window.SOS_SEARCH = " + data.replace("</", "<\\/") + ";\n"
    out = Path(app.outdir)
    (out / "_static" / FILE).write_text(text, "utf-8")


def alone(app):
    """Keep Sphinx from making an index of its own, which no page reads."""
    for name in ("load_indexer", "index_page", "dump_search_index"):
        setattr(app.builder, name, lambda *args: None)


def setup(app):
    """Tell Sphinx."""
    app.connect("builder-inited", alone)
    app.connect("doctree-read", collect)
    app.connect("env-purge-doc", purge)
    app.connect("build-finished", finish)
    return {"version": "1", "parallel_read_safe": False, "parallel_write_safe": True}
