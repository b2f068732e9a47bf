"""examples/client/emd.m and emd_servo.m fly: the terrain's quadrotor holds its height by what another program reads from its
camera, and an AirRobot by what that program commands.

    emd_test.py SINEW LIBRARY SOURCE COMMAND...       COMMAND: the example

Slower than real time, on a machine that may be busy: one of three flights must hold its height over 30 m of hills.
Without the program no motion comes in, and the vehicle does not fly forward: it lands again.
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, LIBRARY, SOURCE = sys.argv[1:4]
COMMAND = sys.argv[4:]
LIMIT_S = 200
SAID = re.compile(r"\d+ messages; period [\d.]+ ms, p99 [\d.]+; picture to message [\d.]+ ms, p99 [\d.]+\n$")


class Emd(unittest.TestCase):
    def fly(self, folder, command, robot="terrain/terrain_octave", duration=40):
        env = {**os.environ, "SINEW_RUN_DIR": folder, "SINEW_RECORD": "off", "SINEW_CLIENT_LIBRARY": LIBRARY}
        run = subprocess.Popen([SINEW, "run", f"{SOURCE}/robots/{robot}.toml", "--rate", "0.4",
                                "--duration", str(duration), "--json", "--no-record"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=env)
        end = time.monotonic() + LIMIT_S
        said = None
        try:
            while not os.path.exists(f"{folder}/{os.path.basename(robot)}.sock") and run.poll() is None and time.monotonic() < end:
                time.sleep(0.1)
            if command:
                said = subprocess.run(command, cwd=f"{SOURCE}/examples/client", capture_output=True, text=True, env=env,
                                      timeout=LIMIT_S)
            out, _ = run.communicate(timeout=LIMIT_S)
        finally:
            run.kill()
            run.wait()
        return said, json.loads(out)["mission"]

    def test_holds_its_height_by_what_octave_reads(self):
        tries = []
        for _ in range(3):
            with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
                said, mission = self.fly(folder, COMMAND)
            if said.returncode == 0 and SAID.search(said.stdout) and mission["good"] and mission["outcome"]:
                print(said.stdout.splitlines()[-1])
                return
            tries.append((said.returncode, said.stdout[-300:], said.stderr[-300:], mission["outcome"], mission["why"]))
        self.fail(tries)

    def test_an_air_robot_is_flown_by_octave_alone(self):
        tries = []
        for _ in range(3):
            with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
                said, mission = self.fly(folder, [*COMMAND[:-1], "emd_servo.m"], "air_robot/emd_octave", 22)
            heights = re.search(r"height ([\d.]+) to ([\d.]+) m, right ([\d.]+)$", said.stdout.strip())
            measures = {m["name"]: m["value"] for m in mission["measures"]}
            if said.returncode == 0 and heights and measures["touches"] == 0 and measures["driven_m"] > 9:
                least, most, right = map(float, heights.groups())
                if 0.75 * right < least and most < 1.3 * right:
                    print(said.stdout.splitlines()[-1])
                    return
            tries.append((said.returncode, said.stdout[-300:], said.stderr[-300:], measures))
        self.fail(tries)


unittest.main(argv=sys.argv[:1])
