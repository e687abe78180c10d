"""The examples in docstrings do what they show, and every public name has one."""

import doctest
from importlib import import_module
from pathlib import Path

import pytest
import upwash

PACKAGE = Path(upwash.__file__).parent
MODULES = sorted(
    ".".join(["upwash", *path.relative_to(PACKAGE).with_suffix("").parts]).removesuffix(".__init__")
    for path in PACKAGE.rglob("*.py")
    if ">>>" in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("module", MODULES)
def test_the_examples_of_a_module_do_what_they_show(module):
    failed, tried = doctest.testmod(import_module(module))
    assert tried and not failed


@pytest.mark.parametrize("name", upwash.__all__)
def test_a_public_name_has_an_example(name):
    assert ">>> " in getattr(upwash, name).__doc__
