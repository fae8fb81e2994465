# Every command a person needs. `make` alone lists them.
PYTHON ?= python3
# or ros-kilted, in .venv-kilted: one or the other, for their wheels have the same names
ROS ?= ros
VENV := .venv$(ROS:ros%=%)
DEEP := .venv-deep
BIN := $(VENV)/bin
PIP := $(BIN)/pip --disable-pip-version-check --quiet
KILTED := sed /^ros-/d constraints.txt | cat - constraints-kilted.txt
INSTALL = $(if $(filter ros,$(ROS)),cat constraints.txt,$(KILTED)) | $(PIP) install --constraint /dev/stdin
# Each process collects all tests and starts fork servers of its own
WORKERS ?= $(shell nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)
PYTEST := $(BIN)/pytest -n $(WORKERS) --dist worksteal
REPORT ?= report.html
SITE ?=
SOLUTION := solutions/obstacle_avoidance/obstacle_avoidance_agent.py

.DEFAULT_GOAL := help
.PHONY: help setup grade test test-engine test-proof test-long test-all test-deep lint format prove conform wheel attacks site workspace lite ways assignments notebooks students bench profile skeletons goldens constraints clean

help: ## list the commands
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1\t\2/' | expand -t 22
	@$(PYTHON) .ci/budget.py 2>/dev/null || true

setup: $(VENV)/.course ## make .venv with the command `course`

grade: $(VENV)/.course ## set up, grade a reference solution, print the table, write report.html
	$(BIN)/course grade obstacle_avoidance $(SOLUTION) --field --report $(REPORT)

test: $(VENV)/.dev ## set up, run the tests but for those that take long
	$(PYTEST) -m "not long"

test-engine: $(VENV)/.dev ## run all tests of the engine, rclpy_virtual_time; make test has the quick ones
	$(PYTEST) rclpy_virtual_time/tests

test-long: $(VENV)/.dev ## run the tests that take long: attacks, browsers, DDS, nbgrader
	$(PYTEST) -m long

test-proof: $(VENV)/.dev ## each check meets a wrong solution, each reference the field checks
	$(PYTEST) -m long tests/grader/authoring/test_proof.py \
	  tests/exercises/ml_velocity/test_ml_velocity_expert.py -k "wrong_solution or reference or published"

test-all: test test-long ## test and test-long: before a release

test-deep: $(DEEP)/.deep ## make .venv-deep with PyTorch and Keras, run what needs them
	$(DEEP)/bin/pytest -m deep
	$(DEEP)/bin/python -m grader.authoring.proof model_formats

lint: $(VENV)/.dev ## ruff, mypy, who imports whom, generated files in step, the budget of lines
	$(BIN)/python .ci/budget.py
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/towncrier build --draft --version next
	$(BIN)/python -m grader.course.skeletons --check
	$(BIN)/python -m grader.authoring.tables --check
	$(BIN)/python -m grader.authoring.mutants --check
	$(BIN)/python -m grader.authoring.pitfalls --check
	$(BIN)/python -m grader.notebook.build --check

format: $(VENV)/.dev ## let ruff format and fix what it can
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

prove: $(VENV)/.dev ## grade all solutions, variants and mutants; print which check kills which
	$(BIN)/python -m grader.authoring.proof

# A checkout of ros2/rclpy at the tag of the installed wheels
RCLPY ?=
conform: $(VENV)/.dev ## is virtual time like time, and portable like real? RCLPY=…
	$(PIP) install --constraint constraints.txt 'ros-jazzy-test-msgs==2.0.3'
	$(BIN)/python -m rclpy_virtual_time.conform cpython
	$(if $(RCLPY),$(BIN)/python -m rclpy_virtual_time.conform rclpy $(RCLPY))
	$(BIN)/python -m grader.authoring.digests build/conform/real.json --all
	$(BIN)/python -m grader.authoring.digests build/conform/real.json --all --portable --compare
	COURSE_PORTABLE=full $(PYTEST) tests/portable

wheel: $(VENV)/.course ## build the wheel for every system into dist (docs/portable.md)
	$(PIP) wheel --no-deps --wheel-dir dist .

bench: $(VENV)/.dev ## measure; ratios against a peer in the same run
	$(BIN)/python benchmarks/peers.py
	@test ! -f build/site/_static/workspace/manifest.json || $(BIN)/python benchmarks/page.py

EXERCISES ?=
profile: $(VENV)/.dev ## CPU time of a grading of each reference; EXERCISES="obstacle_avoidance …" of some
	$(BIN)/python benchmarks/cpu.py $(EXERCISES)

attacks: $(VENV)/.dev ## every attack with all checks; what opens without each layer (docs/attacks.md)
	COURSE_ATTACKS=full $(PYTEST) tests/attacks rclpy_virtual_time/tests/host/test_kernel_filters.py rclpy_virtual_time/tests/host/test_landlock.py
	$(BIN)/python tests/attacks/layers.py --write

site: $(VENV)/.dev ## build the lesson as a site into build/site
	$(BIN)/sphinx-build -q -W --keep-going -n $(SITE) -b html -d build/doctrees lessons build/site
	$(BIN)/python -m grader.authoring.pitfalls build/site/pitfalls/replays
	$(BIN)/python -m grader.authoring.lesson_replays build/site/replays
	@test -f build/workspace/manifest.json || echo "built without the workspace: make workspace"
	@test -f build/lite/index.html || echo "built without notebooks in the browser: make lite"
	@echo "open build/site/index.html"

# With node and npm. A Python 3.12 compiles faster than the page's own: PYTHON312=python3.12
PYTHON312 ?=
workspace: $(VENV)/.dev ## fetch and build what runs exercises in the site's pages (docs/page.md)
	mkdir -p build/packages
	$(BIN)/python -m workspace.build build/workspace build/packages $(PYTHON312)

build/workspace/manifest.json: $(VENV)/.dev $(wildcard $(shell git ls-files \
  exercises grader rclpy_portable rclpy_virtual_time sim workspace 2>/dev/null))
	$(MAKE) workspace

lite: build/workspace/manifest.json ## the notebooks for the browser, with JupyterLite, on top of the workspace
	$(BIN)/python -m workspace.lite build/lite build/packages build/workspace

ways: $(VENV)/.dev ## run two other solutions of each exercise, for the page after full marks; minutes
	$(BIN)/python -m grader.authoring.ways build/ways

assignments: $(VENV)/.dev ## write the notebooks, solutions and all, into notebooks/source for nbgrader
	$(BIN)/python -m grader.notebook.build

notebooks: $(VENV)/.dev ## run every notebook, and the nbgrader course with seven students in all exercises
	COURSE_NOTEBOOKS=full $(PYTEST) tests/notebooks tests/journeys/test_n*.py \
	  tests/browser/test_jupyterlab.py tests/browser/test_formgrader.py

students: $(VENV)/.dev ## grade right solutions in the worlds of 200 students (up to two hours)
	COURSE_STUDENTS=200 $(PYTEST) tests/grader/authoring/test_fairness.py

skeletons: $(VENV)/.dev ## make anew what is generated and in git: skeletons, tables, pitfalls, ghosts
	$(BIN)/python -m grader.course.skeletons
	$(BIN)/python -m grader.authoring.tables
	$(BIN)/python -m grader.authoring.pitfalls --made
	$(BIN)/python -m grader.authoring.ghosts

# soupsieve 3 wants Python 3.11.5, and Debian 12 has 3.11.2
constraints: ## pin the newest versions that fit pyproject.toml
	$(PYTHON) -m pip install --dry-run --ignore-installed --quiet --report - '.[ros,ml,deep,cluster,desk,notebooks,foxglove,site,dev]' \
	  'soupsieve<3' \
	  | $(PYTHON) .ci/constraints.py > constraints.txt
	$(PYTHON) -m pip install --dry-run --ignore-installed --quiet --report - '.[ros-kilted]' \
	  | $(PYTHON) .ci/constraints.py ros- > constraints-kilted.txt

clean: ## remove what can be made again
	rm -rf $(VENV) $(DEEP) build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache report.html

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' \
	  || { echo "expected Python 3.11 - 3.14, but $(PYTHON) is $$($(PYTHON) -V 2>&1);" \
	    "try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.course: $(VENV)/bin/python pyproject.toml constraints.txt
	$(INSTALL) --editable '.[$(ROS)]'
	touch $@

$(VENV)/.dev: $(VENV)/.course
	$(INSTALL) --editable '.[$(ROS),ml,cluster,desk,notebooks,foxglove,site,dev]'
	touch $@

# PyTorch from the index of packages comes with CUDA, gigabytes of it. For its CPU build:
# PIP_EXTRA_INDEX_URL=https://download.pytorch.org/whl/cpu make test-deep
$(DEEP)/.deep: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(DEEP)
	$(DEEP)/bin/pip --disable-pip-version-check --quiet install --constraint constraints.txt \
	  --editable '.[ros,ml,deep,dev]'
	touch $@
