#!/usr/bin/env python3
"""A sweep in parts on a Slurm cluster and over ssh, each with a part that is killed and repeated, comes to the same bytes
as on one machine. The cluster and the ssh server are this test's own, on this machine, and end with it.

    cluster_test.py SOURCE SINEW        exit code 77: a program is missing (tools/setup.sh cluster installs them)
"""
import ctypes
import getpass
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

SOURCE, SINEW = sys.argv[1:3]
PARTS = 8
SWEEP = ["robots/seesaw/seesaw.toml", "--seeds", "1..80", "--duration", "1"]
os.environ["PATH"] += ":/usr/sbin:/sbin"
LIBC = ctypes.CDLL(None, use_errno=True)
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36


def die_with_us():
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def children():
    """Every process by that of its parent."""
    below = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
                parent = int(stat.read().rpartition(")")[2].split()[1])
        except (FileNotFoundError, ProcessLookupError):  # it has ended meanwhile
            continue
        below.setdefault(parent, []).append(int(pid))
    return below


def tree(pid):
    below, found = children(), [pid]
    for one in found:
        found += below.get(one, [])
    return found


def kill(pids):
    for pid in pids:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


def end_all():
    """Everything that came from here; daemons, too: we are the parent of what loses its own."""
    while left := tree(os.getpid())[1:]:
        kill(left)
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        time.sleep(0.02)


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster(unittest.TestCase):
    def setUp(self):
        self.dir = tempfile.mkdtemp(prefix="sinew-")
        self.addCleanup(shutil.rmtree, self.dir)
        self.addCleanup(end_all)
        os.chmod(self.dir, 0o755)  # munge's folder may be seen by all
        # A killed sweep leaves its temporary files.
        self.env = dict(os.environ, SINEW_RECORD="off", TMPDIR=self.dir, SINEW_RUN_DIR=f"{self.dir}/names")
        self.pack, self.results = f"{self.dir}/pack", f"{self.dir}/results"
        self.call([SINEW, "sweep", *SWEEP, "--pack", self.pack], cwd=SOURCE)
        self.call([SINEW, "sweep", *SWEEP, "--results", f"{self.dir}/single.jsonl"], cwd=SOURCE)

    def call(self, argv, **options):
        done = subprocess.run(argv, env=self.env, capture_output=True, text=True, timeout=240, check=False, **options)
        self.assertEqual(done.returncode, 0, f"{argv}\n{done.stdout}\n{done.stderr}\n{self.logs()}")
        return done.stdout

    def daemon(self, name, argv):
        with open(f"{self.dir}/{name}.log", "ab") as log:
            return subprocess.Popen(argv, env=self.env, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                    start_new_session=True, preexec_fn=die_with_us)

    def logs(self):
        text = ""
        for name in sorted(os.listdir(self.dir)):
            if name.endswith(".log"):
                with open(f"{self.dir}/{name}", encoding="utf-8", errors="replace") as log:
                    text += f"== {name}\n{log.read()[-3000:]}\n"
        return text

    def wait_for(self, what, ready, patience_s=60):
        end = time.monotonic() + patience_s
        while not (found := ready()):
            self.assertLess(time.monotonic(), end, f"{what}: not within {patience_s} s\n{self.logs()}")
            time.sleep(0.05)
        return found

    def lines(self, part, results=None):
        try:
            with open(f"{results or self.results}/{part}.jsonl", "rb") as file:
                return file.read().count(b"\n")
        except FileNotFoundError:
            return 0

    def check_merged(self, merged):
        with open(merged, "rb") as ours, open(f"{self.dir}/single.jsonl", "rb") as single:
            self.assertEqual(ours.read(), single.read())


class Slurm(Cluster):
    def start(self):
        controller, *nodes = free_ports(3)
        munge = f"{self.dir}/munge"
        os.mkdir(munge, 0o755)
        with open(os.open(f"{munge}/key", os.O_WRONLY | os.O_CREAT, 0o400), "wb") as key:
            key.write(os.urandom(128))
        for name in ("controller", "node0", "node1"):
            os.mkdir(f"{self.dir}/{name}")
        with open(f"{SOURCE}/tests/cluster/slurm.conf.in", encoding="utf-8") as template:
            text = template.read()
        for key, value in {"DIR": self.dir, "USER": getpass.getuser(), "HOST": socket.gethostname().split(".")[0],
                           "CONTROLLER_PORT": controller, "NODE0_PORT": nodes[0], "NODE1_PORT": nodes[1]}.items():
            text = text.replace(f"@{key}@", str(value))
        with open(f"{self.dir}/slurm.conf", "w", encoding="utf-8") as conf:
            conf.write(text)
        self.env["SLURM_CONF"] = f"{self.dir}/slurm.conf"
        self.daemon("munged", ["munged", "--foreground", *(f"--{key}-file={munge}/{key}" for key in ("key", "pid", "seed")),
                               f"--socket={munge}/socket"])
        self.wait_for("munged", lambda: os.path.exists(f"{munge}/socket"))
        self.daemon("slurmctld", ["slurmctld", "-D", "-c"])
        self.nodes = {name: self.node(name) for name in ("node0", "node1")}
        self.wait_for("two nodes", lambda: self.states().get("idle") == 2)

    def node(self, name):
        return self.daemon(name, ["slurmd", "-D", "-N", name])

    def states(self):
        done = subprocess.run(["sinfo", "-h", "-o", "%T %D"], env=self.env, capture_output=True, text=True, check=False)
        return {state: int(count) for state, count in map(str.split, done.stdout.splitlines())}

    def running_on(self, node):
        tasks = self.call(["squeue", "-h", "-t", "R", "-w", node, "-o", "%K"]).split()
        return int(tasks[0]) + 1 if tasks else None

    def lose(self, node):
        """As when its power fails. The jobs' own processes are below a daemon of theirs, which writes to the node's log."""
        pids = tree(self.nodes[node].pid)
        for pid in tree(os.getpid())[1:]:
            try:
                links = [os.readlink(f"/proc/{pid}/fd/{fd}") for fd in os.listdir(f"/proc/{pid}/fd")]
            except (FileNotFoundError, ProcessLookupError):
                continue
            if f"{self.dir}/{node}/log" in links:
                pids += tree(pid)
        kill(pids)
        self.nodes[node].wait()
        return len(pids)

    def test_an_array_job_that_loses_a_node_comes_to_the_bytes_of_one_machine(self):
        self.start()
        job = self.call(["sbatch", "--parsable", f"--array=0-{PARTS - 1}", f"--output={self.dir}/task-%a.log",
                         f"{SOURCE}/examples/sweep/slurm_array.sh", self.pack, self.results, str(PARTS)]).strip()

        def under_way():
            part = self.running_on("node1")
            return part if part and 3 <= self.lines(part) <= 8 else None  # of 11, with the first, which is no result
        part = self.wait_for("a part under way on node1", under_way)
        self.assertGreater(self.lose("node1"), 3, "daemon, the job's daemon, the script, the sweep, a run")
        had = self.lines(part)
        self.assertLess(had, 1 + 80 // PARTS, "it was killed in the middle")
        self.wait_for("the loss is seen", lambda: any(state.startswith("down") for state in self.states()))
        self.nodes["node1"] = self.node("node1")
        self.wait_for("the end of the job", lambda: not self.call(["squeue", "-h", "-j", job]), 120)
        with open(f"{self.dir}/controller/log", encoding="utf-8") as log:
            self.assertIn("due to failure of node node1", log.read())
        with open(f"{self.dir}/task-{part - 1}.log", encoding="utf-8") as log:
            self.assertIn(f"has {had - 1} of {80 // PARTS} runs", log.read(), "the task went on where it was")
        self.call([f"{self.pack}/run", "merge", *(f"{self.results}/{p}.jsonl" for p in range(PARTS, 0, -1)), "--into",
                   f"{self.dir}/merged.jsonl"])
        self.check_merged(f"{self.dir}/merged.jsonl")


class Ssh(Cluster):
    def start(self):
        port, = free_ports(1)
        for name in ("host", "user"):
            self.call(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", f"{self.dir}/{name}_key"])
        shutil.copy(f"{self.dir}/user_key.pub", f"{self.dir}/authorized")
        with open(f"{self.dir}/sshd_config", "w", encoding="utf-8") as conf:
            conf.write(f"ListenAddress 127.0.0.1\nPort {port}\nHostKey {self.dir}/host_key\nPidFile none\nUsePAM no\n"
                       f"AuthorizedKeysFile {self.dir}/authorized\nPasswordAuthentication no\nPermitRootLogin yes\n"
                       f"StrictModes no\nMaxStartups 100\nSetEnv TMPDIR={self.dir} SINEW_RUN_DIR={self.dir}/names\n")
        with open(f"{self.dir}/ssh_config", "w", encoding="utf-8") as conf:
            conf.write(f"Host node0 node1\nHostName 127.0.0.1\nPort {port}\nIdentityFile {self.dir}/user_key\n"
                       f"IdentitiesOnly yes\nStrictHostKeyChecking no\nUserKnownHostsFile {self.dir}/known_hosts\n"
                       "BatchMode yes\nLogLevel ERROR\n")
        self.env["PARALLEL_SSH"] = f"ssh -F {self.dir}/ssh_config"
        self.env["PARALLEL_HOME"] = f"{self.dir}/parallel"
        os.mkdir(self.env["PARALLEL_HOME"])
        if os.geteuid() == 0 and not os.path.exists("/run/sshd"):  # where sshd as root confines its first half
            os.mkdir("/run/sshd")
            self.addCleanup(os.rmdir, "/run/sshd")
        self.daemon("sshd", [shutil.which("sshd", path=os.environ["PATH"]), "-D", "-e", "-f", f"{self.dir}/sshd_config"])
        self.wait_for("sshd", lambda: subprocess.run(["ssh", "-F", f"{self.dir}/ssh_config", "node0", "true"], env=self.env,
                                                     capture_output=True, check=False).returncode == 0)

    def sweep_of(self, there, part):
        """The process of a part, once it has some results and lacks others."""
        if not 3 <= self.lines(part, f"{there}/results") <= 8:
            return None
        for pid in tree(os.getpid())[1:]:
            try:
                with open(f"/proc/{pid}/cmdline", "rb") as cmdline:
                    words = cmdline.read().decode().split("\0")
            except (FileNotFoundError, ProcessLookupError):
                continue
            if words[0] == f"{there}/bin/sinew" and f"{part}/{PARTS}" in words:
                return pid
        return None

    def test_parts_on_two_machines_of_which_one_is_killed_come_to_the_bytes_of_one_machine(self):
        self.start()
        there = f"{self.dir}/there"
        merged = f"{self.dir}/merged.jsonl"
        driver = self.daemon("parallel", [f"{SOURCE}/examples/sweep/parallel_ssh.sh", self.pack, there, str(PARTS), merged,
                                          "node0", "node1"])
        pid = self.wait_for("part 3 under way", lambda: self.sweep_of(there, 3))
        kill(tree(pid))
        had = self.lines(3, f"{there}/results")
        self.assertLess(had, 1 + 80 // PARTS, "it was killed in the middle")
        self.assertEqual(driver.wait(240), 0, self.logs())
        with open(f"{self.dir}/parallel.log", encoding="utf-8") as log:
            self.assertIn(f"has {had - 1} of {80 // PARTS} runs", log.read(), "the part was flown again, from where it was")
        self.check_merged(merged)


if __name__ == "__main__":
    MISSING = [p for p in ("munged", "slurmctld", "slurmd", "sbatch", "sshd", "ssh", "parallel") if not shutil.which(p)]
    if MISSING:
        print(f"NOT RUN: no {', '.join(MISSING)}; tools/setup.sh cluster installs them")
        sys.exit(77)
    LIBC.prctl(PR_SET_CHILD_SUBREAPER, 1)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # everything is taken down then, too
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
