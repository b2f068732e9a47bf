#!/usr/bin/env python3
"""sinew-fuzz against the plant: a handful of cases, one that must fail, and how it is shown.

usage: search_test.py SINEW_FUZZ ROBOTS
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

FUZZ, ROBOTS = sys.argv[1:3]
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
TEMPORARY = tempfile.TemporaryDirectory(prefix="sinew_search_")
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
os.environ["TMPDIR"] = TEMPORARY.name
QUAD = os.path.join(ROBOTS, "quad/quad.toml")
SMALL = ("--camera", "64x48")  # the pad is seen in it, and nothing here depends on more


def run(*arguments):
    done = subprocess.run([FUZZ, *arguments], capture_output=True, text=True, timeout=500)
    return done.returncode, done.stdout, done.stderr


class Search(unittest.TestCase):
    def tearDown(self):
        self.assertEqual(os.listdir(TEMPORARY.name), [], "left behind in the temporary folder")

    def test_what_is_wrong_on_its_command_line_is_refused(self):
        for arguments, words in ((["--seed", "-1"], "--seed: -1 is not an integer from 0 to 18446744073709551615"),
                                 (["--runs", "-3"], "--runs: -3 is not an integer from 0"),
                                 (["--case-seed", "1.5"], "--case-seed: 1.5 is not an integer from 0"),
                                 (["--jobs", "-1"], "--jobs: -1 is not an integer from 0 to 4096"),
                                 (["--twice-every", "-1"], "--twice-every: -1 is not an integer from 0"),
                                 (["--shrink-runs", "-1"], "--shrink-runs: -1 is not an integer from 0"),
                                 (["--case", "world=-1"], "world=-1"),
                                 (["--seeed", "1"], "--seeed: no such option; sinew-fuzz --help lists them; did you mean --seed?")):
            code, out, err = run(QUAD, *arguments)
            self.assertEqual((code, out), (2, ""), (arguments, err))
            self.assertIn(words, err)

    def test_a_few_cases_are_clean_and_their_figures_are_told(self):
        code, out, err = run(QUAD, *SMALL, "--runs", "4", "--seed", "1", "--twice-every", "3", "--json")
        self.assertEqual(code, 0, out + err)
        figures = json.loads(out.splitlines()[0])
        self.assertEqual(figures["runs"], 4)
        self.assertLess(figures["figures"]["landing error, m"]["max"], 0.15)

    def test_a_failure_is_shrunk_to_what_it_needs(self):
        # Half of the time that the chain really takes: every flight fails, with any disturbance.
        with tempfile.TemporaryDirectory() as folder, open(QUAD, encoding="utf-8") as file:
            robot = os.path.join(folder, "hasty.toml")
            text, changes = re.subn(r"(to = \"guardian.motors\"\n)budget_ms = 10\b", r"\1budget_ms = 2.5", file.read())
            self.assertEqual(changes, 1)
            with open(robot, "w", encoding="utf-8") as out:
                out.write(text)
            code, out, err = run(robot, *SMALL, "--profile", os.path.join(ROBOTS, "quad/quad_exec.toml"), "--runs", "4",
                                 "--seed", "1")
        self.assertEqual(code, 1, out + err)
        self.assertRegex(out, r"run 1, case seed \d+\nfailed: age at .*chain imu_to_motors: older than its budget of 2.500 ms")
        self.assertIn("--case 'world=1 jitter=none'\n", out)

    def test_what_cannot_fly_fails(self):
        # A filter that takes 8 ms of every millisecond starves all below it.
        case = "world=5 jitter=9 gust=1 stress=filter*400 stress=pad*2 fault=baro:off@3+0.5"
        code, out, err = run(QUAD, *SMALL, "--case", case)
        self.assertEqual(code, 1, out + err)
        self.assertIn("failed: ", out)

    def test_a_case_is_repeatable(self):
        case = "world=3 jitter=4 gust=1.5 fault=imu:off@6+0.004 fault=camera:delayed(30ms)@5+1"
        first, again = (run(QUAD, *SMALL, "--case", case, "--json") for _ in range(2))
        self.assertEqual(first[0], 0, first)
        self.assertEqual(first, again)

    def test_what_is_wrong_ends_with_2_and_its_reason(self):
        for arguments, words in (([QUAD, "--case", "fault=imu:off"], "case: fault=imu:off: DEVICE:KIND"),
                                 ([QUAD, "--case", "fault=imu:melted@3+1"], "melted"),
                                 ([QUAD, "--profile", "no_such.toml"], "a profile of execution times"),
                                 ([os.path.join(ROBOTS, "none.toml")], "a robot file that can be read")):
            code, out, err = run(*arguments)
            self.assertEqual(code, 2, (arguments, out, err))
            self.assertIn(words, err)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
