# SPDX-License-Identifier: Apache-2.0
"""``wh_device`` as a LiteX peripheral: a Wishbone slave, with a scene's parameters.

Tried with LiteX 2024.12 of PyPI. ``docs/use_in_your_design.md`` shows the use. LiteX, Migen and
wavehaptics have to be in one Python environment.
"""

from __future__ import annotations

from pathlib import Path

from litex.gen import LiteXModule
from litex.soc.integration.soc import SoCRegion
from litex.soc.interconnect import wishbone
from migen import ClockSignal, Constant, Instance, ResetSignal, Signal
from wavehaptics.fpga.scene_registers import SceneRegisters
from wavehaptics.runtime.repository import RTL_DIR
from wavehaptics.words import formats

SIZE = 0x4000
"""Bytes of the register map: 2^12 registers of 32 bits."""


class WaveHaptics(LiteXModule):
    """The device and its Wishbone slave ``bus``; its other attributes are its pins.

    ``made`` has the scene's parameters. ``more`` are others of ``rtl/wh_device.v``, such as
    ``CAPTURE=12``. The clock ``sys`` must have the scene's ``controller.clock_hz``.
    """

    def __init__(self, platform, made: SceneRegisters, sys_clk_freq: float, **more: int) -> None:
        if round(sys_clk_freq) != round(made.clock_hz):
            raise ValueError(
                f"sys_clk_freq is {sys_clk_freq / 1e6:g} MHz, and the registers are for "
                f"{made.clock_hz / 1e6:g} MHz; change the clock or the scene's controller.clock_hz"
            )
        parameters = {"ARM": 1, **made.parameters, **more}
        ports = parameters["N"]

        self.bus = wishbone.Interface(data_width=32, adr_width=30, addressing="word")

        # Pins, and what a design wires.
        self.enable = Signal()
        self.press = Signal()
        self.clear = Signal()
        self.adc_cs_n = Signal()
        self.adc_sclk = Signal()
        self.adc_sdata = Signal(ports)
        self.enc_a = Signal(ports)
        self.enc_b = Signal(ports)
        self.gate_ah = Signal(ports)
        self.gate_al = Signal(ports)
        self.gate_bh = Signal(ports)
        self.gate_bl = Signal(ports)
        self.running = Signal()
        self.contact = Signal()
        self.fault = Signal()

        # # #

        valid, write, check, ready = Signal(), Signal(), Signal(), Signal()
        address, data, read, error = Signal(12), Signal(32), Signal(32), Signal(2)
        clocked = {"i_clk": ClockSignal(), "i_rst": ResetSignal()}
        self.specials += Instance(
            "wh_wishbone", **clocked,
            i_cyc_i=self.bus.cyc, i_stb_i=self.bus.stb, i_we_i=self.bus.we,
            i_adr_i=self.bus.adr[:12], i_dat_i=self.bus.dat_w, i_sel_i=self.bus.sel,
            o_dat_o=self.bus.dat_r, o_ack_o=self.bus.ack, o_err_o=self.bus.err,
            o_bus_valid_o=valid, o_bus_write_o=write, o_bus_check_o=check,
            o_bus_address_o=address, o_bus_data_o=data,
            i_bus_ready_i=ready, i_bus_data_i=read, i_bus_error_i=error,
        )  # fmt: skip
        self.specials += Instance(
            "wh_device", **clocked, **{f"p_{name}": value for name, value in parameters.items()},
            i_bus_valid_i=valid, i_bus_write_i=write, i_bus_check_i=check,
            i_bus_address_i=address, i_bus_data_i=data,
            o_bus_ready_o=ready, o_bus_data_o=read, o_bus_error_o=error,
            i_enable_i=self.enable, i_press_i=self.press, i_clear_i=self.clear,
            o_adc_cs_n_o=self.adc_cs_n, o_adc_sclk_o=self.adc_sclk, i_adc_sdata_i=self.adc_sdata,
            i_enc_a_i=self.enc_a, i_enc_b_i=self.enc_b,
            o_gate_ah_o=self.gate_ah, o_gate_al_o=self.gate_al,
            o_gate_bh_o=self.gate_bh, o_gate_bl_o=self.gate_bl,
            o_running_o=self.running, o_contact_o=self.contact, o_fault_o=self.fault,
            i_bus_i=Constant(0, formats.BUS_W), i_stop_i=0, i_zero_start_i=0, i_stream_room_i=0,
            i_driver_fault_i=Constant(0, ports),
        )  # fmt: skip
        for path in sorted(Path(RTL_DIR).glob("*.v")):
            platform.add_source(str(path))
        platform.add_verilog_include_path(str(RTL_DIR))


def add_wave_haptics(soc, device: WaveHaptics, name: str = "haptics", origin: int | None = None):
    """Add the device to a SoC's bus as ``name``; its registers begin at the region's origin."""
    setattr(soc, name, device)
    soc.bus.add_slave(name, device.bus, SoCRegion(origin=origin, size=SIZE, cached=False))
