"""Every command for a running robot, against a running robot: what it prints, what it refuses, its exit code."""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SINEW, PROGRAM, SOURCE = sys.argv[1:4]
ROBOT = f"{SOURCE}/tests/apps/live/live_robot.toml"
QUAD = f"{SOURCE}/robots/quad/quad.toml"
LIMIT_S = 120  # for any step here, on a machine that is busy elsewhere


class Live(unittest.TestCase):
    """One robot, ARGUMENTS of run, for all tests of a class; each puts back what it changed."""
    ARGUMENTS = [ROBOT]

    @classmethod
    def start(cls, *arguments):
        out = open(f"{cls.folder.name}/{len(cls.runs)}.txt", "w+")
        run = subprocess.Popen([PROGRAM, "run", *arguments, "--plain"], stdout=out, stderr=subprocess.STDOUT,
                               env=cls.env)
        cls.runs.append((run, out))
        return run

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.env = {**os.environ, "SINEW_RUN_DIR": f"{cls.folder.name}/run"}
        cls.runs = []
        if cls.ARGUMENTS:
            cls.start(*cls.ARGUMENTS)

    @classmethod
    def tearDownClass(cls):
        for run, out in cls.runs:
            if run.poll() is None:
                run.send_signal(signal.SIGTERM)
                run.wait(LIMIT_S)
            out.close()
        cls.folder.cleanup()

    def sinew(self, *arguments, program=SINEW):
        done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=LIMIT_S, env=self.env)
        return done.returncode, done.stdout, done.stderr

    def good(self, *arguments, program=SINEW):
        code, out, err = self.sinew(*arguments, program=program)
        self.assertEqual((code, err), (0, ""), (arguments, out))
        return out

    def asked(self, *arguments):
        return json.loads(self.good(*arguments, "--json"))

    def refused(self, code, words, *arguments):
        got, out, err = self.sinew(*arguments)
        self.assertEqual((got, out), (code, ""), (arguments, err))
        self.assertIn(words, err)


class LiveCommands(Live):
    def setUp(self):
        self.good("status", "--wait", str(LIMIT_S))

    def test_list_and_status_name_the_robot(self):
        self.assertRegex(self.good("list"), r"(?m)^ball +\d+ +/")
        robots = self.asked("list")["robots"]
        self.assertEqual([r["robot"] for r in robots], ["ball"])
        status = self.asked("status")
        self.assertEqual((status["robot"], status["board"], status["pid"]), ("ball", "none", robots[0]["pid"]))
        self.assertEqual([t["name"] for t in status["threads"]], ["loop"])
        out = self.good("status", "--robot", "ball")
        self.assertIn("robot     ball: process", out)
        self.assertIn("stopped: none; disabled: none; with faults: none", out)

    def test_a_robot_that_does_not_run_ends_with_2_and_the_names_of_those_that_do(self):
        self.refused(2, "ball", "status", "--robot", "bal")
        self.refused(2, "ball", "topic", "list", "--robot", "quad")

    def test_top_once_has_a_rate_for_each_thread_and_topic(self):
        out = self.good("top", "--once", "--period", "0.3")
        self.assertRegex(out, r"(?m)^loop +\d+ Hz +\d+ ")
        self.assertRegex(out, r"(?m)^ball.height +\d+ Hz +0 ")
        self.assertIn("ball.height", [t["name"] for t in self.asked("top", "--once", "--period", "0.1")["topics"]])

    def test_topic_list_and_info(self):
        self.assertRegex(self.good("topic", "list"), r"(?m)^apex.apex +RangeSample +apex +loop +100 Hz$")
        self.assertRegex(self.good("topic", "list"), r"(?m)^operator.range +RangeSample +\(external\)")
        topics = {t["name"]: t for t in self.asked("topic", "list")["topics"]}
        self.assertEqual(topics["ball.height"]["writer"], "ball")
        out = self.good("topic", "info", "ball.height")
        self.assertIn("writer    ball in thread loop", out)
        self.assertRegex(out, r"range_m +f64 +m")
        info = self.asked("topic", "info", "ball.height")
        self.assertEqual([f["name"] for f in info["fields"]], ["stamp", "range_m"])
        self.assertGreaterEqual(info["messages"], 0)
        self.refused(1, "no topic ball.size", "topic", "info", "ball.size")

    def test_topic_info_and_module_info_know_types_without_a_robot(self):
        alone = {**self.env, "SINEW_RUN_DIR": f"{self.folder.name}/nobody"}

        def say(program, *arguments):
            done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=LIMIT_S, env=alone)
            return done.returncode, done.stdout + done.stderr
        code, out = say(SINEW, "topic", "info", "GuardianState")
        self.assertEqual(code, 0)
        self.assertRegex(out, r"(?m)^  mode +uint32 +enum +0 standby, 1 armed, 2 active, 3 safe$")
        self.assertIn("1 lease, 2 not finite", json.loads(say(SINEW, "topic", "info", "GuardianState", "--json")[1])
                      ["fields"][5]["doc"])
        code, out = say(SINEW, "module", "info", "control::Mixer")
        self.assertEqual((code, say(SINEW, "module", "info", "Mixer")[1]), (0, out), "its last part is enough")
        self.assertRegex(out, r"(?m)^  motors +out +ActuatorCommand")
        self.assertRegex(out, r"(?m)^  thrust_max_n +number +N +\S+ +0.01 to 1000 +of one rotor$")
        self.assertIn("control::Mixer\n", say(SINEW, "module", "info")[1])
        types = {m["type"]: m for m in json.loads(say(PROGRAM, "module", "info", "--json")[1])["modules"]}
        own = [p["name"] for m in types.values() for p in m["params"] if p["name"] == "restitution"]
        self.assertEqual(own, ["restitution"], "a project's own modules, too")
        code, out = say(SINEW, "module", "info", "control::Mixxer")
        self.assertEqual(code, 2)
        self.assertIn("control::Mixxer: no such type of module; `module info` lists them; did you mean control::Mixer?", out)

    def test_topic_plot_draws_a_running_robot(self):
        picture = f"{self.folder.name}/live.svg"
        drawn = self.asked("topic", "plot", "ball.height.range_m", "--seconds", "0.5", "-o", picture)
        self.assertEqual((drawn["file"], drawn["marks"]), (picture, []))
        self.assertEqual((drawn["series"][0]["name"], drawn["series"][0]["unit"]), ("ball.height.range_m", "m"))
        self.assertGreater(drawn["series"][0]["points"], 10)
        with open(picture) as svg:
            self.assertIn("ball, 0.", svg.read())
        self.refused(2, "ball.hight.range_m: no such topic", "topic", "plot", "ball.hight.range_m", "-o", picture)

    def test_topic_echo_prints_messages_in_their_order(self):
        lines = [json.loads(line) for line in self.good("topic", "echo", "ball.height", "-n", "5", "--json").splitlines()]
        self.assertEqual(len(lines), 5)
        numbers = [line["sequence"] for line in lines]
        self.assertEqual(numbers, sorted(set(numbers)))
        for line in lines:
            self.assertGreaterEqual(line["message"]["range_m"], 0)
            self.assertEqual(line["message"]["stamp"] <= line["published_ns"], True)
        out = self.good("topic", "echo", "ball.height", "-n", "1")
        self.assertRegex(out, r"^stamp: \d+\nrange_m: [0-9.e-]+\n---\n$")
        out = self.good("topic", "echo", "ball.height", "-n", "3", "--field", "range_m")
        self.assertEqual(len([float(line) for line in out.splitlines()]), 3)
        self.assertIn("value", json.loads(self.good("topic", "echo", "ball.height", "-n", "1", "--field", "range_m", "--json")))
        self.refused(2, "--field size: no \"size\"; one of stamp range_m", "topic", "echo", "ball.height", "--field", "size")
        self.refused(2, "no topic ball; it has", "topic", "echo", "ball")
        self.refused(1, "no message within 0.2 s", "topic", "echo", "operator.range", "--timeout", "0.2")

    def test_topic_hz_counts_what_it_sees(self):
        measured = self.asked("topic", "hz", "ball.height", "--seconds", "1")
        self.assertGreater(measured["messages"], 2)
        self.assertGreater(measured["rate_hz"], 0)
        self.assertGreaterEqual(measured["jitter_p99_ns"], measured["jitter_p50_ns"])
        self.assertRegex(self.good("topic", "hz", "ball.height", "--seconds", "0.5"),
                         r"^ball.height: [0-9.]+ Hz; interval p50 .* lost\n$")
        code, _, err = self.sinew("topic", "hz", "operator.range", "--seconds", "0.2")
        self.assertEqual(code, 1)
        self.assertRegex(err, "no message within 0.2 s|nothing new within 0.2 s")

    def test_topic_hz_of_a_topic_that_is_dead_has_no_rate(self):
        self.good("topic", "pub", "operator.range", '{"range_m": 2.5}')
        for as_json in ((), ("--json",)):
            code, out, err = self.sinew("topic", "hz", "operator.range", "--seconds", "0.2", *as_json)
            self.assertEqual(code, 1, out)
            self.assertIn("nothing new within 0.2 s, only an old message", err)
            self.assertNotIn("Hz", out)
        self.assertIsNone(json.loads(out)["rate_hz"])

    def test_topic_pub_reaches_the_robot(self):
        echo = subprocess.Popen([SINEW, "topic", "echo", "operator.range", "-n", "3", "--field", "range_m"],
                                stdout=subprocess.PIPE, text=True, env=self.env)
        deadline = time.monotonic() + LIMIT_S
        while echo.poll() is None and time.monotonic() < deadline:  # the echo may begin late
            self.assertRegex(self.good("topic", "pub", "operator.range", '{"range_m": 2.5}'),
                             r"^ball: published to operator.range in step \d+\n$")
        self.assertEqual(echo.communicate(timeout=LIMIT_S)[0], "2.5\n" * 3)
        many = self.good("topic", "pub", "operator.range", '{"range_m": 1}', "--rate", "100", "-n", "4", "--json")
        steps = [json.loads(line)["step"] for line in many.splitlines()]
        self.assertEqual(len(steps), 4)
        self.assertEqual(steps, sorted(steps))

    def test_topic_pub_refuses_what_is_no_such_message(self):
        self.refused(2, "a message is one JSON object", "topic", "pub", "operator.range", "2.5")
        self.refused(1, "ball.height", "topic", "pub", "ball.height", '{"range_m": 1}')
        self.refused(1, "size", "topic", "pub", "operator.range", '{"size": 1}')

    def test_param_set_answers_with_the_step_and_holds(self):
        self.assertEqual(self.good("param", "get", "ball.restitution"), "0.7\n")
        self.assertRegex(self.good("param", "set", "ball.restitution", "0.5"),
                         r"^ball.restitution = 0.5 from step \d+ of ball on\n$")
        self.assertEqual(self.good("param", "get", "ball.restitution"), "0.5\n")
        back = self.asked("param", "set", "ball.restitution", "0.7")
        self.assertEqual((back["module"], back["param"], back["value"]), ("ball", "restitution", 0.7))
        self.assertGreater(back["step"], 0)
        listed = self.asked("param", "list", "ball")["params"]
        self.assertEqual([(p["param"], p["value"], p["max"]) for p in listed], [("restitution", 0.7, 1)])
        self.assertRegex(self.good("param", "list"), r"(?m)^ball.restitution +0.7 +1 +a number from 0 to 1")

    def test_param_refuses_with_what_is_allowed(self):
        self.refused(1, "a number from 0 to 1", "param", "set", "ball.restitution", "1.5")
        self.refused(1, "a number from 0 to 1", "param", "set", "ball.restitution", "bouncy")
        self.refused(1, "no parameter size; it has restitution", "param", "get", "ball.size")
        self.refused(1, "nobody", "param", "list", "nobody")
        self.refused(2, "restitution: MODULE.PARAM", "param", "set", "restitution", "1")

    def test_param_save_writes_what_differs_and_run_reads_it(self):
        file = f"{self.folder.name}/saved.toml"
        self.good("param", "set", "ball.restitution", "0.25")
        self.assertIn("1 parameter differs from ", self.good("param", "save", file))
        with open(file) as f:
            self.assertIn("\n[ball]\nrestitution = 0.25\n", f.read())
        self.good("param", "set", "ball.restitution", "0.7")
        self.assertEqual(self.asked("param", "save", f"{self.folder.name}/none.toml")["params"], 0)
        before = json.loads(self.good("run", ROBOT, "--virtual", "--duration", "1", "--json", program=PROGRAM))
        after = json.loads(self.good("run", ROBOT, "--virtual", "--duration", "1", "--json", "--params", file,
                                     program=PROGRAM))
        changed = json.loads(self.good("run", ROBOT, "--virtual", "--duration", "1", "--json", "--set",
                                       "ball.restitution=0.25", program=PROGRAM))
        self.assertNotEqual(before["hashes"]["ball.height"], after["hashes"]["ball.height"])
        self.assertEqual(after["hashes"], changed["hashes"])
        with open(file, "a") as f:
            f.write("size = 3\n")
        code, _, err = self.sinew("run", ROBOT, "--virtual", "--params", file, program=PROGRAM)
        self.assertEqual(code, 2)
        self.assertIn(f"{file}:5: ball.size: 3: no such parameter of my::Ball", err)
        self.refused(1, "cannot be written", "param", "save", f"{self.folder.name}/no/such/folder.toml")

    def test_modules_are_disabled_and_enabled(self):
        self.assertRegex(self.good("module", "disable", "apex"), r"^ball: module apex disabled, from step \d+ on\n$")
        self.assertRegex(self.good("module", "list"), r"(?m)^apex +my::Apex +loop +disabled ")
        self.assertIn("disabled: apex", self.good("status"))
        steps = self.asked("module", "enable", "apex")
        self.assertIsInstance(steps["step"], int)
        modules = {m["name"]: m for m in self.asked("module", "list")["modules"]}
        self.assertTrue(modules["apex"]["running"])
        self.refused(1, "nobody", "module", "enable", "nobody")

    def test_the_period_of_a_thread_changes(self):
        self.assertRegex(self.good("thread", "period", "loop", "20000"), r"^ball: thread loop every 20000 us, from step")
        self.asked("thread", "period", "loop", "10000")
        self.refused(1, "10", "thread", "period", "loop", "1")
        self.refused(1, "nobody", "thread", "period", "nobody", "1000")

    def test_a_robot_without_actuators_cannot_be_armed(self):
        for command in ("arm", "disarm"):
            code, out, err = self.sinew(command)
            self.assertEqual((code, out), (1, ""))
            self.assertIn("robot ball: ", err)

    def test_completion_offers_the_running_robots_names(self):
        def offered(*words):
            return self.good("complete", *words).splitlines()
        self.assertEqual(offered("status", "--robot", ""), ["ball"])
        self.assertEqual(offered("topic", "echo", "ap"), ["apex.apex"])
        self.assertEqual(offered("topic", "pub", ""), ["operator.range"])
        self.assertEqual(offered("param", "set", "ball."), ["ball.restitution"])
        self.assertIn("apex", offered("module", "disable", ""))
        self.assertEqual(offered("thread", "period", ""), ["loop"])
        self.assertEqual(offered("topic", "echo", "--robot", "nobody", ""), [])
        self.assertEqual(offered("topic", ""), ["list", "info", "echo", "hz", "plot", "pub"])


class SeveralRobots(Live):
    def test_each_is_reached_by_its_name_and_stop_ends_the_one_that_is_meant(self):
        self.good("status", "--robot", "ball", "--wait", str(LIMIT_S))
        second = self.start(ROBOT, "--name", "other")
        self.good("status", "--robot", "other", "--wait", str(LIMIT_S))
        code, _, err = self.sinew("status")
        self.assertEqual(code, 2)
        self.assertIn("ball", err)
        self.assertIn("other", err)
        # A third of the same name does not start.
        code, _, err = self.sinew("run", ROBOT, "--name", "other", "--duration", "1", program=PROGRAM)
        self.assertEqual(code, 2)
        self.assertIn("other", err)
        self.assertEqual(self.good("stop", "--robot", "other"), "other: ends its run\n")
        self.assertEqual(second.wait(LIMIT_S), 0)
        self.assertEqual([r["robot"] for r in self.asked("list")["robots"]], ["ball"])
        # A command that watches says so when the robot ends.
        echo = subprocess.Popen([SINEW, "topic", "echo", "operator.range"], stderr=subprocess.PIPE, text=True, env=self.env)
        time.sleep(0.5)
        self.good("stop")
        self.assertEqual(self.runs[0][0].wait(LIMIT_S), 0)
        _, err = echo.communicate(timeout=LIMIT_S)
        self.assertIn(echo.returncode, (1, 2), "2: it began after the end")
        self.assertIn("robot", err)
        self.assertEqual(self.good("list"), "no robot runs\n")
        self.refused(2, "no robot", "status")


class Guarded(Live):
    ARGUMENTS = None

    @unittest.skipUnless(os.path.exists(os.path.join(os.path.dirname(SINEW), "sinew-sim")), "there is no simulator")
    def test_rates_of_a_slower_robot_are_in_the_time_of_its_messages(self):
        for pace in (["--rate", "0.2"], ["--virtual"]):
            run = subprocess.Popen([SINEW, "run", QUAD, *pace, "--quiet", "--name", "slow"], env=self.env,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                self.good("status", "--wait", str(LIMIT_S))
                now = self.asked("top", "--once", "--period", "0.1")["now_ns"]
                later = self.good("topic", "echo", "imu.raw", "-n", "100", "--json").splitlines()[-1]
                self.assertLess(now, json.loads(later)["published_ns"], pace)
            finally:
                run.send_signal(signal.SIGTERM)
                run.wait(LIMIT_S)

    @unittest.skipUnless(os.path.exists(os.path.join(os.path.dirname(SINEW), "sinew-sim")), "there is no simulator")
    def test_disarm_stops_and_status_and_plot_say_what_the_guardian_does(self):
        run = subprocess.Popen([SINEW, "run", QUAD, "--virtual", "--quiet", "--fault", "camera:off@4"], env=self.env,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            said = self.good("status", "--wait", str(LIMIT_S))
            while run.poll() is None and "\nguardian" not in said:  # its first step may not have come yet
                said = self.good("status")
            self.assertRegex(said, r"(?m)^guardian  \w+; commands ")
            plot = subprocess.Popen([SINEW, "topic", "plot", "guardian.state.acted", "--seconds", "1000", "-o",
                                     f"{self.folder.name}/acted.svg", "--json"], env=self.env, stdout=subprocess.PIPE)
            while run.poll() is None and not self.asked("status")["guardian"]["acted"]:
                time.sleep(0.05)
            disarmed = self.asked("disarm")
            self.assertIsInstance(disarmed["step"], int)
        finally:
            run.send_signal(signal.SIGTERM)
            run.wait(LIMIT_S)
        marks = json.loads(plot.communicate(timeout=LIMIT_S)[0])["marks"]  # until the end of the run
        self.assertIn("camera_lost", [m["text"] for m in marks])

    @unittest.skipUnless(os.path.exists(os.path.join(os.path.dirname(SINEW), "sinew-sim")), "there is no simulator")
    def test_a_disarm_in_flight_is_named_in_the_result(self):
        run = subprocess.Popen([SINEW, "run", QUAD, "--virtual", "--json", "--name", "falls"], env=self.env,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            status = self.asked("status", "--wait", str(LIMIT_S))
            while not status.get("guardian", {}).get("groups_moving"):
                status = self.asked("status")
            self.asked("disarm")
            deadline = time.monotonic() + LIMIT_S
            while not self.asked("status")["guardian"]["disarmed"]:  # its next step may not have come yet
                self.assertLess(time.monotonic(), deadline)
            self.sinew("stop")  # it may have ended meanwhile
            summary = json.loads(run.communicate(timeout=LIMIT_S)[0])
        finally:
            run.kill()
            run.wait(LIMIT_S)
        self.assertEqual(summary["exit_code"], 1, summary["result"])
        self.assertGreaterEqual(summary["disarmed_s"], status["now_ns"] * 1e-9)
        self.assertLess(summary["disarmed_s"], summary["run_s"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
