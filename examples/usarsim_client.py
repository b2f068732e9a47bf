"""Flies an AirRobot of `sinew-sim --serve usarsim` by text alone: up, round a square, down, with a picture from each corner.

usage: usarsim_client.py [HOST [TEXT_PORT [IMAGE_PORT]]]        pictures: corner_1.jpg to corner_4.jpg
"""
import re
import socket
import struct
import sys

HOST, PORT, IMAGE_PORT = (sys.argv[1:] + ["127.0.0.1", "3000", "5003"][len(sys.argv) - 1:])[:3]
SIDE_M, SPEED_MPS, HEIGHT_M, CLIMB_MPS = 1.0, 0.5, 1.2, 0.5

robot = socket.create_connection((HOST, int(PORT)))
lines = robot.makefile("r", encoding="ascii", newline="\r\n")
camera = socket.create_connection((HOST, int(IMAGE_PORT)))


def say(line):
    robot.sendall(line.encode() + b"\r\n")


def where():
    """Position from the next GroundTruth: x east, y to the right of it, z up."""
    for line in lines:
        if line.startswith("NFO {Error"):
            sys.exit(line)
        if "{Type GroundTruth}" in line:
            return [float(v) for v in re.search(r"{Location ([^}]*)}", line)[1].split(",")]
    sys.exit("the connection ended")


def drive(up=0.0, forward=0.0, right=0.0):
    say(f"DRIVE {{AltitudeVelocity {up:.2f}}} {{LinearVelocity {forward:.2f}}} {{LateralVelocity {right:.2f}}}")


def picture(name):
    camera.sendall(b"OK")
    header = camera.recv(5, socket.MSG_WAITALL)
    with open(name, "wb") as file:
        file.write(camera.recv(struct.unpack(">I", header[1:])[0], socket.MSG_WAITALL))


say("INIT {ClassName USARBot.AirRobot} {Name Square} {Start Pose1}")
start = where()
drive(up=CLIMB_MPS)
while where()[2] < HEIGHT_M:
    pass
for corner, (axis, sign) in enumerate(((0, 1), (1, 1), (0, -1), (1, -1)), 1):
    target = where()[axis] + sign * SIDE_M
    drive(forward=SPEED_MPS * sign * (axis == 0), right=SPEED_MPS * sign * (axis == 1))
    while sign * (target - where()[axis]) > 0:
        pass
    drive()
    picture(f"corner_{corner}.jpg")
    print(f"corner {corner}: {where()}")
drive(up=-CLIMB_MPS)
while where()[2] > start[2] + 0.02:
    pass
print(f"landed {where()}")
