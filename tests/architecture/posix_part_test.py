#!/usr/bin/env python3
"""Feeds posix_part.py a source that uses one thing of Linux and expects its name in the output. CXX: the compiler."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECKER = pathlib.Path(__file__).with_name("posix_part.py")


class PosixPart(unittest.TestCase):
    def check(self, files, listed="a.cpp  what it is\n", page="`a.cpp`, and `v4l2_*`"):
        with tempfile.TemporaryDirectory() as folder:
            room = pathlib.Path(folder, "hal/linux")
            room.mkdir(parents=True)
            pathlib.Path(folder, "docs").mkdir()
            pathlib.Path(folder, "docs/bsd.md").write_text(page, encoding="utf-8")
            (room / "posix.txt").write_text("# a comment\n" + listed, encoding="utf-8")
            for name, text in files.items():
                (room / name).write_text(text, encoding="utf-8")
            done = subprocess.run([sys.executable, CHECKER, folder, os.environ.get("CXX", "c++")], capture_output=True,
                                  text=True, check=False)
        return done.returncode, done.stdout

    def refuses(self, files, says, **more):
        code, out = self.check(files, **more)
        self.assertEqual(code, 1, out)
        self.assertIn(says, out)

    def test_posix_and_the_standard_library_are_accepted(self):
        code, out = self.check({"a.cpp": "#include <unistd.h>\n#include <mutex>\n#include <thread>\n#include <filesystem>\n"
                                         "int f() { int p[2]; return ::getpid() + ::pipe2(p, 0); }\n"})
        self.assertEqual(code, 0, out)
        self.assertIn("1 sources, 0 problems", out)

    def test_a_header_of_the_kernel_is_named(self):
        self.refuses({"a.cpp": "#include <linux/can.h>\n"}, "a.cpp: includes <linux/can.h>, which is not POSIX'")

    def test_also_when_a_header_of_ours_brings_it(self):
        self.refuses({"a.cpp": '#include "hal/linux/b.hpp"\n', "b.hpp": "#pragma once\n#include <sys/epoll.h>\n"},
                     "hal/linux/b.hpp includes <sys/epoll.h>")

    def test_a_call_that_only_linux_has_is_named(self):
        for header, call in [("sched.h", "cpu_set_t s; CPU_ZERO(&s)"), ("sys/mman.h", 'memfd_create("", 0)'),
                             ("fcntl.h", "fcntl(0, F_OFD_SETLK, nullptr)"), ("unistd.h", "syscall(1)"),
                             ("sys/socket.h", "ucred who; (void)who")]:
            self.refuses({"a.cpp": f"#include <{header}>\nvoid f() {{ {call}; }}\n"}, "does not compile with POSIX alone")

    def test_a_path_of_linux_is_named(self):
        self.refuses({"a.cpp": 'const char* f() { return "/proc/self/exe"; }\n'}, "is a path of Linux' own")

    def test_a_listed_file_that_is_not_there_is_named(self):
        self.refuses({}, "hal/linux/a.cpp: is listed in hal/linux/posix.txt, and there is no such file")

    def test_a_source_that_the_page_for_ports_does_not_name_is_named(self):
        code, out = self.check({"a.cpp": "", "v4l2_camera.cpp": "#include <linux/videodev2.h>\n"})
        self.assertEqual(code, 0, out)
        self.refuses({"a.cpp": "", "gpio.cpp": ""}, "hal/linux/gpio.cpp: docs/bsd.md does not say what becomes of it")
        self.refuses({"a.cpp": "", "can.cpp": ""}, "hal/linux/can.cpp: docs/bsd.md", page="`a.cpp`, `socketcand_can.cpp`, `can_*`")

    def test_an_empty_list_is_no_success(self):
        code, out = self.check({}, listed="")
        self.assertEqual(code, 1, out)


if __name__ == "__main__":
    unittest.main()
