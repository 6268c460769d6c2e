"""The pages on reproduced numbers, mistakes and benchmarks say all that chapters, tests and measurements hold."""

import importlib.util
import json
import re
from pathlib import Path

import pytest
import yaml
from executed import executed

ROOT = Path(__file__).parents[1]
BOOK = ROOT / "book"
KNOWN = [f"{source}{k}" for source, most in zip("ABCD", (11, 9, 6, 5), strict=True) for k in range(1, most + 1)]
PAGES = ("reproduced", "errata", "benchmarks")


@pytest.fixture(scope="module")
def errata():
    return executed("errata")


@pytest.fixture(scope="module")
def reproduced():
    return executed("reproduced")


def cells(table):
    """The rows of a table, and what stands above it is left out."""
    lines = table[table.index("| ") :].splitlines()[2:]
    return [[cell.strip() for cell in line[1:-1].split(" | ")] for line in lines]


def rows(page):
    return [row for table in page["tables"] for row in cells(table)]


def mistakes(text):
    return set(re.findall(r"\b[A-D]\d+\b", text))


def test_every_known_mistake_has_one_row_in_the_table_of_its_source_and_a_proof(errata):
    assert len(errata["tables"]) == 4
    for source, table in zip("ABCD", errata["tables"], strict=True):
        numbers = [number for number, *_ in cells(table)]
        assert numbers == [f"{source}{k}" for k in range(1, len(numbers) + 1)]
        assert {number for number in KNOWN if number[0] == source} <= set(numbers)
    assert all(place and proof for _, place, proof in rows(errata))


def test_every_box_of_the_book_about_a_source_stands_in_the_table_once_with_its_chapter(errata):
    told = "\n".join(place for _, place, _ in rows(errata))
    found = 0
    for page in BOOK.glob("*.md"):
        for line in page.read_text("utf-8").splitlines():
            if line.startswith(":::{admonition} Source "):
                title = line.removeprefix(":::{admonition} Source ")[1:].lstrip(",: ")
                assert told.count(f"{title} ({{doc}}`{page.stem}`)") == 1
                found += 1
    assert found == told.count("{doc}") > len(KNOWN)


def test_every_test_that_is_named_as_a_proof_exists_and_has_the_number_in_its_name(errata):
    for number, found in errata["proofs"].items():
        assert found
        for file, claim in found:
            text = (ROOT / "tests" / f"{file}.py").read_text("utf-8")
            assert re.search(rf"^def test_(\w\d+_and_)*{number.lower()}_\w*{claim}\(", text, re.MULTILINE)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_in_the_table_of_contents_and_leads_to_pages_that_are_there_too(page, request):
    toc = yaml.safe_load((BOOK / "_toc.yml").read_text("utf-8"))
    pages = [chapter["file"] for part in toc["parts"] for chapter in part["chapters"]]
    assert page in pages
    text = (BOOK / f"{page}.md").read_text("utf-8")
    if page == "errata":
        text += "\n".join(request.getfixturevalue("errata")["tables"])
    linked = re.findall(r"\{doc\}`([\w-]+)`", text)
    assert linked
    assert set(linked) <= set(pages)


def test_a_number_that_differs_has_a_mistake_and_one_that_agrees_has_none(errata, reproduced):
    listed = {number for number, *_ in rows(errata)}
    for name, _, verdict, _ in rows(reproduced):
        assert ("differs" in verdict) == bool(mistakes(verdict)), name
        assert mistakes(verdict) <= listed


def test_the_numbers_that_differ_are_those_of_the_mistakes_that_printed_a_number(reproduced):
    a, b, c, d = (mistakes(table) for table in reproduced["tables"])
    assert a == {"A4", "A5", "A8", "A11"}
    assert b == set()
    assert c == {"C1", "C2", "C3", "C4", "C7"}
    assert d == {"D1", "D3"}


def test_every_number_of_the_published_table_has_a_row_with_its_digits(reproduced):
    printed = (BOOK / "data" / "fourbar_published.csv").read_text("utf-8").split()[1:]
    texts = [text for line in printed for text in line.split(",")[1:]]
    of_points = [text for name, text, *_ in cells(reproduced["tables"][3]) if "point" in name]
    assert of_points == texts
    assert len(texts) == 40


def in_seconds(text):
    number, unit = re.match(r"([\d.,]+) (s|ms|µs)\b", text).groups()
    return float(number.replace(",", "")) * {"s": 1, "ms": 1e-3, "µs": 1e-6}[unit]


@pytest.mark.parametrize(
    ("number", "file", "ways"),
    [
        (0, "book/measured/hacksaw.json", "ways"),
        (1, "book/measured/wiper.json", "turn"),
        (2, "book/measured/fourbar.json", "ways"),
        (3, "tests/benchmarks/measured/against_nbgrader.json", None),
    ],
)
def test_the_page_of_benchmarks_has_date_computer_and_times_of_the_kept_measurement(number, file, ways):
    kept, shown = json.loads((ROOT / file).read_text("utf-8")), executed("benchmarks")["tables"][number]
    for what in (kept["date"], kept["computer"]["processor"], *kept["versions"], *kept["versions"].values()):
        assert what in shown
    assert (ROOT / re.search(r"`(tests/benchmarks/\w+\.py)`", shown)[1]).exists()
    if ways:
        first = {way: text for _, way, text in reversed(cells(shown))}
        measured = {way: each["seconds"] for way, each in kept[ways].items()}
        if ways == "ways" and "long" in kept:  # seconds by the number of throws, the fewest first
            measured = {way: next(iter(each.values())) for way, each in measured.items()}
        assert {way: in_seconds(first[way]) for way in measured} == pytest.approx(measured, rel=0.05)
    else:
        measured = [kept[each][key] for key in ("one submission alone, s", "all, s") for each in ("ours", "nbgrader")]
        took = [in_seconds(text) for what, _, text in cells(shown) if "submission" in what]
        assert took == pytest.approx(measured, rel=0.05)


@pytest.mark.parametrize(
    ("file", "before", "after", "anew"),
    [
        ("book/a.md", ":::{admonition} Source A, here: this", ":::{admonition} Source A, here: that", True),
        ("book/a.md", "a sentence", "another sentence", False),
        ("tests/test_a.py", "def test_a1_it_is_so(): ...", "def test_a1_it_is_not(): ...", True),
        ("tests/test_a.py", "def test_it_is_so(): ...", "def test_it_is_not(): ...", False),
        ("book/measured/a.json", "1", "2", True),
        ("book/data/a.csv", "1", "2", True),
    ],
)
def test_the_pages_are_run_anew_when_what_the_lists_are_made_of_changes(
    file, before, after, anew, tmp_path, monkeypatch
):
    spec = importlib.util.spec_from_file_location("fresh", BOOK / "_ext" / "fresh.py")
    fresh = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fresh)
    monkeypatch.setattr(fresh, "ROOT", tmp_path)
    path, found = tmp_path / file, []
    path.parent.mkdir(parents=True)
    for text in (before, after):
        path.write_text(text, "utf-8")
        found.append(fresh.fingerprint())
    assert (found[0] != found[1]) == anew
