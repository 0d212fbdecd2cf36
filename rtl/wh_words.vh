// SPDX-License-Identifier: Apache-2.0
//
// wh_words: of the table of words.toml, which this is made from.

`ifndef WH_WORDS_VH
`define WH_WORDS_VH

// CRC-32 of all that two sides have to agree on: everything but default, port and meaning.
// <!-- begin words-crc -->
`define WH_WORDS_CRC 32'h69734c31
// <!-- end words-crc -->

`endif
