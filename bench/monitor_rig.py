"""What the benches of the monitor share: a robot and its monitor, viewers of movies and WebSockets, what a process takes."""
import base64
import os
import pathlib
import socket
import statistics
import struct
import subprocess
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Site:
    """A robot (a command whose first line says that it runs, or a robot file) and a monitor of its own run folder."""

    def __init__(self, build, robot, name, ready=None):
        self.name = name
        self.folder = tempfile.TemporaryDirectory()
        self.env = {**os.environ, "SINEW_RUN_DIR": self.folder.name}
        self.robot = subprocess.Popen([str(word) for word in robot], env=self.env, text=True, stdout=subprocess.PIPE,
                                      stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, start_new_session=True)
        if ready is None:
            self.robot.stdout.readline()
        else:
            while not (pathlib.Path(self.folder.name) / f"{name}.sock").exists():
                if self.robot.poll() is not None:
                    raise SystemExit(f"the robot ended with {self.robot.returncode}")
                time.sleep(0.1)
            threading.Thread(target=self.robot.stdout.read, daemon=True).start()
        self.monitor = subprocess.Popen([str(build / "bin/sinew-monitor"), "--port", "0"], env=self.env, text=True,
                                        stdout=subprocess.PIPE)
        self.port = int(self.monitor.stdout.readline().strip().rsplit(":", 1)[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in (self.monitor, self.robot):
            process.terminate()
        for process in (self.monitor, self.robot):
            process.wait()
        self.folder.cleanup()


def processor_ns(pid):
    """Of all its threads, those that ended included: clock_getcpuclockid() of another process."""
    return time.clock_gettime_ns((~pid << 3) | 2)


def memory_kb(pid):
    """Resident: of its own, of files (programs and libraries, shared with others), of memory shared with robots."""
    found = {}
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        name, _, value = line.partition(":")
        if name in ("VmRSS", "RssAnon", "RssFile", "RssShmem"):
            found[name] = int(value.split()[0])
    return found


class Movie(threading.Thread):
    """Reads a multipart movie and counts its pictures until it is stopped."""

    def __init__(self, port, path, mark=b"content-type: image/jpeg"):
        super().__init__(daemon=True)
        self.link = socket.create_connection(("127.0.0.1", port))
        self.link.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
        self.mark, self.pictures, self.bytes, self.first = mark, 0, 0, b""
        self.start()

    def run(self):
        rest = b""
        while True:
            try:
                got = self.link.recv(1 << 18)
            except OSError:
                return
            if not got:
                return
            if len(self.first) < 1 << 18:
                self.first += got
            text = (rest + got).lower()
            self.pictures += text.count(self.mark)
            self.bytes += len(got)
            rest = (rest + got)[-len(self.mark) + 1:]

    def stop(self):
        self.link.shutdown(socket.SHUT_RDWR)
        self.join()
        self.link.close()


class WebSocket(threading.Thread):
    """A viewer of the Foxglove protocol: subscribes to channels and counts what comes, without looking at it."""

    def __init__(self, port, path, topics, received=1 << 30):
        super().__init__(daemon=True)
        self.topics, self.messages, self.bytes, self.rest, self.counts = topics, 0, 0, b"", {}
        self.link = socket.create_connection(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.link.sendall((f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                           f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
                           "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n").encode())
        self.start()

    def _take(self, size):
        while len(self.rest) < size:
            got = self.link.recv(1 << 18)
            if not got:
                raise OSError("closed")
            self.bytes += len(got)
            self.rest += got
        taken, self.rest = self.rest[:size], self.rest[size:]
        return taken

    def send(self, text):
        data = text.encode()
        head = struct.pack("!BB", 0x81, 0x80 | len(data)) if len(data) < 126 else struct.pack("!BBH", 0x81, 0xFE, len(data))
        self.link.sendall(head + b"\0\0\0\0" + data)  # masked with zeros

    def run(self):
        import json
        try:
            while not self.rest.endswith(b"\r\n\r\n") and b"\r\n\r\n" not in self.rest:
                self.rest += self.link.recv(4096)
            if b" 101 " not in self.rest.split(b"\r\n", 1)[0]:
                return
            self.rest = self.rest.split(b"\r\n\r\n", 1)[1]
            names, whole = {}, b""
            while True:
                first, length = self._take(2)
                if length == 126:
                    length = struct.unpack("!H", self._take(2))[0]
                elif length == 127:
                    length = struct.unpack("!Q", self._take(8))[0]
                whole += self._take(length)
                if first & 0x0F in (8, 9) or not first & 0x80:
                    continue
                message, whole = whole, b""
                self.messages += 1
                if message[:1] == b"{":
                    said = json.loads(message)
                    if said["op"] == "advertise":
                        wanted = [c for c in said["channels"] if self.topics is None or c["topic"] in self.topics]
                        for c in wanted:
                            names[c["id"]] = c["topic"]
                        self.send(json.dumps({"op": "subscribe", "subscriptions":
                                              [{"id": c["id"], "channelId": c["id"]} for c in wanted]}))
                elif message[:1] == b"\x01":
                    topic = names.get(struct.unpack("<I", message[1:5])[0], "?")
                    self.counts[topic] = self.counts.get(topic, 0) + 1
        except OSError:
            return

    def stop(self):
        self.link.shutdown(socket.SHUT_RDWR)
        self.join()
        self.link.close()


def ask(run_folder, robot, request, **members):
    """One request to a robot's socket (docs/robot-socket.md)."""
    import json
    with socket.socket(socket.AF_UNIX) as link:
        link.connect(f"{run_folder}/{robot}.sock")
        text = json.dumps({"request": request, **members}).encode()
        link.sendall(struct.pack("<I", len(text)) + text)

        def take(size):
            got = b""
            while len(got) < size:
                more = link.recv(size - len(got))
                if not more:
                    raise OSError("closed")
                got += more
            return got
        return json.loads(take(struct.unpack("<I", take(4))[0]))


def quantile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))]


def report(name, ratios, goal, more=""):
    """As bench/pairs.hpp: the median of the pairs' ratios and its 95 % interval; false: a clear miss."""
    values, n = sorted(ratios), len(ratios)
    k = 0
    while (k + 1) ** 2 <= 0.9604 * n:
        k += 1
    low, high = values[max(0, n // 2 - k)], values[min(n - 1, n // 2 + k)]
    middle = statistics.median(values)
    verdict = "-" if not goal else "ok" if middle <= goal else "near" if low <= goal else "MISS"
    print(f"{name:<34} {middle:.3f} [{low:.3f}..{high:.3f}]  goal {goal:.2f}  {verdict}  {more}", flush=True)
    return not goal or low <= goal


def lateness_us(run_folder, robot, seconds, thread="stabilise"):
    """Of the releases of a thread in the last seconds, from the robot's time line."""
    reply = ask(run_folder, robot, "timeline", last_ms=int(seconds * 1000))
    number = reply["threads"].index(thread)
    return [event[4] / 1e3 for event in reply["events"] if event[0] == "release" and event[1] == number]


def report_lateness(name, found, tried, beside, goal, more=None):
    """found: of each load (p50, p99, releases) a turn. The ratios of `tried` to `beside`; false: a clear miss."""
    for kind, turns in found.items():
        p50, p99, count = (statistics.median(column) for column in zip(*turns))
        print(f"  {kind:<8} lateness p50 {p50:.1f} us, p99 {p99:.1f} us of {count:.0f} releases a turn{(more or {}).get(kind, '')}")
    good = True
    for quantile_name, column in (("p50", 0), ("p99", 1)):
        ratios = [a[column] / b[column] for a, b in zip(found[tried], found[beside])]
        good &= report(name.format(quantile_name), ratios, goal)
    return good


def report_figure(name, value, goal, unit):
    verdict = "-" if not goal else "ok" if value <= goal else "MISS"
    print(f"{name:<34} {value:.3f} {unit}  goal {goal:.2f}  {verdict}", flush=True)
    return not goal or value <= goal
