"""The examples fly: the simulated quadrotor with another program at its stick.

    steer_test.py SINEW LIBRARY SOURCE COMMAND...       COMMAND: the example, e.g. python3 -B examples/client/steer.py

Slower than real time, on a machine that may be busy: one of three flights must land on the pad.
"""
import json
import os
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, LIBRARY, SOURCE = sys.argv[1:4]
COMMAND = sys.argv[4:]
LIMIT_S = 150


class Steer(unittest.TestCase):
    def fly(self, folder):
        env = {**os.environ, "SINEW_RUN_DIR": folder, "SINEW_RECORD": "off", "SINEW_CLIENT_LIBRARY": LIBRARY,
               "PYTHONPATH": f"{SOURCE}/python"}
        run = subprocess.Popen([SINEW, "run", f"{SOURCE}/examples/client/quad_client.toml", "--rate", "0.25", "--json",
                                "--no-record"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=env)
        end = time.monotonic() + LIMIT_S
        try:
            while not os.path.exists(f"{folder}/quad_client.sock") and run.poll() is None and time.monotonic() < end:
                time.sleep(0.1)
            said = subprocess.run(COMMAND, cwd=f"{SOURCE}/examples/client", capture_output=True, text=True, env=env,
                                  timeout=LIMIT_S)
            time.sleep(2)  # it stands there
            subprocess.run([SINEW, "stop", "--robot", "quad_client"], capture_output=True, env=env, timeout=LIMIT_S)
            out, _ = run.communicate(timeout=LIMIT_S)
        finally:
            run.kill()
            run.wait()
        return said, json.loads(out)["mission"]["outcome"]

    def test_lands_on_the_pad(self):
        tries = []
        for _ in range(3):
            with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
                said, outcome = self.fly(folder)
            if said.returncode == 0 and said.stdout.strip() == "landed" and outcome.startswith("landed on the pad"):
                return
            tries.append((said.returncode, said.stdout[-300:], said.stderr[-300:], outcome))
        self.fail(tries)


unittest.main(argv=sys.argv[:1])
