"""tools/urdf_body.py: a body has its links, its masses and its places where the URDF has them, for any angles.

argv: SOURCE EXAMPLE_CROUCH
"""
import importlib.util
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import tomllib
import unittest

SOURCE, CROUCH = sys.argv[1:3]
TOOL = f"{SOURCE}/tools/urdf_body.py"
spec = importlib.util.spec_from_file_location("urdf_body", TOOL)
tool = importlib.util.module_from_spec(spec)
spec.loader.exec_module(tool)
times, plus, of, rotation = tool.times, tool.plus, tool.of, tool.rotation


def about(axis, angle):
    n = math.sqrt(sum(a * a for a in axis))
    x, y, z = (a / n for a in axis)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


class Tree:
    """A random robot: every third joint is fixed."""

    def __init__(self, seed, links=14):
        self.random = random.Random(seed)
        vec = lambda most: [self.random.uniform(-most, most) for _ in range(3)]
        self.joints = [None] + [{"parent": self.random.randrange(i), "xyz": vec(0.3), "rpy": vec(1.5), "axis": vec(1),
                                 "fixed": i % 3 == 0} for i in range(1, links)]
        self.masses = [{"kg": self.random.uniform(0.1, 2), "com": vec(0.1), "rpy": vec(1)} for _ in range(links)]
        self.angles = {i: self.random.uniform(-1, 1) for i, j in enumerate(self.joints) if j and not j["fixed"]}

    def urdf(self):
        words = lambda v: " ".join(repr(x) for x in v)
        out = '<robot name="any robot">\n'
        for i, m in enumerate(self.masses):
            out += (f'<link name="link{i}"><inertial><origin xyz="{words(m["com"])}" rpy="{words(m["rpy"])}"/><mass value="{m["kg"]!r}"/>'
                    f'<inertia ixx="0.01" iyy="0.02" izz="0.025" ixy="0.001" ixz="0" iyz="0"/></inertial>'
                    f'<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>\n')
        for i, j in enumerate(self.joints):
            if j:
                out += (f'<joint name="joint{i}" type="{"fixed" if j["fixed"] else "revolute"}"><parent link="link{j["parent"]}"/>'
                        f'<child link="link{i}"/><origin xyz="{words(j["xyz"])}" rpy="{words(j["rpy"])}"/>'
                        f'<axis xyz="{words(j["axis"])}"/><limit lower="-2" upper="2" effort="3" velocity="6"/></joint>\n')
        return out + "</robot>\n"

    def frames(self):
        all_of_them = [([0.0] * 3, tool.IDENTITY)]
        for i, j in enumerate(self.joints[1:], 1):
            at, r = all_of_them[j["parent"]]
            turn = times(r, rotation(*j["rpy"]))
            if not j["fixed"]:
                turn = times(turn, about(j["axis"], self.angles[i]))
            all_of_them.append((plus(at, of(r, j["xyz"])), turn))
        return all_of_them

    def middle(self):
        frames, kg = self.frames(), sum(m["kg"] for m in self.masses)
        sums = [0.0] * 3
        for (at, r), m in zip(frames, self.masses):
            sums = plus(sums, [m["kg"] * x for x in plus(at, of(r, m["com"]))])
        return kg, [s / kg for s in sums]


def converted(text, *places):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "robot.urdf"
        file.write_text(text, encoding="utf-8")
        return subprocess.run([sys.executable, "-B", TOOL, str(file), *places], capture_output=True, text=True, check=False)


class Urdf(unittest.TestCase):
    def near(self, a, b, within=1e-7):
        self.assertLess(max(abs(x - y) for x, y in zip(a, b)), within, (a, b))

    def test_links_masses_and_places_are_where_the_urdf_has_them(self):
        for seed in range(20):
            tree = Tree(seed)
            fixed = [f"link{i}" for i, j in enumerate(tree.joints) if j and j["fixed"]]
            done = converted(tree.urdf(), *fixed)
            self.assertEqual(done.returncode, 0, done.stderr)
            body = tomllib.loads(done.stdout)
            frames, places = {}, {}
            kg, moment = 0, [0.0] * 3
            for link in body["link"]:
                at, r = frames[link["parent"]] if "parent" in link else ([0.0] * 3, tool.IDENTITY)
                if "parent" in link:
                    at, r = plus(at, of(r, link["at_m"])), times(r, about(link["axis"], tree.angles[int(link["name"][4:])]))
                frames[link["name"]] = at, r
                kg += link["mass_kg"]
                moment = plus(moment, [link["mass_kg"] * x for x in plus(at, of(r, link["com_m"]))])
            for place in body["place"]:
                at, r = frames[place["link"]]
                places[place["name"]] = (plus(at, of(r, place["at_m"])),
                                         times(r, rotation(*(math.radians(d) for d in place["roll_pitch_yaw_deg"]))))
            whole_kg, middle = tree.middle()
            self.assertAlmostEqual(kg, whole_kg, 7)
            self.near([m / kg for m in moment], middle)
            for i, (at, turn) in enumerate(tree.frames()):
                name = f"link{i}"
                if name in places:  # places have the URDF's axes, links those of the body
                    self.near(places[name][0], at)
                    for mine, theirs in zip(places[name][1], turn):
                        self.near(mine, theirs)
                elif name in frames:
                    self.near(frames[name][0], at)

    def test_the_body_reader_takes_it(self):
        done = converted(Tree(1).urdf())
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "body.toml"
            file.write_text(done.stdout, encoding="utf-8")
            said = subprocess.run([CROUCH, str(file)], capture_output=True, text=True, check=False)
            self.assertEqual(said.stderr, "l_sole: it is missing\n")

    def test_what_cannot_be_is_refused_by_name(self):
        text = Tree(2).urdf()
        for old, new, words in (('type="revolute"', 'type="prismatic"', "joint1: prismatic"), ('<axis xyz="', '<axis xyz="x ', "numbers are wanted"),
                                ('<child link="link1"/>', '<child link="link2"/>', "hangs on nothing"), ("</robot>", "", "robot.urdf")):
            done = converted(text.replace(old, new))
            self.assertNotEqual(done.returncode, 0, new)
            self.assertIn(words, done.stderr)
        self.assertIn("no link is called nowhere", converted(text, "nowhere").stderr)
        mesh = text.replace('<box size="0.1 0.2 0.3"/>', '<mesh filename="x"/>', 1)
        self.assertIn("left out: link link0: mesh", converted(mesh).stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
