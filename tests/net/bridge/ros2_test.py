#!/usr/bin/env python3
"""A robot in a ROS 2 graph, with Fast DDS as the other side: an independent implementation of DDS and of CDR, its code generated
from our IDL. Definitions and samples also go through the npm readers of ROS definitions.

    ros2_test.py BUILD SOURCE [unittest arguments]

BUILD has bin/sinew, bin/sinew-sim, bin/sinew-net and tests/net/bridge. Stage ros2 of ./test installs what it needs (Debian: libfastrtps-dev,
fastddsgen, openjdk); where that is missing it says so and exits with 77.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
BUILD, SOURCE = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
TOOLS = BUILD / "tests/net/bridge"
ECHO = TOOLS / "ros2_echo"
SINEW = BUILD / "bin/sinew"
DOMAINS = iter(range(120 + os.getpid() % 50 * 2, 232))


def reason_to_skip():
    if not shutil.which("fastddsgen") or not pathlib.Path("/usr/include/fastrtps").is_dir():
        return "Fast DDS is not installed (tools/setup.sh ros2)"
    if not ECHO.exists():
        return "the bridge was not built: Cyclone DDS is missing"
    return None


def out_of(*command):
    return subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True).stdout


def build_peer(folder, distro):
    """Code generated of all types of the distribution, and the programs of peer/ with it."""
    folder.mkdir(parents=True)
    for source in (HERE / "peer").iterdir():
        shutil.copy(source, folder)
    (folder / "types.idl").write_text(out_of(ECHO, "types", distro))
    names = [line.split()[1] for line in out_of(ECHO, "list", distro).splitlines()]
    (folder / "echo_list.inc").write_text("".join(f"ECHO({name})\n" for name in names))
    subprocess.run(["fastddsgen", "-typeros2", "-cs", "-replace", "-d", ".", "types.idl"], cwd=folder, check=True,
                   capture_output=True, timeout=120)
    compiler = ["ccache", "g++"] if shutil.which("ccache") else ["g++"]
    programs = ["echo_peer", "graph_peer", "seesaw_peer"] if distro == "humble" else ["echo_peer"]
    units = ["types.cxx", "typesPubSubTypes.cxx"] + [f"{p}.cpp" for p in programs]
    for unit in units:
        subprocess.run([*compiler, "-std=c++17", "-O0", "-w", "-I.", "-c", unit, "-o", f"{unit}.o"], cwd=folder, check=True,
                       timeout=300)
    for program in programs:
        subprocess.run(["g++", "-o", program, f"{program}.cpp.o", "types.cxx.o", "typesPubSubTypes.cxx.o", "-lfastrtps",
                        "-lfastcdr"], cwd=folder, check=True, timeout=300)


class Ros2(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="sinew-ros2-"))
        cls.env = {**os.environ, "SINEW_RUN_DIR": str(cls.folder / "run"), "SINEW_RECORD": "off"}
        (cls.folder / "run").mkdir(mode=0o700)
        for distro in ("humble", "jazzy"):
            build_peer(cls.folder / distro, distro)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def start(self, *command, **options):
        process = subprocess.Popen([str(c) for c in command], env=self.env, text=True, **options)
        self.addCleanup(lambda: (process.terminate(), process.wait(20), [p.close() for p in (process.stdin, process.stdout, process.stderr) if p]))
        return process

    def on_loopback(self, robot, domain):
        """This robot of robots/, in a DDS domain of its own on this machine."""
        file = self.folder / f"{domain}.toml"
        file.write_text(f'extends = "{SOURCE / "robots" / robot}"\n[net]\ndomain = {domain}\ninterfaces = ["127.0.0.1"]\n'
                        'multicast = false\npeers = ["127.0.0.1"]\n')
        return file

    def test_every_type_goes_through_fast_dds_and_back_with_the_same_bytes(self):
        for distro in ("humble", "jazzy"):
            domain = str(next(DOMAINS))
            with self.subTest(distro):
                peer = self.start(self.folder / distro / "echo_peer", domain, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
                self.assertEqual(peer.stdout.readline(), "ready\n")
                done = subprocess.run([str(ECHO), "samples", distro, domain], capture_output=True, text=True, timeout=300)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertIn("types reliable, 0 failed", done.stdout)
                self.assertIn("types best effort, 0 failed", done.stdout)

    def test_definitions_are_those_of_ros_by_readers_of_others(self):
        if not (HERE / "others/node_modules/@foxglove/rosmsg").is_dir():
            self.skipTest("the packages of tests/net/bridge/others are not installed")
        for distro in ("humble", "jazzy"):
            with self.subTest(distro):
                msgs, idl = self.folder / f"{distro}.json", self.folder / f"{distro}.idl"
                msgs.write_text(out_of(ECHO, "msg", distro))
                idl.write_text(out_of(ECHO, "types", distro))
                done = subprocess.run(["node", str(HERE / "others/definitions.mjs"), distro, str(msgs), str(idl)],
                                      capture_output=True, text=True, timeout=120)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def heard(self, peer):
        """What graph_peer heard, by topic."""
        peer.stdin.write("show\n")
        peer.stdin.flush()
        topics = {}
        while (line := json.loads(peer.stdout.readline())) != {}:
            topics[line["topic"]] = line
        return topics

    def until(self, peer, what, wanted, seconds=40):
        end = time.monotonic() + seconds
        while True:
            topics = self.heard(peer)
            if wanted(topics):
                return topics
            self.assertLess(time.monotonic(), end, f"{what}: {json.dumps(topics, indent=1)}")
            time.sleep(0.5)

    def test_a_simulated_robot_is_usable_from_a_ros_2_graph(self):
        domain = str(next(DOMAINS))
        robot = self.on_loopback("quad/quad_ros2.toml", domain)
        bridge = self.start(SINEW, "net", robot, stderr=subprocess.PIPE)  # before the robot, and longer
        self.assertIn("DDS domain", bridge.stderr.readline(), "else the robot starts its own, which ends with it")
        flight = self.start(SINEW, "run", robot, "--no-record", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        peer = self.start(self.folder / "humble/graph_peer", domain, "/quad/quad_ros2", stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE)
        self.assertEqual(json.loads(peer.stdout.readline()), {"ready": True})

        def said(line):
            peer.stdin.write(line + "\n")
            peer.stdin.flush()

        flying = ["rt/quad/imu/data_raw", "rt/quad/odom", "rt/tf", "rt/quad/range", "rt/quad/pressure", "rt/quad/battery",
                  "rt/quad/camera/image_raw", "rt/quad/camera/image_raw/compressed", "rt/quad/pad", "rt/quad/mission", "rt/clock",
                  "rt/diagnostics", "rt/rosout", "ros_discovery_info"]
        topics = self.until(peer, "all topics", lambda t: all(t.get(name, {}).get("count", 0) > 0 for name in flying))
        topics = self.until(peer, "a flight", lambda t: t["rt/quad/odom"].get("z", 0) > 0.3)
        imu, odom = topics["rt/quad/imu/data_raw"], topics["rt/quad/odom"]
        self.assertEqual((imu["frame"], imu["c0"]), ("base_link", -1))
        self.assertEqual((odom["frame"], odom["child"]), ("odom", "base_link"))
        self.assertGreater(odom["w"], 0.7)
        self.assertEqual((topics["rt/tf"]["frame"], topics["rt/tf"]["child"]), ("odom", "base_link"))
        image = topics["rt/quad/camera/image_raw"]
        self.assertEqual((image["width"], image["height"], image["step"], image["encoding"], image["bytes"]),
                         (320, 240, 640, "yuv422_yuy2", 320 * 240 * 2))
        self.assertEqual((topics["rt/quad/camera/image_raw/compressed"]["format"],
                          topics["rt/quad/camera/image_raw/compressed"]["first"]), ("jpeg", 255))
        self.assertLess(topics["rt/quad/battery"]["current"], 0, "it leaves the battery")
        self.assertEqual(topics["rt/quad/range"]["max"], 12)
        self.assertAlmostEqual(topics["rt/quad/pressure"]["pascal"], 101300, delta=500)
        self.assertGreater(topics["rt/diagnostics"]["statuses"], 20)
        who = topics["ros_discovery_info"]
        self.assertEqual((who["node"], who["space"], who["gid"]), ("quad_ros2", "/quad", 24))
        self.assertEqual((who["readers"], who["writers"]), (7, 20))
        self.assertEqual(topics["rt/clock"]["sec"], imu["sec"], "one time for stamps and clock")

        said("static")  # a reader that comes late
        said("drive 1.5")
        said("set attitude.kp_rate 21")
        topics = self.until(peer, "the parameter", lambda t: "value" in t.get("rt/parameter_events", {}))
        event = topics["rt/parameter_events"]
        self.assertEqual((event["node"], event["name"], event["value"]), ("/quad/quad_ros2", "attitude.kp_rate", 21))
        self.assertEqual(float(out_of(ECHO, "parameter", "/quad/quad_ros2", "attitude.kp_rate", domain)), 21)  # by service
        said("set attitude.kp_rate -1")  # outside of its range
        self.until(peer, "the refusal", lambda t: "attitude.kp_rate" in t["rt/rosout"].get("msg", ""))
        topics = self.until(peer, "the static frame", lambda t: "rt/tf_static" in t)
        self.assertEqual(topics["rt/tf_static"]["child"], "camera_optical")
        self.assertAlmostEqual(topics["rt/tf_static"]["y"], -0.5**0.5, places=12)

        velocity = json.loads(subprocess.run([str(SINEW), "topic", "echo", "operator.velocity", "-n", "1", "--json"], env=self.env,
                                             check=True, capture_output=True, text=True, timeout=30).stdout)
        velocity = velocity.get("message", velocity)
        self.assertEqual(velocity["linear_mps"]["x"], 1.5)
        self.assertEqual(velocity["angular_radps"]["z"], -0.75)
        flight.terminate()
        self.until(peer, "that the robot is gone", lambda t: t["rt/rosout"].get("msg") == "the robot is gone")

    def test_a_foreign_simulator_is_the_plant(self):
        domain = str(next(DOMAINS))
        robot = self.on_loopback("seesaw/seesaw_ros2.toml", domain)
        self.start(SINEW, "run", robot, "--no-record", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # and sinew-net
        beam = subprocess.run([str(self.folder / "humble/seesaw_peer"), domain, "15"], capture_output=True, text=True, timeout=60)
        said = json.loads(beam.stdout)
        self.assertGreater(said["commands"], 500, said)
        self.assertLess(said["worst_rad"], 0.1, f"the beam lay at 0.3 rad: {said}")
        status = json.loads(subprocess.run([str(SINEW), "net", "status", "seesaw_ros2", "--json"], env=self.env, check=True,
                                           capture_output=True, text=True, timeout=30).stdout)
        imu = next(t for t in status["ros2"]["topics"] if t["topic"] == "imu.raw")
        self.assertGreater(imu["messages"], 5000, f"of 15000 at 1 kHz, the first before the robot ran: {imu}")


if __name__ == "__main__":
    if reason := reason_to_skip():
        print("skipped:", reason)
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
