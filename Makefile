# Everything happens in .venv; no other state outside the repository is touched.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

.PHONY: help hand test test-slow lint format bench validate calibrate pictures profiles clean
.DEFAULT_GOAL := help

help:  ## show this list
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "handgen needs Python 3.11 or newer; name one with: make PYTHON=python3.12 ..." >&2; exit 2; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { \
	  echo "Python's venv is missing; on Debian: apt install python3-venv" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

hand: $(READY)  ## build params/adult.yaml into outputs/adult/
	$(BIN)/handgen build params/adult.yaml

test: $(READY)  ## run the tests, two files at a time
	$(BIN)/python -m pytest -n 2 --dist loadfile

test-slow: $(READY)  ## run the long studies (hundreds of random hands, kills at random moments)
	$(BIN)/python -m pytest -m slow

lint: $(READY)  ## style and the one-way data flow
	$(BIN)/ruff check .
	$(BIN)/lint-imports

format: $(READY)  ## mend what style can mend by itself
	$(BIN)/ruff check --fix .

bench: $(READY)  ## time build, rules and bend (prints tables)
	$(BIN)/python -m tests.benchmarks.build
	$(BIN)/python -m tests.benchmarks.rules
	$(BIN)/python -m tests.benchmarks.bend times first factorisers

validate: $(READY)  ## bend what the source measured, with every model file; renews the README's figure
	-$(BIN)/handgen validate  # the source's own model, without friction, does not reach 80 kPa: exit 3
	cp outputs/coimbra_index/validation.png docs/

calibrate: $(READY)  ## fit params/models/calibrated.yaml anew (minutes)
	$(BIN)/python -m handgen.bending.calibration

profiles: $(READY)  ## write slicer_profiles/ anew from params/adult.yaml (needs Cura's definitions)
	$(BIN)/handgen profiles params/adult.yaml

pictures: hand  ## renew the README's pictures: build, check, bend and report the shipped hands (needs Chromium)
	cp $(foreach p,hand_palm hand_dorsum hand_side actuators tooling_index,outputs/adult/previews/$(p).png) docs/
	-$(BIN)/handgen check params/thesis_hand.yaml --quiet  # it fails, as it should
	cp outputs/thesis_hand/checks/previews/*_thumb.palm-stiffness_*.png docs/finding.png
	$(BIN)/handgen bend params/adult.yaml --quiet
	cp outputs/adult/bend/index_assembly/curl.png docs/
	-$(BIN)/handgen diagnose params/measurements/coimbra_index.yaml --model thesis --quiet  # it disagrees
	cp outputs/coimbra_index/diagnosis_curves.png docs/diagnosis.png
	$(BIN)/handgen report params/adult.yaml --quiet
	$(BIN)/python -m tests.report_picture outputs/adult/report.html docs/report.png

clean:  ## remove .venv and caches; outputs/ stays
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis .import_linter_cache *.egg-info
