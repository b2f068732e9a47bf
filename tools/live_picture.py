#!/usr/bin/env python3
"""Makes docs/img/live.svg: the live table as a real flight draws it on a terminal, letter by letter.

usage: live_picture.py SINEW ROBOT OUT.svg [SECONDS]

Runs the robot in real time on a terminal of its own and keeps the last table that was drawn before SECONDS (12) were over.
"""
import fcntl
import html
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import time

COLUMNS, ROWS = 100, 60
CHAR_PX, LINE_PX, MARGIN_PX = 7.8, 17, 14


def drawn(command, seconds):
    """What the command writes to a terminal in so many seconds."""
    pid, terminal = pty.fork()
    if pid == 0:
        os.environ["SINEW_RECORD"] = "off"
        os.execv(command[0], command)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
    text, end = b"", time.monotonic() + seconds
    while time.monotonic() < end:
        if select.select([terminal], [], [], 0.1)[0]:
            try:
                text += os.read(terminal, 65536)
            except OSError:
                break
    os.kill(pid, signal.SIGINT)
    while True:  # it must not wait for a terminal that nobody reads
        try:
            if not os.read(terminal, 65536):
                break
        except OSError:
            break
    os.waitpid(pid, 0)
    return text.decode()


def last_table(text):
    """The lines of the last whole drawing: each ends with the command that clears what is below."""
    tables = [part for part in text.split("\x1b[J")[:-1] if "thread " in part]
    if not tables:
        sys.exit("no table was drawn: " + text[-500:])
    plain = re.sub(r"\x1b\[[0-9]*[A-Za-z]|\r", "", tables[-1])
    return plain.rstrip("\n").split("\n")


def svg(lines):
    width = round(2 * MARGIN_PX + CHAR_PX * max(len(line) for line in lines))
    height = 2 * MARGIN_PX + LINE_PX * len(lines)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
           f'<rect width="{width}" height="{height}" rx="6" fill="#1d2127"/>',
           '<g font-family="DejaVu Sans Mono,Menlo,Consolas,monospace" font-size="13" fill="#d8dee6">']
    for i, line in enumerate(lines):
        head = ' fill="#8fb8e8"' if i == 0 or line.startswith(("thread ", "topic ")) else ""
        length = f' textLength="{CHAR_PX * len(line):.1f}"' if line else ""
        out.append(f'<text x="{MARGIN_PX}" y="{MARGIN_PX + LINE_PX * i + 13}" xml:space="preserve"{length}{head}>'
                   f'{html.escape(line)}</text>')
    return "\n".join(out + ["</g>", "</svg>"]) + "\n"


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    program, robot, path = sys.argv[1:4]
    text = drawn([os.path.abspath(program), "run", robot], float(sys.argv[4]) if len(sys.argv) == 5 else 12)
    with open(path, "w", encoding="utf-8") as file:
        file.write(svg(last_table(text)))


if __name__ == "__main__":
    main()
