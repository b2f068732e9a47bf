"""Where the kid of robots/kid/kid_world.toml believes to be and where its ball is, against the truth; in virtual time.

usage: world_test.py SINEW SOURCE [unittest arguments]
"""
import bisect
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = map(os.path.abspath, sys.argv[1:3])
ROBOT = f"{SOURCE}/robots/kid/kid_world.toml"
SECONDS, SETTLE_S = 16, 5
BALL = (0.4, -0.9)


def heading(q):
    return math.atan2(2 * (q["w"] * q["z"] + q["x"] * q["y"]), 1 - 2 * (q["y"] ** 2 + q["z"] ** 2))


class KidWorld(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="sinew_world_")
        cls.folder = cls.temporary.name
        env = dict(os.environ, SINEW_RECORD="on", SINEW_RUN_DIR=cls.folder, TMPDIR=cls.folder)
        done = subprocess.run(
            [SINEW, "run", ROBOT, "--virtual", "--json", "--runs", f"{cls.folder}/runs", "--duration", str(SECONDS),
             "--seed", "11", "--set", f"sim.ball_x_m={BALL[0]}", "--set", f"sim.ball_y_m={BALL[1]}"],
            capture_output=True, text=True, env=env, cwd=cls.folder, timeout=200)
        assert done.stdout, done.stderr
        cls.record = f"{cls.folder}/runs/latest/run.mcap"
        cls.truth = cls.messages("ground_truth")
        cls.stamps = [t["stamp"] for t in cls.truth]

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def messages(cls, topic):
        done = subprocess.run([SINEW, "bag", "cat", cls.record, "--topic", topic], text=True, capture_output=True,
                              timeout=100)
        assert done.returncode == 0, done.stderr
        return [json.loads(line)["message"] for line in done.stdout.splitlines()]

    def at(self, stamp):
        """The true place at this time: x, y, heading."""
        t = self.truth[min(len(self.truth) - 1, bisect.bisect_left(self.stamps, stamp))]
        return t["p_world_m"]["x"], t["p_world_m"]["y"], heading(t["q_world_base"])

    def settled(self, messages):
        return [m for m in messages if m["stamp"] > self.stamps[0] + 1e9 * SETTLE_S]

    def test_it_knows_where_it_is_and_which_half(self):
        poses = self.settled(self.messages("locate.pose"))
        self.assertGreater(len(poses), 5 * (SECONDS - SETTLE_S))
        off, turn = [], []
        for p in poses:
            x, y, h = self.at(p["stamp"])
            off.append(math.dist((p["x_m"], p["y_m"]), (x, y)))
            turn.append(abs((p["heading_rad"] - h + math.pi) % (2 * math.pi) - math.pi))
        off.sort(), turn.sort()
        self.assertLess(off[len(off) // 2], 0.10)
        self.assertLess(off[len(off) * 95 // 100], 0.30)
        self.assertLess(math.degrees(turn[len(turn) // 2]), 3)
        self.assertLess(math.degrees(turn[len(turn) * 95 // 100]), 8)
        self.assertGreater(sum(p["found"] for p in poses) / len(poses), 0.9)

    def test_it_knows_where_the_ball_is(self):
        balls = [b for b in self.settled(self.messages("ball.ball")) if b["confidence"] > 0.5]
        self.assertGreater(len(balls), 20)
        off = sorted(math.dist((b["field_x_m"], b["field_y_m"]), BALL) for b in balls)
        self.assertLess(off[len(off) // 2], 0.25)

    def test_is_believed_again_from_the_record(self):
        done = subprocess.run([SINEW, "replay", self.record], capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "^identical")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
