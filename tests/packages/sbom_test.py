"""The tools of packages: they name the mistakes in a bill of materials; a failed look-up is an error."""
import copy
import hashlib
import json
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile

TOOLS = sys.argv[1]
sys.path.insert(0, TOOLS)
import debian_packages  # noqa: E402
import sbom  # noqa: E402
from sbom_check import problems_of  # noqa: E402

DEP5 = "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n\n"


class Bill(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.package = f"{self.folder.name}/sinew-0.1.0-windows-x86-64.zip"
        with zipfile.ZipFile(self.package, "w") as archive:
            archive.writestr("sinew/README.md", "read me")
            archive.writestr("sinew/robots/quad/quad.toml", "robot")
        files = sbom.unpack(self.package, f"{self.folder.name}/unpacked")
        self.document = sbom.Document(self.package, files, f"{self.folder.name}/unpacked")

    def bill(self):
        return json.loads(self.document.text())

    def problem(self, change, package=None):
        bill = copy.deepcopy(self.bill())
        change(bill)
        return "\n".join(problems_of(bill, package))

    def test_a_whole_one_has_no_problem(self):
        self.assertEqual(problems_of(self.bill(), self.package), [])

    def test_hashes_are_those_of_the_files(self):
        told = {f["fileName"]: f["checksums"][1]["checksumValue"] for f in self.bill()["files"]}
        self.assertEqual(told["./sinew/README.md"], hashlib.sha256(b"read me").hexdigest())

    def test_a_tarball_is_read_like_the_others(self):
        package, files = f"{self.folder.name}/sinew-0.1.0-mipsel.tar.gz", f"{self.folder.name}/unpacked"
        with tarfile.open(package, "w:gz") as tar:
            tar.add(f"{files}/sinew", "sinew")
        again = f"{self.folder.name}/again"
        document = sbom.Document(package, sbom.unpack(package, again), again)
        self.assertEqual(problems_of(json.loads(document.text()), package), [])

    def test_each_wrong_thing_is_named(self):
        def change(path, value):
            def apply(bill):
                at = bill
                for key in path[:-1]:
                    at = at[key]
                if value is None:
                    del at[path[-1]]
                else:
                    at[path[-1]] = value
            return apply

        wrong = [
            (("spdxVersion",), "SPDX-2.2", "spdxVersion"),
            (("documentNamespace",), "https://a/b#c", "documentNamespace"),
            (("creationInfo", "created"), "yesterday", "created"),
            (("packages", 0, "downloadLocation"), None, "downloadLocation"),
            (("packages", 0, "licenseDeclared"), "a licence, or so", "licenseDeclared"),
            (("packages", 0, "packageVerificationCode"), None, "packageVerificationCode"),
            (("packages", 0, "supplier"), "someone", "supplier"),
            (("files", 0, "fileName"), "/absolute", "fileName"),
            (("files", 0, "checksums"), [], "no SHA256"),
            (("files", 0, "SPDXID"), "SPDXRef-DOCUMENT", "twice"),
            (("relationships", 0, "relatedSpdxElement"), "SPDXRef-Package-none", "not in the document"),
            (("relationships", 0, "relationshipType"), "KNOWS", "KNOWS"),
            (("files",), None, "files is missing"),
        ]
        for path, value, named in wrong:
            with self.subTest(path=path):
                self.assertIn(named, self.problem(change(path, value)))

    def test_the_command_says_what_it_cannot_read(self):
        def check(*words):
            done = subprocess.run([f"{TOOLS}/sbom_check.py", *words], capture_output=True, text=True, check=False)
            self.assertNotIn("Traceback", done.stderr)
            return done.returncode, done.stdout + done.stderr

        bill, other = f"{self.folder.name}/bill.json", f"{self.folder.name}/other"
        with open(bill, "w", encoding="utf-8") as f:
            f.write(self.document.text())
        self.assertEqual(check(bill, self.package), (0, ""))
        self.assertEqual(check()[0], 2)
        for text, named in ((None, "No such file"), ("[1]", "no SPDX document"), ("sinew", "no SPDX document")):
            if text:
                with open(other, "w", encoding="utf-8") as f:
                    f.write(text)
            code, said = check(other)
            self.assertEqual(code, 1)
            self.assertIn(f"{other}: {named}", said)
        self.assertEqual(check(bill, other)[0], 1)

    def test_a_lie_about_the_package_is_found(self):
        def other_hash(bill):
            bill["files"][0]["checksums"][1]["checksumValue"] = "0" * 64
        self.assertIn("other checksums", self.problem(other_hash, self.package))

        def one_less(bill):
            gone = bill["files"].pop()["SPDXID"]
            bill["relationships"] = [r for r in bill["relationships"] if r["relatedSpdxElement"] != gone]
        self.assertIn("not in the document", self.problem(one_less, self.package))
        with zipfile.ZipFile(self.package, "a") as archive:
            archive.writestr("sinew/late.txt", "late")
        said = self.problem(lambda bill: None, self.package)
        self.assertIn("sinew/late.txt: is in the package", said)
        self.assertIn("SHA256", said)

    def test_a_licence_is_named_only_where_there_is_one(self):
        one = DEP5 + "Files: *\nCopyright: a\nLicense: Expat\n\nFiles: debian/*\nCopyright: b\nLicense: GPL-2+\n"
        self.assertEqual(debian_packages.licence_of(one)[0], "MIT")
        two = one + "\nFiles: src/*\nCopyright: c\nLicense: Zlib\n"
        self.assertEqual(debian_packages.licence_of(two), ("NOASSERTION", "Debian's copyright file names: Expat; Zlib"))
        self.assertEqual(debian_packages.licence_of(one.replace("Expat", "My-own"))[0], "NOASSERTION")
        self.assertEqual(debian_packages.licence_of("This is free.\n")[0], "NOASSERTION")

    def test_what_cannot_be_looked_up_is_an_error(self):
        with self.assertRaisesRegex(SystemExit, "no package database"):
            debian_packages.Debian(self.folder.name)
        with self.assertRaisesRegex(SystemExit, "libnobody.so.7: no Debian package"):
            debian_packages.Debian("").library("libnobody.so.7")
        with self.assertRaisesRegex(SystemExit, "NAME-VERSION-MACHINE"):
            sbom.name_of("sinew.zip")

    def test_dependencies_that_cannot_be_looked_up_are_an_error(self):
        def depends(*options):
            return subprocess.run([sys.executable, "-B", f"{TOOLS}/deb_depends.py", *options], capture_output=True, text=True)
        said = depends("--sysroot", self.folder.name, "--arch", "arm64", "--triplet", "aarch64-linux-gnu", "--depends",
                       "/bin/true")
        self.assertEqual((said.returncode, said.stdout), (1, ""))
        self.assertIn("no package database", said.stderr)
        said = depends("--depends", self.package)
        self.assertEqual((said.returncode, said.stdout), (1, ""), "a zip is no program")
        self.assertEqual(depends("--sysroot", "/", "--depends", "/bin/true").returncode, 2)
        said = depends("--depends", "/bin/true", "--recommends", "/bin/true")
        self.assertRegex(said.stdout, r"^Depends: libc6 \(>= [0-9.]+\)\nRecommends: \n$", said.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
