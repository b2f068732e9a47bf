"""The third robot: one folder brings its module, its world and its verdict, and no file elsewhere names it.

argv: SINEW SINEW_SIM SOURCE
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SINEW, SIM, SOURCE = sys.argv[1:4]
ROBOT = f"{SOURCE}/robots/seesaw/seesaw.toml"
RUN_DIR = tempfile.TemporaryDirectory()  # this program's robots meet nobody else's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=50, check=False)
    return done.returncode, done.stdout, done.stderr


class Seesaw(unittest.TestCase):
    def fly(self, *more):
        code, out, err = run(SINEW, "run", ROBOT, "--virtual", "--duration", "8", "--json", "--no-record", *more)
        self.assertIn(code, (0, 1), err)
        return code, json.loads(out)

    def test_its_world_judges_it(self):
        code, said = self.fly()
        self.assertEqual((code, said["result"]), (0, "kept the level, valid run"), said)
        self.assertLess(said["tilt_rms_deg"], 2)
        self.assertGreater(said["level_s"], 0)

    def test_a_bad_run_is_told_in_its_words(self):
        code, said = self.fly("--set", "balance.stiffness=0", "--set", "balance.damping=0")
        self.assertEqual((code, said["result"]), (1, "never got level, valid run"), said)

    def test_its_options_are_those_of_the_simulator(self):
        for option in (["--set", "sim.push_radps2=4.5"], ["--plant-arg=--push=4.5"]):
            code, said = self.fly(*option)
            self.assertEqual(code, 1, said)
            self.assertEqual(said["result"], "did not keep the level, valid run")
        code, _, err = run(SIM, "--world", "quad", "--push", "1", "--duration", "1", "--listen", "tcp:127.0.0.1:0")
        self.assertEqual(code, 2)
        self.assertIn("--push: only of the world seesaw", err)

    def test_check_knows_what_it_has_on_board(self):
        text = pathlib.Path(ROBOT).read_text(encoding="utf-8")
        wrong = pathlib.Path(self.id() + ".toml")
        wrong.write_text(text.replace('[actuator.motor]', '[actuator.wing]'), encoding="utf-8")
        try:
            code, out, err = run(SINEW, "check", str(wrong))
            self.assertNotEqual(code, 0)
            self.assertIn("the name of actuators in the world seesaw: motor", out + err)
        finally:
            wrong.unlink()

    def test_no_file_elsewhere_names_it(self):
        names = subprocess.run(["grep", "-rliw", "seesaw", "--include=*.cpp", "--include=*.hpp", "--include=*.txt",
                                "--include=*.cmake", "--include=*.toml", "apps", "cmake", "control", "drivers", "hal", "record", "rt",
                                "sim_hil", "tap", "vision", "CMakeLists.txt"], cwd=SOURCE, capture_output=True, text=True, check=False).stdout
        self.assertEqual(names, "")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
