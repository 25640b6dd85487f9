"""Seeds of command lines: whole numbers in a range, anything else named in one line."""

import argparse

import pytest
from er_models.seed import LARGEST, seed_reader


def test_the_range_is_taken():
    read = seed_reader()
    assert [read(text) for text in ("0", "7", str(LARGEST))] == [0, 7, LARGEST]


@pytest.mark.parametrize("found", ["-1", "8", "1.5", "abc", ""])
def test_all_else_is_told_with_what_is_allowed(found, capsys):
    parser = argparse.ArgumentParser("program")
    parser.add_argument("--seed", type=seed_reader(7))
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["--seed", found])
    assert ended.value.code == 2
    line = f"argument --seed: expected a whole number from 0 to 7, found {found}"
    assert capsys.readouterr().err.rstrip("\n").endswith(line)
