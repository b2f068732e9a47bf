// How the panels of a page stand: a tree of splits whose leaves are tiles. All changes give a new tree.

export type Direction = "row" | "column";

export interface Tile {
  kind: "tile";
  id: string;
  panel: string;
  state: Record<string, unknown>;
}

export interface Split {
  kind: "split";
  id: string;
  direction: Direction;
  sizes: number[]; // shares, their sum is 1
  parts: Node[];
}

export type Node = Tile | Split;

let last = 0;
export function newId(): string {
  last += 1;
  return `${Date.now().toString(36)}${last.toString(36)}`;
}

export function tile(panel: string, state: Record<string, unknown> = {}): Tile {
  return { kind: "tile", id: newId(), panel, state };
}

export function split(direction: Direction, sizes: number[], ...parts: Node[]): Split {
  const sum = sizes.reduce((a, b) => a + b, 0);
  return { kind: "split", id: newId(), direction, sizes: sizes.map((s) => s / sum), parts };
}

export function tilesOf(node: Node): Tile[] {
  return node.kind === "tile" ? [node] : node.parts.flatMap(tilesOf);
}

function map(node: Node, change: (node: Node) => Node): Node {
  if (node.kind === "tile") return change(node);
  return change({ ...node, parts: node.parts.map((p) => map(p, change)) });
}

export function replaceTile(root: Node, id: string, by: Partial<Pick<Tile, "panel" | "state">>): Node {
  return map(root, (n) => (n.kind === "tile" && n.id === id ? { ...n, ...by } : n));
}

/** The new tile stands behind the old one and takes half of its room. */
export function splitTile(root: Node, id: string, direction: Direction, added: Tile): Node {
  const inside = (node: Node): Node => {
    if (node.kind === "tile") return node.id === id ? split(direction, [1, 1], node, added) : node;
    const at = node.parts.findIndex((p) => p.kind === "tile" && p.id === id);
    if (at >= 0 && node.direction === direction) {
      const half = node.sizes[at]! / 2;
      return {
        ...node,
        parts: [...node.parts.slice(0, at + 1), added, ...node.parts.slice(at + 1)],
        sizes: [...node.sizes.slice(0, at), half, half, ...node.sizes.slice(at + 1)],
      };
    }
    return { ...node, parts: node.parts.map(inside) };
  };
  return inside(root);
}

/** Null: it was the last one. */
export function closeTile(root: Node, id: string): Node | null {
  if (root.kind === "tile") return root.id === id ? null : root;
  const parts: Node[] = [], sizes: number[] = [];
  root.parts.forEach((part, i) => {
    const left = closeTile(part, id);
    if (left) parts.push(left), sizes.push(root.sizes[i]!);
  });
  if (parts.length === 0) return null;
  if (parts.length === 1) return parts[0]!;
  const sum = sizes.reduce((a, b) => a + b, 0);
  return { ...root, parts, sizes: sizes.map((s) => s / sum) };
}

export const kLeastShare = 0.08;

/** Moves the border behind part `at` of a split by that share. */
export function moveBorder(root: Node, splitId: string, at: number, by: number): Node {
  return map(root, (n) => {
    if (n.kind !== "split" || n.id !== splitId || at < 0 || at + 1 >= n.sizes.length) return n;
    const a = n.sizes[at]!, b = n.sizes[at + 1]!;
    const least = Math.min(kLeastShare, a, b);
    const moved = Math.max(least - a, Math.min(b - least, by));
    const sizes = [...n.sizes];
    sizes[at] = a + moved;
    sizes[at + 1] = b - moved;
    return { ...n, sizes };
  });
}

/** A tree as it was stored; null where it is none, whoever wrote it. */
export function readNode(value: unknown, depth = 0): Node | null {
  if (typeof value !== "object" || value === null || depth > 12) return null;
  const v = value as Record<string, unknown>;
  if (v.kind === "tile" && typeof v.panel === "string")
    return { kind: "tile", id: typeof v.id === "string" ? v.id : newId(), panel: v.panel, state: typeof v.state === "object" && v.state ? (v.state as Record<string, unknown>) : {} };
  if (v.kind !== "split" || (v.direction !== "row" && v.direction !== "column") || !Array.isArray(v.parts) || !Array.isArray(v.sizes)) return null;
  const parts = v.parts.map((p) => readNode(p, depth + 1));
  const sizes = v.sizes.map(Number);
  if (parts.length < 2 || parts.some((p) => !p) || sizes.length !== parts.length || sizes.some((s) => !(s > 0))) return null;
  const sum = sizes.reduce((a, b) => a + b, 0);
  return { kind: "split", id: typeof v.id === "string" ? v.id : newId(), direction: v.direction, parts: parts as Node[], sizes: sizes.map((s) => s / sum) };
}
