#!/usr/bin/env python3
"""Checks tools/sizes.py with a program made here, with budgets that fit it, and budgets that do not.

Environment: CXX the compiler (set by CMakeLists.txt).
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = "sinew-control"
FIRST = "target\tprogram\twhat\tbytes\tat_most\tnote"


class Sizes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.holder.name)
        ours, theirs = cls.root / "CMakeFiles/p.dir", cls.root / "theirs"
        ours.mkdir(parents=True)
        theirs.mkdir()
        (ours / "a.cpp").write_text("extern const char there[];\nextern const char here[200000] = {1};\nint number[30000];\n"
                                    "int main(int n, char**) { return here[n] + there[n] + number[n]; }\n")
        (theirs / "b.cpp").write_text("extern const char there[300000] = {1};\n")
        cls.bin = cls.root / "bin"
        cls.bin.mkdir()
        for folder, name in ((ours, "a"), (theirs, "b")):
            subprocess.run([os.environ["CXX"], "-c", "-o", folder / f"{name}.o", folder / f"{name}.cpp"], check=True)
        subprocess.run([os.environ["CXX"], "-o", cls.bin / PROGRAM, "CMakeFiles/p.dir/a.o", "theirs/b.o",
                        f"-Wl,-Map,{cls.bin / PROGRAM}.map"], cwd=cls.root, check=True)
        said = subprocess.run(["size", cls.bin / PROGRAM], check=True, capture_output=True, text=True).stdout
        cls.text, cls.data, cls.bss = (int(word) for word in said.splitlines()[1].split()[:3])
        cls.budget = cls.root / "budget.tsv"

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def run_sizes(self, *words, target=None):
        done = subprocess.run([sys.executable, "-B", ROOT / "tools/sizes.py", target or f"amd64={self.bin}", "--only", PROGRAM,
                               "--budget", self.budget, *words], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr

    def write(self, text=None, at_most="", more=()):
        """A budget that fits, except for `text`."""
        own = self.own_text() if not hasattr(self, "own") else self.own
        rows = [("own text", own, ""), ("text", self.text if text is None else text, at_most), ("data", self.data, ""),
                ("bss", self.bss, ""), *more]
        lines = [f"amd64\t{PROGRAM}\t{what}\t{size}\t{most}\tas made" for what, size, most in rows]
        self.budget.write_text("\n".join([FIRST, *lines]) + "\n")

    def own_text(self):
        self.budget.write_text(FIRST + "\n")
        _, out = self.run_sizes()
        return int(out.split(f"{PROGRAM}: own text: ")[1].split()[0])

    def rows(self):
        return {line.split("\t")[2]: line.split("\t") for line in self.budget.read_text().splitlines()[1:]}

    def test_the_numbers_are_those_of_the_tool_size(self):
        self.write()
        code, out = self.run_sizes()
        self.assertEqual(code, 0, out)
        self.budget.write_text(FIRST + "\n")
        _, out = self.run_sizes()
        for what, size in (("text", self.text), ("data", self.data), ("bss", self.bss)):
            self.assertIn(f"{PROGRAM}: {what}: {size} bytes", out)

    def test_own_text_has_our_objects_and_no_others(self):
        own = self.own_text()
        self.assertGreaterEqual(own, 200000)
        self.assertLess(own, 200000 + 2000)  # not the 300000 of the other object

    def test_six_per_cent_too_large_fails_with_both_numbers_and_what_to_do(self):
        allowed = int(self.text / 1.06)
        self.write(text=allowed)
        code, out = self.run_sizes()
        self.assertEqual(code, 1, out)
        self.assertIn(f"sizes: amd64: {PROGRAM}: text: {self.text} bytes, +6.0% beyond the budget of {allowed} (as made)", out)
        self.assertIn("--accept 'why'", out)

    def test_four_per_cent_more_is_within(self):
        self.write(text=int(self.text / 1.04))
        self.assertEqual(self.run_sizes()[0], 0)

    def test_a_page_more_is_no_matter_however_small_the_rest_is(self):
        self.write()
        self.budget.write_text(self.budget.read_text().replace(f"\tdata\t{self.data}\t", "\tdata\t1\t"))
        self.assertLess(self.data, 4096)
        self.assertEqual(self.run_sizes()[0], 0)

    def test_much_less_is_told_and_no_failure(self):
        self.write(text=int(self.text * 1.2))
        code, out = self.run_sizes()
        self.assertEqual(code, 0, out)
        self.assertIn("may follow", out)
        self.write(text=int(self.text * 1.05))
        self.assertNotIn("may follow", self.run_sizes()[1])

    def test_a_missing_row_fails(self):
        self.write()
        self.budget.write_text("\n".join(line for line in self.budget.read_text().splitlines() if "\tdata\t" not in line))
        code, out = self.run_sizes()
        self.assertEqual(code, 1, out)
        self.assertIn(f"amd64: {PROGRAM}: data: {self.data} bytes, and no row in the budget", out)

    def test_a_missing_program_fails_with_how_to_build_it(self):
        self.write()
        code, out = self.run_sizes(target=f"mipsel={self.root / 'nowhere'}")
        self.assertEqual(code, 1, out)
        self.assertIn(f"mipsel: {PROGRAM}: not in", out)
        self.assertIn(f"cmake --build build/mipsel --target {PROGRAM}", out)

    def test_a_map_that_is_gone_is_no_way_around_the_budget_of_own_text(self):
        self.write()
        other = self.root / "unmapped"
        other.mkdir()
        shutil.copy(self.bin / PROGRAM, other)
        code, out = self.run_sizes(target=f"amd64={other}")
        self.assertEqual(code, 1, out)
        self.assertIn("has a budget for own text", out)

    def test_accepting_changes_what_does_not_fit_and_nothing_else(self):
        self.write(text=self.text // 2)
        code, out = self.run_sizes("--accept", "a new filter")
        self.assertEqual(code, 0, out)
        self.assertEqual(self.rows()["text"][3:], [str(self.text), "", "a new filter"])
        self.assertEqual(self.rows()["data"][5], "as made")
        self.assertEqual(self.run_sizes()[0], 0)

    def test_accepting_needs_a_note(self):
        self.write(text=self.text // 2)
        before = self.budget.read_text()
        for note in ("", " ", "one\ttwo"):
            self.assertEqual(self.run_sizes("--accept", note)[0], 2)
        self.assertEqual(self.budget.read_text(), before)

    def test_what_must_never_be_more_cannot_be_accepted(self):
        self.write(text=self.text // 2, at_most=self.text - 1)
        code, out = self.run_sizes("--accept", "please")
        self.assertEqual(code, 1, out)
        self.assertIn(f"{self.text} bytes, and it must never be more than {self.text - 1}", out)
        self.assertEqual(self.rows()["text"][3], str(self.text // 2))

    def memory(self, text):
        path = self.root / "memory"
        path.write_text(text)
        return "--memory", path

    def test_memory_on_a_board_has_a_budget_too(self):
        self.write(more=[("resident", 2000 * 1024, ""), ("locked", 3000 * 1024, 4000 * 1024)])
        good = "rss_kb=2000\nlocked_kb={}\npeak_rss_kb=1900\n"
        self.assertEqual(self.run_sizes(*self.memory(good.format(3000)))[0], 0)
        code, out = self.run_sizes(*self.memory(good.format(3200)))
        self.assertEqual(code, 1, out)
        self.assertIn(f"locked: {3200 * 1024} bytes, +6.7%", out)
        code, out = self.run_sizes(*self.memory(good.format(4001)))
        self.assertIn("must never be more", out)

    def test_a_run_that_locked_nothing_measures_nothing(self):
        self.write()
        code, out = self.run_sizes(*self.memory("rss_kb=1\nlocked_kb=0\npeak_rss_kb=1\n"))
        self.assertEqual(code, 1, out)
        self.assertIn("nothing was locked", out)

    def test_a_broken_budget_is_named_by_its_line(self):
        for line, what in (("amd64\tsinew\ttext\tmany\t\tx", "six columns"), ("amd64\tsinew\ttext\t1\t\t ", "without a note"),
                           ("amd64\tsinew\tlength\t1\t\tx", "six columns")):
            self.budget.write_text(f"{FIRST}\n{line}\n")
            code, out = self.run_sizes()
            self.assertEqual(code, 1, out)
            self.assertIn(f"{self.budget}:2: {what}", out)

    def test_what_is_no_program_is_said(self):
        self.write()
        other = self.root / "script"
        other.mkdir()
        (other / PROGRAM).write_text("#!/bin/sh\n")
        code, out = self.run_sizes(target=f"amd64={other}")
        self.assertEqual(code, 1, out)
        self.assertIn("no little-endian ELF file", out)

    def test_unknown_words_are_wrong_calls(self):
        self.write()
        self.assertEqual(self.run_sizes(target="sparc")[0], 2)
        self.assertEqual(self.run_sizes("--only", "sinew-tail")[0], 2)


class TheRepositorys(unittest.TestCase):
    def test_budget_holds_the_smallest_robot_on_mipsel_to_its_goal(self):
        most = {}
        for line in (ROOT / "tests/boards/size_budget.tsv").read_text().splitlines()[1:]:
            target, program, what, _, at_most, _ = line.split("\t")
            if (target, program) == ("mipsel", "sinew-control-static"):
                most[what] = at_most
        self.assertEqual(most["own text"], "1000000")
        self.assertEqual(most["text"], "2000000")
        self.assertEqual(most["locked"], "4000000")


if __name__ == "__main__":
    unittest.main()
