#!/usr/bin/env python3
"""The files that our tests write, for foreign readers and decoders: made once for both tests that read them.

usage: others_files.py FOLDER TEST...     exit 77: skipped, with the reason

The files of each test program are in FOLDER/NAME of the program; a folder of an earlier time is made anew.
"""
import os
import pathlib
import shutil
import subprocess
import sys

from others_reader_test import SKIPPED, reason_to_skip

# Without the tests that write no file, or some hundred that are each like the next and like those that the other tests
# write: after every cut, every flipped bit and every kill. They take nine tenths of the time. And without those of the
# player, which writes files that are wrong on purpose.
LEFT_OUT = ":".join(("-*RecoveredFromACutAtAnyByte*", "Kill.*", "*/Damage.*Bit*", "*/Damage.CutAtAnyByte*", "Crc32.*",
                     "WriterOnABadDisk.OneThatSaidNo*", "Played.*"))


def main():
    folder, tests = pathlib.Path(sys.argv[1]), sys.argv[2:]
    reason = reason_to_skip("@mcap/core")
    if reason:
        print("skipped:", reason)
        return SKIPPED
    for test in tests:
        files = folder / pathlib.Path(test).name
        shutil.rmtree(files, ignore_errors=True)
        files.mkdir(parents=True)
        ran = subprocess.run([test, "--gtest_filter=" + LEFT_OUT, "--gtest_brief=1"], capture_output=True, text=True,
                             env=dict(os.environ, SINEW_KEEP_FILES=str(files)))
        print(test, "wrote", len(list(files.glob("*.mcap"))), "files", ran.stdout, ran.stderr)
        if ran.returncode not in (0, 1):  # 1: a test failed, which it does as a test of its own, too
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
