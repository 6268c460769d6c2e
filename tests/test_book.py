"""The built book reads alike offline, on a phone and in the dark, and is run anew when the code under it changes."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
HTML = ROOT / "_build" / "html"

ELSEWHERE = r"""["'(\s](?:https?:)?//[\w-]+\.[\w.-]+"""
LOADS = {
    ".html": rf"<(?!a\b)[a-z]+\b[^>]*\s(?:src|srcset|href|data|poster)\s*=\s*{ELSEWHERE}|<script[^>]*>[^<]*{ELSEWHERE}",
    ".css": rf"(?:url\(|@import)\s*{ELSEWHERE}|url\((?:https?:)?//",
    ".js": rf"\b(?:import|importScripts|fetch)\(\s*{ELSEWHERE}",
}

FACTS = """async () => {
    if (window.MathJax?.startup) await MathJax.startup.promise;
    await document.fonts.ready;
    const all = (selector) => [...document.querySelectorAll(selector)];
    return {
        sideways: document.documentElement.scrollWidth - window.innerWidth,
        theme: document.documentElement.dataset.theme,
        withoutAlt: all("main img").filter((image) => !image.alt.trim()).map((image) => image.src),
        broken: all("img").filter((image) => !image.naturalWidth).map((image) => image.src),
        rawMath: all(".math").filter((math) => !math.querySelector("mjx-container")).map((math) => math.textContent),
        badMath: all("mjx-merror").map((error) => error.textContent),
    };
}"""


def pages():
    toc = yaml.safe_load((ROOT / "book" / "_toc.yml").read_text(encoding="utf8"))
    return [toc["root"], *(chapter["file"] for part in toc["parts"] for chapter in part["chapters"])]


@pytest.fixture(scope="session")
def html():
    if not (HTML / "index.html").exists():
        pytest.fail("there is no _build/html: first type jupyter-book build book -W -n --keep-going")
    return HTML


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        (".html", '<script src="https://cdn.example.org/a.js">'),
        (".html", "<link rel='stylesheet' href='//fonts.example.org/a.css'>"),
        (".html", '<script>const url = "https://example.org/a.js"</script>'),
        (".css", 'a { background: url("https://example.org/a.png") }'),
        (".css", "@import 'https://example.org/a.css'"),
        (".css", "a { src: url(//example.org/a.woff) }"),
        (".js", "import('https://example.org/a.js')"),
    ],
)
def test_a_load_from_elsewhere_would_be_seen(kind, code):
    assert re.search(LOADS[kind], code)


def test_nothing_is_loaded_from_another_host(html):
    found = [
        f"{path.relative_to(html)}: {match.group()[:120]}"
        for path in sorted(html.rglob("*"))
        if path.suffix in LOADS
        for match in re.finditer(LOADS[path.suffix], path.read_text(encoding="utf8"))
    ]
    assert found == []


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 360])
@pytest.mark.parametrize("page", pages())
def test_page_reads_offline_on_any_screen(html, chromium, page, width, theme):
    trouble = []
    context = chromium.new_context(viewport={"width": width, "height": 800}, color_scheme=theme, offline=True)
    tab = context.new_page()
    tab.on("console", lambda message: trouble.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: trouble.append(str(error)))
    tab.on("request", lambda request: trouble.append(request.url) if request.url.startswith("http") else None)
    tab.goto((html / f"{page}.html").as_uri())
    facts = tab.evaluate(FACTS)
    context.close()

    assert trouble == []
    assert facts.pop("sideways") <= 0
    assert facts == {"theme": theme, "withoutAlt": [], "broken": [], "rawMath": [], "badMath": []}


def test_a_page_is_run_anew_when_the_code_under_it_changes(tmp_path):
    book = tmp_path / "book"
    shutil.copytree(ROOT / "book" / "_ext", book / "_ext", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "_config.yml", tmp_path)
    (book / "vendor").mkdir()
    (book / "references.bib").write_text("")
    (book / "_toc.yml").write_text("format: jb-book\nroot: index\n")
    (book / "index.md").write_text(
        "---\njupytext: {text_representation: {extension: .md, format_name: myst}}\n"
        "kernelspec: {name: python3, display_name: Python 3}\n---\n# Page\n\n"
        "```{code-cell}\nexec(open('../mechlib/answer.py').read())\nprint('answer', answer)\n```\n"
    )
    code = tmp_path / "mechlib" / "answer.py"
    code.parent.mkdir()
    build = [Path(sys.executable).with_name("jupyter-book"), "build", "book", "-W", "-n"]

    for answer in (1, 2):
        code.write_text(f"answer = {answer}\n")
        done = subprocess.run(build, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert f"answer {answer}" in (tmp_path / "_build" / "html" / "index.html").read_text(encoding="utf8")
