"""`sinew sweep --pack`: a folder that flies the sweep's parts somewhere else, with the bytes of here.

usage: pack_test.py SINEW ROBOTS
"""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SINEW, ROBOTS = map(os.path.abspath, sys.argv[1:3])
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


class Pack(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here, self.there = f"{folder.name}/here", f"{folder.name}/there"
        os.makedirs(f"{self.here}/robots/mine")
        os.mkdir(self.there)
        shutil.copy(f"{ROBOTS}/seesaw/seesaw.toml", f"{self.here}/robots/seesaw.toml")
        with open(f"{self.here}/robots/mine/mine.toml", "w", encoding="utf-8") as mine:
            mine.write('extends = "../seesaw.toml"\n[robot]\nname = "mine"\nseed = 7\n')
        with open(f"{self.here}/robots/runs.txt", "w", encoding="utf-8") as runs:
            runs.write("--duration 1\n--duration 1.5\n")
        self.sweep = ("robots/mine/mine.toml", "--seeds", "1..3", "--list", "robots/runs.txt")

    def call(self, *argv, cwd, code=0, **env):
        done = subprocess.run(argv, cwd=cwd, capture_output=True, text=True, timeout=300, env={**os.environ, **env})
        self.assertEqual(done.returncode, code, f"{argv}\n{done.stdout}\n{done.stderr}")
        return done.stdout + done.stderr

    def pack(self):
        said = self.call(SINEW, "sweep", *self.sweep, "--pack", "packed", cwd=self.here)
        self.assertIn("packed: 6 runs", said)
        self.assertEqual(os.listdir(self.here).count("packed.part"), 0)

    def test_parts_flown_from_a_moved_folder_merge_to_the_bytes_of_here(self):
        self.pack()
        self.call(SINEW, "sweep", *self.sweep, "--results", "single.jsonl", cwd=self.here)
        shutil.move(f"{self.here}/packed", f"{self.there}/a folder")
        for file in ("robots/seesaw.toml", "robots/mine/mine.toml", "robots/runs.txt"):
            os.rename(f"{self.here}/{file}", f"{self.here}/{file}.gone")
        run = f"{self.there}/a folder/run"
        said = self.call(run, "--shard", "2/2", "--results", "2.jsonl", cwd=self.there, LD_DEBUG="files")
        self.assertIn("calling init: ", said)
        ours = f"{self.there}/a folder/"
        opened = {line.split("calling init: ")[1] for line in said.splitlines() if "calling init: " in line}
        foreign = {os.path.basename(path) for path in opened if path.startswith("/") and not path.startswith(ours)}
        foreign -= {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1", "ld-linux-x86-64.so.2"}
        self.assertEqual({name for name in foreign if name.startswith("lib") and not self.of_tools(name)}, set())
        self.call(run, "--shard", "1/2", "--results", "1.jsonl", cwd=self.there)
        self.call(run, "merge", "2.jsonl", "1.jsonl", "2.jsonl", "--into", "all.jsonl", cwd=self.there)
        with open(f"{self.there}/all.jsonl", "rb") as merged, open(f"{self.here}/single.jsonl", "rb") as single:
            self.assertEqual(merged.read(), single.read())

    @staticmethod
    def of_tools(name):
        """sha256sum's and readlink's, which are the system's like their libraries."""
        return name.startswith(("libcrypto.so", "libselinux.so", "libpcre2", "libacl.so", "libattr.so"))

    def test_the_patience_of_a_slower_machine_is_given_again(self):
        self.sweep += ("--patience", "0.1")  # no run ends as soon
        self.pack()
        self.call("packed/run", "--shard", "1/6", "--results", "all.jsonl", "--patience", "60", cwd=self.here)

    def test_a_changed_folder_flies_nothing(self):
        self.pack()
        with open(f"{self.here}/packed/robots/seesaw.toml", "a", encoding="utf-8") as robot:
            robot.write("# tuned here\n")
        said = self.call("packed/run", "--results", "all.jsonl", cwd=self.here, code=2)
        self.assertIn("robots/seesaw.toml: FAILED", said)
        self.assertIn("is not as it was packed", said)
        self.assertFalse(os.path.exists(f"{self.here}/all.jsonl"))

    def test_files_outside_of_the_current_folder_are_refused_and_nothing_is_left(self):
        said = self.call(SINEW, "sweep", "../robots/mine/mine.toml", "--pack", "packed", cwd=f"{self.here}/robots", code=2)
        self.assertIn("../robots/mine/mine.toml: results name files as the command does", said)
        self.assertEqual(sorted(os.listdir(f"{self.here}/robots")), ["mine", "runs.txt", "seesaw.toml"])

    def test_a_folder_that_is_in_use_is_not_touched(self):
        os.mkdir(f"{self.here}/packed")
        with open(f"{self.here}/packed/notes", "w", encoding="utf-8") as notes:
            notes.write("mine")
        self.assertIn("not empty", self.call(SINEW, "sweep", *self.sweep, "--pack", "packed", cwd=self.here, code=2))
        self.assertEqual(os.listdir(f"{self.here}/packed"), ["notes"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
