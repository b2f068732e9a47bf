#!/usr/bin/env python3
"""Feeds include_direction.py small trees with one wrong line each and expects that line to be named."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECKER = pathlib.Path(__file__).with_name("include_direction.py")


TABLE = """# a comment
msg: | messages
math: | mathematics
hal: msg | interfaces
hal/linux: hal | the system
hal/wince_stub: hal | another
rt: hal math msg | the runtime
vision: rt math msg | images
vision/opencv: vision | with OpenCV
control: rt math msg | loops
sim_hil: hal msg | the protocol
sim_hil/board: sim_hil hal | the robot's side
sim_hil/worlds: hal math msg | worlds
apps/robot_file: rt | robot files
apps/sim: sim_hil hal/linux | a simulator
apps: apps/robot_file control vision hal/linux | all
"""


class IncludeDirection(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.write("cmake/rooms.txt", TABLE)
        for room, sees in (line.split("|")[0].split(":") for line in TABLE.splitlines()[1:]):
            self.write(f"{room}/any.hpp", "".join(f'#include "{other}/any.hpp"\n' for other in sees.split()))
        for header in ["msg/time.hpp", "math/sin.hpp", "hal/clock.hpp", "hal/linux/process.hpp", "rt/topic.hpp",
                       "control/filter.hpp", "vision/blob.hpp", "apps/robot_file/robot_file.hpp", "sim_hil/protocol.hpp", "sim_hil/board/board.hpp"]:
            self.write(header, "#pragma once\n")

    def tearDown(self):
        self.folder.cleanup()

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def run_checker(self):
        done = subprocess.run([sys.executable, CHECKER, self.root], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout

    def refuses(self, path, text, line, says):
        self.write(path, text)
        code, out = self.run_checker()
        self.assertEqual(code, 1, out)
        named = [row for row in out.splitlines() if row.startswith(f"{path}:{line}: ")]
        self.assertEqual(len(named), 1, out)
        self.assertIn(says, named[0])
        self.assertIn(" 1 problems", out)

    def accepts(self, path, text):
        self.write(path, text)
        code, out = self.run_checker()
        self.assertEqual(code, 0, out)

    def test_an_arrow_that_points_up_is_named(self):
        self.refuses("rt/a.cpp", '#include "rt/topic.hpp"\n#include "control/filter.hpp"\n', 2,
                     "rt may not include control (allowed: hal, math, msg)")

    def test_rooms_side_by_side_do_not_see_each_other(self):
        self.refuses("vision/a.cpp", '#include "control/filter.hpp"\n', 1, "vision may not include control")

    def test_control_does_not_see_the_hal(self):
        self.refuses("control/a.hpp", '#include "hal/clock.hpp"\n', 1, "control may not include hal")

    def test_rt_does_not_see_the_linux_part_of_the_hal(self):
        self.refuses("rt/a.cpp", '#include "hal/linux/process.hpp"\n', 1, "rt may not include hal/linux")

    def test_nothing_includes_the_apps(self):
        self.refuses("sim_hil/a.cpp", '#include "apps/robot_file/robot_file.hpp"\n', 1, "sim_hil may not include apps")

    def test_the_sim_board_does_not_see_the_simulator(self):
        self.write("sim_hil/worlds/world.hpp", "#pragma once\n")
        self.refuses("sim_hil/board/a.cpp", '#include "sim_hil/worlds/world.hpp"\n', 1,
                     "sim_hil/board may not include sim_hil/worlds (allowed: sim_hil, hal)")

    def test_only_the_simulators_program_opens_real_sockets(self):
        self.accepts("apps/sim/main.cpp", '#include "hal/linux/process.hpp"\n')
        self.refuses("sim_hil/worlds/world.cpp", '#include "hal/linux/process.hpp"\n', 1, "may not include hal/linux")

    def test_tests_include_the_apps_and_apps_not_the_tests(self):
        self.accepts("tests/apps/a_test.cpp", '#include "apps/robot_file/robot_file.hpp"\n')
        self.write("tests/rt/tools.hpp", "")
        self.refuses("apps/a.cpp", '#include "tests/rt/tools.hpp"\n', 1, "apps may not include tests")

    def test_the_command_line_and_tests_include_every_room(self):
        for room in ["apps", "tests/rt", "examples", "bench"]:
            self.accepts(f"{room}/a.cpp", '#include "hal/linux/process.hpp"\n#include "vision/blob.hpp"\n#include <unistd.h>\n')

    def test_an_include_without_its_room_is_named(self):
        self.refuses("rt/a.cpp", '#include "topic.hpp"\n', 1, "with its room")
        self.write("rt/a.cpp", "")
        self.refuses("rt/b.cpp", '#include "../msg/time.hpp"\n', 1, "with its room")

    def test_our_header_in_angle_brackets_is_named(self):
        self.refuses("hal/a.cpp", "#include <control/filter.hpp>\n", 1, "is ours")

    def test_a_header_that_does_not_exist_is_named(self):
        self.refuses("rt/a.cpp", '#include "msg/nothing.hpp"\n', 1, "does not exist")

    def test_posix_lives_in_hal_linux_only(self):
        for header in ["unistd.h", "sys/mman.h", "pthread.h", "linux/futex.h", "poll.h", "fcntl.h", "csignal"]:
            self.refuses("rt/a.cpp", f"#include <{header}>\n", 1, "a POSIX or Linux header is allowed only in hal/linux")
        self.write("rt/a.cpp", "")
        self.accepts("hal/linux/os.cpp", "#include <sys/mman.h>\n#include <thread>\n")

    def test_no_room_sees_windows_headers_and_its_own_part_no_c_header(self):
        for header in ["windows.h", "winsock2.h", "process.h"]:
            self.refuses("rt/a.cpp", f"#include <{header}>\n", 1, "a header of Windows is allowed in no room")
        (self.root / "rt/a.cpp").unlink()
        self.accepts("tests/hal/facts.cpp", "#include <winsock2.h>\n#include <windows.h>\n")
        self.refuses("hal/wince_stub/os.cpp", "#include <errno.h>\n", 1, "a C header")
        for header in ["mutex", "condition_variable", "filesystem"]:
            self.refuses("hal/wince_stub/os.cpp", f"#include <{header}>\n", 1, "Windows CE lacks")
        self.accepts("hal/wince_stub/os.cpp", "#include <array>\n#include <cstring>\n")

    def test_the_c_librarys_mathematics_is_not_in_rt_control_vision(self):
        for room in ["rt", "control", "vision"]:
            self.refuses(f"{room}/a.cpp", "\n#include <cmath>\n", 2, "use math/")
            self.write(f"{room}/a.cpp", "")

    def test_distributions_clocks_and_threads_are_not_in_the_core(self):
        for header in ["random", "ctime", "thread", "mutex", "condition_variable"]:
            self.refuses("control/a.cpp", f"#include <{header}>\n", 1, "is not allowed in control")

    def test_durations_are_allowed_and_clocks_are_not(self):
        self.accepts("vision/a.cpp", "#include <chrono>\nstd::chrono::milliseconds age;\n")
        self.refuses("vision/a.cpp", "#include <chrono>\nauto t = std::chrono::steady_clock::now();\n", 2, "steady_clock")

    def test_libraries_stay_where_they_belong(self):
        self.refuses("rt/a.cpp", "#include <Eigen/Core>\n", 1, "Eigen")
        self.write("rt/a.cpp", "")
        self.refuses("control/a.cpp", "#include <opencv2/core.hpp>\n", 1, "OpenCV")
        self.write("control/a.cpp", "")
        self.accepts("vision/opencv/view.hpp", "#include <opencv2/core/mat.hpp>\n")
        self.refuses("vision/blob.cpp", "#include <opencv2/core/mat.hpp>\n", 1, "OpenCV")

    def test_a_line_with_a_star_is_for_each_folder_there_and_for_its_own(self):
        self.write("cmake/rooms.txt", TABLE + "robots/*: rt | a robot\nrobots/*/world: robots/* math | its world\n")
        self.write("robots/cat/cat.hpp", '#include "rt/any.hpp"\n')
        self.write("robots/dog/dog.hpp", "")
        self.accepts("robots/cat/world/world.cpp", '#include "robots/cat/cat.hpp"\n#include "math/any.hpp"\n')
        self.refuses("robots/cat/world/world.cpp", '#include "robots/dog/dog.hpp"\n', 1,
                     "robots/cat/world may not include robots/dog (allowed: robots/cat, math)")

    def test_a_folder_that_is_in_no_line_of_the_table_is_named(self):
        self.write("rt/deep/a.cpp", "")
        code, out = self.run_checker()
        self.assertEqual(code, 1, out)
        self.assertIn("rt/deep/a.cpp:1: its folder is no room", out)

    def test_an_arrow_that_nobody_needs_is_named(self):
        self.write("rt/any.hpp", '#include "hal/any.hpp"\n#include "msg/any.hpp"\n')
        code, out = self.run_checker()
        self.assertEqual(code, 1, out)
        self.assertIn("rt includes nothing of math: take it out", out)

    def test_a_circle_is_named(self):
        self.write("cmake/rooms.txt", TABLE.replace("msg: |", "msg: hal |"))
        self.write("msg/any.hpp", '#include "hal/any.hpp"\n')
        code, out = self.run_checker()
        self.assertEqual(code, 1, out)
        self.assertIn("these see each other in a circle: msg, hal", out)

    def test_a_line_that_cannot_be_read_is_named(self):
        for line in ["rt hal | no colon", "new: nowhere | sees what is not there", "rt: hal | twice", "empty: |"]:
            self.write("cmake/rooms.txt", TABLE + line + "\n")
            done = subprocess.run([sys.executable, CHECKER, self.root], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1, line)
            self.assertIn("rooms.txt", done.stderr, line)

    def test_a_folder_of_more_than_60_sources_is_named(self):
        for i in range(61):
            self.write(f"rt/file_{i}.cpp", "")
        code, out = self.run_checker()
        self.assertEqual(code, 1, out)
        self.assertRegex(out, "rt:1: 6[0-9] sources in one folder, at most 60")

    def test_comments_and_strings_are_not_code(self):
        self.accepts("rt/a.cpp", '// #include "control/filter.hpp"\n/*\n#include <cmath>\nsteady_clock */\n'
                                 'const char* s = "steady_clock";\n')

    def test_an_include_after_a_comment_with_a_quote_is_still_read(self):
        self.refuses("rt/a.cpp", "// it's\n#include <cmath>  // don't\n", 2, "use math/")

    def test_an_empty_tree_is_not_a_pass(self):
        with tempfile.TemporaryDirectory() as empty:
            (pathlib.Path(empty) / "cmake").mkdir()
            (pathlib.Path(empty) / "cmake/rooms.txt").write_text("")
            done = subprocess.run([sys.executable, CHECKER, empty], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1, done.stdout)


if __name__ == "__main__":
    unittest.main()
