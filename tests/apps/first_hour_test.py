"""Runs every command of docs/first-hour.md as written, in order, and saves the files that the page shows."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SOURCE = sys.argv[1]
PAGE = f"{SOURCE}/docs/first-hour.md"


def pieces():
    """("sh", commands) and (file, text) in the order of the page."""
    name = None
    with open(PAGE) as f:
        text = f.read()
    for match in re.finditer(r"^`([\w.]+)`$|^```(\w+)\n(.*?)^```$", text, re.M | re.S):
        if match.group(1):
            name = match.group(1)
        elif match.group(2) == "sh":
            yield "sh", match.group(3)
        else:
            yield name, match.group(3)
            name = None


class FirstHour(unittest.TestCase):
    def test_every_command_of_the_page_does_what_it_says(self):
        with tempfile.TemporaryDirectory() as home:
            script = ["set -euo pipefail"]
            for kind, text in pieces():
                self.assertIsNotNone(kind, "code that is in no file")
                script.append(f"echo '== {kind}'")
                script.append(text if kind == "sh" else f"cat > {kind} <<'END OF FILE'\n{text}END OF FILE")
            self.assertGreater(len(script), 12, "the page was not understood")
            # The packages are installed, else this could not run; the home folder is the test's own.
            env = {**os.environ, "HOME": home, "SINEW_SKIP_SETUP": "1", "SINEW_RUN_DIR": f"{home}/run"}
            done = subprocess.run(["bash", "-c", "\n".join(script)], cwd=SOURCE, env=env, text=True, timeout=1150,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(done.returncode, 0, done.stdout)
            landed = re.findall(r"^flight time +([0-9.]+) s$", done.stdout, re.M)
            self.assertEqual(done.stdout.count("landed on the pad, valid run"), 4, done.stdout)
            usual, two, four, tuned = (float(s) for s in landed)
            self.assertGreater(two, usual + 4, "two laps of four seconds")
            self.assertGreater(four, two + 4)
            self.assertGreater(tuned, usual + 4)
            self.assertRegex(done.stdout, r"(?m)^imu.raw: ([5-9]\d\d|\d{4})\.\d+ Hz;", "in the robot's time")
            height_m = re.search(r"^p_world_m:\n  x: \S+\n  y: \S+\n  z: (\S+)$", done.stdout, re.M)
            self.assertGreaterEqual(float(height_m[1]), 0.1, "it flies when it is looked at")
            self.assertRegex(done.stdout, r"lap.radius_m = 0.2 from step \d+ of lap on")
            self.assertIn("tuned.toml: 1 parameter differs", done.stdout)
            self.assertIn("100% tests passed, 0 tests failed out of 2", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
