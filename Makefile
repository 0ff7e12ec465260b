# Every target does its own set-up: a virtual environment in .venv, made again when pyproject.toml or constraints.txt changed.
# Needs Python 3.11 or newer and make. Another interpreter: make test PYTHON=/path/to/python3.12

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-input -c constraints.txt
PINS := pyproject.toml constraints.txt
DEMO := out/matrix-liquid

.DEFAULT_GOAL := help
.PHONY: help demo test check docs bench clean

help:
	@echo "make demo    plan the example matrix-liquid and write its folder to $(DEMO)"
	@echo "make test    run the whole test suite"
	@echo "make check   linter, formatting, types, import rules"
	@echo "make docs    build the documentation, plans and pictures included, to docs/_build/html"
	@echo "make bench   measure planning times against the published transcription (half an hour)"
	@echo "make clean   remove the virtual environment and everything generated"

demo: $(VENV)/.ready-test
	$(BIN)/nospill plan matrix-liquid -o $(DEMO)
	@echo "pictures: $(CURDIR)/$(DEMO)/figures"

test: $(VENV)/.ready-test
	$(BIN)/python -m pytest -n 2 --dist loadfile

check: $(VENV)/.ready-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports --no-logo

docs: $(VENV)/.ready-docs
	$(BIN)/python -m sphinx -q -b html -W --keep-going -n -d docs/_build/doctrees docs docs/_build/html
	@echo "documentation: $(CURDIR)/docs/_build/html/index.html"

bench: $(VENV)/.ready-test
	$(BIN)/python -m benchmarks.planning.run

# The stamps are written last, so a set-up that was cut short is done again.
$(VENV)/.ready-test: $(PINS)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "nospill needs Python 3.11 or newer; name one with: make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@echo "setting up $(VENV)"
	@$(BIN)/python -c '' 2>/dev/null || $(PYTHON) -m venv --clear $(VENV)
	@$(PIP) -e ".[test]"
	@touch $@

$(VENV)/.ready-dev: $(VENV)/.ready-test
	@$(PIP) -e ".[test,dev]"
	@touch $@

$(VENV)/.ready-docs: $(VENV)/.ready-test
	@$(PIP) -e ".[test,docs]"
	@touch $@

clean:
	rm -rf docs/_build docs/_generated docs/gallery/[0-9]* docs/notebooks/pictures
	find docs/notebooks -name '*.md' ! -name index.md -delete
	rm -rf $(VENV) build dist out src/nospill.egg-info .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +
