#!/usr/bin/env python3
"""Draws the rooms of cmake/rooms.txt: docs/rooms.svg, and the table between the two marks in docs/design.md.

    tools/rooms.py           writes both
    tools/rooms.py --check   writes nothing; exit 1 when one of them differs from the table
"""
import html
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- rooms: made by tools/rooms.py -->", "<!-- rooms end -->"
CHARACTER, PAD, GAP, BOX, ROW_GAP, WIDTH = 7.4, 10, 8, 26, 40, 960


def read_table():
    """[(room, rooms that it sees, what it holds)] in the table's order."""
    lines = (ROOT / "cmake/rooms.txt").read_text(encoding="utf-8").splitlines()
    found = [re.fullmatch(r"([a-z0-9_/*]+):([a-z0-9_/* ]*)\| (.+)", line) for line in lines if line and line[0] != "#"]
    return [(m[1], m[2].split(), m[3]) for m in found]


def page_table(rooms):
    rows = ["| room | holds | sees |", "|---|---|---|"]
    for room, sees, holds in rooms:
        rows.append(f"| `{room}/` | {holds} | {', '.join(sees) or 'nothing'} |")
    return "\n".join(rows)


def group_of(room):
    return room.split("/")[0]


def levels_of(rooms):
    """{group: longest chain below it}, and {group: groups that it sees, without those that another of them sees}."""
    sees = {group_of(room): set() for room, _, _ in rooms}
    for room, others, _ in rooms:
        sees[group_of(room)] |= {group_of(o) for o in others} - {group_of(room)}
    levels = {}

    def level(group):
        if group not in levels:
            levels[group] = 1 + max((level(o) for o in sees[group]), default=-1)
        return levels[group]

    def all_below(group):
        return sees[group].union(*(all_below(o) for o in sees[group]))

    arrows = {g: {o for o in sees[g] if not any(o in all_below(p) for p in sees[g] if p != o)} for g in sees}
    return {g: level(g) for g in sees}, arrows


class Group:
    """A folder with its rooms as boxes in lines."""

    def __init__(self, name, rooms, most):
        self.name, self.x, self.y, self.boxes = name, 0, 0, []
        x, y, width = PAD, PAD, 0
        for room in rooms:
            box = len(room) * CHARACTER + 2 * PAD
            if x > PAD and x + box + PAD > most:
                x, y = PAD, y + BOX + GAP
            self.boxes.append((room, x, y, box))
            x += box + GAP
            width = max(width, x - GAP + PAD)
        self.width, self.height = width, y + BOX + PAD


def drawing(rooms):
    levels, arrows = levels_of(rooms)
    holds = {room: text for room, _, text in rooms}
    rows, y = {}, PAD
    for number in sorted(set(levels.values()), reverse=True):
        names = [g for g in levels if levels[g] == number]
        most = WIDTH - 2 * PAD if len(names) == 1 else (WIDTH - 2 * PAD) / len(names) + 80
        row = [Group(g, [room for room, _, _ in rooms if group_of(room) == g], most) for g in names]
        x = (WIDTH - sum(g.width for g in row) - 3 * GAP * (len(row) - 1)) / 2
        for group in row:
            group.x, group.y = x, y
            x += group.width + 3 * GAP
            rows[group.name] = group
        y += max(g.height for g in row) + ROW_GAP
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y - ROW_GAP + PAD:.0f}" '
           'font-family="monospace" font-size="12">',
           '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
           '<path d="M0 0 8 4 0 8z" fill="#7d8896"/></marker></defs>',
           f'<rect width="{WIDTH}" height="{y - ROW_GAP + PAD:.0f}" fill="#ffffff"/>']
    for name, group in rows.items():
        for other in sorted(arrows[name]):
            below = rows[other]
            out.append(f'<path d="M{group.x + group.width / 2:.0f} {group.y + group.height:.0f} '
                       f'L{below.x + below.width / 2:.0f} {below.y - 2:.0f}" stroke="#7d8896" marker-end="url(#tip)"/>')
    for group in rows.values():
        out.append(f'<rect x="{group.x:.0f}" y="{group.y:.0f}" width="{group.width:.0f}" height="{group.height:.0f}" rx="8" '
                   'fill="#eef3f8" stroke="#b6c2cf"/>')
        for room, x, box_y, width in group.boxes:
            out.append(f'<g><title>{html.escape(holds[room])}</title><rect x="{group.x + x:.0f}" y="{group.y + box_y:.0f}" '
                       f'width="{width:.0f}" height="{BOX}" rx="4" fill="#ffffff" stroke="#8fa1b5"/>'
                       f'<text x="{group.x + x + width / 2:.0f}" y="{group.y + box_y + 17:.0f}" text-anchor="middle" '
                       f'fill="#1d2733">{room}</text></g>')
    return "\n".join([*out, "</svg>", ""])


def main():
    rooms = read_table()
    page = ROOT / "docs/design.md"
    text = page.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, found, after = rest.partition(END)
    if not found:
        sys.exit(f"{page}: the marks are missing: {BEGIN} ... {END}")
    made = {page: f"{before}{BEGIN}\n{page_table(rooms)}\n{END}{after}", ROOT / "docs/rooms.svg": drawing(rooms)}
    for file, content in made.items():
        if sys.argv[1:] != ["--check"]:
            file.write_text(content, encoding="utf-8")
        elif not file.is_file() or file.read_text(encoding="utf-8") != content:
            sys.exit(f"{file.relative_to(ROOT)}: not what cmake/rooms.txt says; run tools/rooms.py")


if __name__ == "__main__":
    main()
