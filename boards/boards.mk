# SPDX-License-Identifier: Apache-2.0
#
# Bitstreams: every recipe is one call of tools/wavetools/cli/board_commands.py.

# A folder of boards/.
BOARD ?= icebreaker
# The FPGA that is fitted, where a board comes with several: DEVICE=85k
DEVICE ?=
# A scene in place of the board's own: SCENE=my.toml
SCENE ?=
# How many seeds `make seeds` tries.
SEEDS ?= 8

# The user's own tools need no packages of synthesis tools.
SYNTH_TOOLS = $(if $(filter wheel,$(TOOLCHAIN)),$(READY_SYNTH),$(READY))

BITSTREAMS = $(WITH_TOOLS) .venv/bin/python -m wavetools.cli.board_commands

.PHONY: bitstream synth seeds prog flash simulate resources numbers

bitstream: $(SYNTH_TOOLS) ## make the bitstream of BOARD=icebreaker, hx8k, ulx3s, ... (SCENE=my.toml: with your settings)
	@$(BITSTREAMS) bitstream "$(BOARD)" --device "$(DEVICE)" --scene "$(SCENE)"

synth: $(SYNTH_TOOLS) ## make all bitstreams and build/synth/summary.json
	@$(BITSTREAMS) synth --jobs $(JOBS)

seeds: $(SYNTH_TOOLS) ## try SEEDS= seeds of the placer for BOARD=, and say which meet its clock
	@$(BITSTREAMS) seeds "$(BOARD)" --device "$(DEVICE)" --count "$(SEEDS)"

prog: $(READY) ## load the bitstream of BOARD= with the board's own programmer
	@$(BITSTREAMS) prog "$(BOARD)" --device "$(DEVICE)" --scene "$(SCENE)"

flash: $(READY) ## write the bitstream of BOARD= into the board's flash, and verify it
	@$(BITSTREAMS) flash "$(BOARD)" --device "$(DEVICE)" --scene "$(SCENE)"

simulate: $(SYNTH_TOOLS) ## tap and hold the wall of BOARD='s bitstream, placed netlist and motor in a loop
	@$(BITSTREAMS) simulate "$(BOARD)" --device "$(DEVICE)"

resources: $(SYNTH_TOOLS) ## count what each block and option costs, a quarter of an hour
	@$(BITSTREAMS) resources

numbers: $(READY) ## write the numbers of the last whole runs into the pages
	@$(BITSTREAMS) numbers

# The boards' tests synthesise, and simulate netlists.
test $(if $(QUICK),,coverage): $(READY_SYNTH)
