"""sinew bag play: what other programs see of a recorded flight that stands up as a robot.

usage: play_test.py SINEW RECORDING [unittest arguments]
"""
import json
import os
import pty
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, FLIGHT = sys.argv[1:3]
FOLDER = tempfile.TemporaryDirectory(prefix="sinew_play_")
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
OWN = "sinew/"  # topics of the recorder's own
CHANGES = ["param.set", "module.enable", "module.disable", "thread.period", "arm", "disarm", "publish", "publish.memory",
           "publish.bytes", "zones", "stop", "record.start", "record.stop", "record.status", "record.snapshot"]


def tearDownModule():
    FOLDER.cleanup()
    RUN_DIR.cleanup()


def path(name):
    return f"{FOLDER.name}/{name}"


def run(*arguments):
    done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout, done.stderr


def cat(*arguments):
    code, out, err = run("bag", "cat", FLIGHT, *arguments)
    if code != 0:
        raise AssertionError(err)
    return [json.loads(line) for line in out.splitlines()]


class Client:
    """One connection to a robot's socket."""

    def __init__(self, robot):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(60)
        self.socket.connect(f"{RUN_DIR.name}/{robot}.sock")

    def send(self, text):
        self.socket.sendall(struct.pack("<I", len(text)) + text)
        return json.loads(self.take(struct.unpack("<I", self.take(4))[0]))

    def take(self, n):
        data = b""
        while len(data) < n:
            piece = self.socket.recv(n - len(data))
            if not piece:
                raise ConnectionError("the robot ended")
            data += piece
        return data

    def ask(self, request, **arguments):
        return self.send(json.dumps({"request": request, **arguments}).encode())


class Film:
    """A file that stands up as a robot, until the end of the block."""

    def __init__(self, *options, file=FLIGHT, robot="film", **how):
        self.robot = robot
        self.process = subprocess.Popen([SINEW, "bag", "play", file, "--name", robot, "--stay", *options],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **how)

    def __enter__(self):
        while not os.path.exists(f"{RUN_DIR.name}/{self.robot}.sock"):
            if self.process.poll() is not None:
                raise AssertionError(self.process.communicate())
            time.sleep(0.01)
        while True:
            try:
                self.client = Client(self.robot)
                return self
            except ConnectionRefusedError:  # the socket of one before
                time.sleep(0.01)

    def __exit__(self, *failed):
        self.client.socket.close()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.out, self.err = self.process.communicate(timeout=60)

    def ask(self, request, **arguments):
        reply = self.client.ask(request, **arguments)
        if not reply["ok"]:
            raise AssertionError(f"{request}: {reply}")
        return reply

    def wait_for(self, holds):
        """The playback when it is so."""
        while not holds(now := self.ask("playback")):
            time.sleep(0.005)
        return now

    def newest(self, topic):
        code, out, err = run("topic", "echo", topic, "--robot", self.robot, "-n", "1", "--json")
        if code != 0:
            raise AssertionError(err)
        return json.loads(out)["message"]

    def counts(self):
        return {t["name"]: t["messages"] for t in self.ask("status")["topics"]}


class Play(unittest.TestCase):
    def test_it_says_that_it_is_a_recording_and_of_what(self):
        with Film("--paused") as film:
            hello = film.ask("hello")
            self.assertEqual((hello["robot"], hello["recorded_robot"], hello["board"]), ("film", "quad", "sim"))
            self.assertEqual((hello["recording"], hello["virtual_time"], hello["memory"]),
                             (os.path.abspath(FLIGHT), True, True))
            self.assertIn("battery_low", hello["failsafes"])
            self.assertEqual(hello["not_shown"], [])
            info = json.loads(run("bag", "info", FLIGHT, "--json")[1])
            recorded = {t["name"] for t in info["topics"]
                        if not t["name"].startswith(OWN) and not t["name"].endswith("/head")}
            topics = {t["name"]: t for t in film.ask("topics")["topics"]}
            self.assertEqual(set(topics), recorded)
            self.assertEqual((topics["imu.raw"]["writer"], topics["imu.raw"]["thread"]), ("imu", "stabilise"))
            playback = film.ask("playback")
            self.assertEqual((playback["state"], playback["time_ns"]), ("paused", playback["begin_ns"]))
            self.assertAlmostEqual((playback["end_ns"] - playback["begin_ns"]) * 1e-9, info["duration_s"], delta=0.01)
        self.assertEqual((film.process.returncode, film.err), (0, ""))

    def test_after_a_seek_every_topic_shows_what_the_robot_showed_then(self):
        at = cat("--topic", "camera.raw")[7]["log_time_ns"]
        newest = {}
        for m in cat():
            if m["log_time_ns"] <= at:
                newest[m["topic"]] = m
        with Film("--paused") as film:
            begin = film.ask("playback")["begin_ns"]
            self.assertEqual(film.ask("playback.seek", time_ns=at)["time_ns"], at)
            shown = film.counts()
            for topic in shown:
                if topic not in newest:
                    self.assertEqual(shown[topic], 0)
                elif topic != "camera.raw":
                    self.assertEqual(film.newest(topic), newest[topic]["message"], topic)
            image = film.newest("camera.raw")
            self.assertEqual(image["stamp"], newest["camera.raw/head"]["message"]["stamp"])
            self.assertEqual(image["frame_number"], newest["camera.raw/head"]["message"]["frame_number"])
            back = film.ask("playback.seek", time_ns=begin)
            self.assertEqual(back["time_ns"], begin)
            self.assertGreaterEqual(film.counts()["imu.raw"], shown["imu.raw"], "counters only rise")

    def test_steps_go_from_message_to_message(self):
        order = [m for m in cat() if not m["topic"].startswith(OWN) and not m["topic"].endswith("/head")]
        with Film("--paused") as film:
            for n, message in enumerate(order[:3], 1):
                reply = film.ask("playback.step")
                self.assertEqual((reply["messages"], reply["time_ns"], reply["state"]),
                                 (n, message["log_time_ns"], "paused"))
            self.assertEqual(film.ask("playback.step", messages=100)["messages"], 103)
            to_baro = film.ask("playback.step", topic="baro.raw")
            first = next(m for m in order[103:] if m["topic"] == "baro.raw")
            self.assertEqual(to_baro["time_ns"], first["log_time_ns"])
            self.assertEqual(film.newest("baro.raw"), first["message"])

    def test_it_plays_to_its_end_and_begins_again(self):
        with Film("--rate", "100") as film:
            self.assertEqual(film.wait_for(lambda p: p["state"] == "ended")["time_ns"], film.ask("playback")["end_ns"])
            info = json.loads(run("bag", "info", FLIGHT, "--json")[1])
            played = {t["name"]: t["messages"] for t in info["topics"]}
            counts = film.counts()
            self.assertEqual(counts, {name: played[name] for name in counts}, "each message once")
            self.assertEqual(film.ask("playback.step")["state"], "ended")
            self.assertEqual(film.ask("playback.pause")["state"], "ended")
            film.ask("playback.speed", speed=0.01)
            self.assertEqual(film.ask("playback.play")["state"], "playing")
            back = film.ask("playback.seek", time_ns=film.ask("playback")["begin_ns"])
            self.assertEqual((back["state"], back["speed"]), ("playing", 0.01))
            paused = film.ask("playback.pause")
            counts = film.counts()
            self.assertEqual(film.ask("playback")["time_ns"], paused["time_ns"])
            self.assertEqual(film.ask("status")["now_ns"], paused["time_ns"])
            self.assertEqual(film.counts(), counts)
        self.assertEqual(film.process.returncode, 0)

    def test_a_loop_never_ends(self):
        with Film("--rate", "100", "--loop", "--json") as film:
            self.assertTrue(film.ask("playback")["loop"])
            once = sum(film.counts().values())
            total = json.loads(run("bag", "info", FLIGHT, "--json")[1])["messages"]
            film.wait_for(lambda p: p["messages"] > once + 2 * total)
            self.assertEqual(film.ask("playback")["state"], "playing")
        told = json.loads(film.out)
        self.assertEqual((told["robot"], told["file"], told["not_played"]), ("film", FLIGHT, 0))

    def test_a_part_of_the_file_is_a_part_of_the_robots_time(self):
        with Film("--start-offset", "0.5", "--until", "1", "--paused", "--topic", "imu.raw", "--topic", "baro.raw") as film:
            playback = film.ask("playback")
            self.assertAlmostEqual((playback["end_ns"] - playback["begin_ns"]) * 1e-9, 0.5, delta=0.01)
            self.assertEqual({t["name"] for t in film.ask("topics")["topics"]}, {"imu.raw", "baro.raw"})
            refused = film.client.ask("playback.seek", time_ns=playback["begin_ns"] - 1)
            self.assertEqual(refused["error"], {
                "code": "bad_argument",
                "why": f'"time_ns": an integer from {playback["begin_ns"]} to {playback["end_ns"]}'})

    def test_the_commands_for_robots_work_on_it(self):
        with Film("--loop") as film:
            code, out, err = run("topic", "hz", "imu.raw", "--robot", "film", "--seconds", "0.5")
            self.assertEqual(code, 0, err)
            self.assertRegex(out, r"^imu.raw: (999.9|1000.0)\d Hz")  # where the film turns, an interval is 5 us longer or shorter
            code, out, err = run("status", "--robot", "film")
            self.assertEqual(code, 0, err)
            self.assertRegex(out, r"(?m)^guardian ")
            code, out, err = run("param", "get", "attitude.kp_tilt", "--robot", "film")
            self.assertEqual(code, 0, err)
            code, out, err = run("param", "set", "attitude.kp_tilt", "8", "--robot", "film")
            self.assertEqual(code, 1)
            self.assertIn("a recorded run: only its playback can be changed", err)

    def test_status_and_time_line_are_those_of_the_recorded_steps(self):
        with Film("--paused") as film:
            film.ask("playback.step", messages=1000)
            status = film.ask("status")
            threads = {t["name"]: t for t in status["threads"]}
            modules = {m["name"]: m for m in status["modules"]}
            self.assertEqual((threads["stabilise"]["priority"], threads["stabilise"]["period_ns"]), (80, 1_000_000))
            self.assertEqual((modules["imu"]["thread"], modules["imu"]["type"]), ("stabilise", "drivers::ImuSource"))
            self.assertGreater(modules["imu"]["steps"], 10)
            self.assertGreater(modules["filter"]["exec"]["p50_ns"], 0)
            timeline = film.ask("timeline", last_ms=20)
            self.assertEqual(timeline["columns"][0], "kind")
            self.assertTrue({"release", "cycle", "step"} <= {e[0] for e in timeline["events"]})
            self.assertTrue(all(status["now_ns"] - 20_000_000 <= e[3] <= status["now_ns"] for e in timeline["events"]))

    def test_what_would_change_a_robot_is_refused(self):
        with Film("--paused") as film:
            for request in CHANGES:
                self.assertEqual(film.client.ask(request)["error"], {
                    "code": "not_supported", "why": "a recorded run: only its playback can be changed"}, request)
            self.assertEqual(film.ask("playback")["messages"], 0)

    def test_its_clock_is_the_playback_and_no_clock_of_this_machine(self):
        with Film("--paused") as film:
            playback = film.ask("playback.seek", time_ns=film.ask("playback")["begin_ns"] + 500_000_000)
            self.assertEqual(film.ask("clock"), {"ok": True, "now_ns": playback["time_ns"], "monotonic": False})

    def test_bells_that_no_writer_rings_are_refused_as_by_the_robot(self):
        with Film("--paused") as film:
            self.assertEqual({t["wakes_outsiders"] for t in film.ask("topics")["topics"]}, {False})
            refused = film.client.ask("subscribe", topics=[], at_once=["imu.raw"])
            self.assertEqual(refused["error"], {
                "code": "not_supported", "why": "imu.raw: its robot file does not say wake_outsiders = true"})

    def test_hostile_requests_are_refused_with_what_is_allowed(self):
        with Film("--paused") as film:
            for request, arguments, why in (
                    ("playback.seek", {}, '"time_ns": an integer from'),
                    ("playback.seek", {"time_ns": 1.5}, '"time_ns": an integer from'),
                    ("playback.seek", {"time_ns": "0"}, '"time_ns": an integer from'),
                    ("playback.seek", {"time_ns": 2**63}, '"time_ns": an integer from'),
                    ("playback.seek", {"time_ns": -2**63}, '"time_ns": an integer from'),
                    ("playback.seek", {"time_ns": 10**400}, None),
                    ("playback.step", {"messages": 0}, '"messages": an integer from 1 to 1000000'),
                    ("playback.step", {"messages": 2**64 - 1}, '"messages": an integer from 1 to 1000000'),
                    ("playback.step", {"messages": [1]}, '"messages": an integer from 1 to 1000000'),
                    ("playback.step", {"messages": 1, "topic": "imu.raw"}, 'either "messages" or "topic"'),
                    ("playback.step", {"topic": 7}, '"topic": a topic\'s name'),
                    ("playback.step", {"topic": "imu.rw"}, "no topic imu.rw; did you mean imu.raw?"),
                    ("playback.speed", {}, '"speed": a number from 0.01 to 100'),
                    ("playback.speed", {"speed": 0}, '"speed": a number from 0.01 to 100'),
                    ("playback.speed", {"speed": -1}, '"speed": a number from 0.01 to 100'),
                    ("playback.speed", {"speed": 101}, '"speed": a number from 0.01 to 100'),
                    ("playback.speed", {"speed": "fast"}, '"speed": a number from 0.01 to 100'),
                    ("playback.spped", {}, 'no request "playback.spped" in this version; did you mean playback.speed?'),
                    ("subscribe", {"topics": ["nothing"]}, "no topic nothing"),
                    ("timeline", {"last_ms": 10**9}, '"last_ms": an integer from 1 to 60000'),
                    ("params", {"module": "attitud"}, "did you mean attitude?")):
                reply = film.client.ask(request, **arguments)
                self.assertFalse(reply["ok"], (request, arguments))
                if why:
                    self.assertIn(why, reply["error"]["why"])
            for text in (b"[" * 1000, b"{", b'{"request": 7}', b'\xff\xfe'):
                self.assertFalse(film.client.send(text)["ok"])
            self.assertEqual(film.ask("playback")["state"], "paused")
        self.assertEqual(film.process.returncode, 0)

    def test_many_requests_at_once_leave_the_last_one_in_force(self):
        with Film() as film:
            others = [Client("film") for _ in range(3)]
            end = film.ask("playback")["end_ns"]
            for n in range(20):
                for client in others:
                    text = json.dumps({"request": "playback.seek", "time_ns": end * (n % 3) // 3}).encode()
                    client.socket.sendall(struct.pack("<I", len(text)) + text)
            for client in others:
                for _ in range(20):
                    self.assertTrue(json.loads(client.take(struct.unpack("<I", client.take(4))[0]))["ok"])
                client.socket.close()
            film.ask("playback.pause")
            self.assertEqual(film.ask("playback.seek", time_ns=end)["time_ns"], end)

    def test_a_file_without_its_end_is_played_as_far_as_it_goes(self):
        with open(FLIGHT, "rb") as whole, open(path("cut.mcap"), "wb") as cut:
            cut.write(whole.read()[:os.path.getsize(FLIGHT) // 2])
        with Film("--paused", file=path("cut.mcap")) as film:
            reply = film.ask("playback.seek", time_ns=film.ask("playback")["end_ns"])
            self.assertGreater(reply["messages"], 0)
            self.assertIn("cut off", reply["problems"][0])
        self.assertEqual(film.process.returncode, 1)
        self.assertIn("cut.mcap: offset", film.err)

    def test_topics_of_other_types_are_named_and_left_out(self):
        code, _, err = run("bag", "convert", FLIGHT, path("ros2.mcap"), "--ros2")
        self.assertEqual(code, 0, err)
        with Film("--paused", file=path("ros2.mcap")) as film:
            left_out = {t["name"]: t["why"] for t in film.ask("hello")["not_shown"]}
            self.assertIn("sensor_msgs/msg/Imu: no message type of this program", left_out["imu.raw"])
            self.assertNotIn("imu.raw", {t["name"] for t in film.ask("topics")["topics"]})
            self.assertIn("topic imu.raw is not shown", film.client.ask("playback.step", topic="imu.raw")["error"]["why"])
        self.assertIn("imu.raw is not shown: sensor_msgs/msg/Imu", film.err)
        self.assertEqual(film.process.returncode, 0)

    def test_what_cannot_be_begun_ends_with_2(self):
        with open(path("text.mcap"), "w") as text:
            text.write("no recording")
        for options, why in ((["--name", "a b"], 'robot name "a b"'),
                             (["--rate", "101"], "--rate: 101 is not a number from 0.01 to 100"),
                             (["--start-offset", "1", "--from", "1"], "--start-offset"),
                             (["--from", "1000"], "--from 1000: the file has"),
                             (["--topic", "nothing"], "no topic nothing")):
            code, out, err = run("bag", "play", FLIGHT, *options)
            self.assertEqual((code, out), (2, ""), options)
            self.assertIn(why, err)
        code, _, err = run("bag", "play", path("text.mcap"))
        self.assertEqual(code, 2)
        self.assertIn("text.mcap", err)

    def test_a_name_that_was_asked_for_is_taken_or_refused(self):
        with Film("--paused", robot="quad"):
            code, _, err = run("bag", "play", FLIGHT, "--name", "quad")
            self.assertEqual(code, 2)
            self.assertIn('robot "quad" runs already', err)
            beside = subprocess.Popen([SINEW, "bag", "play", FLIGHT, "--paused"],
                                      stdout=subprocess.PIPE, text=True)
            self.assertRegex(beside.stdout.readline(), f"^quad-{beside.pid}: ")  # the recorded name is only a wish
            beside.send_signal(signal.SIGTERM)
            self.assertEqual((beside.communicate(timeout=60)[1], beside.returncode), (None, 0))

    def test_keys_pause_step_and_change_the_speed(self):
        ours, theirs = pty.openpty()

        def own_terminal():
            os.setsid()
            import fcntl
            import termios
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)

        with Film("--paused", stdin=theirs, preexec_fn=own_terminal) as film:
            os.write(ours, b"\033[C\033[C")
            film.wait_for(lambda p: p["messages"] == 2)
            os.write(ours, b"\033[A")
            film.wait_for(lambda p: abs(p["speed"] - 1.1) < 1e-9)
            os.write(ours, b"\033[B")
            film.wait_for(lambda p: abs(p["speed"] - 1) < 1e-9)
            os.write(ours, b"x ")
            film.wait_for(lambda p: p["state"] == "playing")
            os.write(ours, b" ")
            film.wait_for(lambda p: p["state"] == "paused")
            os.write(ours, b"\003")  # Ctrl-C
            self.assertEqual(film.process.wait(timeout=60), 0)
        os.close(ours)
        os.close(theirs)
        self.assertIn("space: pause or play", film.out)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
