#!/usr/bin/env python3
"""Feeds libm_symbols.py and linked_libraries.py small objects and programs that break the rule, and some that do not.

Environment: CXX the compiler, LIBM and LIBMVEC the libraries (set by CMakeLists.txt).
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).parent
CXX = os.environ["CXX"]
LIBM = ["--libm", os.environ["LIBM"]]
if os.environ.get("LIBMVEC"):
    LIBM += ["--libm", os.environ["LIBMVEC"]]


class Built(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def compile(self, name, text, *flags):
        source = self.root / f"{name}.cpp"
        source.write_text(text, encoding="utf-8")
        output = self.root / name
        subprocess.run([CXX, "-O2", "-fno-math-errno", "-o", output, source, *flags], check=True)
        return output

    def run_script(self, script, *arguments):
        done = subprocess.run([sys.executable, HERE / script, *arguments], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr


class LibmSymbols(Built):
    def test_a_call_of_sin_is_named_with_its_object(self):
        obj = self.compile("wave.o", "#include <cmath>\ndouble f(double x) { return std::sin(x); }\n", "-c")
        archive = self.root / "libwave.a"
        subprocess.run(["ar", "rcs", archive, obj], check=True)
        code, out = self.run_script("libm_symbols.py", *LIBM, archive)
        self.assertEqual(code, 1, out)
        self.assertIn("(wave.o): sin\n", out)

    def test_single_precision_and_the_remainder_count_too(self):
        obj = self.compile("a.o", "#include <cmath>\nfloat f(float x) { return std::atan2(x, std::fmod(x, 3.0F)); }\n", "-c")
        code, out = self.run_script("libm_symbols.py", *LIBM, obj)
        self.assertEqual(code, 1, out)
        self.assertIn(": atan2f\n", out)
        self.assertIn(": fmodf\n", out)

    def test_a_square_root_is_an_instruction_and_passes(self):
        obj = self.compile("a.o", "#include <cmath>\nvoid g();\ndouble f(double x) { g(); return std::sqrt(x); }\n", "-c")
        code, out = self.run_script("libm_symbols.py", *LIBM, obj)
        self.assertEqual(code, 0, out)

    def test_our_own_function_of_that_name_passes(self):
        obj = self.compile("a.o", "namespace ours { double sin(double); }\ndouble f(double x) { return ours::sin(x); }\n",
                           "-c")
        code, out = self.run_script("libm_symbols.py", *LIBM, obj)
        self.assertEqual(code, 0, out)

    def test_a_library_without_sin_is_refused_as_reference(self):
        lib = self.compile("libx.so", "extern \"C\" int x() { return 1; }\n", "-shared", "-fPIC")
        code, out = self.run_script("libm_symbols.py", "--libm", lib, lib)
        self.assertNotEqual(code, 0, out)
        self.assertIn("does not export sin", out)


class LinkedLibraries(Built):
    def program_with(self, library):
        """A program whose NEEDED entries name a (made-up) library of that name."""
        lib = self.compile(f"{library}.so", "extern \"C\" int part() { return 0; }\n", "-shared", "-fPIC",
                           f"-Wl,-soname,{library}.so.406")
        return self.compile("program", "extern \"C\" int part();\nint main() { return part(); }\n", str(lib))

    def test_core_and_imgproc_pass(self):
        program = self.program_with("libopencv_imgproc")
        code, out = self.run_script("linked_libraries.py", "--opencv", "core,imgproc", program)
        self.assertEqual(code, 0, out)

    def test_another_part_of_opencv_is_named(self):
        program = self.program_with("libopencv_highgui")
        code, out = self.run_script("linked_libraries.py", "--opencv", "core,imgproc", program)
        self.assertEqual(code, 1, out)
        self.assertIn("libopencv_highgui.so.406: OpenCV's highgui; allowed: core,imgproc", out)

    def test_the_core_may_link_nothing_but_the_compilers_libraries(self):
        code, out = self.run_script("linked_libraries.py", "--only", "", self.program_with("libopencv_core"))
        self.assertEqual(code, 1, out)
        self.assertIn("libopencv_core.so.406", out)
        plain = self.compile("plain", "int main() {}\n")
        code, out = self.run_script("linked_libraries.py", "--only", "", plain)
        self.assertEqual(code, 0, out)


if __name__ == "__main__":
    unittest.main()
