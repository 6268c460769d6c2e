"""Run the pages anew when what they run or read has changed: neither Sphinx nor the execution cache looks at it."""

import hashlib
import re
import shutil
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.config import Config

ROOT = Path(__file__).parents[2]
CODE = ["mechlib/**/*.py", "autograder/**/*.py", "book/engine/*.*", "requirements.lock"]
DATA = ["book/data/*.csv", "book/measured/*.json", "tests/benchmarks/measured/*.json"]
LINES = {  # of pages and tests, what the page of errata reads
    "book/*.md": rb"^:::\{admonition\} Source .*",
    "tests/test_*.py": rb"^def test_[a-d]\d+_\w+",
}


def fingerprint() -> str:
    """Hash of all that a page may run or read; another hash, another page."""
    digest = hashlib.sha256()
    for pattern in (*CODE, *DATA, *LINES):
        for path in sorted(ROOT.glob(pattern)):
            said = path.read_bytes()
            if pattern in LINES:
                said = b"\n".join(re.findall(LINES[pattern], said, re.MULTILINE))
            digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + said + b"\0")
    return digest.hexdigest()[:16]


def key_the_cache(app: Sphinx, config: Config) -> None:
    cache = Path(config.nb_execution_cache_path or ROOT / "_build" / ".jupyter_cache")
    for stale in cache.glob("*"):
        if stale.name != config.code_fingerprint:
            shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    config.nb_execution_cache_path = str(cache / config.code_fingerprint)


def setup(app: Sphinx) -> dict:
    app.add_config_value("code_fingerprint", fingerprint(), rebuild="env")  # a new value: every page is read anew
    app.connect("config-inited", key_the_cache)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
