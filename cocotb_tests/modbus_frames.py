# SPDX-License-Identifier: Apache-2.0
"""A Modbus master's frames and what it makes of the answers, by pymodbus' framer and messages."""

from __future__ import annotations

from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.mei_message import ReadDeviceInformationRequest
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadInputRegistersRequest,
    WriteMultipleRegistersRequest,
    WriteSingleRegisterRequest,
)  # fmt: skip

UNIT = 1
TABLE = 0x2000
"""Register of the table's first word."""

FUNCTION, ADDRESS, VALUE, FAILURE, NOT_NOW = 1, 2, 3, 4, 6
"""Exceptions."""

FRAMER = FramerRTU(DecodePDU(False))


def frame(pdu: ModbusPDU) -> bytes:
    """A request as it stands on the line."""
    return FRAMER.buildFrame(pdu)


def raw(data: bytes, unit: int = UNIT) -> bytes:
    """Any bytes behind the unit, with the right CRC."""
    body = bytes([unit]) + data
    return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")


def read(address: int, count: int, function: int = 3, unit: int = UNIT) -> bytes:
    kind = {3: ReadHoldingRegistersRequest, 4: ReadInputRegistersRequest}[function]
    return frame(kind(address=address, count=count, dev_id=unit))


def write_one(address: int, value: int, unit: int = UNIT) -> bytes:
    return frame(WriteSingleRegisterRequest(address=address, registers=[value], dev_id=unit))


def write(address: int, registers: list[int], unit: int = UNIT) -> bytes:
    return frame(WriteMultipleRegistersRequest(address=address, registers=registers, dev_id=unit))


def words(address: int, values: list[int], unit: int = UNIT) -> bytes:
    """Write words of the table, from one address on."""
    return write(TABLE + 2 * address, halves(values), unit)


def halves(values: list[int]) -> list[int]:
    return [half for value in values for half in (value >> 16 & 0xFFFF, value & 0xFFFF)]


def whole(registers: list[int]) -> list[int]:
    return [high << 16 | low for high, low in zip(registers[::2], registers[1::2], strict=True)]


def identify(code: int = 1, number: int = 0) -> bytes:
    return frame(ReadDeviceInformationRequest(read_code=code, object_id=number, dev_id=UNIT))


def decode(answer: bytes) -> ModbusPDU:
    """What the master reads in an answer, all of which has to be one frame of the unit."""
    used, pdu = FRAMER.handleFrame(answer, UNIT, 0)
    assert used == len(answer), answer.hex()
    assert pdu is not None, answer.hex()
    return pdu
