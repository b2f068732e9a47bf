#!/usr/bin/env python3
"""Checks tests/boards/boot.sh against its head comment, with our program in qemu's place: how it ends, and what it leaves.

The script runs from a folder with its input files and a board that was set up before; it fetches nothing.
"""
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# A shell that starts the tests in the background hands SIGINT down as ignored, and a shell cannot take it back.
signal.signal(signal.SIGINT, signal.SIG_DFL)
NEEDED = ["tests/boards/boot.sh", "tests/boards/setup.sh", "tests/boards/init", "tests/vm/kernel.sh", "tools/lib.sh",
          "tools/own_apt.sh"]

# A board as boot.sh sees it: BOARD says how it ends.
QEMU = """#!/bin/bash
for word in "$@"; do
  case $word in
    local,id=out,path=*) out=${word#local,id=out,path=} out=${out%%,*} ;;
    file:*) console=${word#file:} ;;
  esac
done
echo booting >"$console"
if [[ $BOARD == hangs ]]; then
  echo $$ >"$HERE/pid"
  exec sleep 60
fi
[[ $BOARD != dies ]] || exit 3
echo said >"$out/stdout" && echo complained >"$out/stderr" && echo "$STATUS" >"$out/status"
echo "$UNALIGNED" >"$out/unaligned" && : >"$out/kernel.log"
echo 'board: came to its end' >>"$console"
"""


def until(what):
    """Waits until this is true."""
    end = time.monotonic() + 10
    while not what():
        if time.monotonic() > end:
            raise AssertionError("it did not come to that in 10 s")
        time.sleep(0.02)


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "\nState:\tZ" not in pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii")


class Init(unittest.TestCase):
    """tests/boards/init with stand-ins for all programs that it calls, and no others in its path: the order of its mounts.

    It ends when it asks the network.
    """

    CALLS = ["busybox", "mount", "mkdir", "ln", "insmod", "ip", "poweroff"]

    def mounts(self, source):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        here = pathlib.Path(holder.name)
        for call in self.CALLS:
            (here / call).write_text(f'#!/bin/sh\necho {call} "$@" >>{here}/calls\n', encoding="ascii")
        (here / "ping").write_text("#!/bin/sh\nkill $PPID\n", encoding="ascii")
        (here / "cat").symlink_to("/bin/cat")
        for call in [*self.CALLS, "ping"]:
            (here / call).chmod(0o755)
        (here / "cmdline").write_text(f"console=ttyS0 board.source={source} quiet\n", encoding="ascii")
        (here / "order").touch()
        text = (ROOT / "tests/boards/init").read_text(encoding="utf-8")
        for there, mine in (("/bin/busybox --", f"{here}/busybox --"), ("PATH=/bin\n", f"PATH={here}\n"),
                            ("/proc/cmdline", f"{here}/cmdline"), ("/modules/order", f"{here}/order"),
                            (">/run/ping", f">{here}/said")):
            self.assertIn(there, text)
            text = text.replace(there, mine)
        (here / "init").write_text(text, encoding="utf-8")
        subprocess.run(["sh", str(here / "init")], check=False, capture_output=True, timeout=60)
        return [line.split() for line in (here / "calls").read_text(encoding="utf-8").splitlines()]

    def test_a_checkout_below_the_temporary_folder_is_not_hidden(self):
        for source in ("/tmp/a/checkout", "/run/checkout", "/dev/shm/checkout", "/home/me/checkout"):
            made, mounted = [], []
            for call, *words in self.mounts(source):
                if call == "mkdir":
                    made += words
                elif call == "mount":  # files below its folder are hidden from now on
                    place = words[-1]
                    made = [folder for folder in made if not folder.startswith(place + "/")]
                    mounted = [other for other in mounted if not other.startswith(place + "/")] + [place]
                    if place == source:
                        self.assertIn(source, made, "there is no folder to mount the checkout on")
            self.assertIn(source, mounted)


class Boot(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.here = pathlib.Path(holder.name)
        for name in NEEDED:
            (self.here / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.here / name)
        self.board = self.here / "build/boards/mipsel"
        for folder in (self.board / "boot", self.here / "build/sysroot/mipsel", self.here / "bin"):
            folder.mkdir(parents=True)
        (self.board / "boot/vmlinux-1").touch()
        (self.board / "initramfs.gz").touch()  # newer than its sources
        qemu = self.here / "bin/qemu-system-mipsel"
        qemu.write_text(QEMU, encoding="ascii")
        qemu.chmod(0o755)

    def job(self):
        return (self.board / "out/job").read_text(encoding="utf-8")

    def start(self, *words, how="well", status=0, unaligned=0):
        environment = {**os.environ, "PATH": f"{self.here}/bin:{os.environ['PATH']}", "HERE": str(self.here), "BOARD": how,
                       "STATUS": str(status), "UNALIGNED": str(unaligned)}
        environment.pop("SINEW_SYSROOTS", None)
        process = subprocess.Popen([self.here / "tests/boards/boot.sh", *words], stdout=subprocess.PIPE, text=True,
                                   stderr=subprocess.PIPE, env=environment, start_new_session=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.terminate)
        return process

    def boot(self, *words, **how):
        process = self.start(*(words or ("mipsel", "true")), **how)
        out, err = process.communicate(timeout=60)
        return process.returncode, out, err

    def hanging(self):
        """A boot that runs, and qemu's process in it."""
        process = self.start("mipsel", "true", how="hangs")
        until(lambda: (self.here / "pid").exists() and (self.here / "pid").read_text(encoding="ascii").strip())
        return process, int((self.here / "pid").read_text(encoding="ascii"))

    def test_the_commands_words_and_exit_code_are_its_own(self):
        self.assertEqual(self.boot(status=7), (7, "said\n", "complained\n"))
        self.assertEqual(self.boot()[0], 0)

    def test_a_program_has_to_be_where_the_board_sees_it(self):
        program = self.here / "build/p"
        program.touch()
        self.assertEqual(self.boot("mipsel", str(program), "two words")[0], 0)
        self.assertEqual(self.job(), f"cp {program} /tmp/\nexec /tmp/p two\\ words\n")
        with tempfile.TemporaryDirectory() as elsewhere:
            os.symlink(self.here, f"{elsewhere}/way")
            self.assertEqual(self.boot("mipsel", f"{elsewhere}/way/build/p")[0], 0)
            self.assertEqual(self.job(), f"cp {program} /tmp/\nexec /tmp/p\n")
            pathlib.Path(elsewhere, "p").touch()
            code, _, err = self.boot("mipsel", f"{elsewhere}/p")
        self.assertEqual((code, err), (1, f"boot.sh: {elsewhere}/p: not below {self.here}, which is what the board sees\n"))

    def test_a_board_that_does_not_come_to_its_end_is_125(self):
        code, _, err = self.boot(how="dies")
        self.assertEqual(code, 125)
        self.assertIn("mipsel did not come to its end (qemu: 3", err)
        code, _, err = self.boot("--limit", "0.2", "mipsel", "true", how="hangs")
        self.assertEqual(code, 125)
        self.assertIn("stopped after 0.2 s", err)

    def test_reads_across_words_fail_a_run_that_was_well(self):
        code, out, err = self.boot(unaligned=3)
        self.assertEqual((code, out), (124, "said\n"))
        self.assertIn("3 reads or writes across words", err)
        self.assertEqual(self.boot(unaligned=3, status=7)[0], 7)

    def test_a_board_that_runs_keeps_its_folder_when_somebody_else_wants_it(self):
        self.hanging()
        before = sorted(path.name for path in (self.board / "out").iterdir())
        self.assertIn("job", before)
        code, _, err = self.boot("mipsel", "false")
        self.assertEqual((code, err), (1, "boot.sh: mipsel is running already\n"))
        self.assertEqual(sorted(path.name for path in (self.board / "out").iterdir()), before)
        self.assertIn("true", self.job())

    def test_the_emulator_ends_with_it(self):
        for how in (signal.SIGTERM, signal.SIGINT):
            process, qemu = self.hanging()
            (self.here / "pid").unlink()
            os.killpg(process.pid, how)  # as a terminal does it; qemu is in its own group
            process.communicate(timeout=30)
            self.assertEqual(process.returncode, -how)
            until(lambda: not alive(qemu))  # pylint: disable=cell-var-from-loop

    def test_a_first_file_system_that_could_not_be_packed_is_packed_again(self):
        for path in (self.board / "lib/modules/1", self.board / "busybox"):
            path.mkdir(parents=True) if path.name == "1" else path.touch()
        os.utime(self.board / "initramfs.gz", (1, 1))  # older than its first program
        os.utime(self.here / "tests/boards/setup.sh", (0, 0))
        for name, text in (("modprobe", "#!/bin/sh\n"), ("cpio", "#!/bin/sh\ncat >/dev/null\nexit 1\n")):
            (self.here / "bin" / name).write_text(text, encoding="ascii")
            (self.here / "bin" / name).chmod(0o755)
        for _ in range(2):
            code, _, err = self.boot()
            self.assertEqual(code, 1, err)
            self.assertIn("no kernel to boot", err)
        (self.here / "bin/cpio").write_text("#!/bin/sh\ncat\n", encoding="ascii")
        self.assertEqual(self.boot()[:2], (0, "said\n"))
        self.assertGreater((self.board / "initramfs.gz").stat().st_size, 0)

    def test_wrong_calls_are_told(self):
        for words, said in ((["--limit", "soon", "mipsel", "true"], "soon: no number of seconds"),
                            (["--limit"], "--limit: nothing: no number of seconds"), (["--fast", "mipsel"], "--fast: --limit SECONDS or --shell"),
                            (["sparc", "true"], "sparc: arm64, armhf or mipsel"), (["mipsel"], "which command runs on mipsel?")):
            code, out, err = self.boot(*words)
            self.assertEqual((code, out), (1, ""))
            self.assertIn(said, err)
        self.assertFalse((self.board / "out").exists())


if __name__ == "__main__":
    unittest.main()
