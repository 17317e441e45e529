# Everything sets itself up in .venv; it is set up again only when the two files below change.
NEEDS := pyproject.toml constraints.txt
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet install -c constraints.txt

# Pythons without a wheel of PyBullet, the newest first; and what depends on Python and the engine.
NEWER := $(foreach v,3.13 3.12,python$(v) $(wildcard $(HOME)/.pyenv/versions/$(v).*/bin/python$(v)))
NEUTRAL := tests/simulate tests/servos tests/metrics tests/search/test_command.py \
  $(addprefix tests/test_,cli.py cli_mistakes.py dispatch.py engine_choice.py executors.py \
  experiment.py missing_engine.py own_code.py plan.py plugins.py run.py store.py systems.py)

# Tests start hundreds of processes, none of which should compile the program anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test test-all test-neutral lint types format schemas reports benchmark clean
.DEFAULT_GOAL := run

run: $(VENV)/installed  ## simulate the quick experiment and write its report
	@$(BIN)/gaitlab run eros_quick
	@$(BIN)/gaitlab report eros_quick

test: $(VENV)/installed-dev  ## run the tests, but for the long proofs
	@$(BIN)/python -m pytest -n auto --dist worksteal -m "not long" $(TESTS)

test-all: $(VENV)/installed-dev  ## run all tests
	@$(BIN)/python -m pytest -n auto --dist worksteal

test-neutral:  ## run what depends on it without PyBullet, on the newest Python
	@for python in $(NEWER); do \
	  if "$$python" -c 'import venv' 2>/dev/null; then \
	    exec $(MAKE) --no-print-directory VENV=.venv-newer PYTHON="$$python" \
	      TESTS="$(NEUTRAL)" test; \
	  fi; \
	done; \
	echo "test-neutral: no Python 3.13 or 3.12 here, so nothing is run without PyBullet" >&2

lint: $(VENV)/installed-dev  ## style of the code
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

types: $(VENV)/installed-dev  ## types of the code
	@$(BIN)/mypy

format: $(VENV)/installed-dev  ## put the style right
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

schemas: $(VENV)/installed  ## write the schemas of the files anew, which editors use
	@for kind in experiment surface servo robot; do \
	  $(BIN)/gaitlab schema $$kind --output docs/schema/$$kind.json >/dev/null || exit; \
	done

reports: $(VENV)/installed  ## make the published reports again, in some two hours
	@$(BIN)/gaitlab run eros_quick && $(BIN)/gaitlab report eros_quick
	@for name in reproduction confirmed pitch_confirmed; do $(BIN)/gaitlab run eros_$$name || exit; done; \
	  $(BIN)/gaitlab report eros_reproduction
	@for name in all_robots all_robots_walk; do $(BIN)/gaitlab run $$name --engine mujoco || exit; done; \
	  $(BIN)/gaitlab report all_robots all_robots_walk --engine mujoco --output reports/all_robots
	@for name in eros_push eros_slope; do \
	  $(BIN)/gaitlab run $$name && $(BIN)/gaitlab report $$name || exit; \
	done
	@for name in bending_height frontal_shift step_length period confirmed; do \
	  $(BIN)/gaitlab run nao_$$name || exit; \
	done
	@for paper in eros flow biped nao bioloid; do $(BIN)/gaitlab audit $$paper || exit; done

benchmark: $(VENV)/installed-dev  ## measure speed and size on this machine
	@for file in benchmarks/*.py; do echo "== $$file"; $(BIN)/python "$$file" || exit 1; done

clean:  ## remove what this file has set up; results and reports stay
	rm -rf .venv .venv-newer .pytest_cache .hypothesis .mypy_cache .ruff_cache

$(VENV)/installed: $(NEEDS) | $(VENV)/bin/python
	@echo "installing gaitlab into $(VENV), once" >&2
	@$(PIP) hatchling editables
	@$(PIP) --no-build-isolation -e '.[mujoco]'
	@touch $@

$(VENV)/installed-dev: $(NEEDS) | $(VENV)/bin/python
	@echo "installing gaitlab and its development tools into $(VENV), once" >&2
	@$(PIP) hatchling editables
	@$(PIP) --no-build-isolation -e '.[dev]'
	@touch $(VENV)/installed $@

$(VENV)/bin/python:
	@for python in $(PYTHON) python3.11 python3; do \
	  if "$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
	    exec "$$python" -m venv $(VENV); \
	  fi; \
	done; \
	echo "Python 3.11 or newer is needed, 3.11 best. Install it, or name it: make PYTHON=/path/to/python3.11" >&2; \
	exit 1
