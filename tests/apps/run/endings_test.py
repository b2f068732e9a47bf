"""Runs that do not come to their end: plant, runtime or parent is killed, stopped or continued, or the run is interrupted,
in each phase. What died is named, nothing hangs, and nothing is left behind."""
import glob
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

os.environ["SINEW_RECORD"] = "off"  # a flight is 100 MB; one test asks for a recording

SINEW, SINEW_SIM, ROBOTS = map(os.path.abspath, sys.argv[1:4])
QUAD = f"{ROBOTS}/quad/quad.toml"
LIMIT_S = 120
# Two seconds are promised. The rest is for a machine whose processors belong to other tests: what is wrong here takes
# twenty seconds and more.
SOON_S = 5
CLIMB, DESCEND, TOUCHDOWN = 2, 6, 7  # msg::MissionPhase
# The same phases in half of the time: it flies low and waits for nothing.
SHORT = ("settle_s=0.2", "look_s=0", "hold_s=0.2", "search_height_m=1.2", "approach_height_m=0.7")
ESTABLISHED, SYN_SENT = 1, 2  # of /proc/net/tcp


def stat(pid):
    """Name, state and parent; None: there is no such process."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            text = file.read()
    except OSError:
        return None
    fields = text.rsplit(")", 1)[1].split()
    return text.split("(", 1)[1].rsplit(")", 1)[0], fields[0], int(fields[1])


def child(pid, name):
    for path in glob.glob("/proc/[0-9]*"):
        found = stat(path[6:])
        if found and found[2] == pid and found[0] == name and found[1] != "Z":
            return int(path[6:])
    return None


def lives(pid):
    found = stat(pid)
    return found is not None and found[1] != "Z"  # nobody may wait for an orphan


def answers(path):
    """Whether a program listens at this Unix socket."""
    with socket.socket(socket.AF_UNIX) as client:
        return client.connect_ex(path) == 0


def has_signal(pid, mask, number):
    """Whether it is in a mask of /proc/PID/status: SigCgt, those with a handler, or ShdPnd, those not yet delivered."""
    with open(f"/proc/{pid}/status") as file:
        return bool(int(re.search(rf"(?m)^{mask}:\s*(\w+)$", file.read())[1], 16) >> (number - 1) & 1)


def sleeps(pid):
    return stat(pid)[1] == "S"


def tcp_states(pid):
    """The states of its TCP connections."""
    own = set()
    for path in glob.glob(f"/proc/{pid}/fd/*"):
        try:
            own.add(os.readlink(path))
        except OSError:
            pass  # closed meanwhile
    with open("/proc/net/tcp") as file:
        rows = [line.split() for line in file.readlines()[1:]]
    return {int(row[3], 16) for row in rows if f"socket:[{row[9]}]" in own}


def until(holds, what, limit_s=LIMIT_S):
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        got = holds()
        if got:
            return got
        time.sleep(0.01)
    raise AssertionError(what)


class Run:
    """`sinew run` of the quadrotor, with all processes that belong to it."""

    def __init__(self, test, *arguments, recorded=False, robot=QUAD):
        self.test = test
        folder = tempfile.TemporaryDirectory(prefix="sinew_endings_")
        test.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.temporary = f"{self.folder}/tmp"
        os.mkdir(self.temporary)
        self.env = dict(os.environ, SINEW_RUN_DIR=f"{self.folder}/run", TMPDIR=self.temporary)
        if recorded:
            self.env["SINEW_RECORD"] = "on"
        self.out = open(f"{self.folder}/said.txt", "w+")
        test.addCleanup(self.out.close)
        mission = [word for value in SHORT for word in ("--set", f"mission.{value}")]
        self.process = subprocess.Popen([SINEW, "run", robot, "--seed", "3", "--camera", "64x48", "--plain", *mission,
                                         *arguments], cwd=self.folder, stdout=self.out, stderr=subprocess.STDOUT,
                                        env=self.env, start_new_session=True)
        self.pids = {self.process.pid}
        self.own = "--plant" not in arguments
        test.addCleanup(self.clean)

    def clean(self):
        for pid in self.pids:
            if lives(pid):
                os.kill(pid, signal.SIGKILL)
        self.process.wait()

    def of(self, name):
        """A process of the run, as soon as it is there."""
        pid = until(lambda: child(self.process.pid, name) or self.process.poll() is not None, f"no {name}")
        self.test.assertIsNot(pid, True, self.said())
        self.pids.add(pid)
        return pid

    def plant(self):
        return self.of("sinew-sim")

    def runtime(self):
        if self.own:
            self.plant()  # which is called like us until it begins
        return self.of("sinew")

    def said(self):
        with open(self.out.name) as file:
            return file.read()

    def phase(self):
        done = subprocess.run([SINEW, "topic", "echo", "mission.mission", "-n", "1", "--timeout", "0.2", "--json"],
                              capture_output=True, text=True, env=self.env)
        return json.loads(done.stdout)["message"]["phase"] if done.returncode == 0 and done.stdout else -1

    def reach(self, phase, plant=None):
        """Virtual time: flies on in small pieces; the plant is stopped when this returns, or the run has ended: None. A
        whole flight takes less than a second, which a busy machine may be away from this test."""
        plant = plant or self.plant()
        until(lambda: self.phase() >= 0 or self.process.poll() is not None, "it does not begin")
        while self.process.poll() is None:
            try:
                os.kill(plant, signal.SIGSTOP)
                now = self.phase()
                if now >= phase:
                    return plant
                os.kill(plant, signal.SIGCONT)
            except ProcessLookupError:  # the run has just ended, and its plant with it
                self.process.wait(timeout=LIMIT_S)
                break
            time.sleep(0.02 if now == DESCEND else 0.04 if now >= phase - 2 else 0.1)
        return None

    def fly_until(self, phase):
        """Real time."""
        self.runtime()
        until(lambda: self.phase() >= phase or self.process.poll() is not None, f"phase {phase} does not come")
        self.test.assertIsNone(self.process.poll(), self.said())

    def wait_for(self, words):
        until(lambda: words in self.said() or self.process.poll() is not None, "it does not say: " + words)
        self.test.assertIn(words, self.said())

    def end(self, code, within_s=LIMIT_S, killed=False):
        """Waits for its end with this code, or one of these. `killed`: without a chance to remove its own socket."""
        begin = time.monotonic()
        try:
            got = self.process.wait(LIMIT_S)
        except subprocess.TimeoutExpired:
            got = "it does not end"
        took = time.monotonic() - begin
        said = self.said()
        self.test.assertIn(got, code if isinstance(code, tuple) else (code,), said)
        self.test.assertLess(took, within_s, said)
        for pid in self.pids:
            until(lambda pid=pid: not lives(pid), f"{stat(pid)} is left behind", SOON_S)
        self.test.assertEqual(os.listdir(self.temporary), [], "left behind")
        if not killed:
            left = os.listdir(f"{self.folder}/run") if os.path.isdir(f"{self.folder}/run") else []
            self.test.assertEqual([name for name in left if name.endswith(".sock")], [])
        return said

    def expect_a_dead_plant(self, said, what):
        # On a busy machine the plant may be stopped only after the touchdown: "landed on the pad, but the simulator died".
        mission = re.search(rf"^mission   (?:[^\n]*: |[^\n]*, but |)the simulator {what} at ([0-9.]+) s", said, re.M)
        self.test.assertTrue(mission, said)
        self.test.assertRegex(said, rf"(?m)^timing    not valid as a measurement: the simulator {what} at {mission[1]} s")
        self.test.assertRegex(said, rf"(?m)^ +{mission[1]} s  the simulator {what}$")
        self.test.assertNotIn("the run ended after", said)


class Foreign:
    """A plant that nobody of the run has started."""

    def __init__(self, test, mode):
        self.folder = tempfile.TemporaryDirectory(prefix="sinew_plant_")
        test.addCleanup(self.folder.cleanup)
        self.endpoint = f"unix:{self.folder.name}/plant.sock"
        self.process = subprocess.Popen([SINEW_SIM, "--listen", self.endpoint, mode, "--camera", "64x48"],
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        test.addCleanup(self.clean)
        test.assertIn("listening", self.process.stdout.readline())

    def clean(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


class VirtualTime(unittest.TestCase):
    def run_(self, *arguments, **how):
        return Run(self, "--virtual", *arguments, **how)

    def stopped_in(self, phase, *arguments, **how):
        """A run whose plant is stopped in this phase, and that plant: runs that ended before they could be stopped are
        flown again."""
        for _ in range(10):
            run = self.run_(*arguments, **how)
            plant = run.reach(phase)
            if plant is not None:
                return run, plant
        raise AssertionError(f"it is never stopped in phase {phase}: {run.said()}")

    def test_a_plant_that_dies_while_it_starts_is_named_and_nothing_has_begun(self):
        run = self.run_()
        os.kill(run.plant(), signal.SIGKILL)
        self.assertIn("sinew-sim: signal 9 (Killed)", run.end(2))

    def test_a_plant_that_dies_in_flight_is_named_with_the_time_and_the_run_is_none(self):
        for phase in (CLIMB, DESCEND):
            with self.subTest(phase=phase):
                run, plant = self.stopped_in(phase)
                os.kill(plant, signal.SIGKILL)
                run.expect_a_dead_plant(run.end(1), r"died \(signal 9\)")

    def test_a_plant_that_is_stopped_is_told_while_it_lasts_and_costs_no_byte(self):
        undisturbed = self.run_("--verbose")
        hashes = re.findall(r"^hash .*", undisturbed.end(0), re.M)
        self.assertGreater(len(hashes), 10)
        run, plant = self.stopped_in(CLIMB, "--verbose")
        run.wait_for("no grant from the simulator for 5 s; it is stopped; Ctrl-C ends the run")
        os.kill(plant, signal.SIGCONT)
        run.wait_for("the simulator goes on after ")
        said = run.end(0)
        self.assertEqual(re.findall(r"^hash .*", said, re.M), hashes)
        self.assertRegex(said, r"(?m)^ +[0-9.]+ s  the simulator goes on after [0-9.]+ s$")

        run, plant = self.stopped_in(DESCEND, "--verbose")
        os.kill(run.process.pid, signal.SIGSTOP)  # nor does a runtime that is stopped
        os.kill(plant, signal.SIGCONT)
        os.kill(run.process.pid, signal.SIGCONT)
        self.assertEqual(re.findall(r"^hash .*", run.end(0), re.M), hashes)

    def test_a_signal_ends_a_run_whose_plant_is_stopped_while_it_starts(self):
        run = self.run_()
        os.kill(run.plant(), signal.SIGSTOP)
        until(lambda: sleeps(run.process.pid), "it does not wait")
        os.kill(run.process.pid, signal.SIGINT)
        self.assertIn("interrupted while the simulator started", run.end(1, SOON_S))

    def test_a_signal_ends_a_run_whose_plant_is_stopped_in_flight(self):
        for phase, number in ((CLIMB, signal.SIGINT), (DESCEND, signal.SIGTERM), (TOUCHDOWN, signal.SIGINT)):
            with self.subTest(phase=phase):
                for _ in range(10):
                    run, _ = self.stopped_in(phase)
                    run.process.send_signal(number)
                    # What was granted before the stop is still flown, and within 70 ms of touchdown the mission is done.
                    said = run.end((0, 1) if phase == TOUCHDOWN else (1,), SOON_S)
                    interrupted = re.search(r"(?m)^mission   .*interrupted at \d+\.\d s", said) is not None
                    done = re.search(r"(?m)^ +[0-9.]+ s  done$", said) is not None
                    self.assertEqual(run.process.returncode, 0 if done else 1, said)
                    if interrupted:
                        break
                self.assertTrue(interrupted, said)
                self.assertIn("the simulator is stopped, and was killed", said)

    def test_sinew_stop_ends_a_run_whose_plant_is_stopped(self):
        run, _ = self.stopped_in(CLIMB)
        subprocess.run([SINEW, "stop"], env=run.env, check=True, timeout=LIMIT_S, stdout=subprocess.DEVNULL)
        self.assertRegex(run.end(1, SOON_S), r"(?m)^mission   .*stopped at \d+\.\d s")

    def test_ctrl_c_at_a_terminal_is_an_interruption_not_a_death_and_leaves_a_whole_recording(self):
        run, plant = self.stopped_in(CLIMB, recorded=True)
        os.kill(plant, signal.SIGCONT)
        os.killpg(run.process.pid, signal.SIGINT)  # a terminal sends it to all
        said = run.end(1, SOON_S)
        self.assertRegex(said, r"(?m)^mission   .*interrupted at \d+\.\d s")
        self.assertNotIn("died", said)
        recording = glob.glob(f"{run.folder}/runs/latest/run.mcap")
        self.assertEqual(len(recording), 1, said)
        self.assertTrue(json.loads(subprocess.check_output([SINEW, "bag", "info", recording[0], "--json"]))["whole"])

    def test_a_plant_does_not_outlive_a_runtime_that_is_killed_not_even_when_it_is_stopped(self):
        run, _ = self.stopped_in(CLIMB)
        os.kill(run.process.pid, signal.SIGKILL)
        run.end(-signal.SIGKILL, killed=True)

    def test_a_foreign_plant_that_dies_has_closed_the_connection(self):
        for _ in range(10):
            plant = Foreign(self, "--lockstep")
            run = self.run_("--plant", plant.endpoint)
            if run.reach(CLIMB, plant.process.pid) is not None:
                break
        plant.process.kill()
        run.expect_a_dead_plant(run.end(1), "closed the connection")

    def test_a_signal_ends_a_run_that_waits_for_a_foreign_plant(self):
        with socket.create_server(("127.0.0.1", 0), backlog=0) as nobody:
            address = nobody.getsockname()
            waiting = []  # more than the backlog: whoever comes now is kept waiting in connect()
            for _ in range(3):
                one = socket.socket()
                one.setblocking(False)
                one.connect_ex(address)
                waiting.append(one)
            for silent in (False, True):
                with self.subTest(silent=silent):
                    run = self.run_("--plant", "tcp:%s:%d" % address)
                    until(lambda: has_signal(run.process.pid, "SigCgt", signal.SIGINT) and
                          tcp_states(run.process.pid) == {ESTABLISHED if silent else SYN_SENT}, "it does not connect")
                    os.kill(run.process.pid, signal.SIGINT)
                    self.assertIn("interrupted while", run.end(1, SOON_S))
                for one in waiting:  # then it gets through, and hears nothing
                    one.close()
                waiting = []
                nobody.setblocking(False)
                while not silent:
                    try:
                        nobody.accept()[0].close()
                    except BlockingIOError:
                        break

    def test_a_recording_names_the_end_of_its_run_as_the_run_did(self):
        run, plant = self.stopped_in(0, recorded=True)  # from its first message on
        os.kill(plant, signal.SIGKILL)
        said = run.end(1)
        recording = f"{run.folder}/runs/latest/run.mcap"
        end = json.loads(subprocess.check_output([SINEW, "bag", "info", recording, "--json"]))["result"]["end"]
        self.assertEqual(end, "the simulator died (signal 9)")
        self.assertRegex(said, rf"(?m)^mission   .*{re.escape(end)} at")

    def test_the_next_run_removes_what_a_run_left_that_was_killed_while_its_plant_started(self):
        sockets = []
        for _ in range(20):  # a run may have connected, and removed it, before it is stopped
            run = self.run_()
            end = time.monotonic() + 10
            while not glob.glob(f"{run.temporary}/*.sock") and time.monotonic() < end:
                pass
            os.kill(run.process.pid, signal.SIGSTOP)
            sockets = glob.glob(f"{run.temporary}/*.sock")
            os.kill(run.process.pid, signal.SIGKILL)
            run.process.wait()
            if sockets:
                break
        self.assertEqual(len(sockets), 1, "nothing to remove")
        # Its plant, killed with it, is answered for by the kernel until its last thread has ended.
        until(lambda: not answers(sockets[0]), "its plant does not end")
        subprocess.run([SINEW, "run", QUAD, "--virtual", "--duration", "0.01", "--camera", "64x48", "--quiet"],
                       cwd=run.folder, env=run.env, timeout=LIMIT_S, stdout=subprocess.DEVNULL)
        run.end(-signal.SIGKILL)


class RealTime(unittest.TestCase):
    def run_(self, *arguments, **how):
        return Run(self, *arguments, **how)

    def test_a_plant_that_dies_in_flight_is_named_with_the_time_and_the_run_is_none(self):
        for phase in (CLIMB, DESCEND):
            with self.subTest(phase=phase):
                run = self.run_()
                run.fly_until(phase)
                os.kill(run.plant(), signal.SIGKILL)
                run.expect_a_dead_plant(run.end(1), r"died \(signal 9\)")

    def test_a_plant_that_is_stopped_is_told_while_it_lasts_and_when_it_goes_on(self):
        run = self.run_()
        run.fly_until(CLIMB)
        os.kill(run.plant(), signal.SIGSTOP)
        run.wait_for("no samples from the simulator for 5 s; it is stopped; Ctrl-C ends the run")
        status = subprocess.check_output([SINEW, "status"], env=run.env, text=True)
        self.assertIn("no samples from the simulator for 5 s", status)
        os.kill(run.plant(), signal.SIGCONT)
        run.wait_for("the simulator goes on after ")
        os.kill(run.process.pid, signal.SIGTERM)
        self.assertRegex(run.end(1, SOON_S), r"(?m)^mission   .*interrupted at \d+\.\d s")

    def test_a_signal_ends_a_run_whose_plant_is_stopped(self):
        run = self.run_()
        os.kill(run.plant(), signal.SIGSTOP)
        until(lambda: sleeps(run.process.pid), "it does not wait")
        os.kill(run.process.pid, signal.SIGINT)
        self.assertIn("interrupted while the simulator started", run.end(1, SOON_S))
        run = self.run_()
        run.fly_until(CLIMB)
        os.kill(run.plant(), signal.SIGSTOP)
        time.sleep(2)  # so that its line is full of commands
        os.kill(run.process.pid, signal.SIGINT)
        self.assertRegex(run.end(1, SOON_S), r"(?m)^mission   .*interrupted at \d+\.\d s")

    def test_ctrl_c_at_a_terminal_is_an_interruption_not_a_death(self):
        run = self.run_()
        run.fly_until(DESCEND)
        os.killpg(run.process.pid, signal.SIGINT)
        said = run.end(1, SOON_S)
        self.assertRegex(said, r"(?m)^mission   .*interrupted at \d+\.\d s")
        self.assertNotIn("died", said)
        self.assertNotIn("second signal", said)

    def test_a_runtime_that_dies_is_named_by_its_parent_and_takes_its_plant_along(self):
        run = self.run_()
        run.fly_until(CLIMB)
        os.kill(run.runtime(), signal.SIGKILL)
        said = run.end(1, killed=True)
        self.assertIn("the runtime died: signal 9", said)
        self.assertIn("stop of the actuators: sent", said)

    def test_a_signal_ends_a_run_whose_runtime_is_stopped(self):
        run = self.run_()
        os.kill(run.runtime(), signal.SIGSTOP)  # it may not have begun yet: nobody takes this for hanging
        os.kill(run.process.pid, signal.SIGINT)
        self.assertIn("the runtime ", run.end(1, SOON_S, killed=True))

    def test_a_second_signal_waits_for_nothing(self):
        run = self.run_()
        os.kill(run.runtime(), signal.SIGSTOP)
        os.kill(run.process.pid, signal.SIGINT)
        until(lambda: not has_signal(run.process.pid, "ShdPnd", signal.SIGINT), "it does not hear the first")
        time.sleep(0.4)  # sooner, it is taken for the first one
        os.kill(run.process.pid, signal.SIGINT)
        said = run.end(1, SOON_S, killed=True)
        self.assertIn("ended at once by a second signal", said)
        self.assertEqual(glob.glob(f"{run.folder}/faults/*"), [], "nothing is saved")

    def test_a_parent_that_dies_takes_the_plant_along_and_the_run_says_so(self):
        run = self.run_()
        run.fly_until(CLIMB)
        os.kill(run.process.pid, signal.SIGKILL)
        said = run.end(-signal.SIGKILL)  # and it waits for the runtime
        self.assertRegex(run.said(), r"(?m)^mission   .*the parent process died, and the simulator with it at \d+\.\d s", said)

    def test_a_run_goes_on_beside_a_parent_that_is_stopped(self):
        run = self.run_()
        run.fly_until(CLIMB)
        os.kill(run.process.pid, signal.SIGSTOP)
        until(lambda: run.phase() > CLIMB, "it does not go on")
        runtime = run.runtime()
        os.kill(runtime, signal.SIGINT)
        until(lambda: not lives(runtime), "the runtime does not end", SOON_S)
        os.kill(run.process.pid, signal.SIGCONT)
        said = run.end(1, SOON_S)
        self.assertRegex(said, r"(?m)^mission   .*interrupted at \d+\.\d s")
        self.assertNotIn("the runtime died", said)

    def test_a_foreign_plant_that_dies_has_closed_the_connection(self):
        plant = Foreign(self, "--free")
        robot = f"{plant.folder.name}/short.toml"
        with open(robot, "w") as file:
            file.write(f'extends = "{QUAD}"\n[sim]\nrelink_s = 0.5\n')
        run = self.run_("--plant", plant.endpoint, robot=robot)
        run.runtime()
        until(lambda: run.phase() >= CLIMB, "it does not fly")
        plant.process.kill()
        run.expect_a_dead_plant(run.end(1), "closed the connection")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
