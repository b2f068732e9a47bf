"""Runs every command of docs/text-robots.md, "A new robot in minutes", as written, and saves the files that it shows.

argv: SINEW SOURCE
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = sys.argv[1:3]


def pieces():
    """("sh", commands) and (file, text) in the order of the page."""
    name = None
    text = pathlib.Path(f"{SOURCE}/docs/text-robots.md").read_text(encoding="utf-8")
    for match in re.finditer(r"^`([\w.]+)`$|^```(\w+)\n(.*?)^```$", text, re.M | re.S):
        if match.group(1):
            name = match.group(1)
        elif match.group(2) == "sh":
            yield "sh", match.group(3)
        else:
            yield name, match.group(3)
            name = None


class Page(unittest.TestCase):
    def test_a_new_robot_in_minutes(self):
        with tempfile.TemporaryDirectory() as home:
            script = ["set -euo pipefail; trap 'kill $(jobs -p) 2>/dev/null || true' EXIT"]
            for kind, text in pieces():
                self.assertIsNotNone(kind, "code that is in no file")
                script.append(text if kind == "sh" else f"cat > {kind} <<'END OF FILE'\n{text}END OF FILE")
            self.assertGreater(len(script), 5, "the page was not understood")
            env = {**os.environ, "HOME": home, "SINEW_RUN_DIR": f"{home}/run", "SINEW_RECORD": "off",
                   "PATH": f"{os.path.dirname(SINEW)}:{os.environ['PATH']}"}
            done = subprocess.run(["bash", "-c", "\n".join(script)], cwd=home, env=env, text=True, timeout=100,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertIn("torn: 0", done.stdout)
            position_m = float(re.findall(r"\[(-?\d+\.\d+),", done.stdout)[-1])
            self.assertGreater(position_m, 0.5, done.stdout)
            self.assertLess(position_m, 3)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
