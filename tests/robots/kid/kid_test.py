"""The humanoid of robots/kid on the simulated field, in virtual time.

usage: kid_test.py SINEW SOURCE [unittest arguments]
"""
import json
import math
import os
import socket
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = map(os.path.abspath, sys.argv[1:3])
KID = f"{SOURCE}/robots/kid/kid.toml"
NAO = f"{SOURCE}/robots/kid/kid_nao.toml"
FAST = f"{SOURCE}/robots/kid/kid_58.toml"
BLUE, RED = (f"{SOURCE}/robots/kid/{name}.toml" for name in ("kid_game", "kid_game_red"))
SOON = ("--set", "sim.referee_ready_s=2", "--set", "sim.referee_set_s=1")  # the game begins at 3 s
KICK = f"{SOURCE}/robots/kid/kick.toml"
VISION_LOAD = f"{SOURCE}/robots/kid/kid_vision_load.toml"


def run(folder, *arguments, record=False, robot=KID):
    env = dict(os.environ, SINEW_RECORD="on" if record else "off", SINEW_RUN_DIR=folder, TMPDIR=folder)
    done = subprocess.run([SINEW, "run", robot, "--virtual", "--json", "--runs", f"{folder}/runs", *arguments],
                          capture_output=True, text=True, env=env, cwd=folder, timeout=300)
    if not done.stdout:
        raise AssertionError(done.stderr)
    return done.returncode, json.loads(done.stdout.splitlines()[-1])


def measures(summary):
    return {m["key"]: m["value"] for m in summary["report"]["verdict"]["measures"]}


class Kid(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew_kid_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def replay(self, *arguments):
        done = subprocess.run([SINEW, "replay", f"{self.folder}/runs/latest/run.mcap", *arguments], capture_output=True,
                              text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "^identical")

    def stamps(self, topic):
        done = subprocess.run([SINEW, "bag", "cat", f"{self.folder}/runs/latest/run.mcap", "--topic", topic], text=True,
                              capture_output=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line)["message"]["stamp"] for line in done.stdout.splitlines()]

    def test_walks_its_figure_and_each_step_of_it_can_be_executed_again(self):
        code, summary = run(self.folder, record=True)
        self.assertEqual(code, 0, summary)
        self.assertEqual(measures(summary)["falls"], 0)
        self.assertGreater(measures(summary)["walked_m"], 5)
        self.assertGreater(measures(summary)["turned_deg"], 500, "two circles")
        self.assertEqual(summary["report"]["physics_warnings"], 0)
        taken, answered = self.stamps("camera.raw/head"), self.stamps("camera_pose.pose")
        self.assertEqual(answered, [stamp for stamp in taken if answered[0] <= stamp <= answered[-1]])
        self.assertLess(len(taken) - len(answered), 5, "those before it stands, and the last ones")
        self.replay()
        self.replay("--from", "20")

    def test_rises_however_it_lies_and_walks(self):
        for seed, lie in (("1", 1), ("2", 2), ("1", 4)):  # front, back, right side
            with self.subTest(seed=seed, lie=lie):
                _, summary = run(self.folder, "--set", f"sim.start_lie={lie}", "--seed", seed, "--duration", "14")
                plant = summary["report"]
                self.assertEqual((plant["rises"], plant["on_its_feet"], plant["fallen"]), (1, True, False), plant)
                self.assertLess(plant["longest_down_s"], 8)
                self.assertGreater(plant["walked_m"], 0.3)

    def test_walks_its_figure_without_dynamics(self):
        code, summary = run(self.folder, "--set", "sim.kinematic=1")
        self.assertEqual(code, 0, summary)
        self.assertEqual(measures(summary)["falls"], 0)
        self.assertGreater(measures(summary)["walked_m"], 5)
        self.assertGreater(measures(summary)["turned_deg"], 500, "two circles")

    def test_another_body_that_of_nao_walks_the_figure_too(self):
        for seed in ("1", "2", "3"):
            with self.subTest(seed=seed):
                code, summary = run(self.folder, "--seed", seed, robot=NAO)
                self.assertEqual(code, 0, summary)
                self.assertEqual(measures(summary)["falls"], 0)
                self.assertGreater(measures(summary)["walked_m"], 3)
                self.assertGreater(measures(summary)["turned_deg"], 500, "two circles")

    def test_the_body_of_nao_gets_down_with_a_low_battery(self):
        _, summary = run(self.folder, "--fault", "battery:wrong(-4)@3", "--duration", "12", robot=NAO)
        plant = summary["report"]
        self.assertEqual((plant["falls"], plant["got_down"], plant["motors_stopped"]), (0, 1, True), plant)
        self.assertEqual(plant["verdict"]["outcome"], "got down gently")

    def test_the_same_seed_gives_the_same_bytes_and_another_one_others(self):
        hashes = [run(self.folder, "--duration", "6", "--seed", seed)[1]["hashes"] for seed in ("5", "5", "6")]
        self.assertEqual(hashes[0], hashes[1])
        self.assertNotEqual(hashes[0], hashes[2])

    def test_without_a_leg_it_falls_and_comes_to_rest_without_torque(self):
        code, summary = run(self.folder, "--fault", "right_leg:off@5", "--duration", "15")
        plant = summary["report"]
        self.assertEqual(code, 1)
        self.assertEqual(plant["verdict"]["outcome"], "fell")
        self.assertTrue(plant["at_rest"], plant)
        self.assertTrue(plant["motors_stopped"], plant)

    def test_with_a_low_battery_without_its_imu_or_with_hot_servos_it_gets_down_and_does_not_fall(self):
        for trouble in (("--fault", "battery:wrong(-4)@3"), ("--fault", "imu:off@4"), ("--set", "sim.ambient_c=69.6")):
            with self.subTest(trouble):
                _, summary = run(self.folder, *trouble, "--duration", "12")
                plant = summary["report"]
                self.assertEqual((plant["falls"], plant["got_down"], plant["motors_stopped"]), (0, 1, True), plant)
                self.assertEqual(plant["verdict"]["outcome"], "got down gently")

    def test_keeps_a_ball_in_view_whose_place_it_knows_while_it_walks(self):
        # The four straight parts of the figure. Odometry is part of the error. Of seeds 1 to 20 the worst mean was 9.6
        # degrees and the worst instant 18; of these two less.
        for seed in ("1", "2"):
            with self.subTest(seed=seed):
                _, summary = run(self.folder, "--duration", "22", "--seed", seed)
                plant = summary["report"]
                self.assertEqual(plant["falls"], 0)
                self.assertGreater(plant["walked_m"], 2)
                self.assertLess(plant["ball_off_axis_deg"], 8, plant)
                self.assertLess(plant["ball_off_axis_most_deg"], 20, plant)
        _, without = run(self.folder, "--duration", "22", "--set", "figure.looks_at_ball=false")
        self.assertGreater(without["report"]["ball_off_axis_deg"], 45, "straight ahead the ball is not in view")

    def test_kicks_a_ball_before_its_foot_and_stays_on_its_feet(self):
        code, summary = run(self.folder, robot=KICK, record=True)
        plant = summary["report"]
        self.assertEqual(code, 0, summary)
        self.assertEqual((plant["falls"], plant["ball_touched"], plant["on_its_feet"]), (0, True, True), plant)
        self.assertLess(plant["ball_came_mps"], 0.01, "it lay")
        self.assertGreater(plant["ball_left_mps"], 0.8, plant)
        self.assertGreater(plant["ball_x_m"], -0.3, "forward")
        self.replay()
        self.replay("--from", "4")

    def test_under_a_full_load_of_vision_on_one_core_it_walks_a_minute_and_its_gait_misses_nothing(self):
        code, summary = run(self.folder, robot=VISION_LOAD)
        self.assertEqual(code, 0, summary)
        self.assertGreater(summary["run_s"], 60)
        self.assertEqual(measures(summary)["falls"], 0)
        self.assertGreater(measures(summary)["walked_m"], 9)
        threads = {thread["name"]: thread for thread in summary["threads"]}
        busy_s = {name: thread["execution_ns"]["p50"] * 1e-9 * thread["cycles"] for name, thread in threads.items()}
        self.assertGreater(busy_s["vision"] + busy_s["vision2"], 0.9 * summary["run_s"], "it is a full load")
        self.assertGreater(threads["vision2"]["lateness_ns"]["p50"], 20e6, "which waits")
        gait = threads["gait"]
        self.assertEqual((gait["overruns"], gait["skips"], gait["timeouts"]), (0, 0, 0), gait)
        self.assertGreater(gait["cycles"], 125 * 60)
        self.assertLess(gait["lateness_ns"]["max"] + gait["execution_ns"]["max"], 8e6, gait)
        for module in summary["modules"]:
            if module["name"] in ("ball", "motion", "ball2", "motion2"):
                self.assertGreater(module["ok"], 600, module)
            self.assertEqual(module["fault"], 0, module)

    def test_with_faster_servos_it_walks_its_figure_faster(self):
        code, summary = run(self.folder, robot=FAST)
        self.assertEqual(code, 0, summary)
        self.assertEqual(measures(summary)["falls"], 0)
        self.assertGreater(measures(summary)["fastest_mps"], 0.38)

    def test_stops_a_ball_that_would_roll_off_beside_its_feet(self):
        for seed, stops in (("1", True), ("2", True), ("1", False), ("2", False)):
            with self.subTest(seed=seed, stops=stops):
                _, summary = run(self.folder, "--set", "plan.motion=2", "--set", "sim.ball_roll_mps=1.05", "--set",
                                 "sim.ball_x_m=0", "--set", "sim.ball_y_m=0.13", "--set", f"plan.at_s={3 if stops else 60}",
                                 "--seed", seed, "--duration", "11", robot=KICK)
                plant = summary["report"]
                self.assertEqual((plant["falls"], plant["on_its_feet"], plant["ball_touched"]), (0, True, True), plant)
                self.assertAlmostEqual(plant["ball_came_mps"], 0.7, delta=0.1)
                self.assertLess(plant["ball_mps"], 0.1)
                away_m = math.hypot(plant["ball_x_m"] - plant["x_m"], plant["ball_y_m"] - plant["y_m"])
                self.assertEqual(plant["ball_x_m"] > plant["x_m"], stops, f"before it, or past it: {plant}")
                self.assertTrue(away_m < 0.3 or not stops, plant)

class Game(unittest.TestCase):
    replay = Kid.replay

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew_kid_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_it_walks_only_while_the_game_is_on(self):
        _, before = run(self.folder, *SOON, "--duration", "4", robot=BLUE)
        self.assertLess(before["report"]["walked_m"], 0.1, "it stands for 2 s of the game, too")
        _, summary = run(self.folder, *SOON, "--duration", "10", robot=BLUE, record=True)
        self.replay()
        self.assertTrue(summary["report"]["verdict"]["good"], summary)
        self.assertIn("referee.raw", summary["hashes"])
        plant = summary["report"]
        self.assertGreater(plant["walked_m"], 0.5)
        self.assertEqual(plant["game"]["state"], "playing")
        self.assertEqual(plant["game"]["log"][:4],
                         ["0.0 s: ready", "2.0 s: set", "3.0 s: playing", "3.0 s: kick-off for team 0"])
        _, deaf = run(self.folder, *SOON, "--duration", "10", "--fault", "referee:off@0", robot=BLUE)
        self.assertLess(deaf["report"]["walked_m"], 0.1, "it heard nothing")

    def test_a_robot_that_lies_too_long_is_taken_out_and_walks_when_it_is_back(self):
        _, summary = run(self.folder, *SOON, "--set", "sim.start_lie=1", "--set", "sim.referee_fallen_s=1", "--set",
                         "sim.referee_penalty_s=4", "--duration", "16", robot=BLUE)
        plant = summary["report"]
        log = " | ".join(plant["game"]["log"])
        self.assertRegex(log, r"robot 0: incapable.*robot 0 comes back")
        self.assertEqual(measures(summary)["penalties"], 1)
        self.assertGreater(plant["walked_m"], 0.3)
        self.assertTrue(plant["on_its_feet"], plant)

    def test_the_worlds_referee_speaks_as_a_game_controller(self):
        receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(receiver.close)
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(1)
        other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        other.bind(("127.0.0.1", 0))
        answers = other.getsockname()[1]
        other.close()
        arguments = (f"--gamecontroller=127.0.0.1:{receiver.getsockname()[1]}", "--gamecontroller-teams=12,34",
                     f"--gamecontroller-answers={answers}")
        _, summary = run(self.folder, *SOON, "--duration", "6", *(f"--plant-arg={a}" for a in arguments), robot=BLUE)
        self.assertEqual(summary["report"]["game"]["state"], "playing")
        packets = []
        for _ in range(12):  # two a second of the world's time
            packets.append(receiver.recv(1000))
        self.assertEqual({len(p) for p in packets}, {198})
        self.assertEqual({p[:5] for p in packets}, {b"RGme\x13"})
        states = [p[10] for p in packets]
        self.assertEqual((states[0], states[4], states[-1]), (1, 2, 3), "ready, set, playing")
        self.assertEqual(states, sorted(states))
        self.assertEqual({(p[18], p[108]) for p in packets}, {(12, 34)}, "blue defends the left goal")
        self.assertEqual(packets[-1][13], 12, "which has the kick-off")

    def test_two_robots_of_two_teams_hear_of_a_goal(self):
        env = dict(os.environ, SINEW_RECORD="off", SINEW_RUN_DIR=self.folder, TMPDIR=self.folder)
        done = subprocess.run([SINEW, "team", BLUE, RED, "--virtual", "--json", "--duration", "13", *SOON,
                               "--set", "sim.ball_roll_mps=4", "--set", "sim.ball_roll_at_s=4"],
                              capture_output=True, text=True, env=env, cwd=self.folder, timeout=200)
        self.assertIn(done.returncode, (0, 1), done.stdout + done.stderr)
        said = json.loads(done.stdout)
        for name, own, other in (("kid_blue", 1, 0), ("kid_red", 0, 1)):
            plant = said["plant"]["robots"][name]
            self.assertTrue(plant["verdict"]["good"], plant)
            figures = {m["key"]: m["value"] for m in plant["verdict"]["measures"]}
            self.assertEqual((figures["own_goals"], figures["other_goals"]), (own, other), plant)
            self.assertIn("referee.raw", said["robots"][name]["summary"]["hashes"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
