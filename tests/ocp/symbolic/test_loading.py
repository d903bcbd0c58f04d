"""Printed modules that several threads ask for at once."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from doorman.ocp.kernels.printed.loading import load


def test_no_thread_sees_a_module_before_its_last_line() -> None:
    text = "import time\ntime.sleep(0.05)\nLAST = 'of a text that no other test has'\n"
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(lambda _: load(text), range(6)))
    assert all(module is found[0] and module.LAST for module in found)


def test_a_text_that_fails_is_no_module() -> None:
    before = set(sys.modules)
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            load("FIRST = 1\nLAST = 1 / 0\n")
    assert {name for name in set(sys.modules) - before if "printed" in name} == set()
