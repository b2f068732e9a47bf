"""sinew deploy against a board that is a folder here: fake_ssh.py runs the board's commands, and programs that would
change this machine (sudo, systemctl, useradd, ...) are replaced by stand-ins that log how they were called."""
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, SOURCE = sys.argv[1:3]
RUN_DIR = tempfile.TemporaryDirectory()  # this program's robots meet nobody else's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
SSH = f"{sys.executable} {SOURCE}/tests/apps/deploy/fake_ssh.py"
# The quadrotor as a file that stands alone, with a calibration file.
ROBOT = subprocess.run([SINEW, "check", "--resolved", f"{SOURCE}/robots/quad/quad_pilot.toml"], capture_output=True, text=True,
                       check=True).stdout.replace("'", '"')
ROBOT = ROBOT.replace('name = "quad_pilot"', 'name = "desk"', 1).replace("quad_pilot_calibration.toml", "unit/calibration.toml", 1)
# Called as NAME ARGUMENTS; paths below /etc are the board's.
LOG = '''#!/bin/sh
echo "$(basename "$0") $*" >>"$FAKE_BOARD/log"
'''


class Board(unittest.TestCase):
    def setUp(self):
        self.room = tempfile.TemporaryDirectory(prefix="sinew_deploy_")
        self.addCleanup(self.room.cleanup)
        self.here = pathlib.Path(self.room.name) / "here"
        self.board = pathlib.Path(self.room.name) / "board"
        (self.board / "bin").mkdir(parents=True)
        (self.board / "etc/systemd/system").mkdir(parents=True)
        self.here.mkdir()
        (self.board / "log").touch()
        self.robot = self.here / "desk.toml"
        self.robot.write_text(ROBOT)
        self.dir = self.board / "opt/sinew"
        self.fault = ""
        self.tool("id", 'case "$*" in -u) echo 1000 ;; -un) echo pi ;; *) exit 1 ;; esac')
        self.tool("uname", f"echo {os.uname().machine}")

    def tool(self, name, script):
        path = self.board / "bin" / name
        path.write_text(LOG + script + "\n")
        path.chmod(0o755)

    def log(self):
        return (self.board / "log").read_text()

    def sinew(self, *arguments, ssh=SSH):
        environment = dict(os.environ, FAKE_BOARD=str(self.board), FAKE_FAULT=self.fault)
        done = subprocess.run([SINEW, "deploy", "pi@board", *map(str, arguments), "--ssh", ssh], capture_output=True,
                              text=True, timeout=100, env=environment, cwd=self.here)
        return done.returncode, done.stdout, done.stderr

    def deploy(self, *arguments):
        return self.sinew(self.robot, "--dir", self.dir, "--board", "linux", *arguments)

    def fetch(self, *arguments):
        return self.sinew("--dir", self.dir, "--fetch", *arguments)

    def versions(self):
        return sorted(p.name for p in self.dir.iterdir() if p.name.startswith("version-"))


class Copies(Board):
    def test_program_and_robot_file_arrive_are_tried_and_take_their_place(self):
        code, out, err = self.deploy()
        self.assertEqual(code, 0, out + err)
        app = self.dir / "app"
        self.assertEqual(os.readlink(app), "version-1")
        self.assertEqual((app / "bin/sinew").read_bytes(), pathlib.Path(SINEW).read_bytes())
        self.assertTrue(os.access(app / "bin/sinew", os.X_OK))
        self.assertEqual((app / "desk.toml").read_text(), ROBOT)
        self.assertIn("check:\n", out)
        self.assertIn("no problems", out)
        self.assertRegex(out, r"doctor:\n(  .*\n)+  \d+ checks: ")
        self.assertIn("there is no calibration yet", out)
        self.assertFalse((self.dir / "incoming").exists())
        self.assertNotIn("sudo", self.log())

    def test_the_boards_doctor_looks_at_the_devices_of_the_board_that_it_runs_with(self):
        self.robot.write_text(pathlib.Path(f"{SOURCE}/robots/desk_head/desk_head.toml").read_text(encoding="utf-8"))
        code, out, err = self.deploy()
        self.assertEqual(code, 0, out + err)
        self.assertIn("device.camera", out)
        self.assertRegex(out, r"to run it there: .*/app/desk\.toml --board linux\n")
        here = subprocess.run([SINEW, "doctor", f"{SOURCE}/robots/desk_head/desk_head.toml"], capture_output=True, text=True)
        self.assertNotIn("device.camera", here.stdout)
        self.assertIn('board = "sim": its devices were not checked; --board linux checks them', here.stderr)

    def test_a_login_that_talks_is_not_taken_for_the_board(self):
        self.fault = "noise"
        code, out, err = self.deploy()
        self.assertEqual(code, 0, out + err)

    def test_the_version_before_stays_and_comes_back(self):
        for text in ("# one\n", "# two\n", "# three\n"):
            self.robot.write_text(ROBOT + text)
            code, out, err = self.deploy()
            self.assertEqual(code, 0, out + err)
        self.assertEqual(self.versions(), ["version-2", "version-3"])
        self.assertIn("# three", (self.dir / "app/desk.toml").read_text())
        code, out, err = self.sinew("--dir", self.dir, "--rollback")
        self.assertEqual(code, 0, out + err)
        self.assertIn("version-2 is in force again: sinew ", out)
        self.assertIn("# two", (self.dir / "app/desk.toml").read_text())
        self.assertEqual(self.sinew("--dir", self.dir, "--rollback")[0], 0)
        self.assertIn("# three", (self.dir / "app/desk.toml").read_text())

    def test_without_a_version_before_there_is_no_way_back(self):
        self.assertEqual(self.deploy()[0], 0)
        code, _, err = self.sinew("--dir", self.dir, "--rollback")
        self.assertEqual(code, 1)
        self.assertIn("there is no version before this one", err)

    def test_the_boards_calibration_is_never_overwritten(self):
        ours = self.here / "unit/calibration.toml"
        ours.parent.mkdir()
        ours.write_text("# ours\n")
        self.assertEqual(self.deploy()[0], 0)
        theirs = self.dir / "app/unit/calibration.toml"
        self.assertEqual(theirs.read_text(), "# ours\n", "the first one comes from here")
        theirs.write_text("# measured there\n")
        code, out, err = self.deploy()
        self.assertEqual(code, 0, out + err)
        self.assertIn("the board's own calibration stays", out)
        self.assertEqual(theirs.read_text(), "# measured there\n")
        theirs.write_text("# measured again\n")
        self.assertEqual(self.sinew("--dir", self.dir, "--rollback")[0], 0)
        self.assertEqual(theirs.read_text(), "# measured again\n", "the version before gets the newer one")

    def test_files_that_the_robot_file_names_come_along(self):
        (self.here / "shapes").mkdir()
        (self.here / "shapes/ball.bin").write_bytes(b"\0\1\2" * 700)
        self.robot.write_text(ROBOT + '[device.odd]\ndriver = "odd"\nmodel = "shapes/ball.bin"\nother = "../secret"\n'
                              'third = "no/such/file"\npath = "/dev/null"\n')
        (self.here.parent / "secret").write_text("not beside it")
        code, out, err = self.deploy()
        self.assertEqual(code, 1, "no driver of this name: the board's check says so")
        self.assertIn("desk.toml, shapes/ball.bin\n", out)
        self.assertNotIn("secret", out.split("check:")[0])
        self.assertIn("the robot file does not pass on the board", err)
        self.assertFalse((self.dir / "app").exists())


class Refusals(Board):
    def refused(self, words, code=2):
        got, out, err = self.deploy()
        self.assertEqual(got, code, out + err)
        self.assertIn(words, err)
        self.assertFalse((self.dir / "app").exists())

    def test_what_ssh_says_is_told_with_what_to_do(self):
        for fault, words in (("unreachable", "cannot be reached: is it on"), ("refused", "is sshd running"),
                             ("denied", "refuses this login"), ("unknown", "this name is not known here")):
            self.fault = fault
            self.refused(words)

    def test_a_machine_without_ssh(self):
        code, _, err = self.sinew(self.robot, "--board", "linux", ssh="no-such-ssh-here -p 1")
        self.assertEqual(code, 2)
        self.assertIn("there is no program 'no-such-ssh-here' (Debian: apt-get install openssh-client)", err)

    def test_a_program_for_another_machine_is_not_even_sent(self):
        self.tool("uname", "echo riscv64")
        self.refused("the program is for ")
        self.assertEqual(self.log().count("ssh pi@board"), 1)

    def test_a_binary_that_was_cross_built_is_looked_at_and_not_the_own_one(self):
        binary = self.here / "for_arm"
        binary.write_bytes(b"\x7fELF\x01\x01\x01" + bytes(9) + struct.pack("<HH", 2, 40) + bytes(100))
        code, _, err = self.deploy("--binary", binary)
        if not os.uname().machine.startswith(("arm", "aarch64")):
            self.assertEqual(code, 2)
            self.assertIn("the program is for arm, 32 bit", err)
        binary.write_text("#!/bin/sh\n")
        code, _, err = self.deploy("--binary", binary)
        self.assertEqual(code, 2)
        self.assertIn("is no program that can be read (ELF)", err)

    def test_missing_libraries_are_named_with_their_packages(self):
        self.assertEqual(self.deploy()[0], 0)
        binary = self.here / "lost"
        source = self.here / "lost.c"
        source.write_text("int fmt(void); int main(void) { return fmt(); }\n")
        library = self.here / "fmt.c"
        library.write_text("int fmt(void) { return 0; }\n")
        compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
        self.assertTrue(compiler, "a C compiler")
        subprocess.run([compiler, "-shared", "-fPIC", "-Wl,-soname,libsinew-nowhere.so.1", "-o", self.here / "liblost.so",
                        library], check=True)
        subprocess.run([compiler, "-o", binary, source, self.here / "liblost.so"], check=True)
        before = os.readlink(self.dir / "app")
        code, out, err = self.deploy("--binary", binary)
        self.assertEqual(code, 1, out + err)
        self.assertIn("the board lacks these libraries:\n  libsinew-nowhere.so.1", err)
        self.assertEqual(os.readlink(self.dir / "app"), before)
        self.assertFalse((self.dir / "incoming").exists())

    def test_a_full_disk_is_seen_before_anything_is_sent(self):
        self.tool("df", 'echo Filesystem; echo "/dev/sda1 100 99 1024 99% /"')
        self.refused("the disk is full: 1 MiB are free")

    def test_a_disk_that_fills_up_under_way(self):
        self.tool("tar", 'head -c 100000 >/dev/null; echo "tar: bin/sinew: Cannot write: No space left on device" >&2; exit 2')
        self.refused("the board's disk is full", 1)
        self.assertFalse((self.dir / "incoming").exists())

    def test_a_connection_that_breaks_leaves_the_version_before(self):
        self.assertEqual(self.deploy()[0], 0)
        self.fault = "breaks:200000"
        code, _, err = self.deploy()
        self.assertEqual(code, 1)
        self.assertIn("the connection broke", err)
        self.assertEqual(self.versions(), ["version-1"])
        self.fault = ""
        self.assertEqual(self.deploy()[0], 0)
        self.assertEqual(os.readlink(self.dir / "app"), "version-2")

    def test_a_robot_file_with_problems_is_not_sent(self):
        self.robot.write_text(ROBOT.replace("priority = 80", "priority = 200"))
        code, _, err = self.deploy()
        self.assertEqual(code, 2)
        self.assertIn("thread.stabilise.priority: 200", err)
        self.assertEqual(self.log(), "")

    def test_a_robot_that_lacks_devices_is_not_taken(self):
        self.robot.write_text(pathlib.Path(f"{SOURCE}/robots/quad/quad.toml").read_text(encoding="utf-8"))
        code, out, err = self.deploy()
        self.assertEqual(code, 1, out + err)
        self.assertIn("that gives imu: there is none", out)
        self.assertFalse((self.dir / "app").exists())

    def test_a_simulated_robot_stays_here(self):
        for board in ("sim", "dataset"):
            self.robot.write_text(ROBOT.replace('board = "linux"', f'board = "{board}"'))
            for arguments in ((), ("--unit",), ("--print-unit",)):
                code, out, err = self.sinew(self.robot, "--dir", self.dir, *arguments)
                self.assertEqual(code, 2, out + err)
                self.assertIn(f'desk.toml: robot.board: "{board}": on a robot\'s own computer it is "linux"', err)
        self.robot.write_text(ROBOT.replace('board = "linux"', 'board = "linux"\ndevice_boards = { camera = "sim" }'))
        code, out, err = self.sinew(self.robot, "--dir", self.dir)
        self.assertEqual(code, 2, out + err)
        self.assertIn('robot.device_boards.camera: "sim"', err)
        self.assertEqual(self.log(), "")

    def test_options_that_make_no_sense(self):
        for arguments, words in (([self.robot, "--start"], "--unit"), ([], "a robot file is required"),
                                 ([self.robot, "--board", "linux", "--unit", "--dir", "/opt/a b"], "cannot stand in a unit")):
            code, _, err = self.sinew(*arguments)
            self.assertEqual(code, 2, err)
            self.assertIn(words, err)


class Unit(Board):
    def setUp(self):
        super().setUp()
        # sudo -n COMMAND: paths below /etc are the board's.
        self.tool("sudo", '''shift
[ "$1" = true ] && exit 0
for word; do
  shift
  case $word in /etc/*) word=$FAKE_BOARD$word ;; esac
  set -- "$@" "$word"
done
exec "$@"''')
        self.tool("getent", 'case "$2" in video|i2c) exit 0 ;; *) exit 2 ;; esac')
        self.tool("useradd", "exit 0")
        self.tool("chown", "exit 0")
        self.tool("runuser", "exit 0")
        self.tool("systemctl", '''case $1 in
is-active) [ -e "$FAKE_BOARD/active" ] ;;
start) [ -e "$FAKE_BOARD/broken" ] || touch "$FAKE_BOARD/active" ;;
status) echo "it broke" ;;
esac''')
        self.unit = self.board / "etc/systemd/system/sinew-desk.service"

    def test_the_unit_is_written_enabled_and_started(self):
        code, out, err = self.deploy("--unit")
        self.assertEqual(code, 0, out + err)
        text = self.unit.read_text()
        self.assertIn(f"ExecStart={self.dir}/app/bin/sinew run {self.dir}/app/desk.toml --board linux --plain\n", text)
        self.assertIn("SupplementaryGroups=video i2c\n", text)
        log = self.log()
        self.assertIn(f"useradd --system --user-group --no-create-home --home-dir {self.dir}/data", log)
        self.assertIn("systemctl enable sinew-desk.service", log)
        self.assertNotIn("\nsystemctl start", log)
        self.assertIn("sinew-desk.service is enabled", out)

    def test_it_is_started_where_the_doctor_finds_no_problem_and_only_once(self):
        code, out, err = self.deploy("--unit", "--start")
        ill = "not started: the doctor found problems" in err  # of the machine that this test runs on
        self.assertEqual(code, 1 if ill else 0, out + err)
        self.assertEqual(ill, "\n  problem " in out)
        self.assertEqual((self.board / "active").exists(), not ill)
        if ill:
            return
        self.assertIn("sinew-desk.service runs", out)
        code, out, err = self.deploy("--unit", "--start")
        self.assertEqual(code, 1, out)
        self.assertIn("not started: it runs already", err)
        self.assertEqual(self.log().count("\nsystemctl start"), 1)
        (self.board / "active").unlink()
        (self.board / "broken").touch()
        code, out, err = self.deploy("--unit", "--start")
        self.assertEqual(code, 1)
        self.assertIn("it broke", out)
        self.assertIn("the unit did not start", err)

    def test_a_user_who_cannot_enter_the_folder_is_told(self):
        self.tool("runuser", "exit 1")
        code, _, err = self.deploy("--unit")
        self.assertEqual(code, 1)
        self.assertIn("the unit's user cannot enter this folder", err)
        self.assertFalse(self.unit.exists())

    def test_a_unit_needs_root_and_systemd(self):
        self.tool("systemctl", "exit 1")
        code, _, err = self.deploy("--unit")
        self.assertEqual(code, 2)
        self.assertIn("the board does not run systemd", err)
        self.tool("systemctl", "exit 0")
        self.tool("sudo", "exit 1")
        code, _, err = self.deploy("--unit")
        self.assertEqual(code, 2)
        self.assertIn("pi may not become root on the board; sudo asks for a password", err)
        self.assertFalse((self.dir / "app").exists())

    def test_print_unit_needs_no_board(self):
        self.robot.write_text(ROBOT.replace('board = "sim"', 'board = "linux"'))
        code, out, err = self.sinew(self.robot, "--print-unit")
        self.assertEqual(code, 0, err)
        for line in ("ExecStart=/opt/sinew/app/bin/sinew run /opt/sinew/app/desk.toml --plain", "User=sinew",
                     "LimitRTPRIO=99", "LimitMEMLOCK=infinity", "WorkingDirectory=/opt/sinew/data", "KillSignal=SIGTERM"):
            self.assertIn(line + "\n", out)
        self.assertEqual(self.log(), "")


class Fetch(Board):
    def setUp(self):
        super().setUp()
        self.files = {}
        self.record("runs/desk-1/run.mcap", 300_000)
        self.record("runs/desk-1/ring-1.mcap", 1000)
        self.record("runs/desk 2/run.mcap", 0)
        self.record("faults/desk-3/fault.json", 70)
        self.record("other/file", 70, wanted=False)

    def record(self, name, size, wanted=True, age_s=3600):
        path = self.dir / "data" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(os.urandom(size))
        os.utime(path, (time.time() - age_s,) * 2)
        if wanted:
            self.files[name] = path.read_bytes()

    def expect_all_here(self):
        for name, content in self.files.items():
            self.assertEqual((self.here / name).read_bytes(), content, name)
        self.assertEqual(list(self.here.rglob("*.part")), [])

    def test_brings_what_is_not_here_yet_and_nothing_twice(self):
        for fault in ("noise", ""):
            self.fault = fault
            code, out, err = self.fetch()
            self.assertEqual(code, 0, out + err)
            self.expect_all_here()
        self.assertIn("4 files are here already, 0 to fetch", out)
        self.assertFalse((self.here / "other").exists())

    def test_goes_on_where_the_connection_broke(self):
        self.fault = "breaks:250000"
        code, _, err = self.fetch()
        self.assertEqual(code, 1)
        self.assertIn("the connection broke", err)
        part = self.here / "runs/desk-1/run.mcap.part"
        self.assertGreater(part.stat().st_size, 200_000)
        self.fault = ""
        code, out, err = self.fetch()
        self.assertEqual(code, 0, out + err)
        self.expect_all_here()
        self.assertRegex(out, r"3 files are here already, 1 to fetch, 0\.0 MiB", "not the whole again")

    def test_a_part_that_is_not_the_boards_is_begun_anew(self):
        part = self.here / "runs/desk-1/run.mcap.part"
        part.parent.mkdir(parents=True)
        part.write_bytes(b"something else")
        code, _, err = self.fetch()
        self.assertEqual(code, 1)
        self.assertIn("what came is not what the board has", err)
        self.assertFalse(part.exists())
        self.assertEqual(self.fetch()[0], 0)
        self.expect_all_here()

    def test_a_file_that_is_here_with_another_size_is_left_alone(self):
        mine = self.here / "runs/desk-1/run.mcap"
        mine.parent.mkdir(parents=True)
        mine.write_bytes(b"mine")
        code, _, err = self.fetch()
        self.assertEqual(code, 1)
        self.assertIn("runs/desk-1/run.mcap is here with another size: left alone", err)
        self.assertEqual(mine.read_bytes(), b"mine")
        self.assertTrue((self.here / "runs/desk-1/ring-1.mcap").exists(), "the others come")

    def test_a_run_that_is_being_recorded_waits(self):
        self.record("runs/desk-9/run.mcap", 500, wanted=False, age_s=-60)
        code, out, err = self.fetch()
        self.assertEqual(code, 0, err)
        self.assertIn("runs/desk-9 is being recorded: left for the next time", out)
        self.assertFalse((self.here / "runs/desk-9").exists())

    def test_names_that_lead_elsewhere_are_refused(self):
        self.tool("find", 'echo "4 100 ../../escaped"; echo "4 100 /tmp/escaped"; echo nonsense')
        code, _, err = self.fetch()
        self.assertEqual(code, 1)
        self.assertEqual(err.count("not a file of a run: "), 3 * 2, err)
        self.assertFalse((self.here.parent.parent / "escaped").exists())

    def test_into_another_folder_from_another_folder(self):
        (self.dir / "data").rename(self.board / "card")
        code, out, err = self.sinew("--data", self.board / "card", f"--fetch={self.here}/got")
        self.assertEqual(code, 0, out + err)
        self.assertTrue((self.here / "got/runs/desk-1/run.mcap").exists())
        code, _, err = self.sinew("--data", "/no/such/folder", "--fetch")
        self.assertEqual(code, 2)
        self.assertIn("there is no folder of runs", err)



class Team(Board):
    """Three boards with one command."""
    NAMES = ("ant", "bee", "cat")

    def setUp(self):
        super().setUp()
        lines = []
        for name in self.NAMES:
            folder = self.board / f"pi@{name}"
            (folder / "bin").mkdir(parents=True)
            (folder / "log").touch()
            for tool in (self.board / "bin").iterdir():
                shutil.copy(tool, folder / "bin" / tool.name)
            (self.here / f"{name}.toml").write_text(ROBOT.replace('name = "desk"', f'name = "{name}"'))
            lines += [f"[robot.{name}]", f'host = "pi@{name}"', f'file = "{name}.toml"', ""]
        self.team = self.here / "team.toml"
        self.team.write_text("\n".join(lines))

    def run_team(self, *arguments):
        environment = dict(os.environ, FAKE_BOARD=str(self.board), FAKE_BOARDS=str(self.board), FAKE_FAULT=self.fault)
        done = subprocess.run([SINEW, "deploy", str(self.team), "--dir", "opt/sinew", *map(str, arguments), "--ssh", SSH],
                              capture_output=True, text=True, timeout=280, env=environment, cwd=self.here)
        return done.returncode, done.stdout, done.stderr

    def on(self, name):
        return self.board / f"pi@{name}/opt/sinew"

    def ends(self, out):
        """What the table at the end says of each robot."""
        return {line.split()[0]: line.split(None, 2)[2] for line in out.splitlines()[-len(self.NAMES):]}

    def test_each_robot_comes_to_its_own_board(self):
        code, out, err = self.run_team("--board", "linux")
        self.assertEqual(code, 0, out + err)
        self.assertEqual(self.ends(out), dict.fromkeys(self.NAMES, "done"))
        for name in self.NAMES:
            self.assertIn(f'name = "{name}"', (self.on(name) / f"app/{name}.toml").read_text())
            self.assertFalse(any((self.on(name) / f"app/{other}.toml").exists() for other in self.NAMES if other != name))

    def test_a_board_that_is_off_does_not_keep_the_others_from_theirs(self):
        self.fault = "pi@bee=unreachable"
        code, out, err = self.run_team("--board", "linux")
        self.assertEqual(code, 1, out + err)
        self.assertEqual(self.ends(out), {"ant": "done", "bee": "not begun", "cat": "done"})
        self.assertIn("cannot be reached", err)
        self.fault = ""
        self.assertEqual(self.run_team("--board", "linux")[0], 0)
        self.assertEqual([os.readlink(self.on(name) / "app") for name in self.NAMES], ["version-2", "version-1", "version-2"])
        code, out, err = self.run_team("--rollback")
        self.assertEqual((code, self.ends(out)), (1, {"ant": "done", "bee": "failed", "cat": "done"}), err)

    def test_what_is_wrong_with_the_file_is_said_before_anything_is_sent(self):
        good = self.team.read_text()
        for text, words in ((good.replace('"pi@bee"', '"pi@ant"'), "another board for each robot"),
                            (good.replace("host", "hots", 1), "robot.ant.hots"),
                            (good.replace('file = "ant.toml"', ""), "robot.ant.file"),
                            ("", "a table [robot.NAME] for each robot"), ("[robot", "team.toml:1")):
            self.team.write_text(text)
            code, _, err = self.run_team("--board", "linux")
            self.assertEqual(code, 2, err)
            self.assertIn(words, err)
        self.team.write_text(good)
        code, _, err = self.run_team(self.robot)
        self.assertEqual(code, 2)
        self.assertIn("names the robot files", err)
        self.assertEqual([(self.board / f"pi@{name}/log").read_text() for name in self.NAMES], [""] * 3)

    def test_the_records_of_all_come_back_and_are_executed_again_to_the_same(self):
        for seed, name in enumerate(self.NAMES):
            runs = self.on(name) / "data/runs"
            subprocess.run([SINEW, "run", f"{SOURCE}/robots/seesaw/seesaw.toml", "--virtual", "--duration", "2", "--seed", str(seed),
                            "--runs", str(runs), "--quiet"], capture_output=True, check=False, cwd=self.board,
                           env={k: v for k, v in os.environ.items() if k != "SINEW_RECORD"})
            for path in runs.rglob("*"):
                if not path.is_symlink():
                    os.utime(path, (time.time() - 3600,) * 2)
        code, out, err = self.run_team("--fetch=got", "--replay")
        self.assertEqual(code, 0, out + err)
        self.assertEqual(out.count("1 of 1 runs are identical"), 3, out)
        for name in self.NAMES:
            here, there = ([(p.name, p.read_bytes()) for p in sorted(folder.rglob("run.mcap")) if not p.parent.is_symlink()]
                           for folder in (self.here / "got" / name, self.on(name) / "data"))
            self.assertEqual(here, there)
        broken = next((self.here / "got/bee").rglob("run.mcap"))
        broken.write_bytes(broken.read_bytes()[:5000])
        code, out, err = self.run_team("--fetch=got", "--replay")
        self.assertEqual(code, 1, out + err)
        self.assertEqual(self.ends(out)["bee"], "failed")
        self.assertEqual(self.ends(out)["ant"], "done")

    def test_replay_alone_means_nothing(self):
        code, _, err = self.run_team("--replay")
        self.assertEqual(code, 2)
        self.assertIn("--fetch", err)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]] + sys.argv[3:])
