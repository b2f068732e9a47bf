#!/usr/bin/env python3
"""Pictures of programs of others, under Xvfb: what ./test stage grab runs.

usage: grab_test.py BUILD ROOT [unittest option...]     BUILD: build/release, with sinew and grab_probe
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

BUILD, ROOT = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
SINEW, PROBE = BUILD / "bin/sinew", BUILD / "tests/grab/grab_probe"
LIBRARY = next(BUILD.glob("lib/*/sinew/libsinew_grab.so"))
PROGRAMS = ROOT / "tests/grab/programs"
WORK = pathlib.Path(tempfile.mkdtemp(prefix="sinew-grab-"))
NS = 1e-9
TREES = pathlib.Path(os.environ.get("SINEW_SYSROOTS", ROOT / "build/sysroot")).resolve()
TREE_32, TREE_WINE_32 = TREES / "i386-gl", TREES / "i386"
HAS_32 = (BUILD / "lib/i386-linux-gnu/sinew/libsinew_grab.so").exists()
WINE = shutil.which("wine64") or ("/usr/lib/wine/wine64" if os.path.exists("/usr/lib/wine/wine64") else None)


def compiled(name, *options, compiler="gcc", ending=""):
    out = WORK / (name + ending)
    subprocess.run([compiler, "-O2", "-Wall", "-Wextra", "-o", out, PROGRAMS / (name + ".c"), *options], check=True)
    return out


def flags(package):
    return subprocess.run(["pkg-config", "--cflags", "--libs", package], check=True, capture_output=True, text=True).stdout.split()


def setUpModule():
    global display
    os.environ["SINEW_RUN_DIR"] = str(WORK / "run")
    os.environ["WINEPREFIX"], os.environ["WINEDEBUG"] = str(WORK / "wine"), "-all"
    read, write = os.pipe()
    display = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x960x24", "-nolisten", "tcp"],
                               pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as number:
        os.environ["DISPLAY"] = ":" + number.readline().strip()


def tearDownModule():
    if WINE:
        server = shutil.which("wineserver") or "/usr/lib/wine/wineserver64"
        subprocess.run([server, "-k"], check=False, capture_output=True)
    display.terminate()
    display.wait()
    shutil.rmtree(WORK, ignore_errors=True)


class Grabbed:
    """A program under sinew grab, and what it says of its swaps: {number: (before, after, width, height)} of a window."""

    def __init__(self, command, *options, name="test", window=0):
        self.out = tempfile.TemporaryFile("w+", dir=WORK)
        self.errors = tempfile.TemporaryFile("w+", dir=WORK)
        self.window = window
        self.process = subprocess.Popen([SINEW, "grab", "--name", name, *options, *map(str, command)],
                                        stdout=self.out, stderr=self.errors)

    def __enter__(self):
        end = time.monotonic() + 90  # Wine makes its folder first
        while time.monotonic() < end:
            if re.search(r"grab: \S+ window|grab: .*: window", self.said()):
                return self
            if self.process.poll() is not None:
                break
            time.sleep(0.02)
        raise AssertionError("no window: " + self.said())

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            self.code = self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise
        finally:
            self.last_said, self.last_swaps = self.said(), self.swaps()
            self.out.close()
            self.errors.close()

    def said(self):
        if self.errors.closed:
            return self.last_said
        self.errors.seek(0)
        return self.errors.read()

    def swaps(self):
        if self.out.closed:
            return self.last_swaps
        self.out.seek(0)
        found = re.findall(r"^swap (\d+) (\d+) (\d+) (\d+) (\d+) (\d+)$", self.out.read(), re.M)
        return {int(n): (int(b), int(a), int(w), int(h)) for n, b, a, w, h, window in found}


FIELDS = ["number", "upper", "lower", "shown", "there", "swap", "width", "height", "window", "read"]


def pictures(count, how="view", rate=30, region=None, window=-1, name="test", title=""):
    command = [PROBE, name, str(count), how, str(rate), region or "0,0,0,0", str(window), title]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if done.returncode != 0:
        raise AssertionError(f"{command}: {done.returncode}: {done.stderr}")
    return [dict(zip(FIELDS, map(int, line.split()[1:]))) for line in done.stdout.splitlines()]


def windows():
    """Of the session `test`, as `sinew grab --list --json` says."""
    done = subprocess.run([SINEW, "grab", "--list", "--json"], capture_output=True, text=True, check=True)
    return {w["window"]: w for session in json.loads(done.stdout) if session["name"] == "test" for w in session["windows"]}


def titles(count=1):
    """The titles of so many windows: they come a moment after their windows."""
    end = time.monotonic() + 10
    while time.monotonic() < end:
        found = {n: w["title"] for n, w in windows().items() if w["title"]}
        if len(found) >= count:
            return found
        time.sleep(0.05)
    raise AssertionError(f"{found}")


class Base(unittest.TestCase):
    def check(self, seen, swaps, slack_ns=1_000_000):
        """Whole, in order, stamped between the program's own times around the swap, and not before it was asked for."""
        for p in seen:
            self.assertGreater(p["upper"], 0, p)
            self.assertEqual(p["upper"], p["lower"], "torn")
        numbers = [p["upper"] for p in seen]
        self.assertEqual(numbers, sorted(set(numbers)), "in order, none twice")
        self.assertEqual([p["number"] for p in seen], list(range(len(seen))))
        for p in seen:
            if p["upper"] not in swaps:
                continue  # the program's line came later than we looked
            before, after = swaps[p["upper"]][:2]
            self.assertGreaterEqual(p["shown"], before - slack_ns)
            self.assertLessEqual(p["shown"], after + slack_ns)
            self.assertGreaterEqual(p["read"], p["shown"])


class OwnProgram(Base):
    @classmethod
    def setUpClass(cls):
        cls.bars = compiled("bars_glx", "-lGL", "-lX11")

    def test_order_age_and_wholeness_by_the_shared_memory(self):
        with Grabbed([self.bars, 1000, 60, 640, 480]) as grabbed:
            seen = pictures(60)
            self.check(seen, grabbed.swaps())
            every = pictures(60, rate=0)
            self.check(every, grabbed.swaps())
        # Every picture that the program shows: no number is left out, but where the reader was late.
        steps = [b["upper"] - a["upper"] for a, b in zip(every, every[1:])]
        self.assertEqual(sorted(steps)[len(steps) // 2], 1)
        # 30 of 60: two frames from one to the next.
        steps = [b["upper"] - a["upper"] for a, b in zip(seen, seen[1:])]
        self.assertEqual(sorted(steps)[len(steps) // 2], 2)

    def test_buffered_pictures_are_one_frame_later_and_the_same_otherwise(self):
        with Grabbed([self.bars, 1000, 60, 640, 480], "--read", "buffered") as grabbed:
            seen = pictures(40)
            self.check(seen, grabbed.swaps())
        for p in seen:
            self.assertGreater(p["there"], p["shown"] + 1_000_000, "a frame of 16 ms between")

    def test_a_robots_camera_gets_the_same(self):
        with Grabbed([self.bars, 1000, 60, 640, 480]) as grabbed:
            self.check(pictures(60, "camera"), grabbed.swaps())

    def test_a_robot_file_names_the_program_as_its_camera(self):
        robot = WORK / "eye.toml"
        robot.write_text("""robot = { name = "eye", board = "linux" }
[[thread]]
name = "vision"
priority = 40
device = "camera"
order = ["camera"]
[module.camera]
type = "drivers::CameraSource"
exec_us = 1000
[topic."camera.raw"]
image = { width = 320, height = 240, format = "mono8" }
[device.camera]
driver = "grab"
name = "test"
width = 320
height = 240
format = "mono8"
rate_hz = 30
""")
        with Grabbed([self.bars, 1000, 60, 640, 480]):
            done = subprocess.run([SINEW, "run", robot, "--duration", "6", "--plain", "--runs", WORK / "runs"],
                                  env={**os.environ, "SINEW_RECORD": "on"}, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        info = subprocess.run([SINEW, "bag", "info", WORK / "runs/latest/run.mcap"], capture_output=True, text=True, check=True).stdout
        count = int(re.search(r"camera\.raw/head +\S+ +(\d+)", info)[1])
        self.assertGreater(count, 45, info)

    def test_the_age_of_a_picture_is_that_of_its_reading(self):
        with Grabbed([self.bars, 1000, 60, 640, 480]):
            seen = pictures(60, "view")
        ages = sorted(p["read"] - p["shown"] for p in seen)
        self.assertLess(ages[len(ages) // 2] * NS, 0.016, "most are read before the next frame is shown")

    def test_a_resolution_that_changes_is_said_and_the_picture_follows(self):
        with Grabbed([self.bars, 1000, 60, 640, 480, "--resize", 120, "320x240"]) as grabbed:
            seen = pictures(120)
            self.check(seen, grabbed.swaps())
        sizes = [(p["width"], p["height"]) for p in seen]
        self.assertEqual(sizes[0], (640, 480))
        self.assertEqual(sizes[-1], (320, 240))

    def test_a_part_of_a_window_and_several_views_of_it_at_once(self):
        with Grabbed([self.bars, 2000, 60, 640, 480]) as grabbed:
            probes = [subprocess.Popen([PROBE, "test", "30", "view", "30", region], stdout=subprocess.PIPE, text=True)
                      for region in ("0,0,640,240", "0,240,640,240", "0,0,0,0")]
            seen = [[dict(zip(FIELDS, map(int, line.split()[1:]))) for line in p.communicate(timeout=30)[0].splitlines()] for p in probes]
            for view in seen:
                self.check(view, grabbed.swaps())
                self.assertEqual(len(view), 30)

    def test_each_of_several_windows_is_a_camera(self):
        with Grabbed([self.bars, 2000, 30, 320, 240, "--windows", 3]):
            for window in (0, 1, 2):
                for p in pictures(10, window=window):
                    self.assertEqual(p["upper"] // 1000, window)
                    self.assertEqual(p["upper"], p["lower"])
            listed = subprocess.run([SINEW, "grab", "--list"], capture_output=True, text=True, check=True).stdout
            self.assertEqual(len(re.findall(r"window \d: OpenGL \(GLX\) of 'bars_glx' \(process \d+\), 320x240", listed)), 3, listed)

    def test_windows_of_one_program_are_cameras_by_their_titles(self):
        names = ["Front camera", "Rear camera", "Down"]
        with Grabbed([self.bars, 3000, 60, 320, 240, "--windows", 3, "--titles", ",".join(names)]) as grabbed:
            self.assertEqual(titles(3), dict(enumerate(names)))
            listed = subprocess.run([SINEW, "grab", "--list"], capture_output=True, text=True, check=True).stdout
            self.assertRegex(listed, r"window 1: OpenGL \(GLX\) of 'bars_glx' \(process \d+\), 320x240, 'Rear camera', \d+ pictures")
            for title, window in (("Rear camera", 1), ("Front", 0), ("own", 2)):
                for p in pictures(5, "camera", title=title):
                    self.assertEqual(p["upper"] // 1000, window)
            for title, window in (("Rear", 1), ("Down", 2)):
                to = WORK / f"{window}.png"
                subprocess.run([SINEW, "grab", "--from", "test", "--title", title, "--to", to], check=True, timeout=20)
                self.assertEqual(to.read_bytes()[:4], b"\x89PNG")
            for title, words in (("Side", "no window has 'Side' in its title; there are: 'Front camera', 'Rear camera', 'Down'"),
                                 ("camera", "not one window alone has 'camera' in its title")):
                done = subprocess.run([SINEW, "grab", "--from", "test", "--title", title, "--to", WORK / "no.png"],
                                      capture_output=True, text=True, timeout=20)
                self.assertEqual(done.returncode, 1, done.stderr)
                self.assertIn(words, done.stderr)
            self.assertRegex(grabbed.said(), r"window 2: .*'Down'")

    def test_a_camera_stays_with_its_title_when_the_program_turns_them_round(self):
        with Grabbed([self.bars, 1000, 60, 320, 240, "--windows", 2, "--titles", "Front,Rear", "--turn-titles", 180]):
            seen = [p["upper"] // 1000 for p in pictures(200, "camera", title="Front")]
        self.assertEqual((seen[0], seen[-1]), (0, 1))
        self.assertEqual(seen, sorted(seen), "no way back")

    def test_the_programs_state_of_opengl_is_as_it_was(self):
        for read in ("direct", "buffered"):
            grabbed = Grabbed([self.bars, 200, 100, 320, 240, "--state"], "--read", read)
            with grabbed:
                pictures(60, rate=0)
                self.assertEqual(grabbed.process.wait(20), 0, grabbed.said())

    def test_the_programs_exit_code_is_that_of_sinew_grab(self):
        for code in (0, 7):
            done = subprocess.run([SINEW, "grab", "sh", "-c", f"exit {code}"], capture_output=True, text=True, timeout=20)
            self.assertEqual(done.returncode, code)
            self.assertIn("showed no picture", done.stderr)

    def test_a_program_that_is_killed_ends_the_session_and_the_name_is_free(self):
        with Grabbed([self.bars, 100000, 60, 320, 240]) as grabbed:
            pid = int(re.search(r"process (\d+)", grabbed.said())[1])
            os.kill(pid, signal.SIGKILL)
            self.assertEqual(grabbed.process.wait(20), 128 + 9)
        with Grabbed([self.bars, 1000, 60, 320, 240]):
            pictures(3)

    def test_what_is_wrong_is_said(self):
        for arguments, words in (([], "program"), (["no-such-program"], "no such program"), (["--name", "a/b", "true"], "letters"),
                                 (["--from", "nobody", "--to", str(WORK / "x.png")], "no program is grabbed as 'nobody'"),
                                 (["--bogus", "true"], "--bogus")):
            done = subprocess.run([SINEW, "grab", *arguments], capture_output=True, text=True, timeout=20)
            self.assertNotEqual(done.returncode, 0, arguments)
            self.assertIn(words, done.stderr, arguments)


class ProgramsOfOthers(Base):
    def picture_of(self, command, *options, environment={}):
        """One picture as PNG: its size from the header."""
        to = WORK / "picture.png"
        to.unlink(missing_ok=True)
        done = subprocess.run([SINEW, "grab", "--name", "test", "--to", str(to), "--after", "0.3", *options, *map(str, command)],
                              capture_output=True, text=True, timeout=120, env={**os.environ, **environment})
        self.assertEqual(done.returncode, 0, done.stderr)
        head = to.read_bytes()[:24]
        self.assertEqual(head[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(to.stat().st_size, 2000, "not one colour")
        return (int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")), done.stderr

    def test_glxgears(self):
        size, said = self.picture_of(["glxgears"])
        self.assertEqual(size, (300, 300))
        self.assertIn("OpenGL (GLX)", said)

    def test_es2gears(self):
        size, said = self.picture_of(["es2gears_x11"])
        self.assertEqual(size, (300, 300))
        self.assertIn("OpenGL (EGL)", said)

    def test_vkcube(self):
        for read in ("direct", "buffered"):
            size, said = self.picture_of(["vkcube"], "--read", read)
            self.assertEqual(size, (500, 500))
            self.assertIn("Vulkan", said)

    def test_titles_by_each_way_to_a_window(self):
        """The drawable itself, a GLXWindow, a surface of EGL, and one of Vulkan: behind each there is the window with the title."""
        for command, words in ((["glxgears"], "glxgears"), (["es2gears_x11"], "es2gears"), (["vkcube"], "a cube"),
                               ([compiled("bars_sdl", *flags("sdl2")), 1000], "bars"),
                               ([compiled("bars_glfw", *flags("glfw3")), 1000], "bars")):
            with self.subTest(command[0]), Grabbed(command):
                if command == ["vkcube"]:
                    subprocess.run([compiled("name_windows", "-lX11"), "a cube"], check=True, timeout=20)
                self.assertRegex(titles()[0], words)

    def test_sdl_which_opens_libgl_itself(self):
        with Grabbed([compiled("bars_sdl", *flags("sdl2")), 1000]) as grabbed:
            self.check(pictures(30), grabbed.swaps())

    def test_glfw_which_opens_libgl_itself(self):
        with Grabbed([compiled("bars_glfw", *flags("glfw3")), 1000]) as grabbed:
            self.check(pictures(30), grabbed.swaps())

    @unittest.skipUnless(WINE and shutil.which("x86_64-w64-mingw32-gcc"), "wine64 or its compiler is missing")
    def test_direct3d_9_in_wine(self):
        program = compiled("bars_d3d9", "-ld3d9", "-lgdi32", compiler="x86_64-w64-mingw32-gcc", ending=".exe")
        with Grabbed([WINE, program, 1500]):
            self.check(pictures(20), {})
            self.assertEqual(titles()[0], "bars", "the title is its parent's: Wine draws into a window within it")

    @unittest.skipUnless(WINE and shutil.which("x86_64-w64-mingw32-gcc"), "wine64 or its compiler is missing")
    def test_direct3d_11_in_wine(self):
        program = compiled("bars_d3d11", "-ld3d11", "-ldxgi", "-lgdi32", "-ldxguid", "-luuid", compiler="x86_64-w64-mingw32-gcc", ending=".exe")
        with Grabbed([WINE, program, 1500]):
            self.check(pictures(20), {})


@unittest.skipUnless(HAS_32 and TREE_32.exists(), "no g++-12-multilib, or no tree of 32 bits (toolchains/sysroot.sh i386-gl)")
class ProgramsOf32Bits(Base):
    """Debian's programs and Mesa of 32 bits, from a folder; sinew and the robot have 64."""

    picture_of = ProgramsOfOthers.picture_of

    @classmethod
    def setUpClass(cls):
        cls.libraries = TREE_32 / "usr/lib/i386-linux-gnu"
        driver = (TREE_32 / "usr/share/vulkan/icd.d/lvp_icd.i686.json").read_text()
        (WORK / "lvp_32.json").write_text(driver.replace("/usr/lib/i386-linux-gnu", str(cls.libraries)))
        cls.environment = {"LD_LIBRARY_PATH": str(cls.libraries), "LIBGL_DRIVERS_PATH": str(cls.libraries / "dri"),
                           "VK_ICD_FILENAMES": str(WORK / "lvp_32.json")}

    def test_glxgears_es2gears_and_vkcube(self):
        for program, side, words in (("glxgears.i386-linux-gnu", 300, "OpenGL (GLX)"),
                                     ("es2gears_x11.i386-linux-gnu", 300, "OpenGL (EGL)"), ("vkcube", 500, "Vulkan")):
            with self.subTest(program):
                self.assertEqual((TREE_32 / "usr/bin" / program).read_bytes()[4], 1, "not of 32 bits")
                size, said = self.picture_of([TREE_32 / "usr/bin" / program], environment=self.environment)
                self.assertEqual(size, (side, side))
                self.assertIn(words, said)

    def test_order_age_and_wholeness(self):
        bars = compiled("bars_glx", "-m32", self.libraries / "libGL.so.1", self.libraries / "libX11.so.6",
                        f"-Wl,-rpath-link,{self.libraries}", ending="_32")
        command = ["env", *(f"{name}={value}" for name, value in self.environment.items()), bars, 1000, 60, 640, 480]
        with Grabbed(command) as grabbed:
            self.check(pictures(30), grabbed.swaps())


@unittest.skipUnless(HAS_32 and TREE_32.exists() and TREE_WINE_32.exists() and shutil.which("i686-w64-mingw32-gcc"),
                     "no Wine of 32 bits or no compiler for it (tools/setup.sh windows32), or no OpenGL of 32 bits")
class Wine32(Base):
    """A 32-bit Windows program in Wine's 32-bit half, which lives in a folder of its own; sinew and the robot have 64 bits."""

    def test_direct3d_9(self):
        if subprocess.run([ROOT / "toolchains/wine32.sh", "--check"], cwd=ROOT, capture_output=True, check=False).returncode == 77:
            self.skipTest("wine32.sh needs root")
        program = compiled("bars_d3d9", "-ld3d9", "-lgdi32", compiler="i686-w64-mingw32-gcc", ending="_32.exe")
        head = program.read_bytes()
        machine = int.from_bytes(head[60:64], "little") + 4
        self.assertEqual(head[machine:machine + 2], b"\x4c\x01", "not for the i386")
        command = ["env", "-C", ROOT, ROOT / "toolchains/wine32.sh", "--see", WORK, "--see", TREE_32, "--display", os.environ["DISPLAY"],
                   "--graphics", TREE_32, program, 700]  # it ends by itself: what is the first process of its space hears no SIGTERM
        with Grabbed(command) as grabbed:
            seen = pictures(20)
            self.check(seen, {})
            self.assertIn("OpenGL (GLX) of 'bars_d3d9_32.ex", grabbed.said())
            self.assertEqual({(p["width"], p["height"]) for p in seen}, {(640, 480)})
            self.assertEqual(titles()[0], "bars")


class Library(unittest.TestCase):
    def test_it_brings_no_library_but_the_c_library_into_a_program(self):
        needed = subprocess.run(["readelf", "-d", LIBRARY], capture_output=True, text=True, check=True).stdout
        self.assertEqual(set(re.findall(r"\(NEEDED\).*\[(.*?)\]", needed)) - {"ld-linux-x86-64.so.2"}, {"libc.so.6"})

    def test_its_symbols_are_those_that_it_replaces(self):
        symbols = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
        names = {line.split()[-1] for line in symbols.splitlines()}
        for name in names:
            self.assertRegex(name, r"^(dlsym|glX\w+|egl\w+|XDestroyWindow|vkNegotiateLoaderLayerInterfaceVersion)$")

    def test_a_caller_of_rtld_next_gets_the_next_after_itself(self):
        """The C library finds the caller by its return address: a wrapper of puts() would find itself, for ever."""
        (WORK / "next.c").write_text('#define _GNU_SOURCE\n#include <dlfcn.h>\n#include <stdio.h>\nint puts(const char* s) {\n'
                                     '  int (*real)(const char*) = (int (*)(const char*))dlsym(RTLD_NEXT, "puts");\n'
                                     '  return real == puts ? 0 : real(s); }\n')
        (WORK / "says.c").write_text('#include <stdio.h>\nint main(void) { return puts("it was said") < 0; }\n')
        subprocess.run(["gcc", "-shared", "-fPIC", "-o", WORK / "libnext.so", WORK / "next.c"], check=True)
        subprocess.run(["gcc", "-fno-builtin", "-o", WORK / "says", WORK / "says.c"], check=True)
        done = subprocess.run([WORK / "says"], env={**os.environ, "LD_PRELOAD": f"{LIBRARY}:{WORK / 'libnext.so'}"},
                              capture_output=True, text=True, timeout=10)
        self.assertEqual(done.stdout, "it was said\n")


    @unittest.skipUnless(HAS_32, "no library of 32 bits: g++-12-multilib is missing")
    def test_a_program_of_32_bits_shares_its_pictures_with_a_reader_of_64(self):
        for bits in ("-m64", "-m32"):
            subprocess.run(["gcc", bits, "-O2", "-shared", "-fPIC", "-o", WORK / "libEGL.so.1", PROGRAMS / "fake_egl.c",
                            "-Wl,-soname,libEGL.so.1"], check=True)
            subprocess.run(["gcc", bits, "-O2", "-o", WORK / "bars_fake", PROGRAMS / "bars_fake.c", WORK / "libEGL.so.1",
                            f"-Wl,-rpath,{WORK}"], check=True)
            with Grabbed([WORK / "bars_fake", 2000]) as grabbed:
                seen = pictures(30)
            for p in seen:
                self.assertGreater(p["upper"], 0, p)
                self.assertEqual(p["upper"], p["lower"])
                self.assertEqual(p["upper"], p["swap"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
