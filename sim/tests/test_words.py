# SPDX-License-Identifier: Apache-2.0
"""The table of words against the RTL that it describes, and what is made of it."""

import json
import re
import subprocess

import pytest
from wavehaptics.controller import anchor, wave_core
from wavehaptics.fpga.boards import board_names, load_board
from wavehaptics.host import capture
from wavehaptics.ladder.verilated import verilator_environment
from wavehaptics.runtime.repository import ROOT
from wavehaptics.words import formats, generated, table
from wavehaptics.words.faults import FLAGS
from wavehaptics.words.table import TABLE, WORDS, Sizes, TableError
from wavetools.pages import filler
from wavetools.pages import words as pages_words

PINS = (
    r"clk|rst|enable_i|adc_(cs_n|sclk|din)_o|adc_sdata_i|enc_[ab]_i|gate_([ab][hl]|high|low)_o"
    r"|stop_i|driver_fault_i|anchor_fault_i|phase_current_o|(scale|anchor)_hold_o"
)
"""Ports that are no words: clock, pins, what a board wires, and what ``wh_device`` needs."""


def controller_ports(tmp_path, sizes):
    """{port: (direction, bits)} of ``wh_controller``, as Verilator elaborates it."""
    program, environment = verilator_environment()
    parameters = {"WALLS": sizes.walls, "DELAY_LOG2": sizes.delay_log2}
    top = "wh_controller"
    parameters |= {"SHAPER": sizes.sections, "N": sizes.motors}
    subprocess.run(
        [program, "--json-only", "-Wno-lint", "-Wno-style", f"-I{formats.RTL_DIR}",
         *(f"-G{name}={value}" for name, value in parameters.items()),
         "--Mdir", str(tmp_path), "--top-module", top,
         str(formats.RTL_DIR / f"{top}.v")],
        env=environment, check=True, capture_output=True,
    )  # fmt: skip
    tree = json.loads((tmp_path / f"V{top}.tree.json").read_text())
    ranges = {
        kind["addr"]: kind.get("range", "0:0").split(":")
        for kind in tree["miscsp"][0]["typesp"]
        if kind["type"] == "BASICDTYPE"
    }
    top = next(module for module in tree["modulesp"] if module["name"] == top)
    return {
        port["name"]: (port["direction"], int(ranges[port["dtypep"]][0]) + 1)
        for port in top["stmtsp"]
        if port["type"] == "VAR" and port.get("direction") in ("INPUT", "OUTPUT")
    }


@pytest.mark.parametrize("sizes", [Sizes(), Sizes(3, 2, 2, 5), Sizes(3, 16, 1, 1)])
def test_the_controllers_ports(tmp_path, sizes):
    """Every port that is no pin is in the table, with that width, and nothing else is."""
    found = {
        name: port
        for name, port in controller_ports(tmp_path, sizes).items()
        if not re.fullmatch(PINS, name)
    }
    expected = {
        f"{port}_{direction}": (way, table.port_width(words, sizes))
        for direction, way in (("i", "INPUT"), ("o", "OUTPUT"))
        for port, words in table.ports(direction).items()
    }
    assert found == expected


def test_words_side_by_side_are_where_the_rtl_takes_them():
    assert table.port_width(table.ports()["anchor_words"], Sizes()) == formats.ANCHOR_W
    rtl = (formats.RTL_DIR / "wh_anchor.v").read_text()
    highest_first = re.search(r"assign \{([^}]*)\} = words_i;", rtl)[1].replace("\n", "").split(",")
    names = [word.name for word in table.ports()["anchor_words"]]
    assert [f"anchor_{name.strip()}" for name in reversed(highest_first)] == names
    assert [getattr(anchor, name.removeprefix("anchor_").upper()) for name in names] == list(
        range(anchor.SETTINGS)
    )
    assert [(word.name, word.row.count) for word in table.ports()["shape_words"]] == [
        ("shape_coefficient", wave_core.LOSS1),
        ("shape_loss", wave_core.SECTION_WORDS - wave_core.LOSS1),
    ]
    faults = (formats.RTL_DIR / "wh_faults.vh").read_text()
    for macro, name in (("CURRENT_Q", "guard_zero"), ("WAVE_Q", "guard_lost")):
        fraction = re.search(rf"WH_GUARD_{macro}\s+(\d+)", faults)[1]
        assert WORDS[name].fixed.fraction == int(fraction)


@pytest.mark.parametrize("name", board_names())
def test_a_boards_words_make_sense(name):
    words = load_board(name).words().words
    assert len(words) > 30
    packed = words.pop("anchor_words")  # of all words of its port
    assert packed >> table.port_width(table.ports()["anchor_words"], Sizes()) == 0
    for key, raw in words.items():
        low, high = WORDS[key].range
        if key not in ("extra_ticks", "hold_ticks"):  # as many as the board's delay line counts
            each = raw if isinstance(raw, list) else [raw]
            assert all(low <= WORDS[key].fixed.to_value(one) <= high for one in each), key


def test_values_and_words():
    root = WORDS["root"]
    assert root.fixed.to_raw(2.0) == 2 << formats.ROOT.fraction
    assert root.range == (0.0, formats.ROOT.largest)
    assert WORDS["eta_contact"].default == -1 << formats.ETA.fraction
    assert WORDS["bus"].fixed.to_raw(127.5) == 0xFF00
    with pytest.raises(OverflowError, match=r"-1 is outside 0\.\.\.127\.998"):
        WORDS["bus"].fixed.to_raw(-1)


def test_ports_hold_their_words_side_by_side():
    """The first motor, the first wall, the first row lowest; defaults where nothing is said."""
    sizes = Sizes(motors=2, walls=2, sections=2)
    values = {
        "wall_min": [-1, 2, 3, 4], "samples": 5, "zero": [-1, 7], "guard_damp": 0xBEEF,
        "anchor_words": [1, 2], "shape_coefficient": range(36), "shape_loss": range(12),
    }  # fmt: skip
    found = table.inputs(values, sizes)
    assert found["wall_min_i"] == 0x00000004_00000003_00000002_FFFFFFFF
    assert found["samples_i"] == 5
    assert found["zero_i"] == 0x000007_FFFFFF
    assert found["guard_i"] == 0xBEEF << 24  # behind guard_mask
    assert found["anchor_words_i"] == 2 << formats.ANCHOR_W | 1
    assert found["range_i"] == 0xFFFF
    section = 9 * formats.SHAPE.width + 3 * formats.SHAPE_LOSS_W
    second = found["shape_words_i"] >> section
    assert second & 0xFF == 9
    assert second >> 9 * formats.SHAPE.width & 0xFFF == 3


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"samples": 512}, "samples = 512 doesn't fit u9"),
        ({"root": -(1 << 26) - 1}, "root = -67108865 doesn't fit sCOEF_WqROOT_Q"),
        ({"extra_ticks": 4}, "extra_ticks = 4 doesn't fit uDELAY_LOG2"),
        ({"wall_min": [1, 2]}, "wall_min has 4 words, not 2"),
        ({"sample": 1}, "there is no setting sample"),
        ({"voltage": 1}, "there is no setting voltage"),
    ],
)
def test_what_a_port_cannot_hold(values, message):
    with pytest.raises(ValueError, match=message):
        table.inputs(values, Sizes())


ROW = '[wh_one.first]\naddress = 0\none = { format = "u8", meaning = "it" }\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROW.replace("u8", "x8"), r':3: wh_one.first.one: format = "x8" is not like u8, s24 or'),
        (ROW.replace("u8", "uNO_W"), r':3: .*format = "uNO_W": there is no WH_NO_W'),
        (ROW.replace("u8", "u40"), r":3: .*a word has at most 32 bits, not 40"),
        (ROW.replace("meaning", "meanings"), r":3: wh_one.first.one: meaning"),
        (ROW.replace("address = 0\n", ""), r":1: \[wh_one.first\] has no address"),
        (ROW.replace("= 0", '= "0"'), r":1: wh_one.first: address = '0' is not a number"),
        (ROW.replace("= 0", "= 256"), r":3: .*address 0x100 is outside 0x000...0x0ff"),
        (ROW + ROW.replace("first", "second").replace("one =", "two ="),
         r":6: wh_one.second.two: address 0x000 is that of one"),
        (ROW + ROW.replace("first", "second").replace("= 0", "= 9"),
         r":6: .*there is a one in wh_one already"),
        (ROW.replace("}", ", default = 256 }"), r":3: .*default 256 is outside 0...255"),
        (ROW.replace("}", ", range = [0, 300] }"), r":3: .*range 300 is outside the format's 0"),
        (ROW.replace("}", ', port = "one_o" }'), r':3: .*port = "one_o" is none of a setting'),
        (ROW + 'two = { port = "one_i", per = "motor", format = "u1", meaning = "it" }\n',
         r":4: .*one_i has words per board and per motor"),
        (ROW.replace("= 0\n", '= 0\nchange = "now"\n'), r":1: .*change = 'now' is none of off"),
        (ROW.replace("{", ""), r":3: not valid TOML"),
    ],
)  # fmt: skip
def test_refused_tables(tmp_path, text, message):
    path = tmp_path / "words.toml"
    path.write_text(text)
    with pytest.raises(TableError, match=message) as error:
        table.read(path)
    assert "\n" not in str(error.value)


# ---- Addresses.


def test_addresses():
    """Each word of the largest controller has its own; a motor's words are a stride apart."""
    taken = {}
    for word in WORDS.values():
        for motor in range(1 if word.row.per == "board" else 8):
            for index in range(table.MOST[word.row.per] * word.row.count):
                at = word.at(motor, index)
                assert taken.setdefault(at, word.name) == word.name
                taken[at] = word.name + " again"
    assert max(taken) < 1 << 12
    assert WORDS["eta_free"].at(2) == WORDS["eta_free"].at() + 2 * table.MOTOR_STRIDE
    assert WORDS["wall_max"].at(1, 3) == WORDS["wall_min"].at(1) + 16 + 3
    with pytest.raises(IndexError, match="wall_max has no word 16"):
        WORDS["wall_max"].at(0, 16)


def test_a_new_row_at_the_end_of_its_group_moves_nothing(tmp_path):
    text = TABLE.read_text(encoding="utf-8")
    more = tmp_path / "words.toml"
    row = 'sample_shift = { format = "u4", meaning = "a new one" }\n'
    more.write_text(text.replace("\n[wh_adc_serial.frame]", row + "\n[wh_adc_serial.frame]"))
    words = table.read(more)
    assert words.pop("sample_shift").at() == WORDS["sample_late"].at() + 1
    assert words == WORDS


@pytest.mark.parametrize(
    ("old", "new", "changes"),
    [
        ("measured bus voltage, an input of the board", "something else", False),
        ('uREST_W", unit = "periods"', 'u12", unit = "periods"', True),
        ('uREST_W", unit = "periods"', 'uREST_W", unit = "s"', True),
        ("address = 0x1d0", "address = 0x1d8", True),
        ("compensate =", "compensated =", True),
    ],
)
def test_the_crc_tells_what_two_sides_must_agree_on(tmp_path, old, new, changes):
    text = TABLE.read_text(encoding="utf-8")
    assert text.count(old) == 1
    other = tmp_path / "words.toml"
    other.write_text(text.replace(old, new))
    assert (table.crc(table.read(other)) != table.crc()) == changes
    assert 0 <= table.crc() < 1 << 32


# ---- What is made of it.


def test_every_text_of_the_table_has_its_place():
    """Whether they are stale another test says, for all pages."""
    for name in pages_words.TABLES:
        assert len(filler.marked_pages(name)) == 1, name
    assert len(pages_words.page_rows()) == len(WORDS)
    assert f"`{table.crc():08x}`" in (ROOT / "docs" / "words.md").read_text(encoding="utf-8")


def test_connections_of_a_bench():
    text = generated.connections("X", Sizes(2), None, driven=("clear",))
    assert "reg [53:0] root_i = {27'h0, 27'h0};" in text
    assert ".root_i (root_i)," in text
    assert "wire [63:0] position;" in text
    assert ".position_o (position)," in text
    assert "clear_i" not in text
    wires, ports = text.split("`define X_PORTS")
    assert wires.startswith("`define X_WIRES")
    assert ports.count("_i (") == len(table.ports()) - 1
    assert ports.count("_o (") == len(table.ports("o"))


def test_a_shim_takes_each_port_from_where_it_is_put():
    sizes = Sizes(1, 3, 1, 10)
    values = {"hold_ticks": 900, "u_max": 0x12345678, "wall_max": [-1, -2, -3]}
    words = generated.chunks(values, sizes)
    places = dict(re.findall(r"give\(top\.(\w+)_i, words \+ (\d+)\)", generated.shim_header(sizes)))
    assert list(places) == list(table.ports())
    assert words[int(places["hold_ticks"])] == 900
    assert words[int(places["u_max"])] == 0x12345678
    first = int(places["wall_max"])
    assert words[first : first + 3] == [0xFFFFFFFF, 0xFFFFFFFE, 0xFFFFFFFD]
    assert int(places["shape_words"]) + (9 * 31 + 3 * 12 + 31) // 32 == len(words)


# ---- The settings memory.


def test_every_setting_says_when_it_may_change():
    """What a block counts with, or protects itself by, with the bridges off only."""
    kinds = {}
    for word in WORDS.values():
        if word.row.kind == "setting":
            kinds.setdefault(word.change, set()).add(f"{word.block}.{word.group}")
    assert set(kinds) == set(table.CHANGES)
    counts = ("wh_carrier.carrier", "wh_adc_serial.frame", "wh_pwm.bridge", "wh_wave_core.delay")
    assert kinds["off"] > {*counts, "wh_guard.guard", "wh_trip.trip"}
    assert kinds["anchor"] == {"wh_anchor.anchor"}
    assert kinds["sum"] == {"wh_current.current"}


def test_what_scales_cannot_be_written_below_zero():
    """Such a gain or limit would turn what damps or holds into what pushes."""
    scales = {
        word.name for word in WORDS.values()
        if word.row.kind == "setting" and word.fixed.signed and word.row.unit
        and word.row.unit not in ("counts", "clocks", "ticks")
    }  # fmt: skip
    assert scales > {"gain", "root", "u_max", "clocks_per_volt", "anchor_pull_gain", "anchor_reach"}
    assert {name: WORDS[name].range[0] for name in scales} == dict.fromkeys(scales, 0.0)


def test_words_of_the_memory_are_no_ports():
    own = {word.name for word in WORDS.values() if word.block == table.MEMORY}
    assert own == {"commit", "discard", "settings_busy", "settings_staged"}
    assert not own & {*table.ports(), *table.ports("o")}
    beside = {word.name for word in WORDS.values() if word.block in table.BESIDE}
    assert beside > {"arm", "armed", "arm_refused", "ticks", "flags", "capture", "capture_data"}
    assert not beside & {*table.ports(), *table.ports("o")}
    rtl = (formats.RTL_DIR / "wh_registers.v").read_text(encoding="utf-8")
    for name in ("commit", "discard"):
        at = WORDS[name].at()
        assert re.search(rf"localparam \[11:0\] {name.upper()}\s+= 12'h{at:03x};", rtl)
    for name, register in (("settings_busy", "pass_q"), ("settings_staged", "staged_q")):
        assert f"8'h{WORDS[name].at():02x}:   answer = {{31'd0, {register}}};" in rtl


def test_what_rows_are_made_of_is_at_its_address():
    """In the RTL and in Python; and the bits of ``flags`` in both."""
    rtl = (formats.RTL_DIR / "wh_round_words.v").read_text(encoding="utf-8")
    cases = rtl[rtl.index("casez (code_q") : rtl.index("default:")]
    found = {int(place, 16) for place in re.findall(r"8'h(\w+)", cases)}
    for place in re.findall(r"8'b([\d_?]+)", cases):
        bits = place.replace("_", "")
        low, free = bits.replace("?", "0"), bits.count("?")
        found |= {int(low, 2) + n for n in range(1 << free)}
    assert found == {WORDS[name].at() % 0x100 for name in capture.MOTOR_WORDS}
    board = {int(place, 16) for place in re.findall(r"code_q == 12'h(\w+)", rtl)}
    assert board == {WORDS[name].at() for name in capture.BOARD_WORDS}
    rtl = (formats.RTL_DIR / "wh_registers.v").read_text(encoding="utf-8")
    for place, bit in re.findall(r"8'h(\w\w): +answer = \{31'd0, live_q\[(\d)\]\};", rtl):
        assert WORDS[FLAGS[int(bit)]].at() % 0x100 == int(place, 16)
    assert WORDS["flags"].row.meaning.endswith(f": {', '.join(FLAGS)}")


def test_the_rom_of_a_board_with_some_groups():
    """Its own words at first; words of other groups are fixed: kind 3, and read from the memory."""
    text = generated.settings_rom({"trip": 0x1234}, {"wh_contact.walls"})
    rows = dict(re.findall(r"\('h(\w{3}), [^,]+, 2'b\d+, (8'h\w\w), .*// \w+\n", text))
    assert rows[f"{WORDS['trip'].at():03x}"][3:] >= "e0"
    assert rows[f"{WORDS['wall_min'].at():03x}"][3] in "45"
    assert re.search(r"32'h00001234\)  // trip\n", text)
    text = generated.settings_rom({"wall_min": [1, -2]})
    walls = re.findall(r"\('h(14\w), (\w+), 2'b\d+, 8'h\w\w, (\S+)\)", text)
    assert walls == [
        ("140", "WALLS", "0"),
        ("140", "1", "32'h00000001"),
        ("141", "1", "32'hfffffffe"),
    ]
