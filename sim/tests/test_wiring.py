# SPDX-License-Identifier: Apache-2.0
"""The circuits around a board: simulated, drawn, and told in the pages, all from one table.

The circuits shut the gates when ``alive`` stops, when the FPGA is configured anew and when its
supply falls; a wrong part must be found.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import pytest
from typer.testing import CliRunner
from wavehaptics.fpga.boards import board_names, load_board
from wavehaptics.runtime.repository import ROOT
from wavetools.markers import tables_of
from wavetools.wiring import __main__ as command
from wavetools.wiring import drawings, pages, pins, spice
from wavetools.wiring.parts import FAMILIES, TABLE, Table, WiringError, load_table
from wavetools.wiring.pins import Pin
from wavetools.wiring.sheet import Sheet

FAMILY_TICK_S = 1e-6


@pytest.fixture(scope="module")
def table() -> Table:
    return load_table()


# ---- The table.


def test_values_are_printed_with_their_units(table):
    assert table.text("C1") == "2.2 nF"
    assert table.text("R6") == "33 mΩ"
    assert table.text("R4", "ice40") == "1 kΩ"
    assert table.text("R4") == "1 kΩ (iCE40), 10 kΩ (ECP5)"
    assert table.text("U8") == "AD7276"
    with pytest.raises(WiringError, match=r"boards/wiring.toml: there is no part R99; add"):
        table.text("R99")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("value = 2.2e-09", 'value = "2n2"', r"wiring.toml:\d+: parts.C1.value.float: .* number"),
        ("value = 2.2e-09\n", "", r"wiring.toml:\d+: parts.C1: .* either a type or a value"),
        ("value = 2.2e-09", "value = 2.2 nF", r"wiring.toml:\d+: .*without a unit"),
        ("ecp5 = 10e3 }", "}", r"wiring.toml:\d+: "),
        ('type = "BAT54S"', 'tipe = "BAT54S"', r"wiring.toml:\d+: parts.D1"),
    ],
)
def test_a_bad_table_is_refused_with_its_line(tmp_path, old, new, said):
    text = (ROOT / TABLE).read_text()
    assert old in text
    (tmp_path / TABLE.parent).mkdir()
    (tmp_path / TABLE).write_text(text.replace(old, new, 1))
    with pytest.raises(WiringError, match=said) as refusal:
        load_table(tmp_path)
    assert "\n" not in str(refusal.value)


# ---- The circuits.


@pytest.mark.parametrize("which", ["typical", "most"])
def test_diodes_are_those_of_the_data_sheet(table, which):
    points_a, wanted_v = table.diode.points_a, getattr(table.diode, f"{which}_v")
    lines = ["* a diode", f".model d D({getattr(table.diode, f'{which}_model')})", ".temp 25"]
    for index, current_a in enumerate(points_a):
        lines += [f"I{index} 0 d{index} {current_a}", f"D{index} d{index} 0 d"]
        lines += [f".meas tran v{index} AVG v(d{index}) from=0 to=1u"]
    measured = spice.run("\n".join([*lines, ".tran 0.1u 1u", ".end", ""]))
    for index, wanted in enumerate(wanted_v):
        assert measured[f"v{index}"] == pytest.approx(wanted, abs=0.02)


def test_gates_are_shut_soon_after_the_last_change(table):
    """At each board's tick, stopped high and low, in every corner of parts, supply and warmth."""
    ticks_s = sorted(set(spice.board_ticks(table).values()))
    found = spice.stops(table, ticks_s, spice.corners(table))
    assert len(found) == len(ticks_s) * 2 * 24
    assert spice.stop_complaints(table, found) == []
    # Three motors' tick is 1.4 µs, the brushless board's 2.45 µs, eight motors' 3.96 µs; 1.20 V may
    # shut.
    for longest_s, least_v, most_v in (
        (1.3e-6, 1.80, 2.10),
        (1.5e-6, 1.75, 2.05),
        (2.5e-6, 1.45, 2.00),
        (4.0e-6, 1.20, 1.95),
    ):
        of_ticks = [stop for stop in found if stop.tick_s < longest_s]
        assert min(stop.least_v for stop in of_ticks) > least_v
        assert min(stop.most_v for stop in of_ticks) > most_v
    assert max(stop.most_v for stop in found) < 2.80
    assert 30e-6 < max(stop.shut_s for stop in found) < table.stop.longest_s
    assert max(stop.shut_s for stop in found if stop.level == "low") < 13e-6


def test_the_longest_tick_is_one_that_the_pump_bears(table):
    """A tenth more, and a Schmitt buffer may shut; the build refuses what is longer."""
    longest_s = table.stop.longest_tick_s
    assert spice.stop_complaints(table, spice.stops(table, [longest_s], spice.corners(table))) == []
    longer = spice.stops(table, [1.1 * longest_s], spice.corners(table))
    found = spice.stop_complaints(table, longer)
    assert any(re.search(r"pass sinks to .* V, and .* V may shut", line) for line in found)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"C1": 10e-9}, r"alive stops high, .* the gates are shut after 1\d\d µs, allowed are 40"),
        ({"C2": 10e-9}, r"alive stops low, .* the gates are shut after"),
        ({"R2": 100e3}, r"the gates are shut not within 130 µs, allowed are 40"),
        ({"R2": 1e3}, r"pass sinks to .* V, and .* V may shut"),
        ({"C1": 100e-12}, r"pass reaches .* V, and .* V may open"),
    ],
)
def test_a_wrong_part_of_the_pump_is_found(table, values, said):
    wrong = table.changed(**values)
    found = spice.stops(wrong, [FAMILY_TICK_S], [spice.nominal(table)])
    lines = spice.stop_complaints(wrong, found)
    assert any(re.search(said, line) for line in lines), lines


@pytest.mark.parametrize("family", FAMILIES)
def test_no_gate_rises_while_the_fpga_is_configured_anew(table, family):
    found = spice.configured_anew(table, family, FAMILY_TICK_S)
    assert spice.anew_complaints(table, family, found) == []
    assert [anew.level for anew in found] == ["high", "low"]
    assert 0.1 < max(anew.pin_v for anew in found) < 0.25


def test_pull_downs_on_the_bridges_side_alone_let_both_switches_on(table):
    found = spice.configured_anew(table, "ice40", FAMILY_TICK_S, fpga_side=False)
    lines = spice.anew_complaints(table, "ice40", found)
    assert any(re.search(r"HI and LI reach 3\.\d\d V together", line) for line in lines), lines


def test_ten_kilohm_do_not_hold_an_ice40(table):
    wrong = table.changed(R4={"ice40": 10e3, "ecp5": 10e3})
    found = spice.configured_anew(wrong, "ice40", FAMILY_TICK_S)
    assert any(
        "a pin of the FPGA stands at 1." in x for x in spice.anew_complaints(wrong, "ice40", found)
    )


def test_gates_are_shut_while_the_supply_falls(table):
    assert spice.brown_out(table, FAMILY_TICK_S) < 0.1
    assert spice.brown_out(table, FAMILY_TICK_S, supervised=False) > table.levels.v_ih


def test_ngspice_that_is_missing_or_fails_is_said_in_a_line(monkeypatch):
    with pytest.raises(WiringError, match=r"^ngspice: ") as failure:
        spice.run("* nothing\nR1 a 0 {nobody}\n.tran 1n 1u\n.meas tran x MAX v(a)\n.end\n")
    assert "\n" not in str(failure.value)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(WiringError, match="ngspice is not installed; type `make setup`"):
        spice.run("* nothing\n.end\n")


def test_a_supervisor_of_the_next_threshold_is_refused(table):
    wrong = table.supervisor_levels.model_copy(update={"trip_v": (3.0, 3.15)})
    lines = spice.complaints(table.model_copy(update={"supervisor_levels": wrong}))
    assert lines == ["the supervisor may shut at 3.15 V, and the supply may be 3.13 V"]


def test_an_encoder_of_five_volts_is_divided_to_what_the_fpga_bears(table):
    series, ground = (table.part(name) for name in ("R11", "R12"))
    for encoder_v, sign in ((4.75, 1), (5.25, -1)):
        above = series.of("ice40") * (1 + sign * series.tolerance)
        below = ground.of("ice40") * (1 - sign * ground.tolerance)
        assert table.levels.v_ih < encoder_v * below / (above + below) < 3.45


# ---- The drawings.


@pytest.fixture(scope="module")
def sheets(table) -> dict[str, Sheet]:
    return {name: draw(table) for name, draw in drawings.SHEETS.items()}


@pytest.mark.parametrize("name", drawings.SHEETS)
def test_the_picture_is_what_the_program_draws(sheets, name):
    kept = (ROOT / drawings.FOLDER / f"{name}.svg").read_text()
    drawn = sheets[name].svg()
    assert drawings.texts(kept) == drawings.texts(drawn)
    assert drawings.lines(kept) == drawings.lines(drawn)
    assert len(drawings.lines(drawn)) > 30


@pytest.mark.parametrize("name", drawings.SHEETS)
def test_no_wire_and_no_part_ends_at_nothing(sheets, name):
    assert sheets[name].loose() == []


def test_every_part_is_drawn(table, sheets):
    shown = set().union(*(sheet.shown for sheet in sheets.values()))
    assert shown == set(table.parts)


@pytest.mark.parametrize("name", drawings.SHEETS)
def test_no_text_leaves_the_picture(sheets, name):
    """By a width of 0.55 of the size for a character, more than most of the font have."""
    root = ElementTree.fromstring(sheets[name].svg())
    left, _, width, _ = (float(number) for number in root.attrib["viewBox"].split())
    seen = 0
    for element in root.iter():
        if element.tag.endswith("}text"):
            for line in element:
                x, size = float(line.attrib["x"]), float(element.attrib["font-size"])
                long = 0.55 * size * len(line.text or "")
                part = {"start": 0.0, "middle": 0.5, "end": 1.0}[element.attrib["text-anchor"]]
                assert left <= x - part * long, line.text
                assert x + (1 - part) * long <= left + width, line.text
                seen += 1
    assert seen > 20


@pytest.mark.parametrize("family", FAMILIES)
def test_the_pump_is_drawn_as_it_is_simulated(table, sheets, family):
    """The same ends are joined on the sheet and in the netlist."""
    lines = spice._pump(table, "x", "alive", "pass", spice.nominal(table), family)
    nodes = {}
    for line in lines:
        if line.startswith("."):
            continue
        name, first, second, _ = line.split(maxsplit=3)
        nodes |= {f"{name[:2]}.1": first, f"{name[:2]}.2": second}
    names = {"D1": "D1#1", "D2": "D1#2"}
    drawn = {}
    for number, net in enumerate(sheets[f"gates_{family}"].nets()):
        drawn |= dict.fromkeys(net, number)
    places = {end: drawn[f"{names.get(end[:2], end[:2] + '#1')}{end[2:]}"] for end in nodes}
    pairs = [(a, b) for a in nodes for b in nodes if a < b]
    assert len(pairs) > 90
    assert [nodes[a] == nodes[b] for a, b in pairs] == [places[a] == places[b] for a, b in pairs]


@pytest.mark.parametrize("family", FAMILIES)
def test_both_sides_of_each_gate_are_pulled_down(table, sheets, family):
    sheet = sheets[f"gates_{family}"]
    ways = {
        "ah": "HI of U5A (4)",
        "al": "LI of U5A (5)",
        "bh": "HI of U5B (4)",
        "bl": "LI of U5B (5)",
    }
    for row, (signal, to) in enumerate(ways.items()):
        gate, pull = f"U4{'abcd'[row]}", row + 1
        assert sheet.net_of(f"gate_{signal}") == {f"gate_{signal}", f"{gate}.in1", f"R4#{pull}.1"}
        assert sheet.net_of(f"{gate}.out") == {f"{gate}.out", f"R5#{pull}.1", to}
        assert f"{gate}.in2" in sheet.net_of("U3.out")
        assert {f"R4#{pull}.2", f"R5#{pull}.2"} <= sheet.net_of("ground")
    assert drawings.texts(sheet.svg()).count(table.text("R4", family)) >= 4


def test_emergency_stop_cuts_bus_and_gate_supply(sheets):
    sheet = sheets["power"]
    assert sheet.net_of("PS1.+") == {"PS1.+", "S1a.1"}
    # An encoder's supply stays, or S1 would take the position away.
    assert sheet.net_of("PS2.+") == {"PS2.+", "S1b.1", "supply of an encoder of 5 V"}
    assert "S1c.1" in sheets["inputs"].net_of("ground")


def test_an_input_whose_wire_is_off_is_held(sheets):
    """So that it reads as off the scale, or as an encoder that stands."""
    sense = sheets["sense"]
    for number, (pin, signal) in enumerate({"CS": "adc_cs_n", "SCLK": "adc_sclk"}.items(), 1):
        net = sense.net_of(f"U8.{pin}")
        assert net == {f"U8.{pin}", f"R19#{number}.2", f"R8#{number}.1"}
        assert f"R19#{number}.1" in sense.net_of("3.3 V")
        assert sense.net_of(f"R8#{number}.2") == {f"R8#{number}.2", signal}
    assert {"R23#1.1", "R7#1.2", "C10#1.1"} <= sense.net_of("U8.VIN")
    assert "R23#1.2" in sense.net_of("ground")
    inputs = sheets["inputs"]
    assert {"buffer.in", "encoder's A, 0 to 5 V"} <= inputs.net_of("R22#1.1")
    assert "R22#1.2" in inputs.net_of("3.3 V")
    assert "R18#1.1" in inputs.net_of("led_fault")


def test_a_wire_that_ends_at_another_without_a_dot_is_found(table):
    sheet = Sheet("", table)
    sheet.wire((0, 0), (4, 0))
    sheet.tag((0, 0), "a", "left")
    sheet.tag((4, 0), "b", "right")
    sheet.resistor("R1", (2, 0), (2, 2), "left")
    sheet.rail((2, 2), "3.3 V")
    assert sheet.loose() == [(2, 0)]
    assert "R1#1.1" not in sheet.net_of("a")
    sheet.dot((2, 0))
    assert sheet.loose() == []
    assert {"b", "R1#1.1"} <= sheet.net_of("a")


# ---- A power board that is bought.


@pytest.fixture(scope="module")
def bought() -> Table:
    return load_table(name="boostxl")


def test_its_table_is_the_other_but_for_what_it_says(table, bought):
    assert bought.name == "boostxl"
    assert bought.part("R2") == table.part("R2")
    assert bought.part("C1").value == pytest.approx(10 * table.part("C1").value)
    assert (bought.levels, bought.schmitt) == (table.levels, table.schmitt)
    assert bought.stop.longest_tick_s == pytest.approx(10 * table.stop.longest_tick_s)
    assert "U5" in table.parts
    assert "U5" not in bought.parts


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"C4", "R21"', '"C4", "R99"', r"_boostxl.toml: without: there is no part R99; leave"),
        ("value = 22e-9", 'value = "22n"', r"_boostxl.toml:\d+: parts.C1.value.float: .* num"),
    ],
)  # fmt: skip
def test_a_bad_table_of_a_power_board_is_refused(tmp_path, old, new, said):
    (tmp_path / "boards").mkdir()
    for name in ("wiring.toml", "wiring_boostxl.toml"):
        text = (ROOT / "boards" / name).read_text()
        (tmp_path / "boards" / name).write_text(text.replace(old, new, 1))
    with pytest.raises(WiringError, match=said) as refusal:
        load_table(tmp_path, "boostxl")
    assert "\n" not in str(refusal.value)


def test_its_pump_bears_its_ticks_and_no_longer_one(bought):
    """A period of 25 kHz, or of 100 or 200; a tenth more, and a Schmitt buffer may shut."""
    assert set(spice.board_ticks(bought).values()) == {40e-6}
    assert spice.complaints(bought) == []
    shorter = spice.stops(bought, [5e-6, 10e-6, 20e-6], spice.corners(bought))
    assert spice.stop_complaints(bought, shorter) == []
    longest_s = bought.stop.longest_tick_s
    longer = spice.stops(bought, [1.1 * longest_s], spice.corners(bought))
    lines = spice.stop_complaints(bought, longer)
    assert any(re.search(r"pass sinks to .* V, and .* V may shut", line) for line in lines)


def test_the_others_pump_is_none_for_it(table, bought):
    wrong = bought.changed(C1=table.part("C1").value, C2=table.part("C2").value)
    found = spice.stops(wrong, [40e-6], [spice.nominal(wrong)])
    assert any("may shut" in line for line in spice.stop_complaints(wrong, found))


def test_its_sheet(table, bought):
    """Every wire ends at something, the picture is kept, and no part that it has is missing."""
    sheet = drawings.POWER_BOARDS["boostxl"](bought)
    kept = (ROOT / drawings.FOLDER / "boostxl.svg").read_text()
    assert drawings.texts(kept) == drawings.texts(sheet.svg())
    assert drawings.lines(kept) == drawings.lines(sheet.svg())
    assert sheet.loose() == []
    elsewhere = drawings.inputs(table).shown
    assert sheet.shown <= set(bought.parts) <= sheet.shown | elsewhere


def test_its_gates_are_enabled_by_the_pump_through_the_emergency_stop(bought):
    sheet = drawings.POWER_BOARDS["boostxl"](bought)
    assert sheet.net_of("U3.out") == {"U3.out", "S1b.1"}
    assert sheet.net_of("nEn_uC") == {"nEn_uC", "S1b.2", "PB.13 nEn_uC"}
    assert sheet.net_of("PS1.+") == {"PS1.+", "S1a.1"}
    assert sheet.net_of("VBUS") == {"VBUS", "F1#1.2", "D2#1.2", "PB.J4 +"}
    for pin, port in (("40 PWM_AH", "gate_ah"), ("35 PWM_CL", "gate_cl")):
        assert sheet.net_of(port) == {port, f"PB.{pin}"}
    for number, (pin, name) in enumerate((("A0", "IA"), ("A1", "IB")), 1):
        assert f"U8.{pin}" in sheet.net_of(name)
        assert f"R23#{number}.1" in sheet.net_of(name)


# ---- The pages.


def test_tables_of_the_pages_are_those_of_the_program(table):
    """But for what is simulated: another ngspice may round otherwise."""
    for page, made in pages.makers(table).items():
        text = (ROOT / page).read_text()
        for name, make in made.items():
            if name != "pump":
                assert tables_of(text)[name] == make(), f"{page}: {name}; type `make drawings`"


def test_simulated_numbers_of_the_page(table):
    def numbers(text: str) -> list[float]:
        return [float(number) for number in re.findall(r"\d+\.?\d*", text)]

    kept = tables_of((ROOT / pages.WIRING).read_text())["pump"]
    assert numbers(kept) == pytest.approx(numbers(pages.pump(table)), rel=0.05, abs=1)
    assert len(numbers(kept)) > 30


@pytest.mark.parametrize("name", board_names())
def test_a_boards_page_warns(name):
    text = " ".join((ROOT / "boards" / name / "README.md").read_text().split())
    assert "Not yet tried on a motor" in text
    assert "No pin here tolerates 5 V." in text
    assert f"stay off until this image is in flash**: `make flash BOARD={name}`" in text
    assert "../../docs/wiring/switching_on.md" in text
    fpga = load_board(name).fpga
    if fpga.wiring is None:
        assert f"R3 and R4, {load_table().text('R4', fpga.family)} each" in text
    else:
        assert f"../../docs/wiring/{fpga.wiring}.svg" in text


@pytest.mark.parametrize("name", board_names())
def test_scale_of_the_current_is_that_of_shunt_and_gain(name):
    """And of the parts that the build of a board is told of."""
    board = load_board(name)
    table = load_table(name=board.fpga.wiring)
    assert board.scene.adc.full_scale_a == pytest.approx(pages.full_scale_a(table), rel=0.01)
    sense = board.fpga.sense
    assert sense.shunt_ohm == table.part("R6").of(board.fpga.family)
    assert (sense.gain, sense.swing_v) == (table.current.gain, table.current.swing_v)
    assert sense.supply_v == table.supply.logic_v
    assert table.text("U7").startswith(sense.amplifier)
    driver, adc = (table.text("U5"), "U8") if table.name is None else ("LMG5200", "U8")
    assert board.fpga.bridge.driver == driver
    assert board.fpga.adc in f"{table.text(adc)}, {table.part(adc).role}"


def test_overcurrent_is_below_what_the_amplifier_can_tell(table):
    rows = dict(re.findall(r"\| (.+?) \| ± ([\d.]+) A \|", pages.currents(table)))
    ends = {name.split(",")[0]: float(value) for name, value in rows.items()}
    assert ends["a sample takes the gates off"] < ends["option overcurrent"]
    assert ends["option overcurrent"] < ends["end of what U7 gives truly"]
    assert ends["end of what U7 gives truly"] < ends["end of the ADC's scale"]


def test_bill_counts_boards_and_motors(table):
    assert pages.count(table.part("R4"), 1) == 4
    assert pages.count(table.part("R4"), 3) == 12
    assert pages.count(table.part("U3"), 3) == 1
    assert pages.count(table.part("R8"), 3) == 2
    assert pages.count(table.part("R8"), 8, 4) == 8
    assert pages.sizes() == [(1, 1), (3, 1), (8, 4)]
    bill = pages.bill(table, options=False) + pages.bill(table, options=True)
    for reference in table.parts:
        assert len(re.findall(rf"^\| {reference} \|", bill, re.MULTILINE)) == 1


def test_supply_pins_of_headers_carry_no_signal():
    for name in board_names():
        found = pins.wires(name)
        listed = [pin for rows in found.headers.values() for row in rows for pin in row]
        listed_ports = {pin.port for pin in listed if pin.port}
        assert listed_ports | {port for port, _, _ in found.on_board} == set(pins.ports(name))
        assert any(pin.place == "GND" for pin in listed)
        known = load_board(name).fpga
        sites = {pin.place for pin in listed if re.fullmatch(r"[A-Z]?\d+", pin.place)}
        unused = {"C3", "C4", "B4", "D3"} if name == "colorlight_i5" else set()  # between the PMODs
        assert sites - {*known.free, *known.taken} == unused
        for pin in listed:
            assert pin.port is None or re.fullmatch(r"[A-Z]?\d+", pin.place)
    core = [pin for row in pins.wires("hx8k").headers["J2"] for pin in row if "1.2" in pin.place]
    assert [pin.printed for pin in core] == ["1", "3"]
    assert {pins.goes_to(pin) for pin in core} == {"**never**"}


def test_a_pin_says_whose_it_is():
    """Of CS and SCLK each of several is that of the motors that share it."""
    sclk, sdata = (Pin("6", "A8", f"adc_{name}[1]") for name in ("sclk", "sdata"))
    assert pins.goes_to(sclk, sharing=2) == "motors 2 and 3: R8, SCLK of U8"
    assert pins.goes_to(sclk, sharing=4) == "motors 4 to 7: R8, SCLK of U8"
    assert pins.goes_to(sclk) == "motor 1: R8, SCLK of U8"
    assert pins.goes_to(sdata, sharing=2) == "motor 1: SDATA of U8"
    assert pins.goes_to(sdata, brushless=True) == "phase b: SDATA of U8"
    assert pins.goes_to(sdata, brushless=True, motors=4) == "motor 0, phase b: SDATA of U8"
    gate = Pin("6", "A8", "gate_ch[3]")
    assert pins.goes_to(gate, brushless=True, motors=4) == "motor 3: R4, second U4 pin 1"


def test_a_port_on_no_header_is_refused(tmp_path):
    for path in ("boards/headers.toml", "constraints/hx8k.pcf", "boards/hx8k/fpga.toml",
                 "boards/hx8k/board.toml"):  # fmt: skip
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text((ROOT / path).read_text())
    constraints = tmp_path / "constraints" / "hx8k.pcf"
    text, changed = re.subn(r"(set_io.* gate_ah +)K14", r"\1T9", constraints.read_text())
    assert changed == 1
    constraints.write_text(text)
    with pytest.raises(WiringError, match=r"gate_ah of hx8k at T9 is on no header; name it in"):
        pins.wires("hx8k", tmp_path)


def test_a_page_without_its_marker_is_refused(table):
    with pytest.raises(WiringError, match=r"x.md: there is no <!-- begin pins --> with its end"):
        pages.filled("text", "x.md", {"pins": lambda: ""})


# ---- The command.


def run_command(monkeypatch, table: Table | WiringError):
    def load() -> Table:
        if isinstance(table, WiringError):
            raise table
        return table

    def never(*_: object) -> None:
        raise AssertionError("nothing may be written")

    monkeypatch.setattr(command, "load_table", load)
    monkeypatch.setattr(command.drawings, "write", never)
    monkeypatch.setattr(command.pages, "write", never)
    app = command.typer.Typer()
    app.command()(command.main)
    return CliRunner().invoke(app, [])


def test_circuits_that_are_not_safe_are_neither_drawn_nor_told(table, monkeypatch):
    result = run_command(monkeypatch, table.changed(C1=10e-9))
    assert result.exit_code == 1
    assert "wiring: alive stops high, tick 1.2 µs" in result.output


def test_a_table_that_cannot_be_read_is_a_line(monkeypatch):
    result = run_command(monkeypatch, WiringError("boards/wiring.toml:3: no"))
    assert result.exit_code == 2
    assert result.output == "wiring: boards/wiring.toml:3: no\n"
