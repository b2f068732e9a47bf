"""A runtime for sinew-sim, written from docs/sim-protocol.md with struct and socket only.

Starts the program given on the command line, flies a scripted second in lockstep (or free-running) and checks what
comes over the wire. Exits 0 when everything was as documented.

usage: runtime.py SINEW_SIM [--mode lockstep|free] [--seconds S] [--tcp] [--shared] [--camera WxH] [--seed N]
"""
import argparse
import hashlib
import json
import mmap
import os
import resource
import socket
import struct
import subprocess
import sys
import tempfile
import time

MAGIC, VERSION = 0x50574E53, 1
HELLO, WELCOME, START, CLOCK, GRANT, DONE, COMMAND, STOP, BYE = range(1, 10)
IMU, RANGE, BARO, FRAME, BATTERY, TRUTH, REPORT = 16, 17, 18, 19, 20, 24, 25
HEADER = struct.Struct("<IHHIIq")


class Wire:
    def __init__(self, sock):
        self.sock, self.sent, self.received, self.buffer, self.memory = sock, 0, 0, bytearray(), None

    def send(self, kind, device, at, payload=b""):
        self.sock.sendall(HEADER.pack(24 + len(payload), kind, device, self.sent, 0, at) + payload)
        self.sent += 1

    def bytes(self, n):
        while len(self.buffer) < n:
            if self.sock.family == socket.AF_UNIX:
                more, handles, _, _ = socket.recv_fds(self.sock, 1 << 18, 1)
                for handle in handles:
                    self.memory = mmap.mmap(handle, 0, prot=mmap.PROT_READ)
            else:
                more = self.sock.recv(1 << 18)
            if not more:
                sys.exit("the plant closed the connection")
            self.buffer += more
        out = bytes(self.buffer[:n])
        del self.buffer[:n]
        return out

    def next(self):
        size, kind, device, sequence, flags, at = HEADER.unpack(self.bytes(24))
        assert sequence == self.received and flags == 0, "sequence or flags"
        self.received += 1
        return kind, device, at, self.bytes(size - 24)


def connect(args, folder):
    endpoint = "tcp:127.0.0.1:0" if args.tcp else "unix:" + os.path.join(folder, "plant.sock")
    plant = subprocess.Popen(
        [args.program, "--listen", endpoint, "--camera", args.camera], stdout=subprocess.PIPE, text=True)
    line = plant.stdout.readline()  # "listening on ENDPOINT, camera ..."
    if not line.startswith("listening on "):
        sys.exit("plant did not start")
    where = line[len("listening on "):].split(",")[0]
    if args.tcp:
        host, port = where.split(":")[1:]
        sock = socket.create_connection((host, int(port)))
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    else:
        sock = socket.socket(socket.AF_UNIX)
        sock.connect(where[len("unix:"):])
    return plant, Wire(sock)


def command(commit, value):
    return struct.pack("<qqII8d", 20_000_000, commit, 4, 1, *([value] * 4 + [0.0] * 4))


def pixels_of(payload, slot, generation, camera, memory):
    """From the stream, or from the shared memory of the Welcome."""
    if slot == 0xFFFFFFFF:
        return payload[40:]
    w, h, _, slots, offset, stride = struct.unpack_from("<IIIIQI", camera, 24)
    assert slot < slots
    at = offset + slot * stride
    assert struct.unpack_from("<I", memory, at)[0] == generation, "an overwritten slot"
    return memory[at + 64:at + 64 + w * h * 2]


def check_frame(payload, width, height, camera, memory):
    _, exposure, number, w, h, form, slot, generation = struct.unpack_from("<qqIIIIII", payload)
    assert (w, h, form) == (width, height, 4) and exposure > 0
    assert (slot == 0xFFFFFFFF) == (memory is None)
    pixels = pixels_of(payload, slot, generation, camera, memory)
    assert len(pixels) == w * h * 2
    luma = pixels[::2]
    assert max(luma) - min(luma) > 40, "a frame without contrast"
    return number


def fly(wire, args):
    width, height = map(int, args.camera.split("x"))
    free = args.mode == "free"
    wire.send(HELLO, 0, 0, struct.pack("<IHHdQII32s", MAGIC, VERSION, 1 if free else 0, 1.0, args.seed, 1 if args.shared else 0, 0, b"script"))
    kind, _, _, welcome = wire.next()
    assert kind == WELCOME, "the answer to Hello is Welcome"
    magic, version, devices, step, seed = struct.unpack_from("<IHHqQ", welcome)
    assert (magic, version, seed) == (MAGIC, VERSION, args.seed) and step <= 250_000
    names = [welcome[72 + 96 * i + 56:72 + 96 * i + 88].rstrip(b"\0").decode() for i in range(devices)]
    motors = names.index("motors")
    camera = welcome[72 + 96 * names.index("camera"):]
    assert args.shared == (wire.memory is not None)
    wire.send(START, 0, 0)

    seen, frames, digest, heights, report = {}, [], hashlib.sha256(), [], {}
    end = int(args.seconds * 1e9)
    while True:
        kind, device, at, payload = wire.next()
        seen[kind] = seen.get(kind, 0) + 1
        if kind in (IMU, RANGE, BARO, FRAME, BATTERY):
            digest.update(struct.pack("<q", at) + payload)
        if kind == FRAME:
            frames.append(check_frame(payload, width, height, camera, wire.memory))
        elif kind == BATTERY:
            volt, ampere, charge = struct.unpack_from("<3d", payload, 8)
            assert 13 < volt < 17 and ampere > -2 and 0 <= charge <= 1, (volt, ampere, charge)
        elif kind == TRUTH:
            heights.append(struct.unpack_from("<3d", payload)[2])
        elif kind == REPORT:
            report = json.loads(payload)
        elif kind == BYE:
            sys.exit("plant said: " + payload.decode())
        if kind == (IMU if free else GRANT):
            wire.send(COMMAND, motors, at, command(at, 0.6))
            if not free:
                wire.send(DONE, 0, at)
            if at >= end:
                wire.send(BYE, 0, at, b"script is over")
                return seen, frames, digest.hexdigest(), heights, report


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--mode", choices=["lockstep", "free"], default="lockstep")
    p.add_argument("--seconds", type=float, default=1.0)
    p.add_argument("--camera", default="320x240")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--tcp", action="store_true")
    p.add_argument("--shared", action="store_true", help="take frames from shared memory")
    args = p.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        plant, wire = connect(args, folder)
        try:
            begin = time.monotonic()
            seen, frames, digest, heights, report = fly(wire, args)
            wall = time.monotonic() - begin
            code = plant.wait(timeout=20)
        finally:
            plant.kill()
    for line in plant.stdout:
        print("plant:", line.rstrip())
    print("digest", digest)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{args.seconds:g} s in {wall:.2f} s, plant used {used.ru_utime + used.ru_stime:.2f} s of CPU with its start, "
          f"{used.ru_maxrss // 1024} MB")
    n = args.seconds
    assert code == 0, f"exit code {code}"
    assert abs(seen[IMU] - 1000 * n) <= 2 and abs(seen[RANGE] - 100 * n) <= 2 and abs(seen[BARO] - 50 * n) <= 2, seen
    assert abs(seen[BATTERY] - 10 * n) <= 2, seen
    if args.mode == "lockstep":
        assert frames == list(range(1, len(frames) + 1)) and abs(len(frames) - 30 * n) <= 2, frames
    assert max(heights) > heights[0] + 0.02, "four motors at 0.6 lift it"
    assert "imu_gap_max_ns" in report and report["seed"] == args.seed


main()
