"""A robot on the board `linux` with CAN joints only, and simulated drives in another process at the far end."""
import ctypes
import glob
import os
import queue
import re
import signal
import subprocess
import tempfile
import threading
import time

PATIENCE_S = 60

ROBOT = """
robot = {{ name = "sway", board = "linux" }}

[[thread]]
name = "loop"
priority = 0
period_us = 5000
order = ["sway"{more_order}]

[module.sway]
type = "test::Sway"
params = {{ channels = {channels}, amplitude = 0.3, middle = {middle} }}
{more_modules}
[actuator.body]
command = "sway.command"
channels = {channels}
limit = [-10.0, 10.0]
lease_ms = 1000
safe = "stop"

[guardian]
priority = 99
arming = "auto"

[parent]
hang_ms = {hang_ms}
save_to = "faults"

[record]
enabled = false

{buses}

[device.body]
driver = "can_servos"
{joints}
"""


def bus_text(name, driver, address, more=""):
    return f'[bus.{name}]\ndriver = "{driver}"\naddress = "{address}"\ntick_hz = 200\npriority = 0\n{more}\n'


def joint_text(name, driver, bus, number, more=""):
    return (f'[[device.body.joint]]\nname = "{name}"\ndriver = "{driver}"\nbus = "{bus}"\nid = {number}\n'
            f'max_velocity_radps = 20.0\nfeedback_timeout_ms = 2000\n{more}\n')


def free_bus():
    """A bus over UDP that no other test of this machine uses now, as far as its number can tell."""
    return 20 + os.getpid() % 200


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


def end_with_the_test():
    """In a new process: the kernel ends it when the test ends, for any reason (PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)


class Said:
    """Lines of a process, read by a thread: no test waits for a line that does not come."""

    def __init__(self, argv, **more):
        self.process = subprocess.Popen(argv, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True, bufsize=1,
                                        preexec_fn=end_with_the_test, **more)
        self.lines, self.all = queue.Queue(), []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(line.rstrip("\n"))

    def wait_for(self, pattern, patience_s=PATIENCE_S):
        end = time.monotonic() + patience_s
        while True:
            try:
                line = self.lines.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"never said {pattern!r}; said: {self.all}") from None
            self.all.append(line)
            if found := re.search(pattern, line):
                return found

    def tell(self, line):
        self.process.stdin.write(line + "\n")

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()


class Bench:
    """The robot's folder, its drives and its run. `addCleanup` is the test's."""

    def __init__(self, test, sway, drives_program):
        self.test, self.sway, self.drives_program = test, sway, drives_program
        folder = tempfile.TemporaryDirectory(prefix="sinew_can_")
        test.addCleanup(folder.cleanup)
        self.folder = folder.name

    def drives(self, address, *servos):
        drives = Said([self.drives_program, address, *servos])
        self.test.addCleanup(drives.end)
        drives.wait_for("ready")
        return drives

    def run(self, buses, joints, channels, hang_ms=3000, middle=0.0, more_order="", more_modules="", arguments=()):
        robot = os.path.join(self.folder, "sway.toml")
        with open(robot, "w") as f:
            f.write(ROBOT.format(buses=buses, joints=joints, channels=channels, hang_ms=hang_ms, middle=middle,
                                 more_order=more_order, more_modules=more_modules))
        self.environment = dict(os.environ, SINEW_RUN_DIR=self.folder, SINEW_RECORD="off")
        run = subprocess.Popen([self.sway, "run", robot, "--plain", *arguments], cwd=self.folder,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=self.environment,
                               start_new_session=True, preexec_fn=end_with_the_test)
        self.test.addCleanup(self.end, run)
        return run

    @staticmethod
    def end(run):
        """Ends all processes of the run: also a runtime whose parent has died, and later children of the parent."""
        try:
            os.killpg(run.pid, signal.SIGKILL)  # of a session of its own
        except ProcessLookupError:
            pass  # they have ended
        run.wait()
        run.stderr.close()
