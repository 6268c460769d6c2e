# The course on one computer. `make` alone says what there is. GNU Make 3.81 (macOS) is enough.

PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/.installed

# $(call step,name,command): say what begins, and on failure which step it was.
step = @printf '\n== %s: %s\n' '$@' '$(1)'; $(2) || { printf '\n== %s stopped at: %s\n' '$@' '$(1)' >&2; exit 1; }

.PHONY: help environment course test proofs benchmarks lock clean system
.NOTPARALLEL:

help:
	@echo 'make course       install, release the exercises, build the book, grade the sample cohort'
	@echo 'make test         every test: style, exercises up to date, book, notebooks, pytest'
	@echo 'make proofs       the long proofs'
	@echo 'make benchmarks   speed and memory: the grader beside nbgrader, 300 students, both mechanisms'
	@echo 'make environment  only .venv, from requirements.lock'
	@echo 'make lock         requirements.lock anew, from pyproject.toml'
	@echo 'make clean        remove what was built'
	@echo
	@echo 'Another Python: PYTHON=python3.12 make course'

environment: $(INSTALLED)

$(BIN)/python:
	@version=$$($(PYTHON) -c 'import sys; print("%d.%d.%d" % sys.version_info[:3])' 2>/dev/null) || { \
	    echo '$(PYTHON) does not run. Install Python 3.11 or later, or name one: PYTHON=python3.12 make course' >&2; exit 1; }; \
	case $$version in \
	    3.1[1-9].*|3.[2-9][0-9].*) ;; \
	    *) echo "Python 3.11 or later is needed, $(PYTHON) is $$version. Name another: PYTHON=python3.12 make course" >&2; exit 1;; \
	esac; \
	$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	    echo "Python $$version has no venv module. Type: sudo apt install python3-venv" >&2; exit 1; }; \
	echo "== .venv: Python $$version"; \
	$(PYTHON) -m venv --clear .venv || { rm -rf .venv; exit 1; }

$(INSTALLED): $(BIN)/python requirements.lock pyproject.toml
	$(call step,packages,$(BIN)/python -m pip install --no-input --no-deps -r requirements.lock)
	$(call step,the course itself,$(BIN)/python -m pip install --no-input --no-deps --no-build-isolation -e .)
	@# Matplotlib lists the fonts once and says so on stderr, which in a page of the book would be an error.
	$(call step,fonts,$(BIN)/python -c 'import matplotlib.font_manager')
	@touch $@

course: environment
	$(call step,release,$(BIN)/autograder release)
	$(call step,book,$(BIN)/jupyter-book build book -W -n --keep-going)
	$(call step,sample cohort,$(BIN)/autograder grade tests/cohort/submissions --out _build/cohort --salt tests/cohort/salt --isolation none -j 2)
	@echo 'Book: $(CURDIR)/_build/html/index.html'

test: environment system
	$(call step,style,$(BIN)/ruff check)
	$(call step,layout,$(BIN)/ruff format --check)
	$(call step,exercises up to date,$(BIN)/autograder release --check)
	@# the book is built on one core, and the notebooks run on the others
	$(call step,book and notebooks,{ $(BIN)/jupyter-book build book -W -n --keep-going & book=$$!; \
	    $(BIN)/pytest --nbval-lax -n auto --dist loadfile solutions exercises; notebooks=$$?; \
	    wait $$book && [ $$notebooks = 0 ]; })
	$(call step,pytest,$(BIN)/pytest -n auto --dist worksteal)

proofs: environment system
	@printf '\n== proofs\n'; $(BIN)/pytest -m proof -rP -n auto --dist worksteal tests; code=$$?; \
	if [ $$code -eq 5 ]; then echo 'no proofs yet'; else exit $$code; fi

benchmarks: environment system
	$(call step,side by side with nbgrader,$(BIN)/python tests/benchmarks/against_nbgrader.py)
	$(call step,300 students,$(BIN)/python tests/benchmarks/cohort_of_300.py)
	$(call step,a mechanism along its motion,$(BIN)/python tests/benchmarks/sweeps.py)
	$(call step,dynamics beside loops and an engine,$(BIN)/python tests/benchmarks/wiper.py)
	$(call step,throws beside a loop and plain NumPy,$(BIN)/python tests/benchmarks/fourbar.py)

system:
	@sh .ci/packages

lock: environment
	$(call step,lock,$(BIN)/uv pip compile --universal --python-version 3.11 --all-extras --upgrade --no-emit-index-url \
	    --no-header --no-annotate --output-file requirements.lock pyproject.toml)

clean:
	rm -rf _build
