#!/usr/bin/env python3
"""tests/boards/memory_here.py against a program whose memory is known."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parent / "memory_here.py"
KNOWN = """
import ctypes, mmap, sys, time
page, kib = mmap.PAGESIZE, 1024
held = bytearray(b"x") * (40 * kib * kib)
area = mmap.mmap(-1, 64 * page)
libc = ctypes.CDLL(None, use_errno=True)
at = ctypes.addressof(ctypes.c_char.from_buffer(area))
if libc.mlock(ctypes.c_void_p(at), ctypes.c_size_t(64 * page)) != 0: sys.exit(9)
time.sleep(1)
libc.munlock(ctypes.c_void_p(at), ctypes.c_size_t(64 * page))
del held
print("ready 0.07 s after the start")
sys.exit(4)
"""


class Memory(unittest.TestCase):
    def measure(self, *program):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "memory"
            done = subprocess.run([sys.executable, "-B", TOOL, out, *program], capture_output=True, text=True, check=False,
                                  timeout=60)
            return done, dict(re.findall(r"^(\w+)=(\d+)$", out.read_text(), re.M)) if out.exists() else None

    def test_most_of_the_run_is_told_and_the_programs_words_and_exit_code(self):
        done, memory = self.measure(sys.executable, "-c", KNOWN)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertEqual(done.stdout, "ready 0.07 s after the start\n")
        self.assertEqual(memory["locked_kb"], str(64 * 4))
        self.assertGreater(int(memory["rss_kb"]), 40 * 1024)
        self.assertLess(int(memory["rss_kb"]), 80 * 1024)
        self.assertEqual(memory["start_ms"], "70")

    def test_a_program_may_say_much(self):
        done, memory = self.measure(sys.executable, "-c", "import time; print('x' * 300_000, flush=True); time.sleep(0.5)")
        self.assertEqual((done.returncode, len(done.stdout)), (0, 300_001))
        self.assertIsNotNone(memory)

    def test_what_cannot_be_measured_is_no_number(self):
        done, memory = self.measure("/nowhere/program")
        self.assertEqual((done.returncode, memory), (3, None))
        self.assertIn("/nowhere/program: ", done.stderr)
        self.assertEqual(self.measure()[0].returncode, 2)

    def test_where_the_numbers_cannot_go_nothing_is_started(self):
        with tempfile.TemporaryDirectory() as folder:
            for out in (f"{folder}/nowhere/memory", folder):
                done = subprocess.run([sys.executable, "-B", TOOL, out, "touch", f"{folder}/started"], capture_output=True,
                                      text=True, check=False, timeout=60)
                self.assertEqual(done.returncode, 2)
                self.assertRegex(done.stderr, rf"^memory_here: {re.escape(out)}: ")
            self.assertFalse(pathlib.Path(folder, "started").exists())


if __name__ == "__main__":
    unittest.main()
