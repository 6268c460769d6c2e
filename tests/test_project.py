"""What the project says of itself is true: commands, lock, licence, and the sentences when something is missing."""

import re
import shutil
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

import pytest
import yaml
from hypothesis import settings
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))["project"]

needs_make = pytest.mark.skipif(shutil.which("make") is None, reason="make: not on this computer")


def make(*arguments, cwd=ROOT):
    return subprocess.run(["make", *arguments], cwd=cwd, capture_output=True, text=True, stdin=subprocess.DEVNULL)


@needs_make
def test_make_alone_names_every_target():
    listed = set(re.findall(r"^make (\w+)", make().stdout, re.MULTILINE))
    phony = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(encoding="utf8"), re.MULTILINE).group(1)
    assert listed == set(phony.split()) - {"help", "system"}


@needs_make
@pytest.mark.parametrize(
    ("python", "says"),
    [
        ("exit 127", "Install Python 3.11 or later"),
        ("echo 3.10.12", "Python 3.11 or later is needed, ./python is 3.10.12"),
        ("case $2 in *ensurepip*) exit 1;; *) echo 3.12.4;; esac", "sudo apt install python3-venv"),
    ],
    ids=["absent", "too old", "without venv"],
)
def test_a_missing_python_gets_one_sentence_that_says_what_to_type(tmp_path, python, says):
    shutil.copy(ROOT / "Makefile", tmp_path)
    for name in ("requirements.lock", "pyproject.toml"):
        (tmp_path / name).touch()
    fake = tmp_path / "python"
    fake.write_text(f"#!/bin/sh\n{python}\n")
    fake.chmod(0o755)

    done = make("course", "PYTHON=./python", cwd=tmp_path)

    sentence, *rest = done.stderr.splitlines()
    assert done.returncode != 0
    assert says in sentence
    assert all(line.startswith("make") for line in rest)


@needs_make
def test_a_failing_step_is_named(tmp_path):
    makefile = (ROOT / "Makefile").read_text(encoding="utf8")
    (tmp_path / "Makefile").write_text(makefile + "\nfails:\n\t$(call step,the third step,false)\n")
    done = make("fails", cwd=tmp_path)
    assert done.returncode != 0
    assert "fails stopped at: the third step" in done.stderr


def test_the_lock_satisfies_every_requirement():
    requirements = map(Requirement, chain(PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()))
    locked = {}
    for pin in map(Requirement, (ROOT / "requirements.lock").read_text(encoding="utf8").splitlines()):
        locked.setdefault(pin.name.lower(), []).append(next(iter(pin.specifier)).version)
    wrong = [
        str(needed)
        for needed in requirements
        if needed.name != PROJECT["name"]
        and not all(map(needed.specifier.contains, locked.get(needed.name.lower(), ["0"])))
    ]
    assert wrong == []


def test_the_citation_and_the_licence_are_those_of_the_project():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf8"))
    licence = (ROOT / "LICENSE").read_text(encoding="utf8")
    assert citation["version"] == PROJECT["version"]
    assert PROJECT["license"] == " AND ".join(citation["license"])
    assert "Redistribution and use in source and binary forms" in licence
    assert "Creative Commons Attribution 4.0 International" in licence


def test_the_readme_names_only_commands_that_exist():
    readme = (ROOT / "README.md").read_text(encoding="utf8")
    targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf8"), re.MULTILINE)
    assert set(re.findall(r"\bmake ([a-z]+)", readme)) <= set(targets)
    autograder = Path(sys.executable).with_name("autograder")
    helped = subprocess.run([autograder, "--help"], capture_output=True, text=True, check=True).stdout
    for command in set(re.findall(r"\bautograder ([a-z]+)", readme)):
        assert re.search(rf"\b{command}\b", helped), command


@pytest.mark.parametrize(
    ("reason", "ci", "code"),
    [
        ("browser: none here", "true", pytest.ExitCode.TESTS_FAILED),
        ("isolation level namespaces: not here", "true", pytest.ExitCode.TESTS_FAILED),
        ("isolation level namespaces: not here", "", pytest.ExitCode.OK),
        ("only on Windows", "true", pytest.ExitCode.OK),
    ],
)
def test_a_skip_is_named_last_and_fails_ci_if_an_installation_would_mend_it(pytester, monkeypatch, reason, ci, code):
    monkeypatch.setenv("CI", ci)
    pytester.makeconftest((ROOT / "tests" / "conftest.py").read_text(encoding="utf8"))
    pytester.makepyfile(f"import pytest\n\n@pytest.mark.skip(reason={reason!r})\ndef test_one():\n    pass\n")
    profile = settings.get_current_profile_name()
    done = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    settings.load_profile(profile)  # the inner run shares our process, and has loaded its own
    assert done.ret == code
    done.stdout.fnmatch_lines(["* not run *", f"*test_one: {reason}*"])
