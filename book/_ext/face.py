"""How the site shows itself: descriptions, a page for lost readers, a map of itself.

``repository: url`` of ``_config.yml`` is the one place for the project's
address. With it the pages get their launch buttons (Binder, Colab) and links to
the source and to its issues; without it nothing points anywhere.
"""

import html
from pathlib import Path
from urllib.parse import urljoin, urlsplit

from docutils import nodes

LAUNCH = {
    "binderhub_url": "https://mybinder.org",
    "colab_url": "https://colab.research.google.com",
    "notebook_interface": "jupyterlab",
}
BUTTONS = ("use_repository_button", "use_issues_button")
LOST = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Not found - {project}</title>
<style>
  :root {{ color-scheme: light dark; }}
  body {{ font: 1.1rem/1.6 sans-serif; margin: 15vh auto; max-width: 34rem; padding: 0 1rem; }}
</style>
</head>
<body>
<h1>This page isn't in the book</h1>
<p>It may have another name now. The <a href="{base}index.html">first page</a> leads to
every chapter, and the <a href="{base}search.html">search</a> finds words in all of them.</p>
</body>
</html>
"""  # noqa: E501


def repository(app):
    """The project's address without its last slash, or nothing."""
    return (app.config.html_theme_options.get("repository_url") or "").rstrip("/")


def configure(app, config):
    """Buttons that need the project's address appear when there is one."""
    options = config.html_theme_options
    address = repository(app)
    launch = dict(options.get("launch_buttons") or {})
    if address:
        kind = urlsplit(address).netloc
        launch |= LAUNCH if kind == "github.com" else {}
        options.update(dict.fromkeys(BUTTONS, True))
    options["launch_buttons"] = launch
    options["repository_url"] = address


def description(doctree):
    """The first real paragraph of a page, in at most 200 characters; none that
    introduces the picture at its top.
    """
    for paragraph in doctree.findall(nodes.paragraph):
        text = " ".join(paragraph.astext().split())
        of_page = "sos-introduces" not in paragraph["classes"]
        if len(text) > 60 and "\\" not in text and of_page:
            return text if len(text) <= 200 else text[:197].rsplit(" ", 1)[0] + " …"
    return ""


def describe(app, pagename, templatename, context, doctree):
    """Say what the page is to search engines and to those who pass its link on."""
    if app.builder.name != "html":
        return
    title = context.get("title") or app.config.project
    tags = [("property", "og:title", title), ("property", "og:type", "article")]
    tags.append(("property", "og:site_name", app.config.html_title or title))
    if doctree is not None and (text := description(doctree)):
        tags += [
            (key, name, text)
            for key, name in (
                ("name", "description"),
                ("property", "og:description"),
                ("name", "twitter:description"),
            )
        ]
    base = app.config.html_baseurl
    if base:
        image = urljoin(base.rstrip("/") + "/", "_static/atlas.png")
        tags.append(("property", "og:image", image))
        tags.append(("property", "og:url", context.get("pageurl") or base))
    tags.append(("name", "twitter:card", "summary_large_image" if base else "summary"))
    lines = [
        f'<meta {key}="{name}" content="{html.escape(_text(value), quote=True)}" />'
        for key, name, value in tags
    ]
    context["metatags"] = context.get("metatags", "") + "\n" + "\n".join(lines)


def number(app, pagename, templatename, context, doctree):
    """The title that a page has on paper is numbered as on the screen."""
    if "pagetitle" in context:
        context["pagetitle"] = context["title"]


def _text(title):
    """A title without the tags that it has in a page."""
    return (
        nodes.unescape(str(title)).replace("\n", " ")
        if "<" not in title
        else ("".join(part.rpartition(">")[2] for part in str(title).split("<")))
    )


def finish(app, exception):
    """Write 404.html, and a map of the site where its address is known."""
    if exception or app.builder.name != "html":
        return
    out, base = Path(app.outdir), app.config.html_baseurl
    base = base.rstrip("/") + "/" if base else ""
    lost = LOST.format(project=html.escape(app.config.project), base=base)
    (out / "404.html").write_text(lost, "utf-8")
    if base:
        pages = sorted(app.builder.get_target_uri(d) for d in app.env.found_docs)
        body = "".join(
            f"<url><loc>{html.escape(base + page)}</loc></url>\n" for page in pages
        )
        space = "http://www.sitemaps.org/schemas/sitemap/0.9"
        text = f'<?xml version="1.0" encoding="UTF-8"?>\n<urlset xmlns="{space}">\n'
        (out / "sitemap.xml").write_text(text + body + "</urlset>\n", "utf-8")
        robots = f"User-agent: *\nAllow: /\nSitemap: {base}sitemap.xml\n"
        (out / "robots.txt").write_text(robots, "utf-8")


def setup(app):
    """Tell Sphinx."""
    app.connect("config-inited", configure, priority=100)
    app.connect("html-page-context", describe)
    app.connect("html-page-context", number, priority=900)  # after the theme
    app.connect("build-finished", finish)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
