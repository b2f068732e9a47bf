"""Runs are recorded, and executed again: the real program in a folder of its own. usage: recording_test.py SINEW ROBOTS"""
import glob
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import unittest

LIMIT_S = 300
RUN_DIR = tempfile.TemporaryDirectory()  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
os.environ.pop("SINEW_RECORD", None)


class Recording(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def sinew(self, *arguments, **environment):
        done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=LIMIT_S,
                              cwd=self.folder.name, env={**os.environ, **environment})
        return done.returncode, done.stdout, done.stderr

    def fly(self, *arguments, robot=None, **environment):
        """The summary, and the recordings that exist then."""
        code, out, err = self.sinew("run", robot or f"{ROBOTS}/quad/quad.toml", "--camera", "64x48", "--json", "--plain",
                                    *arguments, **environment)
        self.assertIn(code, (0, 1), out + err)
        return json.loads(out), sorted(glob.glob(f"{self.folder.name}/runs/quad-*/run.mcap"))

    def replay(self, file, *arguments):
        code, out, err = self.sinew("replay", file, "--json", *arguments)
        self.assertIn(code, (0, 1), out + err)
        return code, json.loads(out)

    def test_a_run_is_recorded_unless_told_otherwise_and_replays_identically_also_from_saved_states(self):
        run, files = self.fly("--virtual", "--duration", "13")
        self.assertEqual(len(files), 1)
        self.assertEqual(os.path.join(self.folder.name, run["recording"]["path"]), files[0])
        self.assertEqual(run["recording"]["bytes"], os.path.getsize(files[0]))
        self.assertTrue(all(not why for why in run["recording"]["not_replayable"].values()))
        code, replay = self.replay(files[0])
        self.assertEqual(code, 0, replay)
        self.assertTrue(replay["identical"])
        self.assertEqual(replay["steps"], sum(m["steps"] for m in run["modules"]), "every step of the run")
        for name, module in replay["modules"].items():
            self.assertNotIn("stopped", module, name)
            self.assertEqual(module["not_compared"], 0, name)
        code, late = self.replay(files[0], "--from", "11")
        self.assertEqual(code, 0, late)
        self.assertTrue(late["identical"])
        for name, module in late["modules"].items():
            self.assertLess(module["steps"], 0.8 * replay["modules"][name]["steps"], name)
            self.assertGreater(module["steps"], 0.1 * replay["modules"][name]["steps"], name)
        _, files = self.fly("--virtual", "--duration", "1", "--no-record")
        self.assertEqual(len(files), 1)
        _, files = self.fly("--virtual", "--duration", "1", SINEW_RECORD="off")
        self.assertEqual(len(files), 1)

    def test_latest_leads_to_the_newest_run(self):
        self.fly("--virtual", "--duration", "0.1")
        latest = f"{self.folder.name}/runs/latest"
        first = os.readlink(latest)
        run, _ = self.fly("--virtual", "--duration", "0.1")
        self.assertNotEqual(os.readlink(latest), first)
        self.assertEqual(run["recording"]["path"], f"runs/{os.readlink(latest)}/run.mcap")
        self.fly("--virtual", "--duration", "0.1", "--runs", "there")
        self.assertTrue(os.path.exists(f"{self.folder.name}/there/latest/run.mcap"))
        self.assertEqual(run["recording"]["path"], f"runs/{os.readlink(latest)}/run.mcap", "of its own folder")

    def test_something_else_named_latest_stays_and_the_run_is_recorded(self):
        os.makedirs(f"{self.folder.name}/runs/latest")
        code, out, err = self.sinew("run", f"{ROBOTS}/quad/quad.toml", "--virtual", "--duration", "0.1", "--quiet")
        self.assertIn("runs/latest: not a link of ours, so it stays as it is: the newest run is in runs/quad-", err)
        self.assertEqual(len(glob.glob(f"{self.folder.name}/runs/quad-*/run.mcap")), 1)
        self.assertEqual(os.listdir(f"{self.folder.name}/runs/latest"), [])

    def test_another_parameter_is_named_with_the_first_step_that_differs(self):
        _, files = self.fly("--virtual", "--duration", "4")
        code, replay = self.replay(files[0], "--modules", "attitude,mixer", "--set", "attitude.kp_rate=21.5")
        self.assertEqual(code, 1)
        self.assertFalse(replay["identical"])
        first = replay["first_difference"]
        self.assertEqual(first["module"], "attitude")
        self.assertTrue(first["what"].startswith("wrench.torque_nm."), first)
        self.assertNotEqual(first["recorded"], first["now"])
        self.assertNotIn("difference", replay["modules"]["mixer"], "it is held against the record")

    def test_a_run_in_real_time_replays_identically_as_far_as_nothing_is_lost(self):
        run, files = self.fly("--duration", "4")
        code, replay = self.replay(files[0])
        self.assertTrue(replay["identical"], replay.get("first_difference"))
        self.assertGreater(replay["steps"], 0)
        if not run["recording"]["lost_steps"] and not run["recording"]["lost_messages"]:
            for name, module in replay["modules"].items():
                self.assertNotIn("stopped", module, name)

    def test_what_cannot_be_recorded_is_said_and_the_robot_flies(self):
        with open(os.path.join(self.folder.name, "runs"), "w"):
            pass  # a file where the folder should be
        code, out, err = self.sinew("run", f"{ROBOTS}/quad/quad.toml", "--virtual", "--duration", "1", "--quiet")
        self.assertIn("warning: this run is not recorded: runs: ", err)
        self.assertTrue(out.startswith("mission   did not land"), out)

    @unittest.skipIf("ASAN_OPTIONS" in os.environ, "the sanitizer itself needs more memory than this test allows")
    def test_a_run_that_did_not_begin_leaves_nothing(self):
        with open(f"{ROBOTS}/quad/quad.toml") as f:
            text = f.read()
        os.makedirs(f"{self.folder.name}/runs/quad-before")
        os.symlink("quad-of-the-past", f"{self.folder.name}/runs/latest")
        path = os.path.join(self.folder.name, "deep.toml")
        with open(path, "w") as f:  # stacks of 64 MiB: more than there is
            f.write(re.sub("(?m)^stack_kib = .*", "stack_kib = 65536", text))
        place = f"unix:{self.folder.name}/plant"
        plant = subprocess.Popen([f"{os.path.dirname(SINEW)}/sinew-sim", "--listen", place], stdout=subprocess.DEVNULL)
        try:
            while not os.path.exists(place[5:]) and plant.poll() is None:
                time.sleep(0.05)
            run = subprocess.run([SINEW, "run", path, "--plant", place, "--unsupervised", "--plain"], capture_output=True,
                                 text=True, timeout=LIMIT_S, cwd=self.folder.name, preexec_fn=lambda: resource.setrlimit(
                                     resource.RLIMIT_AS, (250_000_000, 250_000_000)))
        finally:
            plant.terminate()
            plant.wait()
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("sinew: stack", run.stderr)
        self.assertEqual(sorted(os.listdir(f"{self.folder.name}/runs")), ["latest", "quad-before"])
        self.assertEqual(os.readlink(f"{self.folder.name}/runs/latest"), "quad-before", "the newest that is left")

    def test_the_robot_file_chooses_topics_rates_and_pixels(self):
        with open(f"{ROBOTS}/quad/quad.toml") as f:
            text = f.read()
        path = os.path.join(self.folder.name, "some.toml")
        with open(path, "w") as f:
            f.write(text + '\n[record]\nfolder = "here"\nrate_hz = { "imu.raw" = 100 }\npixel_mb_per_s = 0\n'
                    'compression = "zstd"\nsplit_s = 1\n')
        run, _ = self.fly("--virtual", "--duration", "3", robot=path)
        self.assertTrue(run["recording"]["path"].startswith("here/quad-"))
        self.assertGreater(run["recording"]["files"], 2)
        files = glob.glob(f"{self.folder.name}/here/quad-*/run*.mcap")
        self.assertEqual(len(files), run["recording"]["files"])
        self.assertEqual(sum(os.path.getsize(f) for f in files), run["recording"]["bytes"])
        self.assertEqual(run["recording"]["not_replayable"]["filter"], ["input imu.raw at 100 Hz"])
        self.assertIn("pixels of camera.raw not kept", run["recording"]["not_replayable"]["pad"][0])
        with open(path, "a") as f:
            f.write('topics = ["no.such"]\nsplit_mb = -1\n')
        code, _, err = self.sinew("run", path, "--virtual")
        self.assertEqual(code, 2)
        self.assertRegex(err, r"some.toml:\d+: record.split_mb: -1: ")

    def test_no_recording_and_no_file_are_told_apart(self):
        code, _, err = self.sinew("replay", "no-such.mcap")
        self.assertEqual(code, 2)
        self.assertIn("no-such.mcap: no such file", err)
        path = os.path.join(self.folder.name, "text.mcap")
        with open(path, "w") as f:
            f.write("no recording")
        code, _, err = self.sinew("replay", path)
        self.assertEqual(code, 2)
        self.assertIn("not an MCAP file", err)


if __name__ == "__main__":
    SINEW, ROBOTS = sys.argv[1:3]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
