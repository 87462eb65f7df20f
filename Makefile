# `make report` sets up everything and makes the reports; `make test` sets up everything and passes the tests.
SHELL := /bin/bash
# Byte code makes every later start several times faster.
unexport PYTHONDONTWRITEBYTECODE
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PEERS := .venv-bench
FUZZ := .venv-fuzz
SECONDS_EACH ?= 120
MUTANTS ?= 400
BENCHMARKS := $(filter-out %/side_by_side.py,$(wildcard benchmarks/*.py))
CAMPAIGN ?=
NAMES := $(if $(CAMPAIGN),$(CAMPAIGN),$(patsubst campaigns/%/campaign.yaml,%,$(wildcard campaigns/*/campaign.yaml)))

.DEFAULT_GOAL := help
.PHONY: help setup report check-pdf test lint format types unit coverage study bench fuzz mutants docs lock clean

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

test: lint types unit ## lint, type-check and test

lint: $(READY) ## check style
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

format: $(READY) ## rewrite the code in the house style
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

types: $(READY) ## check types
	@$(BIN)/mypy

unit: $(READY) ## run the tests, on all cores
	@$(BIN)/python -W error::SyntaxWarning -m pytest -n auto -q -m "not study"

coverage: $(READY) ## measure the branch coverage of the GUM engine, 95 % at least
	@$(BIN)/coverage run --source=metrology/gum -m pytest -q tests/gum tests/reference
	@$(BIN)/coverage combine -q
	@$(BIN)/coverage report --fail-under=95

study: $(READY) ## run the long blind studies
	@$(BIN)/python -m pytest -n auto -m study

bench: $(READY) $(PEERS)/.ready ## measure ours against peers and against what a user would write otherwise
	@for script in $(BENCHMARKS); do $(BIN)/python $$script --peer-python $(PEERS)/bin/python; done

$(PEERS)/.ready: requirements-bench.lock scripts/setup.sh
	@bash scripts/setup.sh $(PEERS) requirements-bench.lock
	@touch $@

fuzz: $(READY) $(FUZZ)/.ready ## fuzz every reader, SECONDS_EACH=120 each
	@for target in campaign quantity expression readings packed results pdf; do \
	  $(FUZZ)/bin/python fuzz/fuzz.py $$target $(SECONDS_EACH) || exit 1; done

mutants: $(READY) $(FUZZ)/.ready ## change the code of gum, elongation and decay in MUTANTS=400 places, and see which tests notice
	@$(FUZZ)/bin/python scripts/mutants.py $(MUTANTS)

$(FUZZ)/.ready: requirements-fuzz.lock scripts/setup.sh
	@bash scripts/setup.sh $(FUZZ) requirements-fuzz.lock
	@touch $@

docs: $(READY) ## write what is generated in docs/
	@$(BIN)/metrology schema > docs/campaign.schema.json
	@$(BIN)/metrology schema results > docs/results.schema.json
	@$(BIN)/python -m metrology.campaign.documentation > docs/campaign.md
	@$(BIN)/python -m metrology.rig.documentation docs/model.md

RESOLVE := uv pip compile --universal --generate-hashes --no-emit-index-url --no-emit-find-links --no-header \
  --python-version 3.11 -q pyproject.toml

lock: ## resolve the requirements anew (needs uv)
	@$(RESOLVE) --extra sign --extra export --extra cluster --extra dev -o requirements.lock
	@$(RESOLVE) --extra bench -o requirements-bench.lock
	@$(RESOLVE) --extra sign --extra export --extra cluster --extra dev --extra fuzz -o requirements-fuzz.lock
	@! grep -n '://' requirements*.lock

clean: ## remove what was made, keep the environment
	@rm -rf reports build mutants .mypy_cache .pytest_cache .ruff_cache .coverage*
