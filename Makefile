# `make report` sets up everything and makes the reports; `make test` sets up everything and passes the tests.
SHELL := /bin/bash
# Settings of the environment that change how Python starts or how OpenBLAS and NumPy compute: every machine runs the same.
# Byte code makes every later start several times faster.
unexport PYTHONDONTWRITEBYTECODE PYTHONUNBUFFERED PYTHONPATH PYTHONHOME PYTHONSTARTUP PYTHONWARNINGS PYTHONHASHSEED \
  PYTHONOPTIMIZE OPENBLAS_CORETYPE OPENBLAS_L2_SIZE OPENBLAS_NUM_THREADS OPENBLAS_VERBOSE NPY_DISABLE_CPU_FEATURES \
  NPY_ENABLE_CPU_FEATURES
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PEERS := .venv-bench
FUZZ := .venv-fuzz
DOCS := .venv-docs
SECONDS_EACH ?= 120
MUTANTS ?= 400
# Share of the tests that are marked long (`.ci/run` takes them all, LONG=1); of the numerical ones, and of the long ones
# among them, under other arithmetics.
LONG ?= 0.05
PART ?= 0.05
PART_LONG ?= 0.02
PART_SEED ?= 1
KERNEL_PART ?= 1
KERNEL_LONG ?= 1
BENCHMARKS := $(filter-out %/side_by_side.py,$(wildcard benchmarks/*.py))
CAMPAIGN ?=
NAMES := $(if $(CAMPAIGN),$(CAMPAIGN),$(patsubst campaigns/%/campaign.yaml,%,$(wildcard campaigns/*/campaign.yaml)))

.DEFAULT_GOAL := help
.PHONY: help setup report check-pdf test test-all kernels lint format types unit part coverage study bench fuzz mutants docs \
  site release lock clean

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | sort | expand -t 12

$(READY): requirements.lock pyproject.toml scripts/setup.sh
	@bash scripts/setup.sh $(VENV) requirements.lock
	@touch $@

setup: $(READY) ## prepare the environment from the locked requirements

report: $(READY) ## make every campaign's report, or one: make report CAMPAIGN=tapes
	@$(BIN)/metrology $(if $(CAMPAIGN),report campaigns/$(CAMPAIGN)/campaign.yaml,batch campaigns)

check-pdf: $(READY) ## check every report against PDF/A-3a and PDF/UA-1, before and after signing (skipped without a JRE)
	@$(BIN)/python scripts/check_pdf.py; status=$$?; if [ $$status -ne 77 ]; then $(MAKE) -s report && \
	  $(BIN)/python scripts/check_pdf.py --signed $(foreach name,$(NAMES),reports/$(name)); fi

test: lint types unit part ## lint, type-check and test, a seeded part of it under two other arithmetics

test-all: $(READY) ## install Chromium, Java and SoftHSM (Debian, as root), and test without skipping anything
	@bash scripts/test_all.sh
	@$(MAKE) -s lint types
	@METROLOGY_TEST_ALL=1 $(MAKE) -s unit LONG=1

# KERNEL_PART=0.2 KERNEL_LONG=0.1 CAMPAIGN=tapes: a seeded part of the tests, and one campaign.
kernels: $(READY) ## the numerical tests and every campaign under each arithmetic of OpenBLAS and NumPy that this processor has
	@$(BIN)/python scripts/kernels.py list
	@$(BIN)/python scripts/kernels.py test --others -- --part $(KERNEL_PART) --long $(KERNEL_LONG) --part-seed $(PART_SEED)
	@$(BIN)/python scripts/kernels.py campaigns $(if $(CAMPAIGN),campaigns/$(CAMPAIGN))
	@$(BIN)/python scripts/kernels.py verify $(if $(CAMPAIGN),campaigns/$(CAMPAIGN))

lint: $(READY) ## check style, and the docstrings of public functions
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/python scripts/docstrings.py

format: $(READY) ## rewrite the code in the house style
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

types: $(READY) ## check types
	@$(BIN)/mypy

# Each of pytest's processes has a core: further threads of OpenBLAS would only wait, spinning, and double the CPU time.
# A file of tests stays in one process, which makes what its tests share once; a process more than cores, since some wait.
unit: $(READY) ## run the tests, on all cores
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -W error::SyntaxWarning -m pytest -n $$(($$(nproc) + 1)) --dist loadfile -q -m "not study" --long $(LONG) --part-seed $(PART_SEED)

part: $(READY) ## run a seeded part of the numerical tests under two other arithmetics
	@$(BIN)/python scripts/kernels.py test --others 2 -- --part $(PART) --long $(PART_LONG) --part-seed $(PART_SEED)

coverage: $(READY) ## measure the branch coverage of the GUM engine, 95 % at least
	@$(BIN)/coverage run --source=metrology/gum -m pytest -q tests/gum tests/reference
	@$(BIN)/coverage combine -q
	@$(BIN)/coverage report --fail-under=95

# STUDY="tests/test_consistency.py -k tapes": one of them.
study: $(READY) ## run the long blind studies
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist loadgroup -q -m study $(STUDY)

bench: $(READY) $(PEERS)/.ready ## measure ours against peers and against what a user would write otherwise
	@for script in $(BENCHMARKS); do $(BIN)/python $$script --peer-python $(PEERS)/bin/python; done

$(PEERS)/.ready: requirements-bench.lock scripts/setup.sh
	@bash scripts/setup.sh $(PEERS) requirements-bench.lock
	@touch $@

fuzz: $(READY) $(FUZZ)/.ready ## fuzz every reader and the evaluation, SECONDS_EACH=120 each
	@for target in campaign quantity expression readings packed text lvm xlsx ods tdms uff58 parquet numpy mat hdf5 mdf4 \
	  certificate unknown results pdf evaluation; do \
	  $(FUZZ)/bin/python fuzz/fuzz.py $$target $(SECONDS_EACH) || exit 1; done

mutants: $(READY) $(FUZZ)/.ready ## change the code of gum, elongation and decay in MUTANTS=400 places, and see which tests notice
	@$(FUZZ)/bin/python scripts/mutants.py $(MUTANTS)

$(FUZZ)/.ready: requirements-fuzz.lock scripts/setup.sh
	@bash scripts/setup.sh $(FUZZ) requirements-fuzz.lock
	@touch $@

docs: $(READY) $(DOCS)/.ready ## write what is generated in docs/
	@$(BIN)/metrology schema > docs/campaign.schema.json
	@$(BIN)/metrology schema results > docs/results.schema.json
	@$(BIN)/python -m metrology.campaign.documentation > docs/campaign.md
	@$(BIN)/python -m metrology.rig.documentation docs/model.md
	@$(DOCS)/bin/python scripts/man.py
	@$(DOCS)/bin/python scripts/shipped.py licences

# Without -q, which would keep the warnings from being counted too.
site: $(DOCS)/.ready ## build the documentation as a static site, build/site/index.html; a warning is an error
	@NO_MKDOCS_2_WARNING=1 $(DOCS)/bin/mkdocs build --strict

release: $(READY) $(DOCS)/.ready ## build wheel, sdist, bill of materials, locked requirements and licences into dist/
	@rm -rf dist
	@$(BIN)/python -m hatchling build -d dist
	@$(DOCS)/bin/python scripts/shipped.py sbom dist/sbom.cdx.json
	@$(DOCS)/bin/python scripts/shipped.py requirements dist/requirements.txt
	@cp docs/licences.md dist/licences.md
	@! grep -n '://' dist/requirements.txt
	@ls dist

$(DOCS)/.ready: requirements-docs.lock pyproject.toml scripts/setup.sh
	@bash scripts/setup.sh $(DOCS) requirements-docs.lock
	@touch $@

EVERY := --extra files --extra mdf --extra sign --extra export --extra cluster --extra editor --extra dev
RESOLVE := uv pip compile --universal --generate-hashes --no-emit-index-url --no-emit-find-links --no-header \
  --python-version 3.11 -q pyproject.toml

lock: ## resolve the requirements anew (needs uv)
	@$(RESOLVE) $(EVERY) -o requirements.lock
	@$(RESOLVE) --extra bench -o requirements-bench.lock
	@$(RESOLVE) $(EVERY) --extra fuzz -o requirements-fuzz.lock
	@$(RESOLVE) $(EVERY) --extra docs -o requirements-docs.lock
	@! grep -n '://' requirements*.lock

clean: ## remove what was made, keep the environment
	@rm -rf reports build mutants .mypy_cache .pytest_cache .ruff_cache .coverage*
