"""The built book reads alike offline, on a phone and in the dark, and is run anew when the code under it changes."""

import gzip
import re
import shutil
import subprocess
import sys
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
import yaml

from autograder.checks import EXERCISES
from autograder.report import section_address
from mechlib.cylinder import Cylinder
from mechlib.fourbar import FourBar
from mechlib.hacksaw import Hacksaw
from mechlib.wiper import Wiper

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
        small: all("main :is(pre, td, th)").filter((box) => parseFloat(getComputedStyle(box).fontSize) < 12)
            .map((box) => box.textContent.slice(0, 40)),
    };
}"""


JOINTS_AT_ALL_FRAMES = """(figure) => {
    const range = figure.querySelector("input[type=range]");
    return Array.from({ length: Number(range.max) + 1 }, (_, frame) => {
        range.value = frame;
        range.dispatchEvent(new Event("input"));
        return Object.fromEntries([...figure.querySelectorAll(".joint")].map((joint) => {
            const { x, y, width, height } = joint.querySelector("circle").getBoundingClientRect();
            return [joint.dataset.joint, [x + width / 2, y + height / 2]];
        }));
    });
}"""

COLOURS = ("color-contrast", "link-in-text-block")  # the rules that a theme can break
NOTHING_WRONG = {"withoutAlt": [], "broken": [], "rawMath": [], "badMath": [], "small": []}


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


@pytest.mark.parametrize("width", [pytest.param(1280, marks=pytest.mark.proof), 360])
@pytest.mark.parametrize("page", pages())
def test_page_reads_offline_on_any_screen_and_by_anyone(html, opened, axe, page, width):
    with opened((html / f"{page}.html").as_uri(), width, "light", offline=True) as (tab, trouble):
        for theme, rules in (("light", ()), ("dark", COLOURS)):
            tab.emulate_media(color_scheme=theme)
            tab.wait_for_function("(theme) => document.documentElement.dataset.theme === theme", arg=theme)
            facts = tab.evaluate(FACTS)
            assert facts.pop("sideways") <= 0
            assert facts == {"theme": theme, **NOTHING_WRONG}
            assert axe(tab, *rules) == []
    assert trouble == []


@pytest.fixture(scope="session")
def server(html):
    """The book as a web server gives it away."""
    handler = partial(Quiet, directory=html)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.mark.parametrize("page", pages())
def test_page_reads_from_a_server_and_asks_no_other(server, opened, page):
    with opened(f"{server}/{page}.html", 360, "dark") as (tab, trouble):  # the other widths are looked at offline
        facts = tab.evaluate(FACTS)
    assert trouble == []
    assert facts.pop("sideways") <= 0
    assert facts == {"theme": "dark", **NOTHING_WRONG}


def hacksaw_joints():
    crank = np.deg2rad(np.arange(360))
    return dict(zip("OAB", np.moveaxis(Hacksaw().points(crank, Hacksaw().position(crank)), -2, 0), strict=True))


def wiper_joints():
    """By complex numbers: A on its circle, and B where two circles meet, to the right of the line from A to C."""
    wiper, crank = Wiper(), np.exp(1j * np.deg2rad(np.arange(0, 360, 2)))
    A, C, F = wiper.r1 * crank, wiper.r0 + 0 * crank, wiper.r0 + wiper.r5 + 0 * crank
    far = np.abs(C - A)
    at_A = np.arccos((far**2 + wiper.r2**2 - wiper.r3**2) / (2 * far * wiper.r2))
    B = A + wiper.r2 * (C - A) / far * np.exp(1j * at_A)
    blade = (B - C) / wiper.r3
    D, E, G, H = C + wiper.r4 * blade, F + wiper.r4 * blade, C + wiper.r6 * blade, F + wiper.r6 * blade
    places = zip("ABCDEFGHO", (A, B, C, D, E, F, G, H, 0 * A), strict=True)
    return {name: np.stack((z.real, z.imag), axis=-1) for name, z in places}


def cylinder_joints():
    """By complex numbers: A where two circles meet, to the right of the line from O2 to O4, at strokes 5 mm apart."""
    cylinder, a = Cylinder(), np.linspace(0.405, 0.795, 79)
    O2, s, b = cylinder.o2 - 1j * cylinder.o4 + 0 * a, a + cylinder.l, cylinder.b
    line = -O2 / np.abs(O2) * np.exp(-1j * np.arccos((np.abs(O2) ** 2 + s**2 - b**2) / (2 * np.abs(O2) * s)))
    A = O2 + s * line
    places = {"A": A, "P": O2 + a * line, "G₄": 0.6 * A / np.abs(A), "O₂": O2, "O₄": 0 * A}
    return {name: np.stack((z.real, z.imag), axis=-1) for name, z in places.items()}


def fourbar_joints():
    """By complex numbers: B where two circles meet, to the left of the line from A to O4."""
    bars, crank = FourBar(), np.exp(1j * np.deg2rad(np.arange(0, 360, 2)))
    A, O4 = bars.r2 * crank, bars.r1 + 0 * crank
    far = np.abs(O4 - A)
    along = (O4 - A) / far * np.exp(1j * np.arccos((far**2 + bars.r3**2 - bars.r4**2) / (2 * far * bars.r3)))
    places = {"O₂": 0 * crank, "A": A, "B": A + bars.r3 * along, "O₄": O4}
    places["P"] = A + (bars.rcx + 1j * bars.rcy) * along
    return {name: np.stack((z.real, z.imag), axis=-1) for name, z in places.items()}


@pytest.mark.parametrize(
    ("page", "place", "joints"),
    [
        ("index", 0, hacksaw_joints),
        ("index", 1, wiper_joints),
        ("index", 2, cylinder_joints),
        ("index", 3, fourbar_joints),
        ("hacksaw-closure", 0, hacksaw_joints),
        ("wiper-kinematics", 0, wiper_joints),
        ("cylinder-kinematics", 0, cylinder_joints),
        ("fourbar-coupler", 0, fourbar_joints),
    ],
)
def test_a_draggable_figure_lives_in_the_built_page_and_shows_the_mechanism(html, opened, page, place, joints):
    with opened((html / f"{page}.html").as_uri(), 1280, "light") as (tab, trouble):
        seen = tab.locator(".mechanism").nth(place).evaluate(JOINTS_AT_ALL_FRAMES)
        caption = tab.locator("figure:has(.mechanism) figcaption").nth(place).inner_text()
    assert trouble == []
    assert re.match(r"Fig. [\d.]+ ", caption)
    expected = joints()
    drawn = {name: np.array([frame[name] for frame in seen]) for name in expected}
    (origin,) = (drawn[name] for name, place in expected.items() if not np.any(place))
    unit = np.linalg.norm(drawn["A"] - origin, axis=1).mean() / np.linalg.norm(expected["A"][0])  # pixels a metre
    for name, place in expected.items():
        np.testing.assert_allclose(drawn[name] - origin, place * (unit, -unit), atol=0.5)  # half a pixel


class Links(HTMLParser):
    """The links of a page, the anchors that it has, and the files that it shows."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors, self.files = [], set(), set()
        self.feed(path.read_text(encoding="utf8"))

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.anchors |= {attrs["id"]} if attrs.get("id") else set()
        if tag == "a" and attrs.get("href"):
            self.links.append(attrs["href"])
        for name in ("src", "data"):
            if attrs.get(name):
                self.files.add(attrs[name])


def test_no_link_leads_nowhere(html):
    found = {path: Links(path) for path in html.glob("*.html")}
    for path, page in found.items():
        for link in page.links:
            target, _, anchor = link.partition("#")
            if urlsplit(link).scheme:
                assert urlsplit(link).scheme in ("http", "https", "mailto"), f"{path.name}: {link}"
                continue
            file = (path.parent / unquote(urlsplit(target).path)).resolve() if target else path
            assert file.exists(), f"{path.name}: {link}"
            if anchor and file in found:
                assert unquote(anchor) in found[file].anchors, f"{path.name}: {link}"


MOST = 300_000  # bytes


@pytest.mark.parametrize("page", pages())
def test_page_is_light_beside_what_all_pages_share(html, page):
    """Its pictures and the data in it; and all of it, text too, as a server sends it."""
    path = html / f"{page}.html"
    text = path.read_bytes()
    pictures = [(html / file).read_bytes() for file in Links(path).files if file.startswith("_images/")]
    data = [match.group() for match in re.finditer(rb"<(script|svg)\b.*?</\1>", text, re.DOTALL)]
    assert sum(map(len, pictures + data)) < MOST
    assert sum(len(gzip.compress(sent)) for sent in (text, *pictures)) < MOST


def test_a_page_is_run_anew_when_the_code_under_it_changes_and_only_then(tmp_path):
    book = tmp_path / "book"
    shutil.copytree(ROOT / "book" / "_ext", book / "_ext", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "book" / "_static", book / "_static")
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
    again = subprocess.run(build, cwd=tmp_path, capture_output=True, text=True)
    assert "0 added, 0 changed, 0 removed" in again.stdout  # nothing changed: nothing is read or run


@pytest.mark.parametrize("task", [t for e in EXERCISES.values() for t in e.tasks], ids=lambda t: t.name)
def test_feedback_links_to_a_section_of_the_built_book(task):
    page, _, anchor = section_address(str(HTML), task.section).partition("#")
    assert f'id="{anchor}"' in Path(page).read_text("utf-8")
