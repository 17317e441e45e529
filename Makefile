# Everything sets itself up in .venv; it is set up again only when the two files below change.
NEEDS := pyproject.toml constraints.txt
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet install -c constraints.txt

.PHONY: run test test-all lint types format reports benchmark clean
.DEFAULT_GOAL := run

run: .venv/installed  ## simulate the quick experiment and write its report
	@$(BIN)/gaitlab run eros_quick
	@$(BIN)/gaitlab report eros_quick

test: .venv/installed-dev  ## run the tests, but for the long proofs
	@$(BIN)/python -m pytest -n auto --dist worksteal -m "not long"

test-all: .venv/installed-dev  ## run all tests
	@$(BIN)/python -m pytest -n auto --dist worksteal

lint: .venv/installed-dev  ## style of the code
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

types: .venv/installed-dev  ## types of the code
	@$(BIN)/mypy

format: .venv/installed-dev  ## put the style right
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

reports: .venv/installed  ## make the published reports again, in about an hour
	@$(BIN)/gaitlab run eros_quick && $(BIN)/gaitlab report eros_quick
	@$(BIN)/gaitlab run eros_table7 && $(BIN)/gaitlab run eros_table8
	@$(BIN)/gaitlab report eros_table7 eros_table8
	@for paper in eros flow biped nao bioloid; do $(BIN)/gaitlab audit $$paper || exit; done

benchmark: .venv/installed-dev  ## measure speed and size on this machine
	@for file in benchmarks/*.py; do echo "== $$file"; $(BIN)/python "$$file" || exit 1; done

clean:  ## remove what this file has set up; results and reports stay
	rm -rf .venv .pytest_cache .hypothesis .mypy_cache .ruff_cache

.venv/installed: $(NEEDS) | .venv/bin/python
	@echo "installing gaitlab into .venv, once" >&2
	@$(PIP) hatchling editables
	@$(PIP) --no-build-isolation -e .
	@touch $@

.venv/installed-dev: $(NEEDS) | .venv/bin/python
	@echo "installing gaitlab and its development tools into .venv, once" >&2
	@$(PIP) hatchling editables
	@$(PIP) --no-build-isolation -e '.[dev]'
	@touch .venv/installed $@

.venv/bin/python:
	@for python in $(PYTHON) python3.11 python3; do \
	  if "$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
	    exec "$$python" -m venv .venv; \
	  fi; \
	done; \
	echo "Python 3.11 or newer is needed, 3.11 best. Install it, or name it: make PYTHON=/path/to/python3.11" >&2; \
	exit 1
