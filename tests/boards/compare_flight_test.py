#!/usr/bin/env python3
"""Checks tools/compare_flight.sh against its head comment, with our programs in place of those that fly.

The script runs from a folder with its input files and a build with these programs.
"""
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

from boot_test import ROOT, alive, until

SIM = """#!/bin/bash
echo $$ >>"$HERE/pids"
echo 'listening on tcp:127.0.0.1:4560 (lockstep)'
exec sleep 60
"""
# Flies here and, by $1, elsewhere: prints hashes, and ends as $1 says.
FLY = """#!/bin/bash
if [[ $1 == hangs ]]; then
  echo $$ >>"$HERE/pids"
  exec sleep 60
fi
[[ $1 != silent ]] || { echo 'no robot file' >&2 && exit 2; }
printf 'hash imu.raw 11\\r\\nhash filter.state %s\\r\\n' "$([[ $1 == other ]] && echo 23 || echo 22)"
[[ $1 != more ]] || printf 'hash camera.image 33\\r\\n'
[[ $1 != crashes ]] || exit 1
"""


class CompareFlight(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.here = pathlib.Path(holder.name)
        for name in ("tools/compare_flight.sh", "tools/lib.sh"):
            (self.here / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.here / name)
        self.bin = self.here / "build/release/bin"
        self.bin.mkdir(parents=True)
        for name, text in (("sinew-sim", SIM), ("sinew-fly", FLY)):
            (self.bin / name).write_text(text, encoding="ascii")
            (self.bin / name).chmod(0o755)

    def start(self, *words):
        (self.here / "tmp").mkdir(exist_ok=True)
        process = subprocess.Popen([self.here / "tools/compare_flight.sh", *words], stdout=subprocess.PIPE, text=True,
                                   stderr=subprocess.PIPE, start_new_session=True,
                                   env={**os.environ, "HERE": str(self.here), "TMPDIR": str(self.here / "tmp")})
        self.addCleanup(process.communicate)
        self.addCleanup(process.terminate)
        return process

    def compare(self, *words):
        process = self.start(*words)
        out, err = process.communicate(timeout=60)
        return process.returncode, out, err

    def fly(self, how, *options):
        return self.compare("--label", "board", *options, "--", str(self.bin / "sinew-fly"), how)

    def expect_failure(self, how, said):
        code, _, err = self.fly(how)
        self.assertEqual(code, 1)
        self.assertIn(said, err)

    def test_the_same_bytes_are_told(self):
        code, out, err = self.fly("same")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("board: the same bytes on all 2 topics", out)

    def test_the_first_topic_that_differs_is_named(self):
        self.expect_failure("other", "board: the first topic that differs: filter.state")

    def test_a_topic_that_only_the_other_has_is_named(self):
        self.expect_failure("more", "board: the first topic that differs: camera.image")

    def test_a_flight_that_was_none_is_told_with_its_words(self):
        self.expect_failure("silent", "board: no flight (exit 2): no robot file")

    def test_the_whole_mission_has_to_end_well_and_a_part_of_it_need_not(self):
        self.expect_failure("crashes", "board: exit 1")
        self.assertEqual(self.fly("crashes", "--duration", "5")[0], 0)

    def test_whatever_it_started_ends_with_it(self):
        for how in (signal.SIGTERM, signal.SIGINT):
            process = self.start("--", str(self.bin / "sinew-fly"), "hangs")
            pids = self.here / "pids"  # of both simulators, and of the program that flies elsewhere
            until(lambda: pids.exists() and len(pids.read_text(encoding="ascii").split()) == 3)  # pylint: disable=W0640
            os.killpg(process.pid, how)  # as a terminal does it
            process.communicate(timeout=30)
            self.assertEqual(process.returncode, -how)
            for pid in pids.read_text(encoding="ascii").split():
                until(lambda: not alive(int(pid)))  # pylint: disable=W0640
            pids.unlink()
            self.assertEqual(list((self.here / "tmp").iterdir()), [])

    def test_wrong_calls_are_told(self):
        for words, said in (((), "which command flies?"), (("--fast",), "--fast: unknown"), (("--seed",), "--seed: of what?"),
                            (("--duration", "--", "x"), "--duration: of what?")):
            code, out, err = self.compare(*words)
            self.assertEqual((code, out), (1, ""))
            self.assertIn(said, err)
        (self.bin / "sinew-fly").unlink()
        self.assertIn("cmake --build build/release --target sinew-fly", self.fly("same")[2])


if __name__ == "__main__":
    unittest.main()
