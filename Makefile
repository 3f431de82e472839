# A thin layer over venv and pip: nothing has to be installed before `make`.
PYTHON ?= python3
VENV   ?= .venv
BIN     = $(VENV)/bin

.PHONY: install dev demo test processors lint docs fuzz kernels clean

# Editable: in the top folder of a checkout Python finds the folder cncgen before an installed copy, and what is built must be there.
# Python compiles a module when it is first imported: doing so with all of scipy beforehand took longer than the demo.
$(BIN)/cncgen: pyproject.toml setup.py $(wildcard cncgen/kernels/*.py)
	$(PYTHON) -m venv $(VENV)
	PIP_NO_COMPILE=1 $(BIN)/python -m pip install --quiet --editable .
	@touch $@

install: $(BIN)/cncgen

# The main job: plan a NURBS part, stream it into the servo simulation, judge the setpoints.
demo: install
	mkdir -p out
	$(BIN)/cncgen plan programs/butterfly.nc -m xy-table -o out/butterfly.csv
	$(BIN)/cncgen simulate out/butterfly.csv --axis-params xy-table -o out/response.csv
	$(BIN)/cncgen verify out/butterfly.csv --program programs/butterfly.nc --machine xy-table

# Modules of a checkout are compiled here, as pip does those of a wheel: where PYTHONDONTWRITEBYTECODE is set, each run did it anew.
$(VENV)/.dev: pyproject.toml setup.py $(wildcard cncgen/kernels/*.py)
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	$(BIN)/python -m compileall -q cncgen
	@touch $@

dev: $(VENV)/.dev

test: dev
	$(BIN)/python -m pytest -n 2 -q

# The rooms that multiply and decompose matrices, as other processors run them; plans are compared bit by bit in the tests.
# Of STEP-NC the frames and curves, which are such products: clearing features is shapely's arithmetic, the same on each
# processor, and two thirds of the time. The papers run the axes that tests/servo tests; of reports, identification alone solves
# for anything.
processors: dev
	$(BIN)/python -m tests.processors tests/geometry tests/servo tests/report/test_identified.py tests/verify \
		tests/stepnc/test_curves.py tests/stepnc/test_kinematics.py tests/stepnc/test_nist_explicit.py \
		tests/stepnc/test_ap238.py tests/stepnc/test_iso14649.py

# The site, without warnings, into out/site.
docs: dev
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/site

lint: dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Changed inputs at every door, fresh ones each time: a minute, or as long as SECONDS says. What tests/doors_open has is known;
# a new kind fails, unless FUZZ=--tell, and is kept.
fuzz: dev
	$(BIN)/python -m trials.doors --seconds $(or $(SECONDS),60) --open tests/doors_open --keep out/found $(FUZZ)

# After an edit of a kernel in a checkout.
kernels:
	flock .kernels.lock $(BIN)/python setup.py --quiet build_ext --inplace

clean:
	rm -rf build dist out *.egg-info cncgen/kernels/*.c cncgen/kernels/*.so
