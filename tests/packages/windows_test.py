"""The zip for Windows, unpacked, and its program in Wine.

    windows_test.py --source DIR --build DIR --emulator toolchains/wine.sh [CASE...]
"""
import json
import os
import re
import subprocess
import sys
import unittest

from unpacked import ARGS, CASES, Base, found, unpacked


class Windows(Base):
    def test_the_folder_has_the_program_its_robots_and_the_pages(self):
        have = {os.path.relpath(os.path.join(w, n), unpacked()) for w, _, names in os.walk(unpacked()) for n in names}
        for path in ("bin/sinew-fly.exe", "robots/quad/quad.toml", "docs/windows.md", "README.md", "LICENSE"):
            self.assertIn(path, have)
        for path in have:
            self.assertRegex(path, r"^(bin/sinew-fly\.exe|robots/\w+\.(toml|xml)|docs/[\w-]+\.md|third-party/[a-z0-9+-]+\.txt|README\.md|LICENSE)$")

    def test_the_program_runs_and_reads_its_robot(self):
        program = ARGS.emulator.split() + ["bin/sinew-fly.exe"]
        said = subprocess.run(program, cwd=unpacked(), capture_output=True, text=True)
        self.assertEqual(said.returncode, 2)
        self.assertIn("usage: sinew-fly ROBOT.toml ENDPOINT", said.stderr)
        said = subprocess.run(program + ["robots/quad/quad.toml", "tcp:127.0.0.1:1"], cwd=unpacked(), capture_output=True, text=True)
        self.assertEqual(said.returncode, 2, said.stderr)
        self.assertIn("tcp:127.0.0.1:1", said.stderr, "the robot was understood, nobody listens")

    def test_the_program_says_what_is_wrong_with_its_words(self):
        with open(f"{unpacked()}/robots/quad/quad.toml") as f:
            text = f.read()
        with open(f"{unpacked()}/robots/real.toml", "w") as f:
            f.write(text.replace('board = "sim"', 'board = "linux"'))
        self.addCleanup(os.remove, f"{unpacked()}/robots/real.toml")
        here = "tcp:127.0.0.1:1"
        for words, complaint in ((["robots/quad/quad.toml", here, "--fast"], "--fast: unknown"),
                                 (["robots/quad/quad.toml", here, "--seed", "x"], "--seed x: a number"),
                                 (["robots/none.toml", here], "none.toml: file: "),
                                 (["robots/real.toml", here], 'robot.board: "linux": this program has the simulator'),
                                 (["robots/quad/quad.toml", "nowhere"], "sinew-fly: nowhere: ")):
            said = subprocess.run(ARGS.emulator.split() + ["bin/sinew-fly.exe", *words], cwd=unpacked(), capture_output=True,
                                  text=True)
            self.assertEqual(said.returncode, 2, said.stderr)
            self.assertIn(complaint, said.stderr)

    def test_it_loads_nothing_that_windows_has_not(self):
        names = re.findall(r"DLL Name: (\S+)", self.sh(["objdump", "-p", f"{unpacked()}/bin/sinew-fly.exe"]))
        self.assertEqual({n.lower() for n in names}, {"kernel32.dll", "ws2_32.dll", "msvcrt.dll"})

    def test_beside_it_is_a_true_bill_of_materials(self):
        package = found("*.zip")[0]
        self.sh([sys.executable, "-B", f"{ARGS.source}/tools/sbom_check.py", f"{package}.spdx.json", package])
        with open(f"{package}.spdx.json") as f:
            names = {p["name"] for p in json.load(f)["packages"]}
        self.assertLessEqual({"sinew::hal_wince_stub", "libtomlplusplus-dev", "libfmt-dev", "nlohmann-json3-dev"}, names)
        self.expect_licences(package)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *CASES], verbosity=2)
