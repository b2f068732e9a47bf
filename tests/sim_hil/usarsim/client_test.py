"""A client of USARSim, written from its documents and apart from Sinew's codecs, against `sinew-sim --serve usarsim`: real
sockets, real time, real pictures. And the robot files of robots/air_robot that speak it, flown and driven.

argv: SINEW SINEW_SIM SOURCE
"""
import contextlib
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, SINEW_SIM, SOURCE = sys.argv[1:4]
RUN_DIR = tempfile.TemporaryDirectory()  # this program's robots meet nobody else's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


class Server:
    """The program; its report is there once it has ended."""

    def __init__(self, *options):
        self.process = subprocess.Popen(
            [SINEW_SIM, "--serve", "usarsim", "--listen", "tcp:127.0.0.1:0", "--image-listen", "tcp:127.0.0.1:0", "--report",
             "-", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        found = re.search(r"listening on tcp:[\d.]+:(\d+), pictures on tcp:[\d.]+:(\d+)", line)
        assert found, line + self.process.stderr.read()
        self.port, self.image_port = int(found[1]), int(found[2])

    def close(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=30)
        assert self.process.returncode == 0, out + err
        self.said = out
        self.report = json.loads(out.splitlines()[-1])
        return self.report


class Client:
    def __init__(self, server, init=None):
        self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=5)
        self.rest, self.lines = b"", []
        if init:
            self.say(f"INIT {init}")

    def say(self, line):
        self.socket.sendall(line.encode() + b"\r\n")

    def hear(self, seconds):
        """Lines of so long."""
        end, new = time.monotonic() + seconds, []
        while (left := end - time.monotonic()) > 0:
            self.socket.settimeout(left)
            with contextlib.suppress(TimeoutError):
                self.rest += self.socket.recv(65536)
            *lines, self.rest = self.rest.split(b"\r\n")
            new += [line.decode("ascii") for line in lines]
        self.lines += new
        return new

    def until(self, begin, seconds=5):
        """The first new line that begins so."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for line in self.hear(0.05):
                if line.startswith(begin):
                    return line
        raise AssertionError(f"never: {begin}")

    def close(self):
        self.socket.close()


def keys(line):
    return dict(re.findall(r"\{(\w+) ([^{}]*)\}", line))


def vector(text):
    return [float(v) for v in text.split(",")]


def truth(lines):
    """Location and orientation of the last GroundTruth."""
    last = keys([line for line in lines if "{Type GroundTruth}" in line][-1])
    return vector(last["Location"]), vector(last["Orientation"])


class Images:
    def __init__(self, server):
        self.socket = socket.create_connection(("127.0.0.1", server.image_port), timeout=10)

    def take(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            assert more, "closed"
            data += more
        return data

    def ask(self, request=b"OK\r\n"):
        """Type and data."""
        self.socket.sendall(request)
        kind, size = struct.unpack(">BI", self.take(5))
        return kind, self.take(size)

    def close(self):
        self.socket.close()


def rows_of(data):
    """Width, and rows of RGB without their padding, of a raw frame."""
    width, height = struct.unpack(">HH", data[:4])
    pitch = (width * 3 + 3) // 4 * 4
    assert len(data) == 4 + pitch * height, (width, height, len(data))
    return width, [data[4 + y * pitch:4 + y * pitch + width * 3] for y in range(height)]


class UsarsimTest(unittest.TestCase):
    def serve(self, *options):
        server = Server(*options)
        self.addCleanup(lambda: server.process.poll() is None and server.close())
        return server

    def client(self, server, init=None):
        client = Client(server, init)
        self.addCleanup(client.close)
        return client

    def test_sensors_of_an_air_robot_come_as_in_the_captured_session(self):
        server = self.serve("--place", "3")
        client = self.client(server, "{ClassName USARBot.AirRobot} {Name R1} {Location 0,0,2.05} {Rotation 0,0,0}")
        self.assertEqual(client.until("NFO"), "NFO {Gametype BotDeathMatch} {Level Town} {TimeLimit 0}")
        lines = client.hear(2.2)
        forms = {
            "GroundTruth": r"SEN \{Time \d+\.\d{4}\} \{Type GroundTruth\} \{Name GroundTruth\} "
                           r"\{Location 0\.00,0\.00,2\.05\} \{Orientation 0\.00,0\.00,0\.00\}",
            "GPS": r"SEN \{Type GPS\} \{Name GPS\} \{Latitude 39,\d+\.\d{4},N\} \{Longitude 77,\d+\.\d{4},W\} \{Fix 1\} "
                   r"\{Satellites \d+\}",
            "AerialVehicle": r"STA \{Type AerialVehicle\} \{Time \d+\.\d{2}\} \{LightToggle False\} \{LightIntensity 0\} "
                             r"\{Battery 11\d\d\} \{View -1\}"}
        for kind, form in forms.items():
            found = [line for line in lines if f"{{Type {kind}}}" in line]
            self.assertGreaterEqual(len(found), 9, kind)
            for line in found:
                self.assertRegex(line, f"^{form}$")
        times = [float(keys(line)["Time"]) for line in lines if "{Type GroundTruth}" in line]
        for a, b in zip(times, times[1:]):
            self.assertAlmostEqual(b - a, 0.2, delta=0.011)

    def test_several_robots_drive_at_once_and_see_each_other(self):
        server = self.serve("--place", "2", "--target-speed", "0")
        air = self.client(server, "{ClassName USARBot.AirRobot} {Name A} {Location -4,0,0.2}")
        rover = self.client(server, "{Classname USARBot.P3AT}{Name B} {Location -2,-3,0.2} {Rotation 0,0,1.5708}")
        two = self.client(server, "{ClassName P2AT} {Name C} {Start Pose4}")
        for client in (air, rover, two):
            client.hear(0.3)
        air.say("DRIVE {AltitudeVelocity 0.50} {LinearVelocity 0.00} {LateralVelocity 0.50} {RotationalVelocity 0.00}")
        rover.say("DRIVE {Left 2.0} {Right 2.0}")
        two.say("DRIVE {Left -1,0} {Right -1,0}")
        time.sleep(1.5)
        where = [truth(client.hear(0.4))[0] for client in (air, rover, two)]
        self.assertGreater(where[0][1], 0.4, "to the right is +y")
        self.assertGreater(where[0][2], 0.6, "up")
        self.assertGreater(where[1][1], -2.8, "it looks along +y")
        self.assertLess(where[2][0], -5.1, "backwards")
        report = server.close()
        self.assertEqual(report["robots"], 3)
        self.assertEqual((report["torn"], report["unusable"], report["unknown"]), (0, 0, 0))

    def test_vehicles_with_steered_wheels_and_joints_by_name(self):
        server = self.serve("--place", "2", "--target-speed", "0", "--image-type", "raw", "--camera-noise", "0")
        watcher = self.client(server, "{ClassName USARBot.P3AT} {Name W} {Location -6,0,0.2}")
        watcher.hear(0.3)
        images = Images(server)
        self.addCleanup(images.close)
        watcher.say("SET {Type Camera} {Robot W} {Name Camera} {Client 127.0.0.1}")
        watcher.hear(0.2)
        alone = images.ask()[1]
        front = self.client(server, "{ClassName USARBot.FrontAckerman} {Name F} {Location -4,0,0.2}")
        rear = self.client(server, "{ClassName USARBot.BasicAckermanRobot} {Name R} {Location -4,4,0.2}")
        for client in (front, rear):
            client.hear(0.3)
        self.assertNotEqual(images.ask()[1], alone, "it is seen")
        self.assertEqual(keys(front.until("STA"))["FrontSteer"], "0.0000")
        front.say("DRIVE {Speed 4.00} {FrontSteer 0.40} {RearSteer 0.00} {Normalized false} {Light false}")
        rear.say("DRIVE {Speed 4,0} {FrontSteer 0} {RearSteer 0,4}")
        watcher.say("MULTIDRIVE {CameraPan 0.50} {CameraTilt 0.20} {FRFlipper 1.0}")
        self.assertIn("no joint 'FRFlipper'; P3AT has FLWheelRoll, ", watcher.until("NFO {Error MULTIDRIVE}"))
        time.sleep(1.7)
        (to_right, turned), (to_left, back) = [truth(client.hear(0.3)) for client in (front, rear)]
        self.assertGreater(to_right[1], 0.02, "clockwise")
        self.assertTrue(0.1 < turned[2] < 1.5, turned)
        self.assertTrue(4.5 < back[2] < 6.2, back)
        self.assertEqual(keys(front.until("STA"))["FrontSteer"], "0.4000")
        said = [line for line in watcher.hear(0.5) if line.startswith("MISSTA")]
        values = re.findall(r"\{Value ([-0-9.]+)\}", said[-1])
        self.assertEqual([float(v) for v in values], [0.5, 0.2])
        front.say("GETCONF {Type Robot}")
        conf = front.until("CONF")
        self.assertIn("{SteeringType AckermanSteered}", conf)
        self.assertIn("{MaxFrontSteer 0.5000} {MaxRearSteer 0.0000}", conf)
        report = server.close()
        self.assertEqual((report["torn"], report["unusable"], report["unknown"]), (0, 1, 0))

    def test_pictures_whole_and_in_part_raw_and_jpeg(self):
        server = self.serve("--image-type", "raw", "--camera-noise", "0", "--target-speed", "0")
        client = self.client(server, "{ClassName USARBot.P3AT} {Name A} {Start Pose1}")
        client.hear(0.5)
        images = Images(server)
        self.addCleanup(images.close)
        kind, data = images.ask()
        self.assertEqual(kind, 0)
        width, rows = rows_of(data)
        self.assertEqual((width, len(rows)), (320, 240))
        self.assertGreater(len(set(rows)), 200, "it shows something")
        kind, data = images.ask(b"U" + struct.pack(">4I", 30, 100, 63, 50))
        part_width, part = rows_of(data)
        self.assertEqual((part_width, len(part)), (63, 50))
        self.assertEqual(part, [row[90:90 + 189] for row in rows[100:150]], "the same pixels")
        other = self.client(server, "{ClassName USARBot.AirRobot} {Name B} {Location -3,3,1.5}")
        other.hear(0.3)
        width, rows = rows_of(images.ask()[1])
        self.assertEqual((width, len(rows)), (640, 240), "the cameras of both, side by side")
        self.assertNotEqual([row[:960] for row in rows], [row[960:] for row in rows])
        client.say("SET {Type Camera} {Robot B} {Name Camera} {Client 127.0.0.1}")
        client.hear(0.2)
        self.assertEqual(rows_of(images.ask()[1])[1], [row[960:] for row in rows], "its own camera")
        self.assertEqual(server.close()["frames"], 4)

        server = self.serve("--image-type", "good")
        images = Images(server)
        self.addCleanup(images.close)
        kind, data = images.ask(b"noise OK")
        self.assertEqual(kind, 2)
        self.assertEqual((data[:2], data[-2:]), (b"\xff\xd8", b"\xff\xd9"))
        self.assertEqual(server.close()["skipped"], 6)

    def test_faults_of_the_link_end_nothing_else(self):
        server = self.serve()
        steady = self.client(server, "{ClassName USARBot.P3AT} {Name Steady} {Start Pose2}")
        torn = Client(server, "{ClassName USARBot.P3AT} {Name Torn} {Start Pose1}")
        torn.hear(0.3)
        torn.socket.sendall(b"DRIVE {Left 3} {Ri")  # half a line, then the connection is reset
        torn.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        torn.close()
        garbage = self.client(server)
        garbage.socket.sendall(bytes(range(256)) * 40 + b"\r\n" + b"}{}{ {{\r\n")
        deaf = self.client(server, "{ClassName USARBot.P2AT} {Name Deaf} {Start Pose3}")
        for _ in range(2000):
            deaf.say("GETCONF {Type RangeScanner}")  # and never reads
        time.sleep(0.5)
        again = self.client(server, "{ClassName USARBot.AirRobot} {Name Again} {Start Pose1}")
        place = truth(again.hear(0.6))[0]
        self.assertEqual(place[:2], [-5, 0], "the place of the robot that was cut off is free")
        self.assertGreaterEqual(len([line for line in steady.hear(1.0) if line.startswith("STA")]), 4)
        report = server.close()
        self.assertGreaterEqual(report["dropped"], 2)
        self.assertGreaterEqual(report["torn"], 1)
        self.assertEqual([r["name"] for r in report["robots_gone"]][0], "Torn")
        self.assertEqual(report["robots_gone"][0]["drives"], 0, "half a line is not obeyed")

    def test_an_unknown_class_is_told_what_there_is(self):
        server = self.serve()
        client = self.client(server, "{ClassName USARBot.Zerg} {Name Z}")
        self.assertIn("there are USARBot.AirRobot, USARBot.P3AT, USARBot.P2AT", client.until("NFO {Error INIT}"))

    def run_robot(self, server, robot, device):
        done = subprocess.run([SINEW, "run", f"{SOURCE}/robots/air_robot/{robot}.toml", "--no-record", "--json", "--duration",
                               "40", "--set", f"device.{device}.to=tcp:127.0.0.1:{server.port}"],
                              capture_output=True, text=True, timeout=80, check=False)
        self.assertIn(done.returncode, (0, 1), done.stdout + done.stderr)
        time.sleep(0.3)
        gone = server.close()["robots_gone"]
        self.assertEqual(len(gone), 1, done.stdout + done.stderr)
        self.assertEqual(gone[0]["touches"], 0)
        self.assertTrue(gone[0]["stands"])
        return gone[0]

    def test_the_air_robot_takes_off_flies_forward_and_lands(self):
        robot = self.run_robot(self.serve("--place", "3"), "airrobot", "drone")
        self.assertGreater(robot["highest_m"], 1.0)
        self.assertLess(robot["highest_m"], 1.5)
        self.assertAlmostEqual(robot["to_x_m"] - robot["from_x_m"], 1.5, delta=0.5)
        self.assertLess(robot["to_z_m"], 0.15)

    def test_the_p3at_drives_forward_and_stops(self):
        robot = self.run_robot(self.serve("--place", "2"), "p3at", "vehicle")
        self.assertAlmostEqual(robot["to_x_m"] - robot["from_x_m"], 1.2, delta=0.4)
        self.assertLess(abs(robot["to_y_m"] - robot["from_y_m"]), 0.05)

    def test_the_example_flies_its_square(self):
        server = self.serve("--place", "2")
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, f"{SOURCE}/examples/usarsim_client.py", "127.0.0.1", str(server.port),
                                   str(server.image_port)], cwd=folder, capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(len(os.listdir(folder)), 4)
        robot = server.close()["robots_gone"][0]
        self.assertTrue(robot["stands"])
        self.assertGreater(robot["driven_m"], 6)
        self.assertLess(abs(robot["to_x_m"] - robot["from_x_m"]) + abs(robot["to_y_m"] - robot["from_y_m"]), 1)

    def test_options_that_contradict_each_other_are_refused(self):
        for options, why in ((["--serve", "usarsim", "--robot", "a"], "--robot: not with --serve usarsim"),
                             (["--serve", "usarsim", "--world", "seesaw"], "no place that robots enter"),
                             (["--sonar", "apart"], "--sonar: only with --serve usarsim"),
                             (["--serve", "usarsim", "--image-type", "png"], "raw")):
            done = subprocess.run([SINEW_SIM, *options], capture_output=True, text=True, timeout=20, check=False)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            self.assertIn(why, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
