"""calibrate camera and calibrate legs on a recording of the humanoid before its board: the real programs.

usage: board_test.py SINEW ROBOTS [unittest arguments]
"""
import glob
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

LIMIT_S = 300
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
os.environ.pop("SINEW_RECORD", None)
LENS = {"focal": 0.8, "k1": -0.2}  # focal length in heights of the picture: 192 px
POSES = 32


def sinew(folder, *arguments):
    done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=LIMIT_S, cwd=folder)
    return done.returncode, done.stdout, done.stderr


class Board(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="sinew_board_")
        cls.addClassCleanup(cls.folder.cleanup)
        robot = os.path.join(ROBOTS, "kid", "kid_calibrate.toml")
        code, out, err = sinew(cls.folder.name, "run", robot, "--virtual", "--record-images", "--json", "--plain",
                               "--set", "stand.poses=12", "--set", "stand.move_s=0.4", "--set", f"sim.camera_focal={LENS['focal']}", "--set", f"sim.camera_k1={LENS['k1']}")
        if code != 0:
            raise RuntimeError(out + err)
        cls.record = sorted(glob.glob(os.path.join(cls.folder.name, "runs", "*", "*.mcap")))[0]

    def calibrate(self, *arguments):
        return sinew(self.folder.name, "calibrate", *arguments)

    def test_camera_finds_the_secret_lens_within_its_intervals(self):
        code, out, err = self.calibrate("camera", self.record, "--square", "0.04", "--json")
        self.assertEqual(code, 0, out + err)
        found = json.loads(out)
        truth = {"fx": 192, "fy": 192, "cx": 159.5, "cy": 119.5, "k1": LENS["k1"]}
        for name, value in truth.items():
            number = found["camera"][name]
            # One record of a board that is seen from one side only: docs/calibrate.md has the study.
            self.assertLess(abs(number["value"] - value), 2.5 * number["half_width_95"], name)
        self.assertAlmostEqual(found["camera"]["fx"]["value"], 192, delta=4)
        self.assertLess(found["camera"]["fx"]["half_width_95"], 8)
        self.assertLess(found["rms_px"], 0.3)
        self.assertLess(found["held_out_rms_px"], 1.2 * found["rms_px"])
        self.assertIn("takes no distortion", found["remark"])

    def test_camera_writes_what_the_robot_file_takes_and_a_picture(self):
        code, out, err = self.calibrate("camera", self.record, "--square", "0.04", "--file", "camera.toml",
                                        "--params", "params.toml", "--picture", "corners.png")
        self.assertEqual(code, 0, out + err)
        with open(os.path.join(self.folder.name, "camera.toml"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn("[module.sight]\nfx_px = 19", text)
        with open(os.path.join(self.folder.name, "corners.png"), "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")
        code, out, err = sinew(self.folder.name, "run", os.path.join(ROBOTS, "kid", "kid_calibrate.toml"), "--virtual",
                               "--duration", "0.1", "--no-record", "--params", "params.toml", "--set", "stand.poses=3")
        self.assertNotIn("params.toml:", out + err)
        self.assertIn(code, (0, 1), out + err)  # it ended before it stood

    def test_legs_finds_the_secret_zeros(self):
        camera = os.path.join(self.folder.name, "true.toml")
        with open(camera, "w", encoding="utf-8") as file:
            file.write("[module.sight]\nfx_px = 192.0\nfy_px = 192.0\ncx_px = 159.5\ncy_px = 119.5\n")
        # The ball detector knows no distortion, so this record's zeros are looked for without a lens below.
        robot = os.path.join(ROBOTS, "kid", "kid_calibrate.toml")
        code, out, err = sinew(self.folder.name, "run", robot, "--virtual", "--record-images", "--json", "--plain", "--runs",
                               "plain", "--set", "sim.joint_zero_deg=1", "--set", f"stand.poses={POSES}", "--set",
                               f"sim.camera_focal={LENS['focal']}")
        self.assertEqual(code, 0, err)
        report = json.loads(out)["report"]
        record = sorted(glob.glob(os.path.join(self.folder.name, "plain", "*", "*.mcap")))[0]
        code, out, err = self.calibrate("legs", record, "--square", "0.04", "--camera", camera, "--json")
        self.assertEqual(code, 0, out + err)
        found = json.loads(out)
        self.assertGreaterEqual(found["poses"], 26)
        held = 0
        for name, number in found["joints"].items():
            truth = math.radians(report.get("zero_deg_" + name, 0))
            held += abs(number["value"] - truth) <= number["half_width_95"]
            self.assertLess(abs(number["value"] - truth), 2 * number["half_width_95"], name)
        self.assertGreaterEqual(held, 10)
        self.assertLess(found["after_rad"], 0.5 * found["before_rad"])

    def test_says_what_is_missing(self):
        for arguments, text in (
                (("camera", self.record, "--square", "0.04", "--board", "7", "6"), "a board of 7 x 6 inner corners is whole in 0 of"),
                (("camera", self.record, "--square", "0.04", "--topic", "camera9.raw"), "it has no such topic of images; it has: camera.raw"),
                (("camera", self.record, "--square", "0"), "--square"),
                (("camera", "nothing.mcap", "--square", "0.04"), "nothing.mcap"),
                (("legs", self.record, "--square", "0.04", "--board", "7", "7"), "columns + rows has to be odd"),
                (("legs", self.record, "--square", "0.04", "--camera", "none.toml"), "none.toml: there is no such file"),
                (("legs", self.record, "--square", "0.04", "--place", "eye"), "the body has no place 'eye'")):
            code, out, err = self.calibrate(*arguments)
            self.assertNotEqual(code, 0, out)
            self.assertIn(text, out + err)


if __name__ == "__main__":
    SINEW, ROBOTS = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
