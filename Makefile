# make run: analyse the seed four-bar into out/.   make test: run the fast tests.   make test-all: run all tests but long ones (make test-long).
# make docs: build the documents.   All install what is missing first.
# make matrix: build every supported system anew, and run the fast tests on each. SYSTEMS="sid wheels" takes some.
SHELL := /bin/bash
# The Python that Debian's dolfinx is built for, wherever another python3 stands first on the PATH.
SYSTEM_PYTHON ?= /usr/bin/python3
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
# What gmsh's wheel, the solver and the kernels in C++ need, and what VTK needs to draw without a screen.
APT := python3-dolfinx python3-slepc4py python3-scipy python3-h5py python3-venv python3-dev g++ \
       libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1
APT_VIEWS := libegl1 libgl1-mesa-dri
# What the wheels need where the system has apt: the same, and Python's headers for forms and kernels.
APT_WHEELS = $(filter lib%,$(APT)) g++ libc6-dev $(if $(WHEELS_PYTHON),,python3-venv python3-dev)
# Where dolfinx comes from: Debian's packages, or where there are none of 0.5 or later, wheels for Python 3.12 or later.
# A new Debian has no lists of packages yet. Debian testing has no dolfinx at times, and lists that tell of slepc4py alone.
ifndef STACK
STACK := $(shell { apt-cache show python3-dolfinx 2>/dev/null | grep -qE '^Version: 1:0\.([5-9]|1[0-9])' || \
    { grep -qx ID=debian /etc/os-release && ! apt-cache show python3-slepc4py 2>/dev/null | grep -q .; }; } \
    && echo debian || echo wheels)
endif
newest-python = for p in python3.14 python3.13 python3.12 python3; do \
	    $$p -c 'import sys, ensurepip; raise SystemExit(sys.version_info < (3, 12))' 2>/dev/null && echo $$p && break; done
PYTHON := .venv/bin/python
apt-missing = missing=$$(for p in $(1); do dpkg -s $$p >/dev/null 2>&1 || echo $$p; done); \
	if [ -n "$$missing" ]; then \
	    $(SUDO) apt-get update && $(SUDO) env DEBIAN_FRONTEND=noninteractive \
	        apt-get install -y --no-install-recommends $$missing; \
	fi

.PHONY: run test test-all test-long lint docs install clean matrix
run: .venv/solver
	$(PYTHON) -m fenics_mech run demos/four_bar.toml -o out

# One process a core: the tests of a file share what they analyse.
test: install lint
	$(PYTHON) -m pytest -n auto --dist loadfile -m "not slow"

test-all: install lint
	$(PYTHON) -m pytest -n auto --dist loadfile -m "not long"

test-long: install
	$(PYTHON) -m pytest -n auto --dist loadfile -m long

lint: install
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) -m mypy

docs: .venv/documented
	$(PYTHON) -m sphinx -W --keep-going -n -q -b html docs docs/_build/html

.venv/documented: .venv/installed
	$(PYTHON) -m pip install --quiet --editable '.[docs]'
	touch $@

install: .venv/installed

.venv/solver: pyproject.toml setup.py Makefile $(wildcard fenics_mech/_kernels/*.hpp) fenics_mech/_kernels/build.py
ifeq ($(STACK),debian)
	@$(call apt-missing,$(APT))
	$(SYSTEM_PYTHON) -m venv --clear --system-site-packages .venv
	$(PYTHON) -m pip install --quiet --editable .
else
	@! command -v apt-get >/dev/null || { $(call apt-missing,$(APT_WHEELS)); }
	@python=$(or $(WHEELS_PYTHON),$$($(newest-python))); [ -n "$$python" ] || \
	    { echo 'Neither Debian packages of dolfinx nor Python 3.12 or later are here.'; exit 1; }; \
	    $$python -m venv --clear .venv
	$(PYTHON) -m pip install --quiet --editable '.[solver]'
endif
	$(PYTHON) -c 'import gmsh, fenics_mech._fenicsx'
	touch $@

.venv/installed: .venv/solver
	@! command -v apt-get >/dev/null || { $(call apt-missing,$(APT_VIEWS)); }
	$(PYTHON) -m pip install --quiet --editable '.[test]'
	$(PYTHON) -c 'import vtk'
	touch $@

matrix:
	.ci/matrix $(SYSTEMS)

clean:
	rm -rf .venv out docs/_build docs/reference/generated

.PHONY: bench
bench: install
	$(PYTHON) -m pytest tests/benchmarks --benchmark-only -o addopts=
