"""Versions are compared by recordings, and tuned: the real program in a folder of its own.

usage: compare_test.py SINEW ROBOTS [unittest arguments]
"""
import glob
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

LIMIT_S = 300
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
os.environ.pop("SINEW_RECORD", None)


class InFolder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="sinew_compare_")
        cls.addClassCleanup(cls.folder.cleanup)

    @classmethod
    def sinew(cls, *arguments):
        done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=LIMIT_S, cwd=cls.folder.name)
        return done.returncode, done.stdout, done.stderr

    @classmethod
    def fly(cls, *arguments):
        """The run's summary with the path of its recording."""
        code, out, err = cls.sinew("run", *arguments, "--virtual", "--json", "--plain")
        if code not in (0, 1):
            raise RuntimeError(out + err)
        return json.loads(out)

    def good(self, *arguments):
        code, out, err = self.sinew(*arguments)
        self.assertEqual(code, 0, out + err)
        return out

    def refused(self, *arguments):
        code, out, err = self.sinew(*arguments)
        self.assertEqual((code, out), (2, ""), arguments)
        return err


class Flown(InFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.file = cls.fly(f"{ROBOTS}/quad/quad.toml", "--camera", "64x48", "--duration", "3")["recording"]["path"]

    def test_a_chain_without_changes_is_identical(self):
        chained = json.loads(self.good("replay", self.file, "--chain", "--json"))
        alone = json.loads(self.good("replay", self.file, "--json"))
        self.assertTrue(chained["identical"])
        self.assertEqual((chained["steps"], chained["messages"]), (alone["steps"], alone["messages"]))

    def test_a_chain_carries_a_change_onward(self):
        change = ["--set", "attitude.kp_rate=30", "--json"]
        code, out, _ = self.sinew("replay", self.file, *change)
        alone = json.loads(out)["modules"]
        self.assertEqual(code, 1)
        self.assertIn("difference", alone["attitude"])
        self.assertNotIn("difference", alone["mixer"])
        code, out, _ = self.sinew("replay", self.file, "--chain", *change)
        chained = json.loads(out)["modules"]
        self.assertEqual(code, 1)
        self.assertIn("difference", chained["mixer"])
        self.assertNotIn("difference", chained["position"], "it is before what was changed")
        self.assertEqual(chained["mixer"]["steps"], alone["mixer"]["steps"], "it goes on to the end")

    def test_a_comparison_gives_every_field_that_differs(self):
        out = json.loads(self.good("replay", self.file, "--chain", "--set", "attitude.kp_rate=30", "--compare", "--json"))
        self.assertFalse(out["identical"])
        fields = {q["name"]: q for q in out["compared"]}
        torque, motor = fields["attitude.wrench.torque_nm.y"], fields["mixer.motors.value[0]"]
        self.assertEqual(torque["unit"], "N m")
        for q in (torque, motor):
            self.assertGreater(q["max"], q["rms"])
            self.assertGreater(q["rms"], 0)
            self.assertTrue(0 <= q["max_at_s"] <= 3)
        self.assertEqual(torque["messages"], out["modules"]["attitude"]["messages"])
        self.assertEqual(fields["position.attitude.q_world_base.angle"]["max"], 0)
        relative = [q["rms"] / q["spread"] if q["spread"] else math.inf if q["rms"] else 0 for q in out["compared"]]
        self.assertEqual(relative, sorted(relative, reverse=True))

    def test_a_table_for_people_and_a_plot_of_both(self):
        out = self.good("replay", self.file, "--set", "attitude.kp_rate=30", "--compare", "--plot", "both.svg")
        self.assertRegex(out, r"(?m)^attitude\.wrench\.torque_nm\.x +N m +\S+ +\S+ +\d\.\d{3} +\d+ +\S+ %$")
        self.assertRegex(out, r"(?m)^\d+ more are the same$")
        self.assertIn("NOT identical: ", out)
        with open(f"{self.folder.name}/both.svg") as f:
            svg = f.read()
        self.assertEqual(svg.count(">recorded</text>"), 2, "the two torques")
        self.assertEqual(svg.count(">now</text>"), 2)
        self.assertIn("attitude.wrench.torque_nm.x: now", svg)

    def test_a_flight_in_a_simulator_is_held_against_its_truth(self):
        tuned = json.loads(self.good("tune", self.file, "--param", "filter.gyro_noise=0.001,0.01", "--error",
                                     "filter.state.q_world_base.tilt", "--json"))
        self.assertEqual(tuned["against"], "truth")
        self.assertGreater(tuned["recorded"]["messages"], 2000)
        self.assertLess(tuned["recorded"]["rms"], 2, "degrees")

    def test_fields_may_be_chosen(self):
        out = json.loads(self.good("replay", "--compare", "--fields", "filter.state.p_world_m,tilt", self.file, "--json"))
        self.assertEqual({q["name"] for q in out["compared"]},
                         {*(f"filter.state.p_world_m.{axis}" for axis in "xyz"), "filter.state.q_world_base.tilt",
                          "position.attitude.q_world_base.tilt"})
        self.assertTrue(out["identical"])
        err = self.refused("replay", self.file, "--compare", "--fields", "filter.state.p_world_ft")
        self.assertIn("--fields filter.state.p_world_ft: no output of the modules has it", err)
        self.assertIn("--compare", self.refused("replay", self.file, "--plot", "x.svg"))
        self.assertIn("x.jpg: FILE.svg or FILE.png", self.refused("replay", self.file, "--compare", "--plot", "x.jpg"))

    def test_modules_between_parameter_and_error_are_executed_again(self):
        tuned = json.loads(self.good("tune", self.file, "--param", "attitude.kp_rate=10,22", "--error",
                                     "mixer.motors.value[0]", "--against", "recorded", "--json"))
        self.assertEqual(tuned["modules"], ["attitude", "mixer"])
        self.assertEqual(tuned["best"]["params"], {"attitude.kp_rate": 22}, "what it flew with")
        self.assertEqual(tuned["best"]["rms"], 0)
        self.assertGreater(tuned["points"][0]["rms"], 0)


SECONDS = 20


def write_dataset(folder):
    """An IMU that rocks and is pushed to and fro, with bias and noise; and its true motion."""
    noise = random.Random(7)
    with open(f"{folder}/imu0.csv", "w") as imu, open(f"{folder}/groundtruth.csv", "w") as truth:
        imu.write("#stamp,wx,wy,wz,ax,ay,az\n")
        truth.write("#stamp,px,py,pz,qw,qx,qy,qz,vx,vy,vz,bwx,bwy,bwz,bax,bay,baz\n")
        for i in range(SECONDS * 200):
            t = i / 200
            stamp = 1_500_000_000_000_000_000 + i * 5_000_000
            roll, rate = 0.3 * math.sin(1.3 * t), 0.3 * 1.3 * math.cos(1.3 * t)
            pushed = 0.5 * math.sin(3 * t)  # along y of the world, which a filter takes for tilt
            y = math.cos(roll) * pushed + math.sin(roll) * 9.81
            z = -math.sin(roll) * pushed + math.cos(roll) * 9.81
            w = [rate + 0.02, 0.01, -0.01]
            values = [v + noise.gauss(0, 0.002) for v in w] + [v + noise.gauss(0, 0.05) for v in (0, y, z)]
            imu.write(f"{stamp}," + ",".join(f"{v:.9f}" for v in values) + "\n")
            if i % 10 == 0 or i == SECONDS * 200 - 1:
                truth.write(f"{stamp},0,0,0,{math.cos(roll / 2):.9f},{math.sin(roll / 2):.9f},0,0,0,0,0,"
                            "0.02,0.01,-0.01,0,0,0\n")


class Tuned(InFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        write_dataset(cls.folder.name)
        cls.run_ = cls.fly(f"{ROBOTS}/mav_dataset/mav_dataset.toml", "--data", ".")
        cls.file = cls.run_["recording"]["path"]

    def tune(self, *arguments):
        return json.loads(self.good("tune", self.file, "--json", *arguments))

    def test_the_truth_stands_in_the_recording_and_both_are_held_against_it(self):
        out = json.loads(self.good("replay", self.file, "--json"))
        self.assertTrue(out["identical"])
        self.assertNotIn("stopped", out["modules"]["ground_truth"])
        out = json.loads(self.good("replay", self.file, "--compare", "--set", "filter.gyro_noise=0.05", "--json"))
        fields = {q["name"]: q for q in out["compared"]}
        tilt = fields["filter.state.q_world_base.tilt"]["truth"]
        self.assertGreater(tilt["recorded"]["messages"], 3500)
        self.assertNotEqual(tilt["recorded"]["rms"], tilt["now"]["rms"])
        self.assertGreater(fields["filter.state.gyro_bias_radps.y"]["truth"]["recorded"]["messages"], 3500)
        self.assertEqual(fields["filter.state.height_m"]["truth"]["recorded"]["messages"], 0, "it is not known")
        self.assertNotIn("truth", fields["filter.state.pad_known"])
        text = self.good("replay", self.file, "--compare", "--set", "filter.gyro_noise=0.05", "--fields", "tilt,angle",
                         "--plot", "truth.svg")
        self.assertRegex(text, r"(?m)^RMS against the truth +unit +recorded +now +messages$")
        with open(f"{self.folder.name}/truth.svg") as f:
            self.assertEqual(f.read().count(">recorded from truth</text>"), 2)

    def test_what_tuning_says_of_a_value_is_what_a_run_with_it_does(self):
        rms = []
        for value in ("0.0004", "0.05"):
            flown = self.fly(f"{ROBOTS}/mav_dataset/mav_dataset.toml", "--data", ".", "--set", f"filter.gyro_noise={value}", "--set",
                             "filter.valid_tilt_rad=1")
            # A run only counts valid values, from some time on to the end.
            tuned = self.tune("--param", f"filter.gyro_noise={value}", "--error", "tilt", "--from",
                              str(SECONDS - flown["states"] / 200 - 0.0025))["best"]
            self.assertAlmostEqual(tuned["messages"], flown["states"], delta=1)
            self.assertAlmostEqual(tuned["rms"], flown["tilt_rms_deg"], delta=0.002 * flown["tilt_rms_deg"])
            rms.append(tuned["rms"])
        self.assertGreater(abs(rms[1] - rms[0]), 0.1 * rms[0], "else it would show nothing")
        both = self.tune("--param", "filter.gyro_noise=0.0004,0.05", "--error", "tilt", "--from", "5")
        self.assertEqual(both["best"]["rms"], min(p["rms"] for p in both["points"]))

    def test_a_grid_over_several_files_is_the_same_however_many_run_at_once(self):
        arguments = ["--param", "filter.gyro_noise=1e-4:1e-2:3:log", "--param", "filter.accel_noise=0.01,1",
                     "--error", "filter.state.q_world_base.tilt", "again.mcap"]
        shutil.copy(os.path.join(self.folder.name, self.file), f"{self.folder.name}/again.mcap")  # a file that is named twice counts once
        one, four = self.tune(*arguments, "--jobs", "1"), self.tune(*arguments, "--jobs", "4")
        self.assertEqual(one["points"], four["points"])
        self.assertEqual(len(one["points"]), 6)
        self.assertEqual([p["params"]["filter.gyro_noise"] for p in one["points"]],
                         [0.0001, 0.0001, 0.001, 0.001, 0.01, 0.01])
        point = one["points"][0]
        self.assertEqual(point["messages"], sum(f["messages"] for f in point["files"]))
        self.assertEqual(one["replays"], 12)
        self.assertRegex(one["robot_file"], r"^params = \{ accel_noise = \S+, gyro_noise = \S+ \}  # \[module\.filter\]$")

    def test_a_replay_that_hangs_is_a_result_with_its_reason(self):
        arguments = ("tune", self.file, "--param", "filter.gyro_noise=0.001,0.002", "--error", "tilt", "--patience", "0")
        code, out, err = self.sinew(*arguments)
        self.assertEqual(code, 1, out + err)
        self.assertEqual(out.count("hung: no end within 0 s (--patience)"), 2, out)
        self.assertIn("no combination could be executed to its end", err)
        points = json.loads(self.sinew(*arguments, "--json")[1])["points"]
        self.assertEqual([p["stopped"] for p in points], [[f"{self.file}: hung: no end within 0 s (--patience)"]] * 2)

    def test_halves_are_scored_apart(self):
        first = self.tune("--param", "filter.gyro_noise=0.001", "--error", "tilt", "--until", "10.0025")["best"]
        second = self.tune("--param", "filter.gyro_noise=0.001", "--error", "tilt", "--from", "10.0025")["best"]
        whole = self.tune("--param", "filter.gyro_noise=0.001", "--error", "tilt")["best"]
        self.assertEqual(first["messages"] + second["messages"], whole["messages"])
        self.assertAlmostEqual(first["rms"] ** 2 * first["messages"] + second["rms"] ** 2 * second["messages"],
                               whole["rms"] ** 2 * whole["messages"], places=6)

    def test_a_filter_that_says_nothing_is_not_the_best(self):
        code, out, err = self.sinew("tune", self.file, "--param", "filter.gyro_limit_radps=0.1", "--error", "tilt")
        self.assertEqual(code, 1, out + err)
        self.assertRegex(out, r"does not count: \d+ messages are missing")

    def test_a_table_and_a_line_for_the_robot_file(self):
        out = self.good("tune", self.file, "--param", "filter.gyro_noise=0.0004,0.05", "--error", "tilt")
        self.assertIn("filter.state.q_world_base.tilt (deg), RMS against the truth; executed again: filter", out)
        rows = re.findall(r"(?m)^ +(\S+) +(\d\.\S+) +\S+ +\d+$", out)
        self.assertEqual(len(rows), 2)
        self.assertLess(float(rows[0][1]), float(rows[1][1]), "the best stands first")
        self.assertRegex(out, r"(?m)^ +as recorded +\d")
        self.assertIn(f"params = {{ gyro_noise = {rows[0][0]} }}  # [module.filter]", out)

    def test_what_is_wrong_is_named(self):
        for arguments, words in (
                (["--param", "filter.gyro_noise=1:2:3", "--error", "tilt"], "1: a number from 1e-06 to 0.1"),
                (["--param", "filter.gyro_nose=1", "--error", "tilt"], "filter has no parameter gyro_nose; it has: imus, gyro_noise,"),
                (["--param", "filter.gyro_noise=0.01", "--error", "lean"], "--error lean: no output of a module has it"),
                (["--param", "filter.gyro_noise=0.01", "--error", "x"], "--error x: may be filter.state."),
                (["--param", "filter.gyro_noise=0.01", "--error", "pad_known"], "the truth does not have it"),
                (["--param", "filter.gyro_noise=0.01", "--error", "tilt", "--truth", "mocap"], "no topic mocap in the file"),
                (["--param", "states.capacity=10", "--error", "tilt"], "it does not depend on these parameters"),
                (["--param", "filter.gate=1,2", "--param", "filter.gate=3", "--error", "tilt"], "filter.gate stands twice")):
            self.assertIn(words, self.refused("tune", self.file, *arguments))
        self.assertIn("no.mcap: no such file", self.refused("tune", "no.mcap", "--param", "a.b=1", "--error", "tilt"))


if __name__ == "__main__":
    SINEW, ROBOTS = sys.argv[1:3]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
