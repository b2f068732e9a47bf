#!/usr/bin/env python3
"""README.md promises examples of under 60 lines: names those that are longer.

usage: example_lines.py ROOT
"""
import pathlib
import sys
import unittest

ROOT = pathlib.Path(sys.argv.pop()).resolve()
MOST = 59


def too_long(texts):
    """"own.cpp: 61 lines" of each that is, by name its text."""
    counted = {name: len(text.splitlines()) for name, text in texts.items()}
    return [f"{name}: {lines} lines" for name, lines in sorted(counted.items()) if lines > MOST]


class Examples(unittest.TestCase):
    def test_have_fewer_than_60_lines(self):
        texts = {path.name: path.read_text(encoding="utf-8") for path in
                 [*(ROOT / "examples").glob("*.cpp"), *(ROOT / "examples/panels").glob("*.js")]}
        self.assertGreater(len(texts), 5)
        self.assertEqual(too_long(texts), [])

    def test_a_longer_one_is_named(self):
        self.assertEqual(too_long({"a.cpp": "\n" * 59, "b.cpp": "\n" * 60}), ["b.cpp: 60 lines"])


if __name__ == "__main__":
    unittest.main()
