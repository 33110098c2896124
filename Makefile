# `make run`, `make check` and `make test` do all the set-up: they need Python 3.11 or later, make and git.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := run
.PHONY: run check test lint types contracts unit kernels packages study bench tables figures

VENV := .venv
BIN := $(VENV)/bin
CONTRIB := .venv-contrib
TEST_PATH := tests:tests/kit/cameras:tests/kit/clients:tests/kit/comparisons:tests/kit/inputs:tests/kit/pictures:tests/kit/stations  # as pytest's in pyproject.toml
COVERED := --cov --cov-append --cov-report=
IN_TWO_PROCESSES := --numprocesses=2 --dist=loadfile
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

run: $(VENV)/installed
	$(BIN)/hotgauge run

# what a change should pass before it is committed: everything but the tests of the running appliance and of accuracy
check: $(VENV)/installed-dev
	@$(MAKE) --no-print-directory --jobs=2 lint contracts unit types

# tests that compute in two processes first, those that mostly wait after them (one that fails beside another counts as it ends alone), and last those that need the computer for themselves
test: packages $(VENV)/installed-systemd $(CONTRIB)/installed lint types contracts kernels
	rm -f .coverage .coverage.*
	$(BIN)/python -m pytest --cov --cov-report= --durations=20 -m "not alone and not waiting" $(IN_TWO_PROCESSES)
	$(BIN)/python -m pytest $(COVERED) --durations=20 -m waiting $(IN_TWO_PROCESSES) || $(BIN)/python -m pytest $(COVERED) -m waiting --last-failed --last-failed-no-failures=none
	$(BIN)/python -m pytest --cov --cov-append --cov-fail-under=91 --durations=20 -m alone

unit: kernels
	$(BIN)/python -m pytest tests/unit tests/docs $(IN_TWO_PROCESSES)

# compiled once, so that two processes of tests do not both do it
kernels: $(VENV)/installed-dev
	$(BIN)/python -m appliance.service.compiled_code

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/installed-dev
	PYRIGHT_PYTHON_IGNORE_WARNINGS=1 $(BIN)/pyright

contracts: $(VENV)/installed-dev
	$(BIN)/lint-imports --no-logo

# long statistics, written to docs/studies; `make test` runs a sample of them again
study: $(VENV)/installed-dev
	PYTHONPATH=$(TEST_PATH) $(BIN)/python -m studies

bench: $(VENV)/installed-dev $(CONTRIB)/installed
	PYTHONPATH=$(TEST_PATH) $(BIN)/python benchmarks/pair.py
	PYTHONPATH=$(TEST_PATH) $(BIN)/python benchmarks

figures: $(VENV)/installed-dev
	$(BIN)/python docs/figures

tables: $(VENV)/installed-dev
	$(BIN)/python docs/tables
	$(BIN)/python docs/studies

# mbpoll, libmodbus and two packages of npm are Modbus clients that nobody here wrote; the tests read the appliance with
# them. They also build systemd-python, have systemd check the unit, and boot it in a container. GStreamer's RTSP server and Aravis' fake
# camera are the network cameras of the tests; PyGObject is built to speak to both. Reports need Pango, and their tests
# look at their pages; the page for people is driven in Chromium. Mosquitto is the broker of the tests, and Prometheus'
# promtool tries the alert rules
DEBIAN_PACKAGES := mbpoll libmodbus5 $(if $(shell command -v npm),,npm) libsystemd-dev pkg-config gcc systemd systemd-container \
	gir1.2-gst-rtsp-server-1.0 gstreamer1.0-plugins-base gstreamer1.0-plugins-good gstreamer1.0-plugins-bad \
	gstreamer1.0-plugins-ugly gir1.2-aravis-0.8 aravis-tools libgirepository1.0-dev libcairo2-dev \
	libpangoft2-1.0-0 libharfbuzz-subset0 poppler-utils chromium mosquitto mosquitto-clients prometheus
packages:
	@if dpkg-query -W $(DEBIAN_PACKAGES) > /dev/null 2>&1; then exit 0; fi; \
	if [ "$$(id -u)" = 0 ]; then as_root=(); \
	elif sudo -n true 2> /dev/null; then as_root=(sudo -n); \
	else echo "make test: the tests need Debian packages; as root: apt-get install $(DEBIAN_PACKAGES)" >&2; exit 1; fi; \
	"$${as_root[@]}" apt-get update -qq; \
	"$${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y $(DEBIAN_PACKAGES) > /dev/null

$(VENV)/installed: $(BIN)/python pyproject.toml constraints.txt
	$(PIP_INSTALL) -e '.[page,plots]'  # README's examples draw, and people look
	$(BIN)/python -m appliance.service.compiled_code
	@touch $@

$(VENV)/installed-dev: $(BIN)/python pyproject.toml constraints.txt
	$(PIP_INSTALL) -e '.[dev]'
	@touch $@ $(VENV)/installed

$(VENV)/installed-systemd: $(VENV)/installed-dev | packages
	$(PIP_INSTALL) -e '.[systemd,genicam]'
	@touch $@

# OpenCV's own structured forest is in the contrib wheel, which must never share an environment with the plain one
$(CONTRIB)/installed: $(BIN)/python constraints-contrib.txt
	$(BIN)/python -m venv $(CONTRIB)
	$(CONTRIB)/bin/python -m pip install --quiet --disable-pip-version-check -r constraints-contrib.txt
	@touch $@

$(BIN)/python:
	@for python in python3 python3.11 python3.12 python3.13; do \
		if "$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2> /dev/null; then \
			"$$python" -m venv $(VENV) || { rm -rf $(VENV); exit 1; }; exit 0; \
		fi; \
	done; \
	echo "make: no Python 3.11 or later is on the path; install it, on Debian: apt-get install python3 python3-venv" >&2; exit 1
