# SPDX-License-Identifier: Apache-2.0
#
# The circuits around the boards: boards/wiring.toml simulated, drawn and told in the pages.

.PHONY: drawings

drawings: $(READY) ## simulate and draw the circuits of boards/wiring.toml, with the tables of their pages
	@$(WITH_TOOLS) .venv/bin/python -m wavetools.wiring
