"""What of a text is prose, what is a formula; all else is blanked, letter by letter."""

import re

FENCE = re.compile(r"^(`{3,}|~{3,})[^\n]*\n(.*?)^\1\s*$", re.DOTALL | re.MULTILINE)
_MATH = re.compile(r"\$\$.*?\$\$|(?<!\\)\$[^$]*?(?<!\\)\$", re.DOTALL)
_UNIT = re.compile(r"[\s~]?(?:%|°|[a-zA-Zµμ]+)")
_REFERENCE = re.compile(
    r"""(?ix)
    \b(?:thesis(?:'s)?|theorems?|lemmas?|tables?|figs?\.?|figures?|chapters?
       |sections?|sect\.|equations?|eqs?\.|examples?|ex\.|procedures?
       |problems?|corollar(?:y|ies)|appendi(?:x|ces)|definitions?|steps?
       |algorithms?|propositions?|parts?|rows?|columns?|cells?|lines?|cases?
       |remarks?|vertex|vertices|pages?|pp?\.|volume|Python|version|IEEE|ISO)
       (?:[\s~]|\u00a0)+\(?(?:[A-Z]\.)?\d+(?:\.\d+)*\)?
       (?:(?:,\s|\s?(?:and|to|or|-|–)\s?|,\s?and\s)
          \(?(?:[A-Z]\.)?\d+(?:\.\d+)*\)?)*(?![\d%.]*[\d%])
    | \(\d+(?:\.\d+)+\)(?:[-–]\(\d+(?:\.\d+)+\))?
    | \((?:[A-Z]\.)?\d+\.\d+(?:,\s\d+\.\d+)*\)
    | \(\d\)
    | \b\d\.\d\.\d\b
    | ^\|\s(?:[\dA-Z]\.\d(?:\.\d)?(?:,\s|\s(?=[A-Za-z])))+  # a table of contents
    | \b(?-i:[A-Z])\.\d+(?:\.\d+)*
    | \b(?:18|19|20)\d\ds?\b(?!\s?(?:N|kg|Hz|V|m|s|rad|steps|samples|counts)\b)
    | \b\d+(?:st|nd|rd|th)\b
    | ^\s*\d+\.\s        # a numbered list
    | ^\*\*Before:\*\*.*$
    """,
    re.MULTILINE,
)


def blank(match):
    """Spaces for a match; line breaks stay."""
    return re.sub(r"[^\n]", " ", match[0])


def _keep_first(match):
    """Blank a match but for its first group."""
    before = match.start(1) - match.start()
    after = match.end() - match.end(1)
    return " " * before + match[1] + " " * after


def _structure(text):
    """Formulas without indices, exponents, commands: what is left is data."""
    text = re.sub(r"\\(?:label|tag|begin|end|hspace)\{[^}]*\}", blank, text)
    text = re.sub(r"\\[dt]?frac\s?\d\s?\d", blank, text)
    text = re.sub(
        r"\\(?:text|operatorname)\{[^}]*\}",
        lambda match: re.sub(r"\d", " ", match[0]),
        text,
    )
    group = r"\{[^{}]*(?:\{[^{}]*\})?[^{}]*\}"
    text = re.sub(rf"_(?:{group}|\w|\\\w+)", blank, text)
    return re.sub(rf"(?<!10)\^(?:{group}|\w|\\(?!circ)\w+)", blank, text)


def split(text):
    """Blank what isn't prose; return prose and formulas, of equal length."""
    text = FENCE.sub(blank, text)
    text = re.sub(r"<!--.*?-->", blank, text, flags=re.DOTALL)
    text = re.sub(r"^\([\w-]+\)=\s*$", blank, text, flags=re.MULTILINE)
    text = re.sub(r"^:[\w-]+:.*$", blank, text, flags=re.MULTILINE)
    text = re.sub(
        r"^:{3,}\{[^}]*\}[ \t]*(?:ex-\S+|(.*))$",
        lambda m: _keep_first(m) if m[1] else blank(m),
        text,
        flags=re.MULTILINE,
    )
    text = re.sub(r"\{[\w:-]+\}`[^`]*`", blank, text)
    text = re.sub(r"\*★+, [^*\n]*\*|\*\*Time:\*\*[^\n]*", blank, text)
    text = re.sub(r"\[T [^\[\]\n]+\]", blank, text)
    # A link to a chapter: test_notebooks compares its number with the file's.
    text = re.sub(r"\[(?:[Cc]hapter )?\d+(?:\. [^\]\n]*)?\]\(\d\d_\S+?\)", blank, text)
    text = re.sub(r"\]\([^)\s]*\)|<https?://[^>]*>|https?://\S+", blank, text)
    text = re.sub(r"</?[a-z][^>\n]*>", blank, text)
    text = re.sub(r"(?<=\$\$)[ ]*\([\w-]+\)", blank, text)
    formulas = list(re.sub(r"[^\n]", " ", text))
    for match in _MATH.finditer(text):
        unit = _UNIT.match(text, match.end())  # it may follow the formula
        end = unit.end() if unit else match.end()
        formulas[match.start() : end] = text[match.start() : end]
    prose = re.sub(r"`[^`\n]*`", _code, _MATH.sub(blank, text))
    return _REFERENCE.sub(blank, prose), _structure("".join(formulas))


def _code(match):
    """Inline code: identifiers and indices go, numbers stay."""
    return re.sub(r"[A-Za-z_]\w*|\[[^\]]*\]|^`|`$", blank, match[0])
