# SPDX-License-Identifier: Apache-2.0
"""What ``rtl/wh_device.v`` is made of by the table of words: settings, commands, live words.

The text stands inside the module. Its settings go to the controller by wires ``set_PORT``, and what
the controller tells comes by wires with the names of its ports, without ``_o``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from wavehaptics.words import table
from wavehaptics.words.generated import verilog_number
from wavehaptics.words.table import (
    LEGS,
    MEMORY,
    MOST,
    THREE_PHASE_LEGS,
    Word,
    format_parts,
)

_COPIES = {"board": (), "motor": ("PARTS",), "wall": ("PARTS", "WALLS"),
           "section": ("PARTS", "SECTIONS")}  # fmt: skip
"""How many copies of a word a wire has, in Verilog. A part is a motor, or an axis of one."""


_ALSO = {
    "restart": "set_restart || loading",
    "clear": "set_clear || clear_i",
    "zero_start": "set_zero_start || zero_start_i || arm_zero_start || clear_zero",
}
"""Inputs that the module itself drives as well."""


_SEEN = {"host_sequence": "seen_host_sequence", "host_v": "seen_host_v"}
"""Outputs of the controller that the module keeps while a frame reads them."""


_OTHERS = ("wh_surface_frame",)
"""Blocks that the module hasn't got: settings that nobody reads, and live words that are 0."""


_STAGED = {"off": "0", "any": "0"}
"""By the kind of change: words that nobody reads meanwhile wait for no reader."""


def _bits(word: Word) -> str:
    return verilog_number(format_parts(word.row.format)[1])


def _sum(words: Iterable[Word]) -> str:
    """Bits of a copy of words side by side; "" for none."""
    known, named = 0, Counter[str]()
    for word in words:
        if (bits := _bits(word)).isdigit():
            known += word.row.count * int(bits)
        else:
            named[bits] += word.row.count
    terms = [bits if count == 1 else f"{count}*{bits}" for bits, count in named.items()]
    return " + ".join([*terms, *([str(known)] if known else [])])


def _factor(text: str) -> str:
    return f"({text})" if " " in text else text


def _wire(name: str, words: list[Word]) -> str:
    factors = [*_COPIES[words[0].row.per], _factor(_sum(words))]
    if len(factors) == 1:
        return f"wire [{_last(_sum(words))}:0] {name};"
    return f"wire [{'*'.join(factors).removesuffix('*1')}-1:0] {name};"


def _last(bits: str) -> str:
    return str(int(bits) - 1) if bits.isdigit() else f"{bits}-1"


def _groups() -> dict[str, list[Word]]:
    found: dict[str, list[Word]] = {}
    for word in table.WORDS.values():
        if word.row.kind == "setting":
            found.setdefault(f"{word.block}.{word.group}", []).append(word)
    return found


def _runs(words: list[Word]) -> list[list[Word]]:
    """Rows of a group whose words stand evenly apart in one copy: all, or of sections each."""
    if words[0].row.per == "section":
        return [[word] for word in words]
    return [words]


def _place(word: Word) -> str:
    """Lowest bit of a word in its port, by the copy (motor n, wall or section k)."""
    mates = table.ports(beside=word.block in table.BESIDE, legs=None)[word.port[:-2]]
    copy = {"board": "", "motor": "n", "wall": "n*WALLS + k", "section": "n*SECTIONS + k"}
    below = _sum(mates[: mates.index(word)])
    if not copy[word.row.per]:
        return below or "0"
    first = f"{_factor(copy[word.row.per])}*{_factor(_sum(mates))}".removesuffix("*1")
    return f"{first} + {below}" if below else first


def _instance(name: str, words: list[Word]) -> list[str]:
    """A ``wh_setting_group`` for one copy of the rows, and where its words go."""
    row, first = words[0].row, words[0].at() & 0xFF
    bits = [_bits(word) for word in words for _ in range(word.row.count)]
    offset = {"wall": " + K[7:0]", "section": f" + 8'd{row.count} * K[7:0]"}.get(row.per, "")
    lines = [f"wire [{_last(_sum(words))}:0] {name}_words;"]
    packed = ", ".join(
        f"8'd{bit}" if bit.isdigit() else f"{bit.removeprefix('`WH_')}_8" for bit in reversed(bits)
    )
    pending = {"board": "", "motor": "[n]", "wall": "[n*WALLS + k]", "section": "[n*SECTIONS + k]"}
    lines += [
        "",
        "wh_setting_group #(",
        f"    .STAGED    ({_STAGED.get(words[0].change, '1')}),",
        f"    .PART      ({'PART[3:0]' if row.per != 'board' else chr(52) + chr(39) + 'd0'}),",
        f"    .FIRST     (8'h{first:02x}{offset}),",
        f"    .STRIDE    (8'd{MOST['wall'] if row.per == 'wall' else 1}),",
        f"    .WORDS     ({len(bits)}),",
        f"    .WIDTHS    ({{{packed}}}),",
        f"    .TOTAL_W   ({_sum(words)})",
        f") {name} (",
        "    `WH_DEVICE_BUS",
        f"    .hold_i    (hold_{words[0].change}{'[n]' if words[0].change == 'anchor' else ''}),",
        f"    .pending_o (pending_{name}{pending[row.per]}),",
        f"    .words_o   ({name}_words)",
        ");",
        "",
    ]
    for number, word in enumerate(words):
        width, low = _sum([word]), _sum(words[:number]) or "0"
        goal = f"set_{word.port[:-2]}[{_place(word)} +: {width}]"
        lines.append(f"assign {goal} = {name}_words[{low} +: {width}];")
    return lines


def _indented(lines: Iterable[str], depth: int = 1) -> list[str]:
    return [f"{'    ' * depth}{line}" if line else "" for line in lines]


def _group(words: list[Word]) -> tuple[list[str], list[str]]:
    """Lines of a group, and its wires of ``pending_o``."""
    per, lines, pendings = words[0].row.per, [], []
    for number, run in enumerate(_runs(words)):
        name = run[0].group if number == 0 else f"{run[0].group}_{number}"
        pendings.append(f"pending_{name}")
        copies = "*".join(_COPIES[per])
        lines.append(f"wire{f' [{copies}-1:0]' if copies else ''} pending_{name};")
        inner = _instance(name, run)
        part = ["localparam [31:0] PART = n + 1;"]
        if per == "board":
            lines += [*inner, ""]
            continue
        lines += ["generate", f"    for (n = 0; n < PARTS; n = n + 1) begin : {name}_of_motor"]
        if per == "motor":
            lines += _indented([*part, *inner], 2)
        else:
            count = _COPIES[per][1]
            lines += _indented([*part, f"for (k = 0; k < {count}; k = k + 1) begin : each_copy"], 2)
            lines += _indented(["localparam [31:0] K = k;", *inner], 3)
            lines += ["        end"]
        lines += ["    end", "endgenerate", ""]
    return lines, pendings


def _command(word: Word) -> list[str]:
    """A strobe, or a register that is written. A board's strobe of several bits comes with any."""
    port, bits = word.port[:-2], _bits(word)
    place = f"12'h{word.at():03x}"
    if word.row.per == "board":
        one = " && command_data_q[0]" if bits == "1" else ""
        return [f"assign set_{port} = command_q && command_address_q == {place}{one};"]
    here = f"command_q && command_address_q == {{PART[3:0], 8'h{word.at() & 0xFF:02x}}}"
    lines = ["localparam [31:0] PART = n + 1;", ""]
    if bits == "1":
        lines.append(f"assign set_{port}[n] = {here} && command_data_q[0];")
    else:
        lines += [
            f"reg [{_last(bits)}:0] word_q;", "", "always @(posedge clk) begin",
            f"    if ({here}) begin",
            f"        word_q <= command_data_q[{_last(bits)}:0];",
            "    end", "end", "", f"assign set_{port}[n*{bits} +: {bits}] = word_q;",
        ]  # fmt: skip
    loop = f"    for (n = 0; n < PARTS; n = n + 1) begin : {word.name}_of_motor"
    return ["generate", loop, *_indented(lines, 2), "    end", "endgenerate"]


def _live(word: Word) -> str:
    """A case of the live words, of 33 bits. Words of one row on the board come by one port."""
    port, bits = word.port, _bits(word)
    name = port if port.endswith("_i") else _SEEN.get(port[:-2], port[:-2])
    place = "0" if word.row.per == "board" else f"m*{bits}"
    if bits == "1":
        value = f"{{32'd0, {name}}}" if word.row.per == "board" else f"{{32'd0, {name}[m]}}"
    else:
        top = f"{name}[{place} + {bits} - 1]" if word.fixed.signed else "1'b0"
        ahead = 33 - int(bits) if bits.isdigit() else f"33-{bits}"
        value = f"{{{{{ahead}{{{top}}}}}, {name}[{place} +: {bits}]}}"
    if (low := _index_bits(word)) is not None:
        place = f"bus_address_i[11:{low}] == {12 - low}'h{word.at() >> low:x}"
        return f"if ({place}) live = {value};"
    number = f"12'h{word.at():03x}" if word.row.per == "board" else f"8'h{word.at() & 0xFF:02x}"
    return f"{number}: live = {value};"


def _index_bits(word: Word) -> int | None:
    """Bits of an address that count the words of a board's row, None of one with one word."""
    if word.row.count == 1 or word.row.per != "board":
        return None
    bits = (word.row.count - 1).bit_length()
    if word.row.count != 1 << bits or word.at() % word.row.count:
        raise ValueError(f"{word.name}: the words of a live row are 2^n, at a multiple of that")
    return bits


def device_words() -> str:
    """``rtl/wh_device_words.vh``."""
    inputs, outputs = table.ports(legs=None), table.ports("o", legs=None)
    lines = ["// Settings and commands, on their way to the controller and beside it.", ""]
    driven = {port: words for port, words in inputs.items() if words[0].row.kind != "live"}
    beside = {
        port: words
        for port, words in table.ports(beside=True).items()
        if words[0].row.kind == "setting"
    }
    lines += [_wire(f"set_{port}", words) for port, words in (driven | beside).items()]
    lines += ["", "// Widths that a tool or the hardware sets.", ""]
    named = dict.fromkeys(_bits(word) for word in table.WORDS.values())
    lines += [
        f"localparam [7:0] {bits.removeprefix('`WH_')}_8 = "
        f"{bits}{'' if bits[0] == '`' else '[7:0]'};"
        for bits in named
        if not bits.isdigit()
    ]
    lines += ["", "// What the controller tells.", ""]
    lines += [_wire(port, words) for port, words in outputs.items()]
    others = [word for word in table.WORDS.values() if word.block in _OTHERS]
    nobody = ", ".join(f"set_{w.port[:-2]}" for w in others if w.row.kind == "setting")
    lines += [
        f"wire [{_last(_bits(word))}:0] {word.port[:-2]} = {_bits(word)}'d0;"
        for word in others
        if word.row.kind == "live"
    ]
    lines += [f"wire unused_others = &{{1'b0, {nobody}}};"]
    lines += ["", "// The groups.", ""]
    pendings: list[str] = []
    for words in _groups().values():
        made, found = _group(words)
        lines += made
        pendings += found
    lines += [f"assign changing = {' || '.join(f'(|{wire})' for wire in pendings)};"]
    lines += ["", "// Commands.", ""]
    words = [word for word in table.WORDS.values() if word.block != MEMORY]
    for word in words:
        if word.row.kind == "command" and word.block not in _OTHERS:
            lines += _command(word)
    lines += ["", "// Live words.", "", "always @* begin", "    live = 33'd0;"]
    lines += ["    case (bus_address_i)"]
    live = [word for word in words if word.row.kind == "live"]
    board = [word for word in live if word.row.per == "board"]
    lines += _indented((_live(word) for word in board if _index_bits(word) is None), 2)
    lines += ["        default: live = 33'd0;", "    endcase"]
    lines += _indented(_live(word) for word in board if _index_bits(word) is not None)
    lines += ["    for (m = 0; m < PARTS; m = m + 1) begin"]
    lines += ["        if ({28'd0, bus_address_i[11:8]} == m + 1) begin"]
    lines += ["            case (bus_address_i[7:0])"]
    lines += _indented((_live(word) for word in live if word.row.per == "motor"), 4)
    lines += ["                default: live = 33'd0;", "            endcase"]
    lines += ["        end", "    end", "end", ""]
    made = [_connected(name, legs) for name, legs in _CONTROLLERS.items()]
    return "\n".join(lines) + "\n" + "\n".join(made)


_CONTROLLERS = {"WH_DEVICE": LEGS, "WH_BRUSHLESS": THREE_PHASE_LEGS}
"""What stands in the module, by the beginning of its macros' names."""


def _connected(name: str, legs: int) -> str:
    """``NAME_PORTS``, a controller's connections; ``NAME_WITHOUT``, wires that it leaves out.

    What a brushless motor tells once, all parts have, by ``NAME_ONCE``.
    """
    ports, without, once = [], [], []
    everything = table.ports(legs=None)
    for port, words in everything.items():
        if words[0].row.kind == "live":
            ports.append(f".{port}_i ({port}_i)")
            continue
        wire, there = f"set_{port}", words[0].parts(1, legs)
        one = legs == THREE_PHASE_LEGS and words[0].row.per != "board" and there == 1
        if not there:
            without.append(wire)
        else:
            part = _first_part(words) if one else ""
            ports.append(f".{port}_i ({_ALSO.get(port, wire + part)})")
            without += [wire] if one else []
    for port, words in table.ports("o", legs=legs).items():
        one = legs == THREE_PHASE_LEGS and words[0].row.per != "board"
        one = one and words[0].parts(1, legs) == 1
        ports.append(f".{port}_o ({'once_' if one else ''}{port})")
        if one:
            part = _first_part(words).replace("[0]", "[0:0]")
            once += [f"wire {part} once_{port};", f"assign {port} = {{PARTS{{once_{port}}}}};"]
    return (
        " \\\n    ".join([f"`define {name}_PORTS", *(f"{port}," for port in ports)])
        + "\n\n"
        + " \\\n    ".join([f"`define {name}_WITHOUT", ", \\\n    ".join(without)])
        + "\n"
        + ("\n" + " \\\n    ".join([f"`define {name}_ONCE", *once]) + "\n" if once else "")
    )


def _first_part(words: list[Word]) -> str:
    """The bits of a wire that are the first motor's."""
    factors = [*_COPIES[words[0].row.per][1:], _factor(_sum(words))]
    bits = "*".join(factors).removesuffix("*1")
    return "[0]" if bits == "1" else f"[{bits}-1:0]"
