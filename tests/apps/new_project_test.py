"""`sinew new` writes a project that builds by the commands of its own README, runs, and passes its test."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SINEW, SOURCE = sys.argv[1:3]
RUN_DIR = tempfile.TemporaryDirectory()  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


class NewProject(unittest.TestCase):
    def sh(self, command, cwd, code=0):
        done = subprocess.run(["bash", "-c", command], cwd=cwd, capture_output=True, text=True, timeout=240)
        self.assertEqual(done.returncode, code, f"{command}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def test_it_builds_runs_and_passes_its_test(self):
        with tempfile.TemporaryDirectory() as folder:
            here = f"{folder}/my_robot"
            said = self.sh(f'"{SINEW}" new my_robot', folder)
            # Runs the commands that it tells the user to type.
            out = self.sh(said.splitlines()[1], folder)
            self.assertRegex(out, r"wave +1000 steps, 1000 ok")
            self.sh("ctest --test-dir build --no-tests=error", here)
            ours = os.path.relpath(here, folder)
            self.assertEqual(len([f for f in os.listdir(f"{folder}/{ours}") if f != "build"]), 6)

            # The program is the whole command for the project's modules and ours.
            graph = json.loads(self.sh("./build/my_robot graph my_robot.toml --json", here))
            self.assertEqual([m["type"] for m in graph["modules"]], ["my::Wave"])
            self.sh("./build/my_robot run my_robot.toml --virtual --set wave.height_m=99", here, 2)
            self.sh(f'./build/my_robot check "{SOURCE}/robots/quad/quad.toml"', here)
            real = json.loads(self.sh("./build/my_robot run my_robot.toml --duration 0.3 --json", here))
            self.assertGreater(real["modules"][0]["ok"], 0)
            if os.path.exists(os.path.join(os.path.dirname(SINEW), "sinew-sim")):
                flown = self.sh(f'./build/my_robot run "{SOURCE}/robots/quad/quad.toml" --virtual --duration 0.5', here, 1)
                self.assertIn("did not land", flown)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
