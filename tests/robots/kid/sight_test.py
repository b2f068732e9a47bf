"""What the kid of robots/kid sees while it walks, against where ball and lines are; in virtual time.

usage: sight_test.py SINEW SOURCE [unittest arguments]
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = map(os.path.abspath, sys.argv[1:3])
ROBOT = f"{SOURCE}/robots/kid/kid_sight.toml"
START = (-1.0, -1.5, 0.0)  # as [sim] of kid.toml
BALL = (0.5, -1.0)
SECONDS = 7

# The middles of the straight lines of the field, x0 y0 x1 y1: docs/pitch.md. A line of a mirrored half is added below.
HALF = [(4.475, -2.975, 4.475, 2.975), (0, -2.975, 0, 2.975), (0, 2.975, 4.475, 2.975), (0, -2.975, 4.475, -2.975),
        (3.475, -1.475, 3.475, 1.475), (3.475, 1.475, 4.475, 1.475), (3.475, -1.475, 4.475, -1.475),
        (2.475, -2.475, 2.475, 2.475), (2.475, 2.475, 4.475, 2.475), (2.475, -2.475, 4.475, -2.475)]
LINES = HALF + [(-x0, -y0, -x1, -y1) for x0, y0, x1, y1 in HALF]


def moved(frame, x, y):
    """A point of a frame (x, y, heading in the outer one) in the outer one."""
    fx, fy, turn = frame
    return (fx + math.cos(turn) * x - math.sin(turn) * y, fy + math.sin(turn) * x + math.cos(turn) * y)


def off_line(line, p):
    x0, y0, x1, y1 = line
    n2 = (x1 - x0) ** 2 + (y1 - y0) ** 2
    s = min(1, max(0, ((p[0] - x0) * (x1 - x0) + (p[1] - y0) * (y1 - y0)) / n2))
    return math.dist(p, (x0 + s * (x1 - x0), y0 + s * (y1 - y0)))


class KidSight(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="sinew_sight_")
        cls.folder = cls.temporary.name
        env = dict(os.environ, SINEW_RECORD="on", SINEW_RUN_DIR=cls.folder, TMPDIR=cls.folder)
        done = subprocess.run(
            [SINEW, "run", ROBOT, "--virtual", "--json", "--runs", f"{cls.folder}/runs", "--duration", str(SECONDS), "--set",
             f"sim.ball_x_m={BALL[0]}", "--set", f"sim.ball_y_m={BALL[1]}",
             "--set", f"figure.ball_x_m={BALL[0] - START[0]}", "--set", f"figure.ball_y_m={BALL[1] - START[1]}"],
            capture_output=True, text=True, env=env, cwd=cls.folder, timeout=200)
        assert done.stdout, done.stderr
        cls.summary = json.loads(done.stdout.splitlines()[-1])

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def sights(self, topic):
        done = subprocess.run([SINEW, "bag", "cat", f"{self.folder}/runs/latest/run.mcap", "--topic", topic], text=True,
                              capture_output=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line)["message"] for line in done.stdout.splitlines()]

    def place(self, sight, point):
        """On the field; the odometry begins where the robot starts."""
        frame = (sight["x_m"], sight["y_m"], sight["heading_rad"])
        return moved(START, *moved(frame, point["x_m"], point["y_m"]))

    def test_ball_and_lines_are_seen_where_they_are(self):
        sights = self.sights("sight.sight") + self.sights("sight2.sight")
        self.assertGreater(len(sights), 15 * (SECONDS - 3), "two cameras at 10 Hz, from when it stands")
        balls = [(math.dist(self.place(s, b["at"]), BALL), math.dist((b["at"]["x_m"], b["at"]["y_m"]), (0, 0)))
                 for s in sights for b in s["ball"][:s["balls"]]]
        self.assertGreater(len(balls), 5 * (SECONDS - 3))
        self.assertGreater(sum(off < 0.08 + 0.12 * far for off, far in balls) / len(balls), 0.9, sorted(balls)[-5:])
        lines = [min(max(self.sigmas(s, l[end], line) for end in ("from", "to")) for line in LINES)
                 for s in sights for l in s["line"][:s["lines"]]]
        self.assertGreater(len(lines), 20)
        self.assertGreater(sum(off < 3 for off in lines) / len(lines), 0.9, sorted(lines)[-8:])

    def sigmas(self, sight, point, line):
        """How far an end is from a line, in standard deviations of its own across that line, and 5 cm of odometry."""
        turn = START[2] + sight["heading_rad"]
        x0, y0, x1, y1 = line
        nx, ny = y0 - y1, x1 - x0
        # The line's normal in the frame of the robot.
        rx, ry = math.cos(turn) * nx + math.sin(turn) * ny, math.cos(turn) * ny - math.sin(turn) * nx
        variance = (rx * rx * point["xx_m2"] + 2 * rx * ry * point["xy_m2"] + ry * ry * point["yy_m2"]) / (nx * nx + ny * ny)
        return max(0, off_line(line, self.place(sight, point)) - 0.05) / math.sqrt(variance)

    def test_is_seen_again_from_the_record(self):
        done = subprocess.run([SINEW, "replay", f"{self.folder}/runs/latest/run.mcap"], capture_output=True, text=True,
                              timeout=200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "^identical")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
