# SPDX-License-Identifier: Apache-2.0
#
# Bitstreams: every recipe is one call of sim/wavehaptics/bitstreams.py.

# A folder of boards/.
BOARD ?= icebreaker
# The FPGA that is fitted, where a board comes with several: DEVICE=85k
DEVICE ?=

BITSTREAMS = $(WITH_TOOLS) .venv/bin/python -m wavehaptics.bitstreams

.PHONY: bitstream synth prog resources numbers

bitstream: $(READY_SYNTH) ## make the bitstream of BOARD=icebreaker, hx8k, ulx3s, ...
	@$(BITSTREAMS) bitstream "$(BOARD)" --device "$(DEVICE)"

synth: $(READY_SYNTH) ## make all bitstreams and build/synth/summary.json
	@$(BITSTREAMS) synth

prog: $(READY) ## load the bitstream of BOARD= with the board's own programmer
	@$(BITSTREAMS) prog "$(BOARD)" --device "$(DEVICE)"

resources: $(READY_SYNTH) ## count what each block and option costs, a quarter of an hour
	@$(BITSTREAMS) resources

numbers: $(READY) ## write the last synthesis' numbers into boards/summary.json and the README pages
	@$(BITSTREAMS) numbers

# The boards' tests synthesise, and simulate netlists.
test: $(READY_SYNTH)
