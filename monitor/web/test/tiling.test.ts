import { describe, expect, it } from "vitest";
import { closeTile, kLeastShare, moveBorder, readNode, replaceTile, split, splitTile, tile, tilesOf, type Node, type Split } from "../src/tiling";

const sum = (numbers: number[]) => numbers.reduce((a, b) => a + b, 0);

describe("tiles", () => {
  it("split in two, in the direction of their row without another level", () => {
    const a = tile("a"), b = tile("b"), c = tile("c"), d = tile("d");
    const root = splitTile(split("row", [1, 1], a, b), b.id, "row", c) as Split;
    expect(root.sizes).toEqual([0.5, 0.25, 0.25]);
    const deeper = splitTile(root, a.id, "column", d) as Split;
    expect(tilesOf(deeper).map((t) => t.panel)).toEqual(["a", "d", "b", "c"]);
    expect((deeper.parts[0] as Split).direction).toBe("column");
  });

  it("close and leave their room to the others; a split of one is none", () => {
    const a = tile("a"), b = tile("b"), c = tile("c");
    const root = split("row", [1, 1, 2], a, b, c);
    const two = closeTile(root, c.id) as Split;
    expect(two.sizes).toEqual([0.5, 0.5]);
    expect(closeTile(two, a.id)).toEqual(b);
    expect(closeTile(b, b.id)).toBeNull();
  });

  it("keep their sum when a border moves, and none vanishes", () => {
    let root: Node = split("row", [1, 1, 1], tile("a"), tile("b"), tile("c"));
    const id = root.id;
    root = moveBorder(root, id, 0, 0.1);
    expect(sum((root as Split).sizes)).toBeCloseTo(1);
    expect((root as Split).sizes[0]).toBeCloseTo(1 / 3 + 0.1);
    root = moveBorder(root, id, 0, 5);
    expect((root as Split).sizes[1]).toBeCloseTo(kLeastShare);
    root = moveBorder(root, id, 0, -5);
    expect((root as Split).sizes[0]).toBeCloseTo(kLeastShare);
    expect(moveBorder(root, id, 2, 0.1)).toEqual(root);
  });

  it("change their panel without touching the others", () => {
    const a = tile("a"), b = tile("b", { topic: "imu" });
    const root = replaceTile(split("row", [1, 1], a, b), a.id, { panel: "c" });
    expect(tilesOf(root).map((t) => [t.panel, t.state])).toEqual([["c", {}], ["b", { topic: "imu" }]]);
  });

  it("come back from storage, and nonsense does not", () => {
    const root = split("row", [1, 3], tile("a"), split("column", [1, 1], tile("b"), tile("c")));
    expect(readNode(JSON.parse(JSON.stringify(root)))).toEqual(root);
    const bad: unknown[] = [null, 7, {}, { kind: "tile" }, { kind: "split", direction: "row", sizes: [1], parts: [tile("a")] }, { kind: "split", direction: "up", sizes: [1, 1], parts: [tile("a"), tile("b")] }, { kind: "split", direction: "row", sizes: [1, -1], parts: [tile("a"), tile("b")] }, { kind: "split", direction: "row", sizes: [1, 1], parts: [tile("a"), {}] }];
    for (const value of bad) expect(readNode(value)).toBeNull();
  });
});
