# SPDX-License-Identifier: Apache-2.0
"""The pages use plain words: what they don't say, and what they say instead."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from wavehaptics.runtime.repository import ROOT

PAGES = (
    "*.md", "docs/**/*.md", "boards/**/*.md", "formal/*.md", "rtl/*.md", "sim/scenes/README.md",
)  # fmt: skip

INSTEAD = {
    r"hang(s|ing)? on": "depends on; is connected to",
    r"(comes?|came|coming) to (no|an) end": "never finishes; ends",
    r"(comes?|came|coming) to(?! (no|an?|rest|the end|pages)\b)": "is; results in; amounts to",
    r"(ma[dk]e|makes|making)( \w+){0,2} good": "compensates, is compensated",
    r"rungs?|(the|whose) ladder": "model, fidelity level",
    r"(usual|old) ways?": "baseline: sampled impedance control",
    r"withheld|withholds?": "residue, what the limit cuts off",
    r"owed": "residue, carried over to the next period",
    r"(tables?|memor(y|ies)) of words": "register map",
    r"live words?": "status register; live value",
    r"settings['’]? memory": "register file",
    r"settings? groups?": "shadow bank; group",
    r"given (together|over)|being given|change over": "committed, applied together",
    r"(encoder|a|one|per|each) cells?|cells? (off|later|late)": "count",
    r"wish(es|ed)?": "target impedance; request",
    r"twins?": "mutant that must fail",
    r"last place": "LSB",
    r"stands? in": "is in",
    r"seen and left": "known limitation",
    r"(nobody|whoever|who) (knows|wants|believes)": "say which value, and to what",
    r"to be had": "available",
    r"is dear|are dear|dearly": "costs much; takes much logic",
    r"has ways of its own": "say which paths",
}
"""Patterns of words, in lower case, with what to say instead; a blank is any white space."""

EXAMPLES = (
    "It hangs on λ.", "Routing came to\nno end.", "Each block comes to 30 LUT.",
    "The dead time is made good.", "It makes it good.", "On any rung", "the Usual way beside it",
    "What is withheld", "half a clock is owed", "the table of words", "live words are sent",
    "the settings memory", "a setting group", "they are given together", "half of a cell",
    "within 1 % of the wish", "each with a twin", "half of a last place", "It stands in the file.",
    "It was seen and left.", "a voltage that nobody knows",
    "seldom to be had", "Anchors are dear.", "Off has ways of its own.",
)  # fmt: skip


def prose(text: str) -> str:
    """A page without code, generated sections, targets of links and comments; lines stay."""

    def blank(found: re.Match[str]) -> str:
        return "\n" * found[0].count("\n")

    for pattern, flags in (
        (r"<!-- begin (\S+) -->\n.*?<!-- end \1 -->", re.S),
        (r"<!--.*?-->", re.S),
        (r"^ *```.*?^ *```", re.S | re.M),
        (r"(?<=\])\([^)\s]*\)", 0),
    ):
        text = re.sub(pattern, blank, text, flags=flags)
    return re.sub(r"`[^`\n]*`", lambda found: "`" * len(found[0]), text)


def anchor(heading: str) -> str:
    """The anchor that a heading has on a page."""
    return re.sub(r"[^\w -]", "", heading.strip().lower()).replace(" ", "-")


def linked_anchors() -> set[tuple[str, str]]:
    """(name of a page, anchor) of links: such a heading can't change by itself."""
    found = set()
    for path in ROOT.glob("**/*.md"):
        if "build" in path.parts or ".venv" in path.as_posix():
            continue
        for page, place in re.findall(r"\]\(([^)\s#]+)#([^)\s]+)\)", path.read_text("utf-8")):
            found.add(((path.parent / page).resolve().as_posix(), place))
    return found


def not_plain(text: str, kept: frozenset[str] = frozenset()) -> list[tuple[int, str, str]]:
    """(line, words, what to say instead) in a page's text, but for headings in ``kept``."""
    text = "\n".join(
        "" if line.startswith("#") and anchor(line.lstrip("#")) in kept else line
        for line in prose(text).split("\n")
    )
    found = []
    for words, instead in INSTEAD.items():
        pattern = rf"\b(?:{words})(?!\w)".replace(" ", r"\s+")
        for match in re.finditer(pattern, text, re.I):
            line = text.count("\n", 0, match.start()) + 1
            found.append((line, " ".join(match[0].split()), instead))
    return sorted(found)


def pages() -> list[Path]:
    """The pages that are judged, from the root."""
    return [p.relative_to(ROOT) for pattern in PAGES for p in sorted(ROOT.glob(pattern))]


LINKED = linked_anchors()


@pytest.mark.parametrize("page", pages(), ids=str)
def test_page_uses_plain_words(page):
    path = ROOT / page
    kept = frozenset(place for of, place in LINKED if of == path.resolve().as_posix())
    found = [
        f"{page}:{line}: '{words}'; say: {instead}"
        for line, words, instead in not_plain(path.read_text(encoding="utf-8"), kept)
    ]
    assert not found, "\n" + "\n".join(found)


def test_each_pattern_finds_its_example():
    """And one example is found by each: a pattern that finds nothing is none."""
    used = set()
    for example in EXAMPLES:
        found = not_plain(example)
        assert found, example
        used |= {instead for *_, instead in found}
    assert used == set(INSTEAD.values())


@pytest.mark.parametrize(
    "text",
    [
        "`hangs on`", "```\nhangs on\n```\n", "<!-- begin x -->\nhangs on\n<!-- end x -->",
        "[the page](the-usual-way.md)", "It comes to rest.", "about 30 logic cells",
        "a flux that stands still", "It depends on λ.",
    ],
)  # fmt: skip
def test_plain_and_generated_text_passes(text):
    assert not_plain(text) == []


def test_message_names_the_line():
    assert not_plain("One.\n\n```\ncode\n```\nIt hangs\non λ.")[0][:2] == (6, "hangs on")


def test_heading_that_is_linked_to_may_stay():
    text = "## The usual way beside it\n"
    assert not_plain(text) != []
    assert not_plain(text, frozenset({"the-usual-way-beside-it"})) == []
