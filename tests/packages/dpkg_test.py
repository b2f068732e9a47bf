"""The .debs, handled by dpkg itself: installed into their own root, removed, purged, and installed over an older version.

    dpkg_test.py --source DIR --build DIR [--emulator "qemu-arm -L SYSROOT"] [CASE...]

The root is empty except for dpkg's database, which says that this system's packages (for a board: its sysroot's) are
installed there: so the packages that Depends names must exist, in the right version. dpkg needs root: a user without
root becomes root in a user namespace; without these the test is skipped, with the reason.
"""
import os
import re
import shutil
import subprocess
import sys
import unittest

from unpacked import ARGS, CASES, CROSS, WORK, Base, field, found, unpacked

DEBS = {field(deb, "Package"): deb for deb in found("*.deb")}
MACHINE = field(DEBS["sinew"], "Architecture") if DEBS else ""
SYSROOT = "".join(re.findall(r"-L (\S+)", ARGS.emulator))
BECOME_ROOT = []
if os.geteuid() != 0:
    BECOME_ROOT = ["unshare", "--user", "--map-root-user"]


def may_be_root():
    try:
        return subprocess.run([*BECOME_ROOT, "true"], capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


def files_below(folder):
    """All files and folders there, except dpkg's own."""
    have = set()
    for where, folders, names in os.walk(folder):
        have.update(os.path.relpath(f"{where}/{name}", folder) for name in folders + names)
    return {path for path in have if not re.match("var(/lib(/dpkg.*)?)?$", path)}


class Root(Base):
    def setUp(self):
        self.root = f"{WORK.name}/{self.id().rsplit('.', 1)[1]}"
        self.database = f"{self.root}/var/lib/dpkg"
        for folder in ("info", "updates", "triggers", "parts", "alternatives"):
            os.makedirs(f"{self.database}/{folder}")
        self.pretend([])

    def pretend(self, stanzas):
        """Enters these packages as installed into dpkg's database; their files are not there."""
        with open(f"{self.database}/status", "w") as f:
            f.write("\n\n".join(stanzas) + "\n")
        own = subprocess.run(["dpkg", "--print-architecture"], check=True, capture_output=True, text=True).stdout.strip()
        with open(f"{self.database}/arch", "w") as f:
            f.write("".join(f"{name}\n" for name in dict.fromkeys([own, MACHINE])))
        for stanza in stanzas:
            name, arch = (re.search(rf"^{key}: (.*)$", stanza, re.M)[1] for key in ("Package", "Architecture"))
            same = re.search(r"^Multi-Arch: same$", stanza, re.M)
            open(f"{self.database}/info/{name}{':' + arch if same else ''}.list", "w").close()

    def pretend_this_system(self):
        with open(f"{SYSROOT}/var/lib/dpkg/status", encoding="utf-8") as f:
            stanzas = f.read().strip().split("\n\n")
        stanzas = [s for s in stanzas if re.search("^Status: install ok installed$", s, re.M)]
        self.assertTrue(any(re.search("^Package: libc6$", s, re.M) for s in stanzas))
        # Missing configuration files need no keeping, and our own packages are still to be installed.
        stanzas = [re.sub(r"^Conffiles:\n( .*\n?)+", "", s, flags=re.M).rstrip() for s in stanzas
                   if re.search(r"^Package: (.*)$", s, re.M)[1] not in DEBS]
        self.pretend(stanzas)

    def dpkg(self, *words, code=0):
        done = subprocess.run([*BECOME_ROOT, "dpkg", f"--root={self.root}", f"--log={WORK.name}/dpkg.log", *words],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def state_of(self, package):
        done = subprocess.run(["dpkg-query", f"--admindir={self.database}", "-W", "-f=${Status} ${Version}", package],
                              capture_output=True, text=True)
        return done.stdout if done.returncode == 0 else "unknown"

    def expect_installed(self, *packages):
        for name in packages:
            self.assertEqual(self.state_of(name), f"install ok installed {field(DEBS[name], 'Version')}")
            self.assertEqual(self.dpkg("--verify", name), "", "each file is as its checksum says")

    def start(self, name, *words):
        return [*ARGS.emulator.split(), f"{self.root}/usr/bin/{name}", *words]


class Install(Root):
    def test_what_dpkg_installs_runs(self):
        self.pretend_this_system()
        self.dpkg("--install", *DEBS.values())
        self.expect_installed(*DEBS)
        self.assertRegex(self.sh(self.start("sinew", "--version")), r"^\d+\.\d+\.\d+$")
        robot = f"{self.root}/usr/share/sinew/robots/quad/quad.toml"
        self.assertIn("topics", self.sh(self.start("sinew", "check", robot)))
        if not CROSS:  # the kernel starts the simulator, too
            said = self.sh(self.start("sinew", "run", robot, "--virtual", "--duration", "0.5"), code=1, PATH="/usr/bin:/bin")
            self.assertIn("did not land", said)

    def test_there_is_nothing_but_what_the_packages_hold(self):
        self.pretend_this_system()
        self.dpkg("--install", *DEBS.values())
        self.assertEqual({f"usr/{p}" for p in files_below(unpacked())} | {"usr"}, files_below(self.root))

    def test_missing_dependencies_are_refused(self):
        said = self.dpkg("--install", DEBS["sinew"], code=1)
        self.assertRegex(said, r"sinew(:\w+)? depends on libc6")
        self.assertIn("unpacked", self.state_of("sinew"))

    def test_the_simulator_wants_the_command_of_its_own_version(self):
        self.pretend_this_system()
        said = self.dpkg("--install", DEBS["sinew-sim"], code=1)
        version = re.escape(field(DEBS["sinew"], "Version"))
        self.assertRegex(said, rf"sinew-sim(:\w+)? depends on sinew(:\w+)? \(= {version}\)")
        self.dpkg("--install", DEBS["sinew"])
        self.dpkg("--configure", "sinew-sim")
        self.expect_installed("sinew", "sinew-sim")

    def test_apt_would_install_them_on_this_system(self):
        if CROSS:
            self.skipTest("this system is no board")
        if not shutil.which("apt-get"):
            self.skipTest("no apt-get")
        said = self.sh(["apt-get", "install", "--simulate", "--no-install-recommends", *DEBS.values()])
        for name in DEBS:
            self.assertRegex(said, rf"Conf {name} \(")
        self.assertEqual(len(re.findall("^Conf ", said, re.M)), len(DEBS), f"all that they need is here:\n{said}")


class Remove(Root):
    def setUp(self):
        super().setUp()
        self.pretend_this_system()
        self.dpkg("--install", *DEBS.values())

    def test_remove_leaves_nothing(self):
        self.dpkg("--remove", *DEBS)
        self.assertEqual(files_below(self.root), set())
        for name in DEBS:
            self.assertNotIn("installed", self.state_of(name))

    def test_purge_leaves_what_people_and_robots_wrote(self):
        theirs = {"etc/sinew/quad.toml": "my robot", "var/lib/sinew/quad/run.mcap": "my record"}
        for path, text in theirs.items():
            os.makedirs(os.path.dirname(f"{self.root}/{path}"), exist_ok=True)
            with open(f"{self.root}/{path}", "w") as f:
                f.write(text)
        self.dpkg("--purge", *DEBS)
        left = files_below(self.root)
        self.assertEqual({p for p in left if os.path.isfile(f"{self.root}/{p}")}, set(theirs))
        for path, text in theirs.items():
            with open(f"{self.root}/{path}") as f:
                self.assertEqual(f.read(), text)

    def test_what_others_need_is_not_removed(self):
        self.assertRegex(self.dpkg("--remove", "sinew", code=1), r"sinew-sim(:\w+)? depends on sinew")
        self.sh(self.start("sinew", "--version"))


class Upgrade(Root):
    def older(self, name):
        """The package as an older version would have been, with a file more."""
        folder = f"{WORK.name}/older-{name}"
        if not os.path.isdir(folder):
            self.sh(["dpkg-deb", "-R", DEBS[name], folder])
            version = field(DEBS[name], "Version")
            with open(f"{folder}/DEBIAN/control") as f:
                control = f.read()
            with open(f"{folder}/DEBIAN/control", "w") as f:
                f.write(control.replace(version, "0.0.1-1"))
            with open(f"{folder}/usr/share/doc/{name}/gone", "w") as f:
                f.write("of the older version\n")
        deb = f"{folder}.deb"
        self.sh(["dpkg-deb", "--root-owner-group", "-Znone", "-b", folder, deb])
        return deb

    def test_an_older_version_gives_way_whole(self):
        self.pretend_this_system()
        self.dpkg("--install", *(self.older(name) for name in DEBS))
        self.assertEqual(self.state_of("sinew"), "install ok installed 0.0.1-1")
        os.makedirs(f"{self.root}/etc/sinew")
        with open(f"{self.root}/etc/sinew/quad.toml", "w") as f:
            f.write("my robot")
        self.dpkg("--install", *DEBS.values())
        self.expect_installed(*DEBS)
        for name in DEBS:
            self.assertFalse(os.path.exists(f"{self.root}/usr/share/doc/{name}/gone"), name)
        with open(f"{self.root}/etc/sinew/quad.toml") as f:
            self.assertEqual(f.read(), "my robot")

    def test_no_package_owns_what_people_change(self):
        for name, deb in DEBS.items():
            folder = f"{WORK.name}/control-{name}"
            self.sh(["dpkg-deb", "-e", deb, folder])
            triggers = ["triggers"] if name == "sinew" else []  # of libsinew_client.so.1, for ldconfig
            self.assertEqual(sorted(os.listdir(folder)), ["control", "md5sums"] + triggers, f"{name}: neither conffiles nor scripts")


if __name__ == "__main__":
    for there, why in ((bool(DEBS), "no .deb in this build"),
                       (may_be_root(), "not root, and no user namespace to be root in: dpkg would install nothing")):
        if not there:
            print(f"skipped: {why}")
            sys.exit(77)  # ctest: skipped
    unittest.main(argv=[sys.argv[0], *CASES], verbosity=2)
