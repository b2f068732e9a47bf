"""The Python package against a running robot, with numpy and without.

    python_test.py PROGRAM LIBRARY SOURCE
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, LIBRARY, SOURCE = sys.argv[1:4]
os.environ["SINEW_CLIENT_LIBRARY"] = LIBRARY
os.environ["SINEW_RECORD"] = "off"
sys.path.insert(0, f"{SOURCE}/python")
sys.dont_write_bytecode = True
if "--without-numpy" in sys.argv:
    sys.modules["numpy"] = None  # an import of it fails
import sinew  # noqa: E402

try:
    import numpy
except ImportError:
    numpy = None
LIMIT_S = 60  # for any step here, on a machine that is busy elsewhere


class Python(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="sinew-")
        os.environ["SINEW_RUN_DIR"] = cls.folder.name
        cls.start()

    @classmethod
    def start(cls):
        cls.run_ = subprocess.Popen([PROGRAM, "run", f"{SOURCE}/tests/client/client_robot.toml", "--plain"],
                                    stdout=subprocess.DEVNULL, env=os.environ)
        end = time.monotonic() + LIMIT_S
        while True:
            try:
                cls.robot = sinew.attach("ball")
                return
            except sinew.Error:
                if time.monotonic() > end or cls.run_.poll() is not None:
                    raise
                time.sleep(0.05)

    @classmethod
    def tearDownClass(cls):
        cls.run_.send_signal(signal.SIGTERM)
        cls.run_.wait(LIMIT_S)
        cls.folder.cleanup()

    def test_lists_what_runs(self):
        self.assertEqual(sinew.robots(), [sinew.RunningRobot("ball", self.run_.pid)])
        self.assertEqual((self.robot.name, self.robot.pid), ("ball", self.run_.pid))
        with self.assertRaisesRegex(sinew.NotFound, 'no robot "bal" runs'):
            sinew.attach("bal")

    def test_reads_fields_in_place(self):
        height = self.robot.topic("ball.height")
        self.assertEqual(height.fields["range_m"].unit, "m")
        for _ in range(10):
            message = height.wait(LIMIT_S)
            metres = message["range_m"]
            if not message.valid:
                continue  # this machine was busy elsewhere for half a second
            self.assertTrue(0 <= metres <= 1, metres)
            self.assertEqual(message["stamp"], message.stamp_ns)
            self.assertEqual(message.copy().to_dict(), message.to_dict())
        if numpy:
            self.assertEqual(message.array["range_m"][0], metres)
            with self.assertRaises(ValueError):
                message.array["range_m"][0] = 0  # the robot's memory
        with self.assertRaisesRegex(sinew.NotFound, "did you mean ball.height"):
            self.robot.topic("ball.heigth")

    def test_a_topic_without_messages_gives_none(self):
        own = sinew.attach("ball")
        self.assertIsNone(own.topic("operator.range").wait(0.01) if own.topic("operator.range").latest() is None else None)

    def test_the_writer_itself_may_wake_us(self):
        own = sinew.attach("ball")
        own.topic("ball.height").wake_at_once()
        first = own.topic("ball.height").wait(LIMIT_S)
        second = own.topic("ball.height").next(LIMIT_S)
        self.assertEqual(second.sequence, (first.sequence + 1 + second.missed) % 2**32)
        with self.assertRaisesRegex(sinew.Error, "wake_outsiders = true"):
            own.topic("apex.apex").wake_at_once()

    def test_sets_and_gets_parameters(self):
        self.robot.set("ball", "restitution", 0.5)
        self.assertEqual(self.robot.get("ball", "restitution"), 0.5)
        with self.assertRaisesRegex(sinew.Error, "ball.restitution: 7: a number from 0 to 1"):
            self.robot.set("ball", "restitution", 7)

    def test_asks_anything(self):
        self.assertEqual(self.robot.request("hello")["robot"], "ball")
        with self.assertRaisesRegex(sinew.Error, "did you mean hello"):
            self.robot.request("helo")

    def test_publishes_numbers(self):
        operator = self.robot.topic("operator.range")
        stamp = self.robot.now_ns()
        operator.publish(range_m=2.5, stamp_ns=stamp)
        message = operator.latest()
        self.assertEqual((message["range_m"], message.stamp_ns), (2.5, stamp))
        with self.assertRaisesRegex(sinew.NotFound, "RangeSample has no field range"):
            operator.publish(range=2.5)
        with self.assertRaisesRegex(sinew.Error, "the robot's present time"):
            operator.publish(range_m=1, stamp_ns=self.robot.now_ns() + 10**12)
        with self.assertRaisesRegex(sinew.Error, "written by a module"):
            self.robot.topic("ball.height").publish(range_m=1)

    def test_publishes_pixels(self):
        camera = self.robot.topic("camera.raw")
        rows = bytes((x + y) % 256 for y in range(48) for x in range(64))
        pixels = numpy.frombuffer(rows, "u1").reshape(48, 64) if numpy else memoryview(rows).cast("B", (48, 64))
        camera.publish(pixels=pixels, frame_number=7, stamp_ns=self.robot.now_ns())
        message = camera.wait(LIMIT_S)
        self.assertEqual((message["width"], message["height"], message["frame_number"]), (64, 48, 7))
        self.assertEqual(bytes(message.bulk), rows)
        if numpy:
            self.assertTrue((message.pixels == pixels).all())
            whole = numpy.zeros((480, 640, 2), "u1")
            camera.publish(pixels=whole, format="yuyv")
            seen = camera.wait(LIMIT_S)
            self.assertEqual((seen.pixels.shape, seen.pixels.base is not None, seen.pixels.flags.writeable),
                             ((480, 640, 2), True, False))
            with self.assertRaisesRegex(sinew.Error, "room for 614400"):
                camera.publish(pixels=numpy.zeros((480, 640, 3), "u1"))

    def test_views_outlive_the_connection(self):
        own = sinew.attach("ball")
        data = own.topic("ball.height").wait(LIMIT_S).data
        own.close()
        self.assertEqual(len(bytes(data)), 16)
        with self.assertRaises(sinew.Closed):
            own.now_ns()


class End(unittest.TestCase):
    def test_a_wait_ends_when_the_robot_does(self):
        Python.setUpClass()
        topic = Python.robot.topic("ball.height")
        os.kill(Python.run_.pid, signal.SIGKILL)
        Python.run_.wait(LIMIT_S)
        for _ in topic:  # to the end
            pass
        with self.assertRaises(sinew.Closed):
            topic.wait(LIMIT_S)
        Python.folder.cleanup()


class Replay(unittest.TestCase):
    def test_pixels_from_outside_are_executed_again_to_the_same_bytes(self):
        with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
            env = {**os.environ, "SINEW_RUN_DIR": folder, "SINEW_RECORD": "on"}
            os.environ["SINEW_RUN_DIR"] = folder
            run = subprocess.Popen([PROGRAM, "run", f"{SOURCE}/tests/client/client_robot.toml", "--plain", "--runs",
                                    f"{folder}/runs", "--record-images"], stdout=subprocess.DEVNULL, env=env)
            end = time.monotonic() + LIMIT_S
            while not os.path.exists(f"{folder}/ball.sock") and time.monotonic() < end:
                time.sleep(0.05)
            with sinew.attach("ball") as robot:
                camera = robot.topic("camera.raw")
                for i in range(8):
                    camera.publish(pixels=memoryview(bytes([i]) * 64 * 48).cast("B", (48, 64)), format="mono8",
                                   stamp_ns=robot.now_ns())
            run.send_signal(signal.SIGTERM)
            run.wait(LIMIT_S)
            files = [os.path.join(where, name) for where, _, names in os.walk(f"{folder}/runs") for name in names
                     if name.endswith(".mcap")]
            done = subprocess.run([PROGRAM, "replay", *files, "--json"], capture_output=True, text=True,
                                  env=env, timeout=LIMIT_S)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            camera = json.loads(done.stdout)["modules"]["camera"]
            self.assertEqual((camera["messages"], camera["not_compared"]), (8, 0), camera)


unittest.main(argv=sys.argv[:1])
