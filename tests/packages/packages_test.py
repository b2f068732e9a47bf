"""The packages of a build, used as a user does: unpacked somewhere else, and a project built against them.

    packages_test.py --source DIR --build DIR [--emulator "qemu-arm -L SYSROOT" --toolchain FILE] [CASE...]

The packages have to be there: `cmake --build DIR --target packages` makes them.
"""
import glob
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import unittest

from unpacked import ARGS, CASES, CROSS, WORK, Base, field, found, unpacked


class Contents(Base):
    def test_there_is_a_package_of_each_kind(self):
        names = sorted(os.path.basename(p).split("_")[0] for p in found("*.deb"))
        if names:
            self.assertEqual(names, ["libsinew-dev", "sinew", "sinew-monitor", "sinew-net", "sinew-sim"])
        else:
            self.assertEqual(len(found("*.tar.gz")), 1)

    def test_each_has_what_it_is_for_and_nothing_else(self):
        libraries = "usr/lib/[a-z0-9_-]+-linux-gnu[a-z]*/"
        allowed = {
            "sinew": rf"usr/bin/sinew(-fly|-control)?$|usr/share/man/man1/sinew(-fly|-control)?\.1\.gz$|{libraries}sinew/(libsinew_(libcamera|grab)\.so|vulkan/VkLayer_sinew_grab\.json)$|{libraries}libsinew_client\.so\.1(\.0\.0)?$|usr/lib/python3/dist-packages/sinew/\w+\.(pyi?|typed)$|usr/lib/systemd/system/sinew@\.service$"
                     r"|usr/share/(sinew/robots/(\w+/)?\w+\.(toml|onnx|ini)|bash-completion/completions/sinew)$",
            "libsinew-dev": rf"usr/include/(sinew/[\w/]+\.hpp|sinew_client\.h)$|usr/share/sinew/mex/sinew_mex\.c$|{libraries}(libsinew_client\.so|libsinew_\w+\.a|cmake/Sinew/Sinew[\w-]+\.cmake)$"
                            r"|usr/share/doc/sinew/(reference/)?[\w-]+\.md$",
            "sinew-monitor": r"usr/(bin/sinew-monitor|share/man/man1/sinew-monitor\.1\.gz)$",
            "sinew-net": r"usr/(bin/sinew-net|share/man/man1/sinew-net\.1\.gz)$",
            "sinew-sim": r"usr/(bin/sinew-(sim|fuzz|learn)|share/man/man1/sinew-(sim|fuzz|learn)\.1\.gz)$",
        }
        needed = {
            "sinew": ["usr/bin/sinew", "usr/bin/sinew-fly", "usr/bin/sinew-control", "usr/share/sinew/robots/quad/quad.toml",
                      "usr/lib/python3/dist-packages/sinew/__init__.py"],
            "libsinew-dev": ["usr/include/sinew/rt/module.hpp", "usr/include/sinew/hal/platform.hpp", "usr/include/sinew_client.h"],
            "sinew-monitor": ["usr/bin/sinew-monitor"],
            "sinew-net": ["usr/bin/sinew-net"],
            "sinew-sim": ["usr/bin/sinew-sim"],
        }
        for tarball in found("*.tar.gz"):  # all but the last as one prefix
            programs = "|".join(allowed[name] for name in ("sinew", "libsinew-dev", "sinew-monitor", "sinew-net"))
            with tarfile.open(tarball) as tar:
                files = ["usr/" + m.name.split("/", 1)[1] for m in tar.getmembers() if m.isfile() or m.issym()]
            for path in files:
                self.assertRegex(path, f"^({programs}|usr/share/doc/sinew/(LICENSE|third-party/[a-z0-9+-]+\\.txt)$)")
            for path in needed["sinew"] + needed["libsinew-dev"] + needed["sinew-net"] + ["usr/share/doc/sinew/LICENSE"]:
                self.assertIn(path, files)
        for deb in found("*.deb"):
            name = field(deb, "Package")
            lines = self.sh(["dpkg-deb", "-c", deb]).splitlines()
            paths = [line.split(None, 5)[5].split(" -> ")[0][2:] for line in lines]
            files = [p for p in paths if not p.endswith("/")]
            for path in files:
                document = rf"usr/share/doc/{name}/(copyright|changelog\.Debian\.gz|third-party/[a-z0-9+-]+\.txt)$"
                self.assertRegex(path, f"^({allowed[name]}|{document})", f"in {name}")
            for program in [p for p in files if "/bin/" in p]:
                self.assertIn(f"usr/share/man/man1/{os.path.basename(program)}.1.gz", files)
            for path in needed[name] + [f"usr/share/doc/{name}/copyright"]:
                self.assertIn(path, files)
            for line, path in zip(lines, paths):
                mode = "lrwxrwxrwx" if " -> " in line else "drwxr-xr-x" if path.endswith("/") else "-rwxr-xr-x" if "/bin/" in path else "-rw-r--r--"
                self.assertTrue(line.startswith(f"{mode} root/root "), line)

    def test_fields_are_those_of_debian(self):
        if not found("*.deb"):
            self.skipTest("a tarball has none")
        for deb in found("*.deb"):
            arch = deb.rsplit("_", 1)[1][:-len(".deb")]
            self.assertEqual(field(deb, "Architecture"), arch)
            self.assertRegex(field(deb, "Version"), r"^\d+\.\d+\.\d+-\d+$")
            depends = field(deb, "Depends")
            self.assertRegex(depends, r"libc6(-dev)?\b")
            if field(deb, "Package") == "sinew":
                self.assertRegex(depends, r"libc6 \(>= 2\.\d+\).*libstdc\+\+6 \(>= ")
                self.assertIn("liblz4-1", depends)
                self.assertNotIn("libcamera", depends, "it is loaded when a robot asks for it")
            if field(deb, "Package") == "sinew-sim":
                self.assertIn("libmujoco", depends)
                self.assertIn(f"sinew (= {field(deb, 'Version')})", depends)

    def test_programs_are_stripped_and_of_the_right_machine(self):
        machines = {"amd64": "X86-64", "arm64": "AArch64", "armhf": "ARM", "mipsel": "MIPS"}
        arch = next((m for m in machines if any(re.search(rf"[_-]{m}\.", p) for p in found("*.deb") + found("*.tar.gz"))))
        for program in glob.glob(f"{unpacked()}/bin/*") + glob.glob(f"{unpacked()}/lib/*/sinew/*.so"):
            self.assertIn(machines[arch], self.sh(["readelf", "-h", program]))
            self.assertNotIn(".debug_info", self.sh(["readelf", "-SW", program]))
            self.assertNotIn(".symtab", self.sh(["readelf", "-SW", program]))

    def test_nothing_names_a_folder_of_the_machine_that_built_it(self):
        hidden = [ARGS.source, ARGS.build] + re.findall(r"-L (\S+)", ARGS.emulator)
        for where, _, names in os.walk(unpacked()):
            for name in names:
                with open(f"{where}/{name}", "rb") as f:
                    data = f.read()
                for folder in hidden:
                    self.assertNotIn(os.path.realpath(folder).encode() + b"/", data, f"{where}/{name}")

    def test_beside_each_is_a_true_bill_of_materials(self):
        for package in found("*.deb") + found("*.tar.gz") + found("*.zip"):
            self.sh([sys.executable, "-B", f"{ARGS.source}/tools/sbom_check.py", f"{package}.spdx.json", package])
            with open(f"{package}.spdx.json") as f:
                bill = json.load(f)
            names = {p["name"] for p in bill["packages"]}
            self.assertTrue({"sinew::rt", "sinew::hal", "libtomlplusplus-dev"} <= names or re.match("sinew-(sim|monitor|net)", os.path.basename(package)), names)
            if "sinew-sim" in os.path.basename(package):
                self.assertTrue(any(n.startswith("libmujoco") for n in names), names)

    def test_what_each_holds_of_others_goes_with_its_licence(self):
        for package in found("*.deb") + found("*.tar.gz"):
            self.expect_licences(package)

    def test_depends_are_what_dpkg_shlibdeps_says_of_the_installed_programs(self):
        if not found("*.deb"):
            self.skipTest("a tarball names none")
        for deb in found("sinew_*.deb"):
            with open(f"{deb}.spdx.json") as f:
                bill = json.load(f)
            ids = {p["SPDXID"]: p["name"] for p in bill["packages"]}
            programs = {f["SPDXID"] for f in bill["files"] if "/bin/" in f["fileName"]}
            linked = {ids[r["relatedSpdxElement"]] for r in bill["relationships"]
                      if r["relationshipType"] == "DYNAMIC_LINK" and r["spdxElementId"] in programs}
            self.assertEqual({d.split()[0] for d in field(deb, "Depends").split(", ")}, linked,
                             "two ways to look it up, one answer")


class Lintian(Base):  # a minute for each package
    def test_lintian_finds_neither_error_nor_warning(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed")
        for deb in found("*.deb"):  # Debian's list of wishes knows nothing of us
            self.sh(["lintian", "--fail-on", "error,warning", "--suppress-tags", "initial-upload-closes-no-bugs", deb])


class Installed(Base):
    def test_the_command_runs(self):
        self.assertRegex(self.sh(self.program("sinew") + ["--version"]), r"^\d+\.\d+\.\d+$")
        said = self.sh(self.program("sinew") + ["check", f"{unpacked()}/share/sinew/robots/quad/quad.toml"])
        self.assertIn("topics", said)

    def test_completion_is_the_commands_own(self):
        with open(f"{unpacked()}/share/bash-completion/completions/sinew") as f:
            self.assertEqual(f.read(), self.sh(self.program("sinew") + ["completion", "bash"]))

    def test_a_manual_page_has_every_option_of_its_program(self):
        pages = glob.glob(f"{unpacked()}/share/man/man1/*.1.gz")
        self.assertEqual({os.path.basename(p)[:-len(".1.gz")] for p in pages}, set(os.listdir(f"{unpacked()}/bin")))
        for path in pages:
            with gzip.open(path, "rt") as f:
                page = f.read().replace("\\-", "-")
            said = self.sh(self.program(os.path.basename(path)[:-len(".1.gz")]) + ["--help"])
            for option in re.findall(r"^  (--[\w-]+)", said, re.M):
                self.assertIn(f"\n.B {option}", page, path)
        with gzip.open(f"{unpacked()}/share/man/man1/sinew.1.gz", "rt") as f:
            page = f.read()
        for option in re.findall(r"^  (--[\w-]+)", self.sh(self.program("sinew") + ["topic", "echo", "--help"]), re.M):
            self.assertIn(option.replace("-", "\\-"), page.split(".SS topic echo\n")[1].split(".SS")[0])

    def test_the_smallest_robot_runs(self):
        said = self.sh(self.program("sinew-control") + ["1.5", "0.2"])
        self.assertRegex(said, r"tilt -?\d+\.\d mrad, at first 300\.0")

    def test_a_robot_flies_with_the_simulator_beside_it(self):
        if CROSS:
            self.skipTest("sinew starts sinew-sim, which only a board's kernel can do")
        said = self.sh(self.program("sinew") + ["run", f"{unpacked()}/share/sinew/robots/quad/quad.toml", "--virtual",
                                                "--duration", "0.5"], code=1, PATH="/usr/bin:/bin")
        self.assertIn("did not land", said)

    def test_without_the_simulator_it_is_said_where_it_comes_from(self):
        alone = f"{WORK.name}/alone"
        os.makedirs(alone)
        shutil.copy(f"{unpacked()}/bin/sinew", alone)
        command = ARGS.emulator.split() + [f"{alone}/sinew", "run", f"{unpacked()}/share/sinew/robots/quad/quad.toml", "--virtual"]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PATH": "/nowhere" if not CROSS
                                                                            else "/usr/bin:/bin"})
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("Debian package sinew-sim", done.stderr)


class Project(Base):
    """The project of `sinew new`, built by the commands of its README against the unpacked packages."""

    def configure(self, folder, *options, code=0, **env):
        command = ["cmake", "-B", "build", "-G", "Ninja", "-DCMAKE_CXX_COMPILER_LAUNCHER=", *options]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env={**os.environ, **env})
        self.assertEqual(done.returncode == 0, code == 0, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def project(self, name):
        self.sh(self.program("sinew") + ["new", name])
        return f"{WORK.name}/{name}"

    def where(self, *extra):
        options = [f"-DCMAKE_PREFIX_PATH={unpacked()}", *extra]
        return options + [f"-DCMAKE_TOOLCHAIN_FILE={ARGS.toolchain}"] if ARGS.toolchain else options

    def test_it_builds_and_runs_and_passes_its_test(self):
        here = self.project("first")
        said = self.configure(here, *self.where())
        self.assertNotIn("Warning", said)
        with open(f"{here}/build/CMakeCache.txt") as f:
            self.assertIn(f"Sinew_DIR:PATH={unpacked()}/lib/", f.read())
        self.sh(["cmake", "--build", "build", "-j2"], here)
        self.sh(["ctest", "--test-dir", "build", "--no-tests=error"], here)
        self.assertIn("1000 ok", self.sh(ARGS.emulator.split() + ["./build/first", "run", "first.toml", "--virtual", "--verbose"], here))
        if not CROSS:  # a program elsewhere, with nothing in PATH, finds the simulator of the prefix
            said = self.sh(["./build/first", "run", f"{unpacked()}/share/sinew/robots/quad/quad.toml", "--virtual", "--duration",
                            "0.5"], here, code=1, PATH="/usr/bin:/bin")
            self.assertIn("did not land", said)
        with open(f"{here}/build/build.ninja") as f:
            rules = f.read()
        self.assertIn("-ffp-contract=off", rules, "the same arithmetic as ours")
        small = self.sh(["readelf", "-h", "build/first"], here).find("ELF32") >= 0
        self.assertEqual("_TIME_BITS=64" in rules, small, "the same times as ours")

    def test_the_command_that_wrote_it_is_found_without_a_word(self):
        if CROSS:
            self.skipTest("a cross build is told where the board's files are")
        here = self.project("second")
        self.configure(here, CMAKE_PREFIX_PATH="")
        with open(f"{here}/build/CMakeCache.txt") as f:
            self.assertIn(f"Sinew_DIR:PATH={unpacked()}/lib/", f.read())

    def test_only_what_is_asked_for_is_looked_for(self):
        here = f"{WORK.name}/small"
        os.makedirs(here)
        with open(f"{here}/CMakeLists.txt", "w") as f:
            f.write("cmake_minimum_required(VERSION 3.25)\nproject(small LANGUAGES CXX)\n"
                    "find_package(Sinew REQUIRED COMPONENTS rt OPTIONAL_COMPONENTS record nothing)\n"
                    "message(STATUS \"record: ${Sinew_record_FOUND} nothing: ${Sinew_nothing_FOUND}\")\n"
                    "if(TARGET fmt::fmt OR TARGET PNG::PNG)\n  message(FATAL_ERROR \"rt needs neither\")\nendif()\n")
        said = self.configure(here, *self.where("-DSINEW_EXTERNAL_LZ4=OFF"))
        self.assertIn("record: FALSE nothing: FALSE", said)

    def test_what_is_missing_is_named_with_its_package(self):
        here = f"{WORK.name}/missing"
        os.makedirs(here)
        with open(f"{here}/CMakeLists.txt", "w") as f:
            f.write("cmake_minimum_required(VERSION 3.25)\nproject(missing LANGUAGES CXX)\n"
                    "find_package(Sinew REQUIRED COMPONENTS record kitchen)\n")
        said = self.configure(here, *self.where("-DSINEW_EXTERNAL_LZ4=OFF"), code=1)
        flat = " ".join(said.split())
        self.assertIn("sinew::record: SinewExternal::lz4 is missing (Debian: liblz4-dev)", flat)
        self.assertIn("sinew::kitchen: there is no such room in this Sinew", flat)

    def test_libraries_of_another_machine_are_refused(self):
        here = f"{WORK.name}/foreign"
        os.makedirs(here)
        with open(f"{here}/CMakeLists.txt", "w") as f:
            f.write("cmake_minimum_required(VERSION 3.25)\nproject(foreign LANGUAGES CXX)\n"
                    "set(CMAKE_LIBRARY_ARCHITECTURE vax-linux-gnu)\nfind_package(Sinew REQUIRED COMPONENTS rt)\n")
        folder = glob.glob(f"{unpacked()}/lib/*/cmake/Sinew")[0]
        self.assertRegex(self.configure(here, *self.where(f"-DSinew_DIR={folder}"), code=1), r"version: [\d.]+ \(\S+-linux-gnu")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *CASES], verbosity=2)
