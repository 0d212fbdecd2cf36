# SPDX-License-Identifier: Apache-2.0
"""Files are there whole or not at all, and a digest tells what has changed."""

from __future__ import annotations

import json
import math

import pytest
from wavehaptics.runtime.files import digest_of, replacing, write_json, write_text


def test_a_file_is_written_into_a_folder_that_is_made(tmp_path):
    path = tmp_path / "new" / "one.json"
    assert write_json(path, {"Ω": [1.5, None]}) == path
    assert json.loads(path.read_text(encoding="utf-8")) == {"Ω": [1.5, None]}
    assert path.read_bytes().endswith(b"}\n")
    assert [p.name for p in path.parent.iterdir()] == ["one.json"]


@pytest.mark.parametrize("fault", [ValueError, KeyboardInterrupt])
def test_what_was_there_stays_when_writing_fails(tmp_path, fault):
    path = write_text(tmp_path / "kept.txt", "before")

    def stopped() -> None:
        with replacing(path) as part:
            part.write_text("half")
            raise fault

    with pytest.raises(fault):
        stopped()
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_no_number_is_refused_and_leaves_nothing(tmp_path):
    with pytest.raises(ValueError, match="JSON compliant"):
        write_json(tmp_path / "metrics.json", {"stiffness": math.nan})
    assert list(tmp_path.iterdir()) == []


def test_a_digest_counts_words_names_and_contents(tmp_path):
    first, second = (write_text(tmp_path / name, "same") for name in ("a", "b"))
    digests = [
        digest_of("told"), digest_of("other"), digest_of("told", [first]),
        digest_of("told", [second]), digest_of("told", [first, second]),
    ]  # fmt: skip
    write_text(first, "changed")
    digests.append(digest_of("told", [first]))
    assert len(set(digests)) == len(digests)
    assert digest_of("told", [first]) == digests[-1]
    (tmp_path / "below").mkdir()
    below = write_text(tmp_path / "below" / "a", "changed")
    assert digest_of("told", [below]) == digests[-1]
    assert digest_of("told", [below], tmp_path) != digest_of("told", [first], tmp_path)


def test_a_link_stays_one(tmp_path):
    """What it points to is replaced, in its own folder."""
    (tmp_path / "there").mkdir()
    target = tmp_path / "there" / "a.txt"
    target.write_text("old")
    link = tmp_path / "a.txt"
    link.symlink_to(target)
    assert write_text(link, "new") == link
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert [path.name for path in target.parent.iterdir()] == ["a.txt"]
