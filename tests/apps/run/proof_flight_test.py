"""The proof of exact replay: a flight in real time on a machine with no processor to spare, in which everything happens
that makes a run hard to repeat. usage: proof_flight_test.py SINEW FLIP_BIT QUAD"""
import glob
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest

LIMIT_S = 120  # for any step here, on a machine that is busy elsewhere, too
SET_PARAM, ENABLE, DISABLE, SET_PERIOD = range(4)  # rt::Request::Kind
STALE = 1  # rt::StepStatus


class ProofFlight(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.env = {**os.environ, "SINEW_RUN_DIR": f"{cls.folder.name}/run"}
        cls.env.pop("SINEW_RECORD", None)
        for attempt in range(5):  # a recorder that the load starves reports it; the run is no proof then
            cls.summary = cls.fly(f"{cls.folder.name}/{attempt}")
            recording = cls.summary["recording"]
            if not recording["lost_messages"] and not recording["lost_steps"]:
                break
        cls.file = glob.glob(f"{cls.folder.name}/{attempt}/latest/run.mcap")[0]
        cls.modules = {name: i for i, name in enumerate(m["name"] for m in cls.summary["modules"])}
        cls.steps = [step for m in cls.messages("sinew/steps") for step in m["steps"]]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def fly(cls, runs):
        load = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count())]
        try:
            with open(f"{cls.folder.name}/out.json", "w+") as out:
                run = subprocess.Popen([SINEW, "run", QUAD, "--json", "--plain", "--runs", runs, "--fault", "camera:off@7+1"],
                                       stdout=out, env=cls.env)
                pid = json.loads(cls.good("status", "--wait", str(LIMIT_S), "--json"))["pid"]
                time.sleep(1)
                os.kill(pid, signal.SIGSTOP)  # still on the ground: deadlines are missed, a queue overflows
                time.sleep(0.15)
                os.kill(pid, signal.SIGCONT)
                time.sleep(1)
                cls.good("param", "set", "attitude.kp_rate", "21.5")
                cls.good("module", "disable", "motion")
                time.sleep(0.3)
                cls.good("module", "enable", "motion")
                cls.good("thread", "period", "ranging", "12500")
                run.wait(LIMIT_S)
                out.seek(0)
                return json.load(out)
        finally:
            for process in load:
                process.kill()
                process.wait()

    @classmethod
    def good(cls, *arguments):
        return subprocess.run([SINEW, *arguments], stdout=subprocess.PIPE, text=True, timeout=LIMIT_S, env=cls.env,
                              check=True).stdout

    @classmethod
    def messages(cls, topic, file=None):
        lines = cls.good("bag", "cat", file or cls.file, "--topic", topic).splitlines()
        return [json.loads(line)["message"] for line in lines]

    def replay(self, file, *arguments):
        done = subprocess.run([SINEW, "replay", file, "--json", *arguments], stdout=subprocess.PIPE, text=True,
                              timeout=LIMIT_S, env=self.env)
        self.assertIn(done.returncode, (0, 1))
        return done.returncode, json.loads(done.stdout)

    def of(self, module):
        return [s for s in self.steps if s["module"] == self.modules[module]]

    def test_everything_happened_in_it(self):
        late = [s for s in self.of("mixer") if s["completed_ns"] - s["release_ns"] > 1_000_000]
        self.assertTrue(late, "an overrun")
        self.assertTrue(any(i["dropped"] for s in self.of("filter") for i in s["inputs"]), "a queue drop")
        requests = {r["kind"]: r for r in self.messages("sinew/requests")}
        self.assertEqual(sorted(requests), [SET_PARAM, ENABLE, DISABLE, SET_PERIOD])
        self.assertFalse(any(r["refused"] for r in requests.values()))
        camera = self.of("camera")
        lost = [s for s in camera if s["status"] == STALE]
        self.assertTrue(lost, "a device lost")
        self.assertLess(lost[-1]["number"], camera[-1]["number"], "and found")
        self.assertTrue(any(m["acted"] for m in self.messages("guardian.state")), "an action of the guardian")
        self.assertGreater(self.summary["missed_deadlines"], 0)

    def test_every_step_of_it_is_identical_when_executed_again(self):
        recording = self.summary["recording"]
        self.assertEqual((recording["lost_messages"], recording["lost_steps"]), ({}, {}), "in five flights")
        self.assertEqual({m: why for m, why in recording["not_replayable"].items() if why}, {})
        code, again = self.replay(self.file)
        self.assertTrue(again["identical"], again.get("first_difference"))
        self.assertEqual(code, 0, again)
        self.assertEqual(again["steps"], sum(m["steps"] for m in self.summary["modules"]), "all that there were")
        self.assertEqual(sum(m["not_compared"] for m in again["modules"].values()), 0)
        self.assertEqual(self.good("bag", "check", self.file).count("differ"), 0)

    def test_one_flipped_bit_of_what_a_module_said_is_named(self):
        chance = random.Random(4)
        writers = {"filter.state": "filter", "attitude.wrench": "attitude", "mixer.motors": "mixer",
                   "mission.setpoint": "mission", "position.attitude": "position", "guardian.state": "guardian",
                   "pad.sighting": "pad", "motion.field": "motion"}
        named = 0
        for topic, writer in writers.items():
            recorded = self.messages(topic)
            n = chance.randrange(1, len(recorded) + 1)
            flipped = f"{self.folder.name}/{topic}.mcap"
            byte, bit = chance.randrange(8, 32), chance.randrange(8)
            subprocess.run([FLIP_BIT, self.file, flipped, topic, str(n), str(byte), str(bit)], timeout=LIMIT_S, check=True)
            code, again = self.replay(flipped)
            means_something = self.messages(topic, flipped)[n - 1] != recorded[n - 1]
            os.remove(flipped)
            if not means_something:
                continue  # padding between two fields
            named += 1
            where = f"bit {bit} of byte {byte} of message {n} of {topic}"
            self.assertEqual((code, again["identical"]), (1, False), where)
            difference = again["modules"][writer]["difference"]
            published = [s for s in self.of(writer) if s["outputs"]]
            self.assertIn(difference["step"], [s["number"] for s in published], where)
            self.assertTrue(difference["what"].startswith(topic.split(".")[1] + "."), difference)
            self.assertNotEqual(difference["recorded"], difference["now"], where)
        self.assertGreaterEqual(named, 5)

    def test_one_flipped_bit_of_the_file_is_named(self):
        path = f"{self.folder.name}/damaged.mcap"
        with open(self.file, "rb") as f:
            data = bytearray(f.read())
        data[len(data) // 3] ^= 4
        with open(path, "wb") as f:
            f.write(data)
        code, again = self.replay(path)
        self.assertEqual(code, 1)
        self.assertTrue(again["problems"], again)


if __name__ == "__main__":
    SINEW, FLIP_BIT, QUAD = sys.argv[1:4]
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
