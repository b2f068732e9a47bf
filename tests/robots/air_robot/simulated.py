"""Robots that speak text, at the wire: each has its own sockets and the simplest body that can fly or drive.

What they understand is written from the protocols' own documents, apart from Sinew's codecs.
"""
import contextlib
import math
import re
import select
import socket
import struct
import threading
import time


class Body:
    """Follows velocities with a delay; stands on the ground."""

    def __init__(self, height_m=0.0, ground_m=0.0):
        self.x = self.y = self.yaw = 0.0
        self.z, self.ground, self.highest = height_m, ground_m, height_m
        self.v = [0.0, 0.0, 0.0, 0.0]       # forward, left, up, turn (to the left)
        self.wanted = [0.0, 0.0, 0.0, 0.0]
        self.at = time.monotonic()

    def step(self):
        now = time.monotonic()
        dt, self.at = min(now - self.at, 0.1), now
        for i in range(4):
            self.v[i] += (self.wanted[i] - self.v[i]) * min(1.0, dt / 0.15)
        self.x += dt * (self.v[0] * math.cos(self.yaw) - self.v[1] * math.sin(self.yaw))
        self.y += dt * (self.v[0] * math.sin(self.yaw) + self.v[1] * math.cos(self.yaw))
        self.z = max(self.ground, self.z + dt * self.v[2])
        self.yaw += dt * self.v[3]
        self.highest = max(self.highest, self.z)


class Robot:
    """A thread that runs cycle() some 100 times a second until close()."""

    def __init__(self):
        self.errors, self.closing = [], False
        self.lock = threading.Lock()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        try:
            while not self.closing:
                with self.lock:
                    self.cycle()
                time.sleep(0.01)
        except Exception as error:  # the test looks at it
            self.errors.append(repr(error))
            raise

    def close(self):
        self.closing = True
        self.thread.join()
        for s in self.sockets():
            s.close()


class UsarSim(Robot):
    """TCP: one AirRobot (or P3AT, with `wheels`) for each connection, sensors five times a second."""

    def __init__(self, wheels=False):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.setblocking(False)
        self.port = self.listener.getsockname()[1]
        self.peer, self.rest = None, b""
        self.body = Body(0.1, 0.1)
        self.wheels, self.spawned, self.commands, self.connections = wheels, False, [], 0
        self.next = 0.0
        self.silent = False
        super().__init__()

    def sockets(self):
        return [s for s in (self.listener, self.peer) if s]

    def cut(self):
        with self.lock:
            if self.peer:
                self.peer.close()
            self.peer = None

    def say(self, text):
        if not self.peer or self.silent:
            return
        try:
            self.peer.sendall(text.encode())
        except OSError:
            self.peer = None

    def cycle(self):
        if not self.peer and select.select([self.listener], [], [], 0)[0]:
            self.peer, _ = self.listener.accept()
            self.rest, self.spawned = b"", False
            self.connections += 1
            self.body.wanted = [0.0] * 4
            self.say("NFO {Gametype BotDeathMatch} {Level EmptyRoom} {TimeLimit 0}\r\n")
        if self.peer and select.select([self.peer], [], [], 0)[0]:
            try:
                data = self.peer.recv(4096)
            except OSError:
                data = b""
            if not data:
                self.peer.close()
                self.peer = None
                self.body.wanted = [0.0] * 4
            self.rest += data
            *lines, self.rest = re.split(rb"[\r\n]", self.rest)
            for line in filter(None, lines):
                self.command(line.decode())
        self.body.step()
        if self.spawned and time.monotonic() > self.next:
            self.next = time.monotonic() + 0.2
            b = self.body
            self.say(f"SEN {{Time {time.monotonic():.4f}}} {{Type GroundTruth}} {{Name GroundTruth}} "
                     f"{{Location {b.x:.2f},{-b.y:.2f},{b.z:.2f}}} {{Orientation 0.00,0.00,{-b.yaw:.2f}}}\r\n"
                     f"STA {{Type AerialVehicle}} {{Time {time.monotonic():.2f}}} {{Battery 1182}}\r\n")

    def command(self, line):
        self.commands.append(line)
        word, *_ = line.split(maxsplit=1)
        keys = dict(re.findall(r"\{(\w+) ([^{}]*)\}", line))
        if word == "INIT":
            self.spawned = True
        elif word == "DRIVE" and self.spawned:
            number = {k: float(v) for k, v in keys.items()}
            if self.wheels:
                left, right = number["Left"] * 0.11, number["Right"] * 0.11
                self.body.wanted = [(left + right) / 2, 0, 0, (right - left) / 0.4]
            else:
                self.body.wanted = [number["LinearVelocity"], -number["LateralVelocity"], number["AltitudeVelocity"],
                                    -number["RotationalVelocity"]]


def udp(port=0):
    s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    s.bind(("127.0.0.1", port))
    s.setblocking(False)
    return s


def received(s):
    while True:
        try:
            yield s.recvfrom(2048)
        except BlockingIOError:
            return


class Tello(Robot):
    """UDP: commands and replies on one port, the state ten times a second to `state_port` of the commander."""

    def __init__(self, state_port):
        self.s = udp()
        self.port, self.state_port = self.s.getsockname()[1], state_port
        self.peer, self.commands = None, []
        self.body, self.flying, self.rising = Body(), False, False
        self.next, self.heard, self.lost_takeoffs, self.silent = 0.0, time.monotonic(), 1, False
        super().__init__()

    def sockets(self):
        return [self.s]

    def cycle(self):
        for data, peer in received(self.s):
            text = data.decode()
            self.commands.append(text)
            self.heard = time.monotonic()
            if text == "command":
                self.peer = peer
                self.reply("ok")
            elif self.peer:
                self.command(text)
        b = self.body
        if self.rising:
            b.wanted = [0, 0, 0.5, 0]
            if b.z > 0.8:
                self.rising = False
                b.wanted = [0.0] * 4
                self.reply("ok")
        if not self.flying:
            b.wanted = [0, 0, -0.5, 0]
        b.step()
        if self.peer and time.monotonic() > self.next and not self.silent:
            self.next = time.monotonic() + 0.1
            yaw = round(-math.degrees(b.yaw))
            state = (f"pitch:0;roll:0;yaw:{yaw};vgx:{round(b.v[0] * 10)};vgy:0;vgz:0;templ:60;temph:62;"
                     f"tof:{round(b.z * 100) + 10};h:{round(b.z * 100)};bat:87;baro:44.12;time:0;agx:0.00;agy:0.00;"
                     f"agz:-999.00;\r\n")
            self.s.sendto(state.encode(), (self.peer[0], self.state_port))

    def reply(self, text):
        with contextlib.suppress(OSError):
            self.s.sendto(text.encode(), self.peer)

    def command(self, text):
        if text == "takeoff":
            if self.lost_takeoffs:  # a radio loses datagrams
                self.lost_takeoffs -= 1
            elif not self.flying:
                self.flying = self.rising = True
        elif text == "land":
            self.flying = self.rising = False
            self.reply("ok")
        elif text.startswith("rc "):
            right, forward, up, turn = (int(w) for w in text.split()[1:])
            assert all(-100 <= n <= 100 for n in (right, forward, up, turn)), text
            if self.flying and not self.rising:
                self.body.wanted = [forward / 100, -right / 100, up / 100, -math.radians(turn)]
        else:
            self.reply("unknown command: " + text)


class ArDrone(Robot):
    """UDP: AT commands on one port, navdata from another after it was asked for."""

    WATCHDOG, BOOTSTRAP, FLYING = 1 << 30, 1 << 11, 1

    def __init__(self):
        self.at, self.nav = udp(), udp()
        self.port, self.nav_port = self.at.getsockname()[1], self.nav.getsockname()[1]
        self.peer, self.commands, self.sequence, self.old = None, [], 0, 0
        self.body, self.flying, self.configured, self.number = Body(), False, False, 0
        self.next, self.heard, self.watched, self.silent, self.flips = 0.0, time.monotonic(), 0.0, False, 0
        super().__init__()

    def sockets(self):
        return [self.at, self.nav]

    def cycle(self):
        for data, peer in received(self.nav):
            assert data == b"\1\0\0\0", data
            self.peer = peer
        for data, _ in received(self.at):
            assert data.endswith(b"\r"), data
            for command in data.decode().split("\r")[:-1]:
                self.command(command)
        now = time.monotonic()
        if now - self.heard > 2:  # no command: it hovers, its watchdog bit says so
            self.body.wanted = [0.0] * 4
        if not self.flying:
            self.body.wanted = [0, 0, -0.5, 0]
        self.body.step()
        if self.peer and now > self.next and not self.silent:
            self.next = now + 1 / 15
            self.nav.sendto(self.navdata(), self.peer)

    def navdata(self):
        b = self.body
        self.number += 1
        state = self.FLYING * self.flying | (self.WATCHDOG if time.monotonic() - self.heard > 2 else 0)
        state |= 0 if self.configured else self.BOOTSTRAP
        data = struct.pack("<IIII", 0x55667788, state, self.number, 1)
        if self.configured:
            control = (3 if self.flying else 2) << 16
            demo = struct.pack("<II3fi3f", control, 71, 0.0, 0.0, -math.degrees(b.yaw) * 1000, round(b.z * 1000),
                               b.v[0] * 1000, -b.v[1] * 1000, -b.v[2] * 1000)
            demo += bytes(148 - 4 - len(demo))
            data += struct.pack("<HH", 0, 148) + demo
        return data + struct.pack("<HHI", 0xFFFF, 8, sum(data))

    def command(self, text):
        match = re.fullmatch(r"AT\*(\w+)=(\d+)(?:,(.*))?", text)
        assert match, text
        name, number, rest = match[1], int(match[2]), match[3]
        self.heard = time.monotonic()
        if number <= self.sequence and number != 1:
            self.old += 1
            return
        self.sequence = number
        self.commands.append(text)
        values = rest.split(",") if rest else []
        if name == "CONFIG" and rest == '"general:navdata_demo","TRUE"':
            self.configured = True
        elif name == "REF":
            flying = bool(int(rest) & 1 << 9)
            if flying and not self.flying:
                self.body.wanted = [0, 0, 0.5, 0]
                self.flips += 1
            self.flying = flying
        elif name == "PCMD":
            flag, *bits = (int(v) for v in values)
            assert len(bits) == 4, text
            roll, pitch, up, turn = (struct.unpack("<f", struct.pack("<i", b))[0] for b in bits)
            if self.flying:
                self.body.wanted = [-pitch * 1.5, -roll * 1.5, up * 0.7, -turn * 1.7] if flag & 1 else [0.0] * 4


def free_udp_port():
    s = udp()
    port = s.getsockname()[1]
    s.close()
    return port
