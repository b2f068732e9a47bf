"""sinew record start, stop, status, snapshot: the recordings of a flying robot. usage: record_commands_test.py SINEW ROBOTS"""
import glob
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

LIMIT_S = 120
os.environ.pop("SINEW_RECORD", None)


class RecordCommands(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="sinew_record_")
        self.addCleanup(self.folder.cleanup)
        self.env = dict(os.environ, SINEW_RUN_DIR=f"{self.folder.name}/sockets")

    def fly(self, record, *arguments):
        """A flight in real time, from its socket's first answer on."""
        with open(f"{ROBOTS}/quad/quad.toml") as f:
            text = f.read()
        with open(f"{self.folder.name}/quad.toml", "w") as f:
            f.write(text + "\n" + record)
        for model in glob.glob(f"{ROBOTS}/*.xml"):
            os.symlink(model, os.path.join(self.folder.name, os.path.basename(model)))
        self.run_ = subprocess.Popen([SINEW, "run", "quad.toml", "--camera", "64x48", "--plain", "--json", *arguments],
                                     cwd=self.folder.name, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                     env=self.env)
        self.addCleanup(self.end, self.run_)
        self.sinew("status", "--wait", "60")

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.terminate()
        process.communicate()

    def land(self):
        self.run_.send_signal(signal.SIGTERM)
        out, err = self.run_.communicate(timeout=LIMIT_S)
        return json.loads(out), err

    def sinew(self, *arguments, code=0):
        done = subprocess.run([SINEW, *arguments], cwd=self.folder.name, capture_output=True, text=True,
                              timeout=LIMIT_S, env=self.env)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code == 0 else done.stderr

    def record(self, command):
        return json.loads(self.sinew("record", command, "--json"))

    def wait_for_steps(self, seconds):
        time.sleep(seconds)  # of flight; nothing here depends on how many there are

    def result_of(self, path):
        return json.loads(self.sinew("bag", "info", path, "--json"))["result"]

    def expect_replay(self, path):
        """All complete records replay as recorded; a loaded machine may have lost some, and reports it."""
        check = json.loads(self.sinew("bag", "check", path, "--json"))
        self.assertEqual(check["problems"], [])
        done = subprocess.run([SINEW, "replay", path, "--json"], cwd=self.folder.name, capture_output=True, text=True)
        replay = json.loads(done.stdout)
        self.assertTrue(replay["identical"], replay.get("first_difference"))
        for name, module in replay["modules"].items():
            if not check["not_replayable"][name]:
                self.assertNotIn("stopped", module, name)
                self.assertGreater(module["steps"], 0, name)

    def test_a_recording_begins_and_ends_in_flight(self):
        self.fly("[record]\nenabled = false\n")
        status = self.record("status")
        self.assertEqual(status, {"recording": None, "ring": None})
        self.assertIn("nothing is being recorded\nno flight ring", self.sinew("record", "status"))
        self.assertIn("nothing is being recorded", self.sinew("record", "stop", code=1))
        self.assertIn("no flight ring", self.sinew("record", "snapshot", code=1))
        self.wait_for_steps(1)
        path = self.record("start")["path"]
        self.assertRegex(path, r"^runs/quad-[0-9-]+/run.mcap$")
        self.assertIn("it is being recorded already: " + path, self.sinew("record", "start", code=1))
        self.wait_for_steps(2)
        status = self.record("status")["recording"]
        self.assertEqual(status["path"], path)
        self.assertGreater(status["bytes"], 0)
        self.assertGreater(status["seconds"], 1)
        stopped = self.record("stop")
        self.assertEqual(stopped["path"], path)
        self.assertEqual(stopped["bytes"], os.path.getsize(f"{self.folder.name}/{path}"))
        self.assertIsNone(self.record("status")["recording"], "and it flies on")
        second = self.record("start")["path"]
        self.assertNotEqual(second, path)
        self.wait_for_steps(1)
        summary, _ = self.land()
        self.assertEqual([r["path"] for r in summary["recordings"]], [path, second])
        self.expect_replay(path)
        self.expect_replay(second)
        self.assertEqual(self.result_of(path), {"end": "the recording was stopped, the run went on"})
        landed = self.result_of(second)
        self.assertEqual((landed["end"], landed["outcome"]), ("interrupted", summary["mission"]["outcome"]))

    def test_a_snapshot_has_the_last_seconds(self):
        self.fly("[record]\nenabled = false\n[record.ring]\nseconds = 2\n")
        self.wait_for_steps(4)
        for attempt in range(120):  # a loaded machine may be dumping a deadline miss just now, and the next one then
            done = subprocess.run([SINEW, "record", "snapshot", "--json"], capture_output=True, text=True, env=self.env)
            if done.returncode == 0:
                break
            self.assertIn("dumped already", done.stderr)
            time.sleep(0.5)
        path = json.loads(done.stdout)["path"]
        self.assertRegex(path, r"^runs/quad-[0-9-]+/ring-[0-9]+.mcap$")
        ring = self.record("status")["ring"]
        self.assertIn(path, [d["path"] for d in ring["dumps"] if d["reason"] == "asked for"])
        self.assertLessEqual(ring["bytes"], ring["room_bytes"])
        self.assertLess(ring["room_bytes"], 32.01e6, "32 MB in whole pages")
        summary, _ = self.land()
        self.assertIn(path, [d["path"] for d in summary["ring"]["dumps"]])
        info = json.loads(self.sinew("bag", "info", path, "--json"))
        self.assertGreater(info["duration_s"], 1.5)
        self.expect_replay(path)

    def test_a_run_without_a_recorder_says_so(self):
        self.fly("", "--no-record")
        self.assertIn("this run has no recorder", self.sinew("record", "start", code=1))
        self.land()
        self.assertFalse(os.path.exists(f"{self.folder.name}/runs"))

    def test_what_the_guardian_does_is_dumped_and_the_same_run_gives_the_same_files(self):
        files = []
        for again in range(2):
            folder = tempfile.TemporaryDirectory(prefix="sinew_record_")
            self.addCleanup(folder.cleanup)
            with open(f"{ROBOTS}/quad/quad.toml") as f:
                text = f.read()
            with open(f"{folder.name}/quad.toml", "w") as f:
                f.write(text + "\n[record.ring]\nseconds = 2\n")
            for model in glob.glob(f"{ROBOTS}/*.xml"):
                os.symlink(model, os.path.join(folder.name, os.path.basename(model)))
            done = subprocess.run([SINEW, "run", "quad.toml", "--virtual", "--duration", "6", "--camera", "64x48",
                                   "--json", "--fault", "range:off@4"], cwd=folder.name, capture_output=True,
                                  text=True, timeout=LIMIT_S, env=self.env)
            summary = json.loads(done.stdout)
            dump = summary["ring"]["dumps"][0]
            self.assertEqual(dump["reason"], "failsafe range_lost")
            self.assertGreater(dump["at_s"], 4.3, "that is how long the range must be silent")
            paths = [f"{folder.name}/{p}" for p in (summary["recording"]["path"], dump["path"])]
            self.expect_replay(paths[1])
            files += [self.contents(path) for path in paths]
        self.assertTrue(files[0] == files[2], "the recording")
        self.assertTrue(files[1] == files[3], "the dump")

    def contents(self, path):
        """Every message; of saved states not the hash, since what lies between two members of a module is in it, too."""
        lines = self.sinew("bag", "cat", path).splitlines()
        self.assertGreater(len(lines), 1000)
        return [re.sub('"data":{"bytes":([0-9]+),"hash":"[0-9a-f]+"}', r'"data":\1', line) for line in lines]


if __name__ == "__main__":
    SINEW, ROBOTS = [os.path.abspath(a) for a in sys.argv[1:3]]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
