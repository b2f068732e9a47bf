#!/usr/bin/env python3
"""A body (docs/bodies.md) from a URDF file: links, hinges, masses, boxes, cylinders and spheres.

usage: urdf_body.py ROBOT.urdf [PLACE_LINK...] > body.toml

Links that hang on a fixed joint become part of the link that they hang on, with their mass. Links that are named on the command
line (a camera's, the IMU's, a sole's) become places. In the body all frames are parallel when all joints are
at 0, as docs/bodies.md says; the joints' zeros stay where the URDF has them. Servos are made of each pair of `effort` and
`velocity`. What is left out is said: meshes, sliding joints (refused), mimic joints (refused).
"""
import math
import re
import sys
import xml.etree.ElementTree as xml

IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def fail(text):
    sys.exit(f"urdf_body.py: {text}")


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def of(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def numbers(text, count, where):
    try:
        all_of_them = [float(word) for word in text.split()]
    except ValueError:
        all_of_them = []
    if len(all_of_them) != count or not all(map(math.isfinite, all_of_them)):
        fail(f"{where}: {text!r}: {count} numbers are wanted")
    return all_of_them


def rotation(roll, pitch, yaw):
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]]


def angles(r):
    pitch = math.asin(max(-1, min(1, -r[2][0])))
    if abs(r[2][0]) > 1 - 1e-12:
        return [0.0, pitch, math.atan2(-r[0][1], r[1][1])]
    return [math.atan2(r[2][1], r[2][2]), pitch, math.atan2(r[1][0], r[0][0])]


def origin(element, where):
    found = element.find("origin") if element is not None else None
    if found is None:
        return [0.0] * 3, IDENTITY
    return (numbers(found.get("xyz", "0 0 0"), 3, where),
            rotation(*numbers(found.get("rpy", "0 0 0"), 3, where)))


def shown(values, digits=9):
    words = [f"{round(v, digits) + 0.0:.10g}" for v in values]
    return "[" + ", ".join(words) + "]" if len(words) > 1 else words[0]


def named(name):
    return re.sub(r"[^A-Za-z0-9_]", "_", name)


class Mass:
    """Sums of mass, moment and inertia about the link's origin."""

    def __init__(self):
        self.kg, self.moment, self.about = 0.0, [0.0] * 3, [[0.0] * 3 for _ in range(3)]

    def add(self, kg, com, inertia):
        self.kg += kg
        self.moment = plus(self.moment, [kg * c for c in com])
        square = sum(c * c for c in com)
        for i in range(3):
            for j in range(3):
                self.about[i][j] += inertia[i][j] + kg * ((square if i == j else 0) - com[i] * com[j])

    def middle(self):
        return [m / self.kg for m in self.moment] if self.kg > 0 else [0.0] * 3

    def inertia(self):
        com = self.middle()
        square = sum(c * c for c in com)
        at = [[self.about[i][j] - self.kg * ((square if i == j else 0) - com[i] * com[j]) for j in range(3)] for i in range(3)]
        return [at[0][0], at[1][1], at[2][2], at[0][1], at[0][2], at[1][2]]


class Converter:
    def __init__(self, robot, wanted):
        self.links = {link.get("name"): link for link in robot.findall("link")}
        self.joints = robot.findall("joint")
        self.wanted, self.places, self.servos, self.out, self.left_out = wanted, [], {}, [], []
        children = {joint.find("child").get("link") for joint in self.joints}
        roots = [name for name in self.links if name not in children]
        if len(roots) != 1:
            fail(f"one link that hangs on nothing is wanted, here are {len(roots)}: {', '.join(roots)}")
        for name in wanted:
            if name not in self.links:
                fail(f"no link is called {name}; known: {', '.join(self.links)}")
        self.link(roots[0], None, [0.0] * 3, None, None, IDENTITY)
        self.text = f'name = "{named(robot.get("name", "robot"))}"\n\n' + "".join(
            f'[[servo]]\nname = "{name}"\nstall_nm = {effort:g}\nno_load_radps = {velocity:g}\n\n'
            for (effort, velocity), name in self.servos.items()) + "\n".join(self.out) + "".join(
            f'\n[[place]]\nname = "{named(name)}"\nlink = "{on}"\nat_m = {shown(at)}\n'
            f'roll_pitch_yaw_deg = {shown([math.degrees(a) for a in angles(turn)])}\n' for name, on, at, turn in self.places)

    def link(self, name, parent, at, joint, axis, turn):
        """`turn` takes the URDF's axes of this link to those of the body."""
        own, mass, shapes, hinges = named(name), Mass(), [], []
        self.gather(name, own, [0.0] * 3, turn, mass, shapes, hinges)
        lines = [f'[[link]]\nname = "{own}"']
        if joint is not None:
            limit = joint.find("limit")
            where = f'joint {joint.get("name")}: limit'
            if limit is None and joint.get("type") != "continuous":
                fail(f"{where} is missing")
            get = lambda key, otherwise: float(limit.get(key, otherwise)) if limit is not None else otherwise
            low, high = get("lower", -math.pi), get("upper", math.pi)
            servo = self.servos.setdefault((max(get("effort", 1), 1e-3), max(get("velocity", 1), 1e-2)), f"servo_{len(self.servos) + 1}")
            lines.append(f'parent = "{parent}"\nat_m = {shown(at)}\naxis = {shown(axis)}\n'
                         f'range_deg = {shown([math.degrees(low), math.degrees(high)], 6)}\nservo = "{servo}"')
        if mass.kg > 0:
            lines.append(f'mass_kg = {shown([mass.kg])}\ncom_m = {shown(mass.middle())}\ninertia_kgm2 = {shown(mass.inertia(), 12)}')
        self.out.append("\n".join(lines + shapes) + "\n")
        for child, place, hinge, direction, child_turn in hinges:
            self.link(child, own, place, hinge, direction, child_turn)

    def gather(self, name, own, at, turn, mass, shapes, hinges):
        """What belongs to the link `own`: of this link, `at` there, and of those that are fixed to it."""
        if name in self.wanted:
            self.places.append((name, own, at, turn))
        element = self.links[name]
        inertial = element.find("inertial")
        if inertial is not None:
            com, r = origin(inertial, f"link {name}: inertial")
            i = {key: float(inertial.find("inertia").get(key, 0)) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")}
            r = times(turn, r)
            tensor = [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]]
            mass.add(float(inertial.find("mass").get("value")), plus(at, of(turn, com)), times(times(r, tensor), transposed(r)))
        for collision in element.findall("collision"):
            self.shape(name, collision, at, turn, shapes)
        for joint in self.joints:
            if joint.find("parent").get("link") != name:
                continue
            kind, where = joint.get("type"), f'joint {joint.get("name")}'
            offset, r = origin(joint, where)
            child, place, child_turn = joint.find("child").get("link"), plus(at, of(turn, offset)), times(turn, r)
            if kind == "fixed":
                self.gather(child, own, place, child_turn, mass, shapes, hinges)
            elif kind in ("revolute", "continuous") and joint.find("mimic") is None:
                axis = joint.find("axis")
                direction = numbers(axis.get("xyz"), 3, where) if axis is not None else [1.0, 0.0, 0.0]
                hinges.append((child, place, joint, of(child_turn, direction), child_turn))
            else:
                fail(f"{where}: {'a mimic joint' if joint.find('mimic') is not None else kind}: only fixed, revolute and continuous ones")

    def shape(self, name, collision, at, turn, shapes):
        offset, r = origin(collision, f"link {name}: collision")
        where, direction = plus(at, of(turn, offset)), [math.degrees(a) for a in angles(times(turn, r))]
        for kind in collision.find("geometry"):
            if kind.tag == "box":
                own = f'kind = "box"\nsize_m = {shown(numbers(kind.get("size"), 3, name))}'
            elif kind.tag == "sphere":
                own = f'kind = "sphere"\nradius_m = {float(kind.get("radius")):g}'
            elif kind.tag == "cylinder":  # with its ends rounded within its length
                radius, length = float(kind.get("radius")), float(kind.get("length"))
                own = f'kind = "capsule"\nradius_m = {radius:g}\nlength_m = {max(length - 2 * radius, 1e-4):g}'
            else:
                self.left_out.append(f"link {name}: {kind.tag}")
                continue
            shapes.append(f'\n[[link.shape]]\n{own}\nat_m = {shown(where)}\nroll_pitch_yaw_deg = {shown(direction, 6)}')


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    try:
        robot = xml.parse(sys.argv[1]).getroot()
    except (OSError, xml.ParseError) as error:
        fail(f"{sys.argv[1]}: {error}")
    converter = Converter(robot, sys.argv[2:])
    print(converter.text, end="")
    for text in converter.left_out:
        print(f"urdf_body.py: left out: {text}", file=sys.stderr)


if __name__ == "__main__":
    main()
