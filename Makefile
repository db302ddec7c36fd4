# make run: analyse the seed four-bar into out/.   make test: run the fast tests.   make test-all: run all tests.
# make docs: build the documents.   All install what is missing first.
SHELL := /bin/bash
# The Python that Debian's dolfinx is built for, wherever another python3 stands first on the PATH.
SYSTEM_PYTHON ?= /usr/bin/python3
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
APT := python3-dolfinx python3-slepc4py python3-scipy python3-h5py python3-venv \
       libegl1 libgl1 libgl1-mesa-dri libglu1-mesa libxcursor1 libxft2 libxinerama1
PYTHON := .venv/bin/python

.PHONY: run test test-all lint docs install clean
run: install
	$(PYTHON) -m fenics_mech run demos/four_bar.toml -o out

# One process a core: the tests of a file share what they analyse.
test: install lint
	$(PYTHON) -m pytest -n auto --dist loadfile -m "not slow"

test-all: install lint
	$(PYTHON) -m pytest -n auto --dist loadfile

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

.venv/installed: pyproject.toml Makefile
	@missing=$$(for p in $(APT); do dpkg -s $$p >/dev/null 2>&1 || echo $$p; done); \
	if [ -n "$$missing" ]; then \
	    $(SUDO) apt-get update && $(SUDO) env DEBIAN_FRONTEND=noninteractive \
	        apt-get install -y --no-install-recommends $$missing; \
	fi
	$(SYSTEM_PYTHON) -m venv --clear --system-site-packages .venv
	$(PYTHON) -m pip install --quiet --editable '.[test]'
	$(PYTHON) -c 'import dolfinx, gmsh, slepc4py, vtk'
	touch $@

clean:
	rm -rf .venv out docs/_build docs/reference/generated

.PHONY: bench
bench: install
	$(PYTHON) -m pytest tests/benchmarks --benchmark-only -o addopts=
