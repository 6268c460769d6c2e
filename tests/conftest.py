"""What every test may lean on: a browser, reproducible examples, and a last word on what was not run."""

import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest
from hypothesis import settings

pytest_plugins = ["pytester"]

CI = os.environ.get("CI") == "true"

# The reasons for a skip that a computer of our own must not have: what is missing there can be installed.
INSTALLABLE = ("browser", "isolation level", "bubblewrap", "landlock", "seccomp")

settings.register_profile("local", deadline=None)  # a slow computer is no counterexample
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if CI else "local")


def skips(terminalreporter):
    """Name and reason of each skipped test, and whether its reason is one that CI does not take."""
    for report in terminalreporter.getreports("skipped"):
        reason = (
            report.longrepr[-1].removeprefix("Skipped: ") if isinstance(report.longrepr, tuple) else report.wasxfail
        )
        yield report.nodeid, reason, reason.startswith(INSTALLABLE)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_sessionfinish(session):
    result = yield
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if CI and reporter and session.exitstatus == pytest.ExitCode.OK and any(bad for *_, bad in skips(reporter)):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
    return result


def pytest_terminal_summary(terminalreporter):
    skipped = list(skips(terminalreporter))
    if skipped:
        terminalreporter.section("not run")
    for name, reason, installable in skipped:
        terminalreporter.line(f"{name}: {reason}" + (" (a failure, since CI=true)" if CI and installable else ""))


@pytest.fixture(scope="session")
def busy():
    """Keeps every core busy with so many processes."""

    @contextmanager
    def load(processes_a_core):
        # a session each, since the kernel may share a core out among sessions
        spin = (sys.executable, "-c", "while True: pass")
        spinning = [subprocess.Popen(spin, start_new_session=True) for _ in range(processes_a_core * os.cpu_count())]
        try:
            yield
        finally:
            for process in spinning:
                process.kill()
                process.wait()

    return load


@pytest.fixture(scope="session")
def chromium():
    """A headless browser of the system's, with its own calls home turned off."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="browser: playwright is not installed")
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    path = next(filter(None, map(shutil.which, names)), None)
    if path is None:
        pytest.skip("browser: no Chromium on this computer (Debian, Ubuntu: sudo apt install chromium)")
    quiet = ["--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"]
    root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    with sync_api.sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=path, args=quiet + root)
        except sync_api.Error as error:
            pytest.skip(f"browser: {path} does not start ({str(error).splitlines()[0]})")
        yield browser
        browser.close()


WCAG = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa")  # 2.1 AA

# A violation is told with the rule, the element, and what would mend it.
AXE = """async (rules) => {
    const { violations } = await axe.run(document, { runOnly: rules, resultTypes: ["violations"], preload: false });
    return violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html} ${node.failureSummary}`));
}"""


@pytest.fixture(scope="session")
def axe():
    """What of the page in a tab breaks the rules of WCAG 2.1 AA, or some of them."""
    script = pytest.importorskip("axe_playwright_python.sync_playwright", reason="browser: no axe").Axe().axe_script

    def violations(tab, *rules):
        if not tab.evaluate("'axe' in window"):
            tab.evaluate(script)
        return tab.evaluate(AXE, rules or WCAG)

    return violations


@pytest.fixture
def opened(chromium):
    """Opens a page, tells its trouble, and whatever it asked of another host than its own."""

    @contextmanager
    def visit(url, width, theme, **options):
        trouble = []
        context = chromium.new_context(
            viewport={"width": width, "height": 800}, color_scheme=theme, reduced_motion="reduce", **options
        )
        home = f"{urlsplit(url).scheme}://{urlsplit(url).netloc}/"
        tab = context.new_page()
        tab.on("console", lambda message: trouble.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: trouble.append(str(error)))
        tab.on(
            "request", lambda asked: trouble.append(asked.url) if not asked.url.startswith((home, "data:")) else None
        )
        tab.goto(url)
        yield tab, trouble
        context.close()

    return visit
