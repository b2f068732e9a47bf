"""A runtime that dies or hangs in flight: its lease runs out in the plant, the parent stops the motors over its own line,
starves the watchdog and saves the last seconds."""
import glob
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SINEW, SINEW_SIM, ROBOTS = sys.argv[1:4]
LIMIT_S = 60


def children(pid):
    found = []
    for path in glob.glob("/proc/[0-9]*/stat"):
        try:
            with open(path) as f:
                fields = f.read().rsplit(")", 1)[1].split()
            if int(fields[1]) == pid:
                found.append(int(path.split("/")[2]))
        except (OSError, IndexError):
            pass  # it ended meanwhile
    return found


class ParentFlight(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="sinew_parent_")
        self.addCleanup(self.folder.cleanup)
        self.watchdog = os.path.join(self.folder.name, "watchdog")
        os.mkfifo(self.watchdog)
        self.watchdog_end = os.open(self.watchdog, os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, self.watchdog_end)
        with open(f"{ROBOTS}/quad/quad.toml") as f:
            text = f.read()
        self.assertIn("virtual_cores = 1 }", text)
        text = text.replace("virtual_cores = 1 }", "virtual_cores = 1, tap_history_ms = 2000 }")
        # Only the flight ring: no file.
        text += "\n[record]\nenabled = false\n[record.ring]\nseconds = 2\n"
        # The lease has to run out long before the parent takes the silence for hanging.
        text += f'\n[parent]\nhang_ms = 600\nwatchdog = "{self.watchdog}"\nwatchdog_timeout_ms = 1000\nsave_to = "faults"\n'
        self.robot = os.path.join(self.folder.name, "quad.toml")
        with open(self.robot, "w") as f:
            f.write(text)
        for model in glob.glob(f"{ROBOTS}/*.xml"):
            os.symlink(model, os.path.join(self.folder.name, os.path.basename(model)))

    def fly(self):
        """Starts plant and robot; returns when the motors run."""
        address = f"unix:{self.folder.name}/plant.sock"
        # A sanitizer would make an exit code of the segmentation fault.
        environment = dict(os.environ, SINEW_RUN_DIR=self.folder.name, ASAN_OPTIONS="handle_segv=0")
        environment.pop("SINEW_RECORD", None)
        small = ("--camera", "64x48")
        self.plant = subprocess.Popen([SINEW_SIM, "--listen", address, "--free", "--seed", "1", "--relink", "2", *small],
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(self.end, self.plant)
        self.assertIn("listening", self.plant.stdout.readline())
        self.run_ = subprocess.Popen([SINEW, "run", self.robot, "--plant", address, "--plain", *small],
                                     cwd=self.folder.name, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                     env=environment)
        self.addCleanup(self.end, self.run_)
        said = ""
        for line in self.run_.stdout:
            said += line
            if re.search(r"climb|search|approach", line):
                return
        self.fail("never flew: " + said + self.run_.stderr.read())

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.kill()
        process.wait()
        for stream in (process.stdout, process.stderr):
            if stream:
                stream.close()

    def strike(self, number):
        runtime = children(self.run_.pid)
        self.assertEqual(len(runtime), 1, "the runtime is the one child of its parent")
        while os.read(self.watchdog_end, 4096):
            break  # until now it was fed
        os.kill(runtime[0], number)
        _, self.said = self.run_.communicate(timeout=LIMIT_S)
        self.plant_said, _ = self.plant.communicate(timeout=LIMIT_S)

    def expect_the_safe_end(self, fault):
        self.assertEqual(self.run_.returncode, 1, self.said)
        self.assertIn(fault, self.said)
        self.assertRegex(self.said, r"stop of the actuators: sent")
        self.assertRegex(self.plant_said, r"stopped by a supervisor at \d")
        self.assertIn("the watchdog is not fed any more", self.said)
        rest = b""
        try:
            rest = os.read(self.watchdog_end, 4096)
        except BlockingIOError:
            pass
        self.assertNotIn(b"V", rest, "an armed watchdog must stay armed")
        folders = glob.glob(f"{self.folder.name}/faults/quad-*")
        self.assertEqual(len(folders), 1, self.said)
        with open(f"{folders[0]}/fault.json") as f:
            self.assertIn(fault, json.load(f)["fault"])
        with open(f"{folders[0]}/messages.jsonl") as f:
            messages = [json.loads(line) for line in f]
        topics = {m["topic"] for m in messages}
        self.assertLessEqual({"imu.raw", "filter.state", "mixer.motors", "guardian.motors", "camera.raw"}, topics)
        published = [m["published_ns"] for m in messages]
        self.assertEqual(published, sorted(published))
        states = [m["published_ns"] for m in messages if m["topic"] == "filter.state"]
        self.assertGreater(states[-1] - states[0], 1.8e9, "tap_history_ms of the robot file")

    def expect_the_ring(self):
        """The runtime's memory became a recording that replays, except for the last moment."""
        dump = re.search(r"the flight ring is in (runs/quad-[0-9-]+/ring-[0-9]+.mcap)", self.said)
        self.assertTrue(dump, self.said)
        path = f"{self.folder.name}/{dump.group(1)}"
        info = json.loads(subprocess.check_output([SINEW, "bag", "info", path, "--json"]))
        self.assertTrue(info["whole"])
        self.assertGreater(info["duration_s"], 1)
        self.assertEqual(subprocess.call([SINEW, "bag", "check", path], stdout=subprocess.DEVNULL), 0)
        replay = json.loads(subprocess.run([SINEW, "replay", path, "--json"], capture_output=True).stdout)
        self.assertTrue(replay["identical"], replay.get("first_difference"))
        self.assertGreater(replay["steps"], 0)

    def test_a_lost_terminal_ends_nothing(self):
        self.fly()
        self.run_.stdout.close()  # like `| tee` when tee dies
        for pid in [self.run_.pid, *children(self.run_.pid)]:
            os.kill(pid, signal.SIGHUP)
        time.sleep(2.5)  # it says something every two seconds
        self.assertIsNone(self.run_.poll(), "a signal or a closed pipe ended it")
        self.run_.terminate()
        self.assertEqual(self.run_.wait(timeout=60), 1)  # it has not landed
        self.assertNotIn("died", self.run_.stderr.read())

    def test_kill_9(self):
        self.fly()
        self.strike(signal.SIGKILL)
        self.expect_the_safe_end("the runtime died: signal 9")
        self.expect_the_ring()

    def test_segmentation_fault(self):
        self.fly()
        self.strike(signal.SIGSEGV)
        self.expect_the_safe_end("the runtime died: signal 11")

    def test_a_stopped_process_is_a_hanging_one_and_its_lease_runs_out_before(self):
        self.fly()
        self.strike(signal.SIGSTOP)
        self.expect_the_safe_end("the runtime hangs: no commit of the guardian")
        self.assertRegex(self.plant_said, r"leases that ran out: [1-9]")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:], verbosity=2)
