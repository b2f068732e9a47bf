"""The commands that need no running robot: what they print, what they refuse, and their exit codes."""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SINEW, SOURCE = sys.argv[1:3]
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
QUAD = f"{SOURCE}/robots/quad/quad.toml"
BALL = f"{SOURCE}/examples/own_program.toml"


def run(*arguments, **options):
    done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=60, **options)
    return done.returncode, done.stdout, done.stderr


class CommandLine(unittest.TestCase):
    def test_check_accepts_our_robots_and_prints_their_slots(self):
        for robot in ("quad/quad.toml", "mav_dataset/mav_dataset.toml"):
            code, out, err = run("check", f"{SOURCE}/robots/{robot}")
            self.assertEqual(code, 0, err)
            self.assertIn("no problems", out)
            self.assertRegex(out, r"camera.raw +\d+ = +2 \+")

    def test_check_names_every_problem_of_a_broken_robot(self):
        broken = f"{SOURCE}/examples/broken_robot.toml"
        code, _, err = run("check", broken)
        self.assertEqual(code, 1)
        self.assertIn(f"{broken}:2: robot.colour: \"red\": unknown key", err)
        self.assertIn(f"{broken}:6: thread.control.priority: 150: an integer from 0 to 98", err)
        self.assertRegex(err, r":16: module.mixer.in.wrench: .*attitude.wrench")
        self.assertRegex(err, r":17: module.mixer.params.idle: 0.9")
        self.assertIn("4 problems", err)

    def test_check_asks_no_execution_time_of_a_robot_with_real_devices(self):
        with open(f"{SOURCE}/robots/desk_head/desk_head.toml") as file:
            text = file.read()
        with tempfile.TemporaryDirectory() as folder:
            for board, code in (("sim", 1), ("linux", 0)):
                robot = os.path.join(folder, f"{board}.toml")
                with open(robot, "w") as file:
                    file.write(re.sub(r"(?m)^exec_us = .*$", "", text).replace('board = "sim"', f'board = "{board}"'))
                done, _, err = run("check", robot)
                self.assertEqual(done, code, err)
                self.assertEqual("exec_us" in err, board == "sim")

    def test_keys_of_devices_are_refused_at_their_line_before_anything_opens(self):
        with open(f"{SOURCE}/robots/desk_head/desk_head.toml") as file:
            lines = file.read().split("\n")
        wrong = {'address = "can0"': ('address = "host:1/can0"', 'bus.can0.address: "host:1/can0": the name of an '
                                      'interface, e.g. "can0"'),
                 "device_timeout_ms = 100": ("device_timeout_ms = 1", "device.head.joint.pan.device_timeout_ms: 1: 0 (as "
                                             "the drive is set) or at least 30, as our signs of life come every 10 ms "
                                             "(the bus's master_heartbeat_ms)"),
                 'format = "yuyv"': ('format = "jpeg"', 'device.camera.format: "jpeg": one of "mono8", "rgb8", "bgr8", '
                                     '"yuyv"')}
        expected = []
        for old, (new, text) in wrong.items():
            at = lines.index(old)
            lines[at] = new
            expected.append(f":{at + 1}: {text}\n")
        with tempfile.TemporaryDirectory() as folder:
            robot = os.path.join(folder, "wrong.toml")
            with open(robot, "w") as file:
                file.write("\n".join(lines))
            for command in (["check", robot], ["run", robot, "--board", "linux", "--duration", "1"]):
                code, _, err = run(*command)
                self.assertNotEqual(code, 0)
                for text in expected:
                    self.assertIn(robot + text, err)
                self.assertNotIn("there is no such device", err)

    def desk_head(self, *changes):
        """The path of a robot like robots/desk_head/desk_head.toml, with these changes."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        with open(f"{SOURCE}/robots/desk_head/desk_head.toml") as file:
            text = file.read()
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        robot = os.path.join(folder.name, "head.toml")
        with open(robot, "w") as file:
            file.write(text)
        return robot, lambda place: 1 + text[:text.index(place)].count("\n")

    def test_check_and_run_refuse_the_same_in_the_same_words(self):
        for change, place, words in (
                (("id = 2\n", "id = 1\n"), "id = 1\ncounts_per_turn = 65536\nmin_rad = -1.0",
                 "device.head.joint.tilt.id: 1: a number that no other servo on its bus has: 'pan' has it (bus can0)"),
                (("tick_hz = 500", "tick_hz = 4000"), "[bus.can0]", "bus.can0.max_load_percent: 90: 2 servos at 4000 Hz need "),
                (("channels = 2", "channels = 3"), "channels = 3", "actuator.head.channels: 3: 2, as follower.command"),
                (("[device.imu]", "[device.gyro]"), "[module.imu]", "module.imu: \"imu\": the name of a [device.NAME] that gives imu: gyro"),
                (("width = 320\nheight = 240\nformat = \"yuyv\"", "width = 1280\nheight = 720\nformat = \"rgb8\""),
                 "width = 1280", "device.camera: 1280x720 rgb8, 2764800 bytes: at most 614400 bytes, as topic.\"camera.raw\"")):
            robot, line_of = self.desk_head(change, ('board = "sim"', 'board = "linux"'))
            code, _, err = run("check", robot)
            self.assertEqual(code, 1, err)
            self.assertIn(f"{robot}:{line_of(place)}: {words}", err)
            done, _, said = run("run", robot, "--duration", "1")
            self.assertEqual(done, 2, said)
            self.assertEqual(re.sub(r"\d+ problems?\n", "", err), re.sub("warning: .* is not calibrated .*\n", "", said))

    def test_check_reads_the_calibration_that_is_there(self):
        robot, _ = self.desk_head(("desk_head_calibration.toml", "unit.toml"))
        unit = os.path.join(os.path.dirname(robot), "unit.toml")
        self.assertEqual(run("check", robot)[0], 0, "it is not there on a new robot")
        with open(unit, "w") as file:
            file.write("[device.foo]\nx = 1\n[device.imu]\nrate_hz = -5\n")
        code, _, err = run("check", robot)
        self.assertEqual(code, 1, err)
        self.assertIn(f"{unit}:2: device.foo.x: 1: a key of a device of the robot file: ", err)
        code, out, _ = run("check", robot, "--json")
        problem = json.loads(out)["problems"][0]
        self.assertEqual((code, problem["file"], problem["line"], problem["key"]), (1, unit, 2, "device.foo.x"))
        with open(unit, "w") as file:
            file.write("[device.imu]\nrate_hz = -5\n")
        self.assertIn(f"{unit}:2: device.imu.rate_hz: -5: a number from 0", run("check", robot)[2])
        with open(unit, "w") as file:
            file.write("[device.imu]\ngyro_bias_x_radps = 0.002\n")
        self.assertEqual(run("check", robot)[0], 0)

    def test_a_problem_of_a_file_that_is_extended_names_that_file(self):
        with tempfile.TemporaryDirectory() as folder:
            base, robot = os.path.join(folder, "base.toml"), os.path.join(folder, "robot.toml")
            with open(QUAD, encoding="utf-8") as file:
                lines = file.read().replace("mass_kg = 1.2", "mass_kg = -1.2").splitlines()
            with open(base, "w") as file:
                file.write("\n".join(lines))
            with open(robot, "w") as file:
                file.write('extends = "base.toml"\n[module.mission.params]\nsearch_height_m = -5\n')
            line = next(n for n, text in enumerate(lines, 1) if "mass_kg = -1.2" in text)
            words = f"{base}:{line}: module.position.params.mass_kg: -1.2: a number from "
            own = f"{robot}:3: module.mission.params.search_height_m: -5: a number from "
            for command in (["check", robot], ["run", robot, "--virtual"]):
                err = run(*command)[2]
                self.assertIn(words, err)
                self.assertIn(own, err)
            problems = json.loads(run("check", robot, "--json")[1])["problems"]
            self.assertEqual([(p.get("file"), p["line"]) for p in problems], [(None, 3), (base, line)], "in the order of the whole")

    def test_check_takes_another_board_than_the_files(self):
        self.assertEqual(run("check", f"{SOURCE}/robots/desk_head/desk_head.toml", "--board", "linux")[0], 0)
        code, _, err = run("check", f"{SOURCE}/robots/quad/quad.toml", "--board", "linux")
        self.assertEqual(code, 1)
        self.assertIn("module.imu: \"imu\": the name of a [device.NAME] that gives imu: there is none", err)
        code, out, err = run("check", f"{SOURCE}/robots/quad/quad.toml", "--board", "moon", "--json")
        self.assertEqual(code, 1)
        self.assertIn("from --board moon: robot.board: ", err)
        self.assertEqual(json.loads(out)["problems"][0]["line"], 0)

    def test_what_an_option_says_wrong_is_told_as_from_it(self):
        robot = f"{SOURCE}/robots/desk_head/desk_head.toml"
        for options, words in ((["--board", "moon"], "from --board moon: robot.board: \"moon\": "),
                               (["--board-of", "imu=moon"], "from --board-of imu=moon: robot.device_boards.imu: "),
                               (["--set", "ball.radius_m=-1"], "from --set ball.radius_m=-1: module.ball.params.radius_m: -1: "),
                               (["--set", "bus.can0.bit_rate=5"], "from --set bus.can0.bit_rate=5: bus.can0.bit_rate: 5: "),
                               (["--camera", "1280x960"], "from --camera 1280x960: sim.camera: 1280x960 yuyv, ")):
            code, _, err = run("run", robot, "--virtual", *options)
            self.assertEqual(code, 2, err)
            self.assertIn(words, err)
            self.assertNotIn(":0:", err)

    def test_check_says_the_same_in_json(self):
        code, out, _ = run("check", f"{SOURCE}/examples/broken_robot.toml", "--json")
        self.assertEqual(code, 1)
        checked = json.loads(out)
        self.assertFalse(checked["ok"])
        self.assertIn({"line": 6, "key": "thread.control.priority", "value": "150",
                       "allowed": "an integer from 0 to 98"}, checked["problems"])
        code, out, _ = run("check", QUAD, "--json")
        self.assertEqual(code, 0)
        checked = json.loads(out)
        self.assertTrue(checked["ok"])
        self.assertEqual(checked["problems"], [])
        self.assertLess(sum(t["bytes"] for t in checked["topics"]), checked["segment_bytes"])
        for t in checked["topics"]:
            self.assertEqual(t["slots"], t["loans"] + t["keep"] + t["pins"] + t["pending"], t)

    def test_a_file_that_cannot_be_read_ends_with_2(self):
        for command in ("check", "graph"):
            code, out, err = run(command, "no_such.toml")
            self.assertEqual((code, out), (2, ""))
            self.assertIn("a robot file that can be read", err)

    def test_doctor_looks_at_this_machine_and_says_how_bad_it_is(self):
        code, out, err = run("doctor", QUAD)
        self.assertIn(code, (0, 1), err)
        self.assertEqual(code == 1, bool(re.search(r"^problem ", out, re.M)), out)
        self.assertRegex(out, r"(?m)^13 checks: ")
        checks = json.loads(run("doctor", "--json")[1])["checks"]
        self.assertEqual(len(checks), 13)
        strict = run("doctor", "--strict")[0]
        self.assertEqual(strict, int(any(c["state"] in ("problem", "warning") for c in checks)))

    def test_graph_shows_threads_and_bindings(self):
        code, out, _ = run("graph", QUAD)
        self.assertEqual(code, 0)
        self.assertIn("thread stabilise: priority 80, every 1 ms", out)
        self.assertRegex(out, r"<- imu +imu.raw \(queue of 32\)")
        code, out, _ = run("graph", QUAD, "--dot")
        self.assertTrue(out.startswith("digraph \"quad\""))
        self.assertIn("\"filter\" -> \"attitude\" [label=\"filter.state\"]", out)

    def test_graph_says_the_same_in_json(self):
        code, out, _ = run("graph", QUAD, "--json")
        self.assertEqual(code, 0)
        graph = json.loads(out)
        stabilise = next(t for t in graph["threads"] if t["name"] == "stabilise")
        self.assertEqual((stabilise["priority"], stabilise["period_us"]), (80, 1000))
        self.assertEqual(stabilise["modules"], ["imu", "filter", "attitude", "mixer"])
        state = next(t for t in graph["topics"] if t["name"] == "filter.state")
        self.assertEqual((state["writer"], state["message"]), ("filter", "NavState"))
        self.assertIn("attitude", state["readers"])
        mixer = next(m for m in graph["modules"] if m["name"] == "mixer")
        thrust = next(p for p in mixer["params"] if p["name"] == "thrust_max_n")
        self.assertEqual(thrust["value"], 6.0)

    def test_what_is_wrong_on_the_command_line_ends_with_2_and_its_reason(self):
        for arguments, words in (
                (["run", "no_such.toml"], "a robot file that can be read"),
                (["run", QUAD, "--set", "mixer.nothing=1"], "module.mixer.params.nothing"),
                (["run", QUAD, "--set", "nobody.x=1"], "no module nobody"),
                (["run", QUAD, "--virtual", "--plant", "unix:/no/such/socket"], "no plant at unix:/no/such/socket"),
                (["run", QUAD, "--board", "moon"], "robot.board: \"moon\""),
                (["run", QUAD, "--board", "linus"], "; did you mean linux?"),
                (["doctor", QUAD, "--board", "linus"], "; did you mean linux?"),
                (["module", "info", "Mixxer"], "; did you mean control::Mixer?"),
                (["run", QUAD, "--virtual", "--board", "none"], "this board has no devices"),
                (["run", QUAD, "--camera", "9x9"], "--camera 9x9"),
                (["run", QUAD, "--camera", "320x240x"], "--camera 320x240x"),
                (["run", QUAD, "--camera=-320x240"], "--camera -320x240"),
                (["run", QUAD, "--virtual", "--fault", "imu:bent@1"], "kind 'bent': one of off, stuck"),
                (["run", QUAD, "--virtual", "--plant", "unix:/x", "--fault", "imu:off@1"], "only a plant that this run starts"),
                (["run", BALL], "module.ball.type: \"my::Ball\": a known module type"),
                (["run", f"{SOURCE}/robots/mav_dataset/mav_dataset.toml", "--virtual", "--data", "/no/such/folder"], "/no/such/folder"),
                (["run", f"{SOURCE}/robots/mav_dataset/mav_dataset.toml", "--virtual"], "--data DIR"),
                (["calibrate", "joint", f"{SOURCE}/robots/desk_head/desk_head.toml", "--device", "head", "--joint", "pan"], "--at"),
                (["doctor", "no_such.toml"], "a robot file that can be read"),
                (["doctor", "--root", "/no/such/folder"], "/no/such/folder"),
                (["new", "Big"], "Big: a name of a-z, 0-9 and _"),
                (["new", "test"], "CMake or the project itself has a target of this name"),
                (["completion", "fish"], "bash"),
                (["fly"], "fly: no such command"),
                (["chekc", QUAD], "chekc: no such command; sinew --help lists them; did you mean check?"),
                (["bag", "inof", "x.mcap"], "inof: no such command; sinew bag --help lists them; did you mean info?"),
                (["run", QUAD, "--viritual"], "--viritual: no such option; sinew run --help lists them; did you mean --virtual?"),
                (["run", QUAD, "--seeed=3"], "--seeed: no such option; sinew run --help lists them; did you mean --seed?"),
                (["check", QUAD, "x.toml"], "x.toml: one argument too many; sinew check --help lists what it takes"),
                (["run", QUAD, "--set", "mixr.thrust_max_n=1"], "; did you mean mixer?"),
                (["run", QUAD, "--set", "mixer.thrust_max=1"], "; did you mean thrust_max_n?"),
                (["run", QUAD, "--set", "sim.gust=3"], "; did you mean gust_mps?"),
                (["run", QUAD, "--virtual", "--set", "sim.gust_mps=99"], "--set sim.gust_mps=99: a number from 0 to 15 m/s"),
                (["run", QUAD, "--virtual", "--plant-arg=--gust=99"],
                 "sinew-sim: exit code 2: --gust: 99: a number from 0 to 15 m/s\n"),
                (["run", QUAD, "--virtual", "--plant-arg=--gustt=9"], "; did you mean --gust?\n"),
                ([], "A subcommand is required")):
            code, out, err = run(*arguments)
            self.assertEqual(code, 2, (arguments, out, err))
            self.assertIn(words, err)
            self.assertEqual(out, "")

    def test_a_file_that_could_not_come_to_be_is_refused_or_left_out(self):
        with tempfile.TemporaryDirectory() as folder:
            plot, trace = f"{folder}/tilt.svg", f"{folder}/trace.json"
            code, _, err = run("run", QUAD, "--virtual", "--plot", plot)
            self.assertEqual(code, 2)
            self.assertIn(f'--plot {plot}: only for a run on a recorded folder (board "dataset"); this run has a plant', err)
            self.assertEqual(run("run", QUAD, "--virtual", "--trace", trace, "--plant", "unix:/no/such/socket")[0], 2)
            self.assertEqual(os.listdir(folder), [])
            with open(trace, "w") as f:
                f.write("mine")
            self.assertEqual(run("run", QUAD, "--virtual", "--trace", trace, "--plant", "unix:/no/such/socket")[0], 2)
            with open(trace) as f:
                self.assertEqual(f.read(), "mine", "an older file stays as it was")
            code, _, err = run("run", QUAD, "--virtual", "--trace", f"{folder}/none/trace.json")
            self.assertEqual((code, "No such file or directory" in err), (2, True), err)

    def commands(self, *words):
        """All commands that do something, as lists of words."""
        code, out, err = run(*words, "--help")
        self.assertEqual(code, 0, err)
        names = re.findall(r"^  (\S+)", out.partition("Subcommands:")[2], re.MULTILINE)
        return [c for name in names for c in self.commands(*words, name)] or [(list(words), out)]

    def test_a_whole_number_is_not_below_0_for_any_option_of_any_command(self):
        found = 0
        for words, text in self.commands():
            for option in re.findall(r"^  (?:-\w,)?(--\S+) (?:N|UINT)\b", text, re.MULTILINE):
                found += 1
                for wrong in ("-1", "1.5", "18446744073709551616"):
                    code, _, err = run(*words, f"{option}={wrong}")
                    self.assertEqual(code, 2, (words, option))
                    self.assertRegex(err, f"{option}: {re.escape(wrong)} is not an integer from ")
        self.assertGreaterEqual(found, 4, "run --seed, echo and pub --count, tune --jobs")

    def test_help_and_version_end_with_0(self):
        for arguments in (["--help"], ["run", "--help"], ["--version"]):
            self.assertEqual(run(*arguments)[0], 0, arguments)

    def test_the_help_of_the_script_that_builds_and_flies_is_complete_before_any_build(self):
        done = subprocess.run([f"{SOURCE}/run", "--help"], capture_output=True, text=True, timeout=60, check=True)
        self.assertTrue(done.stdout.endswith("\n\n" + run("run", "--help")[1]),
                        "an option changed: sinew run --help > tools/run_help.txt")

    def test_new_never_touches_what_exists(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(f"{folder}/full")
            with open(f"{folder}/full/main.cpp", "w") as f:
                f.write("mine")
            code, _, err = run("new", "full", cwd=folder)
            self.assertEqual(code, 1)
            self.assertIn("full: exists; nothing is overwritten", err)
            self.assertEqual(os.listdir(f"{folder}/full"), ["main.cpp"])
            os.symlink("nowhere", f"{folder}/dangling")
            self.assertEqual(run("new", "a", "dangling", cwd=folder)[0], 1)


class Completion(unittest.TestCase):
    def complete(self, *words, cwd=None):
        """The words that TAB offers behind the last word, from the function that bash would call."""
        script = 'source <("$0" completion bash); COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _sinew "$0"; ' \
                 'printf "%s\\n" "${COMPREPLY[@]}"'
        done = subprocess.run(["bash", "--norc", "-c", script, SINEW, "sinew", *words], capture_output=True, text=True,
                              cwd=cwd, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split("\n")[:-1]

    def test_commands_and_options(self):
        self.assertEqual(self.complete("ch"), ["check"])
        self.assertIn("run", self.complete(""))
        self.assertNotIn("complete", self.complete("comp"), "it is the shell's own")
        self.assertEqual(self.complete("run", "--plant"), ["--plant", "--plant-arg"])
        self.assertEqual(self.complete("graph", "x.toml", "--d"), ["--dot"])

    def test_values_of_options(self):
        self.assertEqual(self.complete("run", "--board", ""), ["sim", "linux", "dataset", "none"])
        self.assertEqual(self.complete("run", "--board", "d"), ["dataset"])
        self.assertEqual(self.complete("tune", "--against", ""), ["truth", "recorded"])
        self.assertEqual(self.complete("run", "--seed", ""), [""], "nothing is offered for a number")
        seesaw = f"{SOURCE}/robots/seesaw/seesaw.toml"
        self.assertEqual(self.complete("run", seesaw, "--set", "sim."), ["sim.push_radps2=", "sim.seed="])
        self.assertIn("sim.gust_mps=", self.complete("run", "--set", ""), "of all worlds")

    def test_robot_files_and_folders(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(f"{folder}/robots")
            for name in ("a b.toml", "b.toml", "notes.txt"):
                open(f"{folder}/{name}", "w").close()
            self.assertEqual(sorted(self.complete("check", "", cwd=folder)), ["a b.toml", "b.toml", "robots/"])
            self.assertEqual(self.complete("run", "--virtual", "b", cwd=folder), ["b.toml"])
            self.assertEqual(self.complete("run", "b.toml", "--data", "", cwd=folder), ["robots"])
            self.assertEqual(self.complete("replay", "n", cwd=folder), ["notes.txt"])
            self.assertEqual(self.complete("replay", "notes.txt", "n", cwd=folder), ["notes.txt"], "it takes several")
            self.assertEqual(self.complete("bag", "check", "notes.txt", "n", cwd=folder), [""], "it takes one")
            self.assertEqual(self.complete("tune", "notes.txt", "--jobs", "2", "n", cwd=folder), ["notes.txt"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
