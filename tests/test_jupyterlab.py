"""A student at work: an exercise and a chapter in a real JupyterLab, in a real browser."""

import json
import re
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import jupytext
import pytest

ROOT = Path(__file__).parents[1]
STARTING = 60  # s until the server answers, and then until a cell has run: a loaded computer is no failure

WRONG = """def brackets(f, a, b, n):
    x = np.linspace(a, b, n)
    y = np.array([f(point) for point in x])
    return np.column_stack((x[:-1], x[1:]))[y[:-1] * y[1:] < 0]"""
RIGHT = """def brackets(f, a, b, n):
    if not a < b or n < 1:
        raise ValueError(f"no interval: a = {a}, b = {b}, n = {n}")
    x = np.linspace(a, b, n + 1)
    y = np.array([f(point) for point in x])
    return np.column_stack((x[:-1], x[1:]))[y[:-1] * y[1:] < 0]"""

SETTINGS = {
    "notebook-extension/tracker": {"windowingMode": "none"},  # every cell is in the page
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
}


@pytest.fixture(scope="module")
def lab(chromium, tmp_path_factory):
    """A JupyterLab with an empty home, over a folder with one exercise and one chapter."""
    work, home = tmp_path_factory.mktemp("work"), tmp_path_factory.mktemp("home")
    shutil.copy(ROOT / "exercises" / "01_newton_1d.ipynb", work)
    jupytext.write(jupytext.read(ROOT / "book" / "newton-1d.md"), work / "newton-1d.ipynb")
    for name, values in SETTINGS.items():
        path = home / ".jupyter/lab/user-settings/@jupyterlab" / f"{name}.jupyterlab-settings"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(values))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    options = {
        "ServerApp.port": port,
        "ServerApp.port_retries": 0,
        "ServerApp.root_dir": work,
        "IdentityProvider.token": "",
    }
    with open(home / "log", "w") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root"]
            + [f"--{name}={value}" for name, value in options.items()],
            env={"PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin", "HOME": str(home)},
            stdout=log,
            stderr=log,
        )
    for _ in range(5 * STARTING):
        time.sleep(0.2)
        assert server.poll() is None, (home / "log").read_text()
        try:
            urlopen(f"http://127.0.0.1:{port}/api", timeout=2).close()
            break
        except (URLError, TimeoutError):
            continue
    yield f"http://127.0.0.1:{port}"
    server.terminate()
    server.wait(20)


class Notebook:
    """A notebook in a tab of the browser."""

    def __init__(self, tab):
        self.tab = tab
        tab.locator("#jp-bottom-panel, #jp-main-statusbar").get_by_text("(ipykernel) | Idle").wait_for()

    def cell(self, words):
        return self.tab.locator(".jp-CodeCell").filter(has=self.tab.locator(".cm-content", has_text=words)).first

    def write(self, words, text):
        """Type a text in place of a cell's."""
        self.cell(words).locator(".cm-content").click()
        self.tab.keyboard.press("Control+A")
        self.tab.keyboard.insert_text(text)

    def run(self, words):
        """Run a cell, and give its output when it has ended."""
        cell = self.cell(words)
        before = self._prompt(cell)
        for tenth in range(10 * STARTING):
            now = self._prompt(cell)
            if now != before and re.fullmatch(r"\[\d+\]:", now):
                return cell.locator(".jp-Cell-outputArea")
            if now == before and tenth % 30 == 0:  # a key that comes while the page is being laid out is lost
                cell.locator(".cm-content").click()
                self.tab.keyboard.press("Control+Enter")
            self.tab.wait_for_timeout(100)
        raise AssertionError(f"the cell {words!r} did not end: {now}")

    @staticmethod
    def _prompt(cell):
        return cell.locator(".jp-InputArea-prompt").inner_text().strip()


@pytest.fixture
def notebook(lab, chromium):
    context = chromium.new_context(viewport={"width": 1280, "height": 900})
    context.set_default_timeout(1000 * STARTING)

    def visit(name):
        tab = context.new_page()
        tab.goto(f"{lab}/lab/workspaces/{Path(name).stem}/tree/{name}")  # or the notebook of the other test opens too
        return Notebook(tab)

    yield visit
    context.close()


def test_a_student_reads_which_mistake_it_is_mends_it_and_gets_full_points(notebook):
    exercise = notebook("01_newton_1d.ipynb")
    exercise.run("import numpy as np")
    exercise.write("def brackets", WRONG)
    exercise.run("def brackets")
    card = exercise.run('check("brackets")').inner_text()
    assert "brackets: partly right, 0.5 of 2 points" in card
    assert "The grid has n points, and not n subintervals. Count the fence posts" in card
    assert "To read: newton-1d" in card

    exercise.write("def brackets", RIGHT)
    exercise.run("def brackets")
    card = exercise.run('check("brackets")').inner_text()
    assert "brackets: right, 2 of 2 points" in card
    assert "✗" not in card


def test_the_live_widget_of_the_chapter_moves_when_its_slider_is_dragged(notebook):
    chapter = notebook("newton-1d.ipynb")
    chapter.run("import matplotlib.pyplot as plt")
    chapter.run("return exp(x) - 6 * x")
    output = chapter.run("from ipywidgets import")
    picture = output.locator(".jp-RenderedSVG img")
    before = picture.get_attribute("src")
    handle = output.locator(".noUi-handle").first
    handle.scroll_into_view_if_needed()
    at = handle.bounding_box()
    x, y = at["x"] + at["width"] / 2, at["y"] + at["height"] / 2
    chapter.tab.mouse.move(x, y)
    chapter.tab.mouse.down()
    chapter.tab.mouse.move(x + 60, y, steps=5)
    chapter.tab.mouse.up()
    for _ in range(10 * STARTING):
        if picture.get_attribute("src") != before:
            return
        chapter.tab.wait_for_timeout(100)
    raise AssertionError("the picture did not change")
