"""A second implementation of the team protocol, written from docs/team-protocol.md, against the first.

usage: team_frame_test.py TOOL
"""
import random
import struct
import subprocess
import sys
import unittest

TOOL = sys.argv[1]
HEAD, ECHO, MESSAGE = struct.Struct("<4sBBBBHHIIIq"), struct.Struct("<HIIqq"), struct.Struct("<BHIIq")
MOST_NS = 2 ** 61
PRINTABLE = bytes(range(0x21, 0x7F))


class Refused(Exception):
    pass


def need(holds):
    if not holds:
        raise Refused


def pack(head, echoes, messages):
    robot, team, start, sequence, sent = head
    out = HEAD.pack(b"SNWT", 1, len(echoes), len(messages), 0, robot, 0, team, start, sequence, sent)
    for echo in echoes:
        out += ECHO.pack(*echo)
    for topic, kind, number, stamp, content in messages:
        out += MESSAGE.pack(len(topic), len(content), kind, number, stamp) + topic + content
    return out


def unpack(data):
    need(len(data) >= HEAD.size)
    magic, version, n_echoes, n_messages, zero, robot, zeros, team, start, sequence, sent = HEAD.unpack_from(data)
    need(magic == b"SNWT" and version == 1 and zero == 0 and zeros == 0 and robot > 0 and n_echoes <= 15)
    need(abs(sent) <= MOST_NS)
    at, echoes, messages = HEAD.size, [], []
    for _ in range(n_echoes):
        need(len(data) >= at + ECHO.size)
        echoes.append(ECHO.unpack_from(data, at))
        need(echoes[-1][0] > 0 and abs(echoes[-1][3]) <= MOST_NS and abs(echoes[-1][4]) <= MOST_NS)
        at += ECHO.size
    for _ in range(n_messages):
        need(len(data) >= at + MESSAGE.size)
        n_topic, n_content, kind, number, stamp = MESSAGE.unpack_from(data, at)
        at += MESSAGE.size
        need(len(data) >= at + n_topic + n_content)
        topic, content = data[at:at + n_topic], data[at + n_topic:at + n_topic + n_content]
        need(abs(stamp) <= MOST_NS)
        need(1 <= n_topic <= 64 and n_content >= 4 and all(c in PRINTABLE for c in topic))
        messages.append((topic, kind, number, stamp, content))
        at += n_topic + n_content
    need(at == len(data))
    return (robot, team, start, sequence, sent), echoes, messages


def as_text(head, echoes, messages):
    parts = [" ".join(map(str, head))] + [" ".join(map(str, e)) for e in echoes]
    parts += [f"{m[0].decode()} {m[1]} {m[2]} {m[3]} {m[4].hex()}" for m in messages]
    return "ok " + " | ".join(parts)


def any_frame(r):
    def u(bits):
        return r.choice([0, 1, 2 ** bits - 1, r.getrandbits(bits)])

    def i64():
        return r.choice([0, -1, -MOST_NS, MOST_NS, r.randint(-MOST_NS, MOST_NS)])

    head = (r.choice([1, 65535, r.randint(1, 65535)]), u(32), u(32), u(32), i64())
    echoes = [(r.randint(1, 65535), u(32), u(32), i64(), i64()) for _ in range(r.choice([0, 1, 3, 15]))]
    messages = [(bytes(r.choices(PRINTABLE, k=r.choice([1, 64, r.randint(1, 64)]))), u(32), u(32), i64(),
                 r.randbytes(r.choice([4, 5, r.randint(4, 300)]))) for _ in range(r.choice([0, 1, 2, 4]))]
    return head, echoes, messages


class TeamFrame(unittest.TestCase):
    def setUp(self):
        self.random = random.Random(22)

    def answers(self, frames):
        done = subprocess.run([TOOL], input="".join(f.hex() + "\n" for f in frames), capture_output=True, text=True,
                              timeout=60, check=True)
        answers = done.stdout.splitlines()
        self.assertEqual(len(answers), len(frames))
        return answers

    def test_both_read_and_write_the_same_bytes(self):
        frames = [any_frame(self.random) for _ in range(500)]
        packed = [pack(*f) for f in frames]
        for frame, data, answer in zip(frames, packed, self.answers(packed)):
            read, written = answer.rsplit(" = ", 1)
            self.assertEqual(read, as_text(*frame))
            self.assertEqual(written, data.hex())
            self.assertEqual(unpack(bytes.fromhex(written)), frame)

    def test_both_refuse_the_same_datagrams(self):
        r, damaged = self.random, []
        for _ in range(3000):
            data = bytearray(pack(*any_frame(r)))
            for _ in range(r.choice([0, 1, 1, 2])):
                data[r.randrange(min(len(data), r.choice([12, 80, 2000])))] = r.choice([0, 1, 255, r.randrange(256)])
            cut = r.choice([None, None, len(data) - 1, r.randrange(len(data) + 1)])
            damaged.append(bytes(data[:cut]) + (b"\0" if r.random() < 0.1 else b""))
        refused = 0
        for data, answer in zip(damaged, self.answers(damaged)):
            try:
                frame = unpack(data)
                self.assertEqual(answer.rsplit(" = ", 1)[0], as_text(*frame), data.hex())
            except Refused:
                refused += 1
                self.assertTrue(answer.startswith("no "), data.hex() + ": " + answer)
        self.assertGreater(refused, 500)
        self.assertLess(refused, len(damaged) - 500)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
