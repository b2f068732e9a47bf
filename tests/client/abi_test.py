"""The shared library shows exactly the functions that abi.txt lists, and the header, the version script and the Python
package name the same ones.

    abi_test.py LIBRARY SOURCE
"""
import re
import subprocess
import sys
import unittest

LIBRARY, SOURCE = sys.argv[1:3]


def text(path):
    with open(f"{SOURCE}/{path}") as f:
        return f.read()


class Abi(unittest.TestCase):
    listed = text("tests/client/abi.txt").split()

    def test_the_library_shows_these_functions_and_nothing_else(self):
        lines = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
        symbols = [line.split()[1:] for line in lines.splitlines()]
        shown = sorted(name.split("@")[0] for kind, name in symbols if kind != "A")  # A: the version's own name
        self.assertEqual(shown, self.listed)
        self.assertTrue(all(name.endswith("@@SINEW_CLIENT_1") for kind, name in symbols if kind != "A"))

    def test_the_header_declares_these_functions(self):
        self.assertEqual(sorted(re.findall(r"^SINEW_API [^(]*?(\w+)\(", text("client/sinew_client.h"), re.M)), self.listed)

    def test_the_version_script_names_these_functions(self):
        self.assertEqual(sorted(re.findall(r"^    (\w+);", text("client/libsinew_client.map"), re.M)), self.listed)

    def test_the_python_package_declares_these_functions(self):
        self.assertEqual(sorted(re.findall(r'^    "(\w+)":', text("python/sinew/_library.py"), re.M)), self.listed)

    def test_the_library_asks_only_for_the_systems_libraries(self):
        lines = subprocess.run(["readelf", "-d", "-W", LIBRARY], capture_output=True, text=True, check=True).stdout
        needed = {n.split(".so")[0] for n in re.findall(r"\(NEEDED\).*\[(.+)\]", lines)}
        self.assertLessEqual(needed, {"libstdc++", "libgcc_s", "libc", "libm", "ld-linux-x86-64", "libatomic"})
        self.assertIn("[libsinew_client.so.1]", lines)


unittest.main(argv=sys.argv[:1])
