"""How the site shows itself, and what one address in _config.yml changes."""

import json
import re
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "book" / "_ext"))
face = pytest.importorskip("face")


def meta(path):
    text = path.read_text("utf-8")
    pairs = re.findall(r'<meta (?:name|property)="([^"]+)" content="([^"]*)"', text)
    return dict(pairs)


def test_pages_describe_themselves(site):
    descriptions = set()
    for page in (
        "intro",
        "05_h_infinity_norm",
        "16_delay_theorem",
        "own_plant",
        "api/plants",
    ):
        tags = meta(site / "book" / f"{page}.html")
        assert 60 < len(tags["description"]) <= 200
        assert tags["og:description"] == tags["description"]
        assert tags["og:title"] and "<" not in tags["og:title"]
        descriptions.add(tags["description"])
    assert len(descriptions) == 5
    front = meta(site / "book" / "intro.html")["description"]
    assert front.startswith("An executable book")  # not what introduces the picture


def test_there_is_an_icon_and_a_page_for_lost_readers(site):
    text = (site / "book" / "05_h_infinity_norm.html").read_text("utf-8")
    icon = re.search(r'<link rel="icon" href="([^"]+)"', text)[1]
    assert (site / "book" / icon).resolve().is_file()
    lost = (site / "404.html").read_text("utf-8")
    for target in re.findall(r'href="([^"]+)"', lost):
        assert (site / target).is_file()
    assert not (site / "sitemap.xml").exists()  # no address is known


def test_theorems_are_listed_with_numbers_and_titles(site):
    text = (site / "book" / "theorems.html").read_text("utf-8")
    assert "Bounded real lemma" in text and "thm-" in text
    assert len(re.findall(r"<li>", text)) > 60
    assert "prf-prf.html" not in text  # the list of raw labels
    index = (site / "genindex.html").read_text("utf-8")
    for word in ("analytic centre", "design_pid()", "Schur complement"):
        assert word in index
    assert not re.search(r'<li><a href="[^"]*">(An?|The) [^(]', index)


def configured(url="", baseurl=""):
    """The configuration after the extension has seen it."""
    options = {"repository_url": url, "use_repository_button": False}
    config = SimpleNamespace(
        html_theme_options=options, html_baseurl=baseurl, project="sosbook"
    )
    face.configure(SimpleNamespace(config=config), config)
    return config


def test_one_address_brings_the_buttons(site):
    options = configured("https://github.com/you/sosbook/").html_theme_options
    assert options["repository_url"] == "https://github.com/you/sosbook"
    assert options["use_repository_button"] and options["use_issues_button"]
    assert "mybinder" in options["launch_buttons"]["binderhub_url"]
    assert "colab" in options["launch_buttons"]["colab_url"]
    none = configured().html_theme_options
    assert not none["launch_buttons"] and not none["use_repository_button"]
    elsewhere = configured("https://gitlab.com/you/sosbook").html_theme_options
    assert not elsewhere["launch_buttons"] and elsewhere["use_repository_button"]
    given = yaml.safe_load((ROOT / "_config.yml").read_text("utf-8"))
    assert set(given["repository"]) >= {"url", "branch"}
    assert "_config.yml" in (ROOT / "README.md").read_text("utf-8")


def test_with_an_address_there_is_a_map_of_the_site(tmp_path):
    config = configured(baseurl="https://example.org/book")
    builder = SimpleNamespace(name="html", get_target_uri=lambda d: f"{d}.html")
    env = SimpleNamespace(found_docs={"book/a", "book/b"})
    app = SimpleNamespace(outdir=tmp_path, config=config, builder=builder, env=env)
    face.finish(app, None)
    places = re.findall(
        r"<loc>(.*?)</loc>", (tmp_path / "sitemap.xml").read_text("utf-8")
    )
    assert places == [f"https://example.org/book/book/{x}.html" for x in "ab"]
    assert "https://example.org/book/index.html" in (tmp_path / "404.html").read_text(
        "utf-8"
    )


# Elsewhere


def test_binder_takes_the_lock_and_a_python_that_the_package_knows():
    folder = ROOT / ".binder"
    (line,) = (folder / "requirements.txt").read_text("utf-8").split("\n")[:-1]
    assert (folder / line.removeprefix("-r ")).resolve() == ROOT / "requirements.txt"
    python = (folder / "runtime.txt").read_text("utf-8").strip()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    version = python.removeprefix("python-")
    assert f"Programming Language :: Python :: {version}" in project["classifiers"]
    post = (folder / "postBuild").read_text("utf-8")
    assert post.startswith("#!") and "jupyter trust book/*.ipynb" in post


def test_the_devcontainer_installs_the_lock():
    text = (ROOT / ".devcontainer" / "devcontainer.json").read_text("utf-8")
    asked = json.loads(text)
    assert "-r requirements.txt" in asked["postCreateCommand"]
    version = re.search(r"python:(3\.\d+)", asked["image"])[1]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert f"Programming Language :: Python :: {version}" in project["classifiers"]
