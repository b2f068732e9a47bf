"""tools/manual_page.py: a program's page has all of its help; text that is no help makes no page."""
import gzip
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

TOOL = f"{sys.argv[1]}/manual_page.py"

HELP = """What it does.
Usage: robot [OPTIONS] SUBCOMMAND

Positionals:
  file FILE REQUIRED          a file, ~ or ^

Options:
  -h,--help                   Print this help message and exit
  --board {sim,linux,dataset,none}
                              instead of the file's
  --speed FLOAT:FLOAT in [0 - 3]=1
                              of the ball
  --just-before-the-column X  of it
  --bare

Subcommands:
  go                          goes

Exit codes: 0 done.
"""
GO = """goes
Usage: robot go [OPTIONS]

Options:
  -h,--help                   Print this help message and exit
  --far M                     .so far

Exit codes: 0 done.
"""
SMALL = "usage: tiny [SECONDS]\nDoes little.\n  SECONDS   for so long\nPrints nothing.\n"


class Page(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def program(self, body):
        path = pathlib.Path(self.folder.name) / "robot"
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return str(path)

    def make(self, *program, into="page.1", code=0):
        done = subprocess.run([sys.executable, "-B", TOOL, "--name", "robot", "--what", "a robot", "--version", "1.2.3",
                               "--into", f"{self.folder.name}/{into}", "--", *program], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stderr if code else pathlib.Path(f"{self.folder.name}/{into}").read_bytes()

    def test_each_option_has_its_meaning_whatever_its_length(self):
        page = self.make(self.program(f"case $1 in go) cat <<'T'\n{GO}T\n;; *) cat <<'T'\n{HELP}T\nesac")).decode()
        self.assertIn('.TH ROBOT 1 "" "Sinew 1.2.3" "Sinew"\n.SH NAME\nrobot \\- a robot\n', page)
        for name, meaning in (("--board {sim,linux,dataset,none}", "instead of the file\\(aqs"),
                              ("--speed FLOAT:FLOAT in [0 - 3]=1", "of the ball"),
                              ("--just-before-the-column X", "of it"),
                              ("--bare", "\\&"),
                              ("file FILE REQUIRED", "a file, \\(ti or \\(ha")):
            self.assertIn(".TP\n.B " + name.replace("-", "\\-") + "\n" + meaning + "\n", page)

    def test_commands_have_parts_and_say_nothing_twice(self):
        page = self.make(self.program(f"case $1 in go) cat <<'T'\n{GO}T\n;; *) cat <<'T'\n{HELP}T\nesac")).decode()
        part = page.split(".SS go\n")[1]
        self.assertIn(".B robot go [OPTIONS]\n", part)
        self.assertIn(".B \\-\\-far M\n\\&.so far\n", part, "a word of text is no request to troff")
        self.assertNotIn("Exit codes", part)
        self.assertNotIn("help", part)

    def test_of_a_small_program_the_lines_of_its_usage(self):
        page = self.make(self.program(f"cat <<'T'\n{SMALL}T")).decode()
        self.assertIn(".SH SYNOPSIS\n.B tiny [SECONDS]\n", page)
        self.assertIn("Does little.", page)
        self.assertIn(".TP\n.B SECONDS\nfor so long\n", page)

    def test_same_help_makes_same_bytes(self):
        program = self.program(f"cat <<'T'\n{SMALL}T")
        first, second = self.make(program, into="a.1.gz"), self.make(program, into="b.1.gz")
        self.assertEqual(first, second)
        self.assertEqual(gzip.decompress(first), self.make(program))

    def test_what_has_no_help_is_an_error(self):
        self.assertIn("--help: exit code 3", self.make(self.program("echo no >&2; exit 3"), code=1))
        self.assertIn("no line 'usage:'", self.make(self.program("echo hello"), code=1))
        self.assertIn("nowhere", self.make("/nowhere", code=1))
        self.assertFalse(pathlib.Path(f"{self.folder.name}/page.1").exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
