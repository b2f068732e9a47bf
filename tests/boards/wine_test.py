#!/usr/bin/env python3
"""toolchains/wine.sh, with our program in Wine's place: tests that start at once share one prefix, made once."""
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# As Wine does: a program that finds a half-made prefix fails.
WINE = """#!/bin/sh
if [ "$1" = wineboot ]; then
  echo begun >>"$WINEPREFIX/boots"
  [ ! -e "$WINEPREFIX/refuses" ] || exit 1
  sleep 0.5
  : >"$WINEPREFIX/whole"
  exit 0
fi
[ -e "$WINEPREFIX/whole" ] || exit 53
echo "$@"
"""


class Prefix(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        here = pathlib.Path(holder.name)
        (here / "wine64").write_text(WINE, encoding="ascii")
        (here / "wine64").chmod(0o755)
        self.prefix = here / "prefix"
        self.prefix.mkdir()
        self.environment = {**os.environ, "PATH": f"{here}:{os.environ['PATH']}", "WINEPREFIX": str(self.prefix)}

    def start(self, *words):
        return subprocess.Popen(["sh", str(ROOT / "toolchains/wine.sh"), *words], env=self.environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def boots(self):
        return (self.prefix / "boots").read_text(encoding="ascii").count("begun")

    def test_programs_that_start_at_once_wait_for_the_one_that_makes_it(self):
        programs = [self.start("program.exe", str(i)) for i in range(4)]
        for i, program in enumerate(programs):
            out, _ = program.communicate(timeout=60)
            self.assertEqual((program.returncode, out), (0, f"program.exe {i}\n"))
        self.assertEqual(self.boots(), 1)

    def test_a_prefix_that_cannot_be_made_is_said_and_tried_again_by_the_next(self):
        (self.prefix / "refuses").touch()
        program = self.start("program.exe")
        _, said = program.communicate(timeout=60)
        self.assertEqual(program.returncode, 1)
        self.assertIn(f"wineboot could not make {self.prefix}", said)
        (self.prefix / "refuses").unlink()
        program = self.start("program.exe")
        program.communicate(timeout=60)
        self.assertEqual((program.returncode, self.boots()), (0, 2))


if __name__ == "__main__":
    unittest.main()
