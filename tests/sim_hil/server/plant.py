#!/usr/bin/env python3
"""A mass on four thrusters that moves up and down, written from docs/sim-protocol.md alone; lockstep only.
usage: plant.py unix:PATH|tcp:PORT SECONDS    listens, says where, serves one runtime, prints the final height"""
import random, socket, struct, sys

STEP, MASS, GRAVITY, MAX_THRUST = 250_000, 1.0, 9.81, 5.0  # ns, kg, m/s^2, N per thruster
kind, where = sys.argv[1].split(":", 1)
listener = socket.socket(socket.AF_UNIX if kind == "unix" else socket.AF_INET, socket.SOCK_STREAM)
listener.bind(where if kind == "unix" else ("127.0.0.1", int(where)))
listener.listen(1)
print(where if kind == "unix" else listener.getsockname()[1], flush=True)
link = listener.accept()[0]
if kind == "tcp": link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
stream, sent, received = link.makefile("rb"), 0, 0

def pack(type_, device, time, payload=b""):
    global sent
    sent += 1
    return struct.pack("<IHHIIq", 24 + len(payload), type_, device, sent - 1, 0, time) + payload

def read():
    global received
    head = stream.read(24)
    if len(head) < 24: sys.exit("runtime is gone")
    size, type_, device, sequence, flags, time = struct.unpack("<IHHIIq", head)
    if sequence != received: sys.exit("messages are missing")
    received += 1
    return type_, device, time, stream.read(size - 24)

def device(kind, channels, period, latency, name):
    return struct.pack("<HHIqqIIIIQII32sQ", kind, 0, channels, period, latency, 0, 0, 0, 0, 0, 0, 0, name, 0)

type_, _, _, hello = read()
magic, version, mode, rate, seed = struct.unpack("<IHHdQ", hello[:24])
if (type_, magic, version, mode) != (1, 0x50574E53, 1, 0):
    link.sendall(pack(9, 0, 0, b"this plant speaks version 1, lockstep"))
    sys.exit("cannot serve this Hello")
noise = random.Random(seed)
link.sendall(pack(2, 0, 0, struct.pack("<IHHqQQQ32s", magic, 1, 3, STEP, seed, 0, 0, b"point_mass") + device(
    1, 0, 1_000_000, 0, b"imu") + device(2, 0, 20_000_000, 5_000_000, b"range") + device(5, 4, 0, 0, b"motors")))
if read()[0] != 3: sys.exit("no Start")
height, speed, accel, command = 0.0, 0.0, 0.0, (0, 0, [])  # command: commit, end of its lease, setpoints
for t in range(0, int(float(sys.argv[2]) * 1e9) + 1, STEP):
    imu = struct.pack("<q6d", t, 0, 0, 0, 0, 0, accel + GRAVITY + noise.gauss(0, 0.05))
    out = pack(16, 0, t, imu) if t % 1_000_000 == 0 else b""
    if t % 20_000_000 == 0: out += pack(17, 1, t, struct.pack("<qd", t + 5_000_000, height + noise.gauss(0, 0.005)))
    link.sendall(out + pack(5, 0, t))
    while (message := read())[0] != 6:
        if message[0] == 9: sys.exit("runtime: " + message[3].decode())
        lease, _, count, armed, *values = struct.unpack("<qqII8d", message[3].ljust(88, b"\0"))  # a Stop: all zero
        command = (message[2], message[2] + lease, [max(0.0, min(1.0, v)) * armed for v in values[:count]])
    thrust = MAX_THRUST * sum(command[2]) if command[0] <= t < command[1] else 0.0
    accel = thrust / MASS - GRAVITY if height > 0.0 or thrust > MASS * GRAVITY else 0.0
    speed = speed + accel * STEP * 1e-9 if height > 0.0 or accel > 0.0 else 0.0
    height = max(0.0, height + speed * STEP * 1e-9)
link.sendall(pack(25, 0, t, b'{"valid": true, "height_m": %.6f}' % height) + pack(9, 0, t, b"end of run"))
