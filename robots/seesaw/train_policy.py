#!/usr/bin/env python3
"""Trains the policy of seesaw_policy.toml and writes it as ONNX: train_policy.py OUT.onnx [SEED]

A network of 8 inputs (four steps of accelerometer and gyro), 8 hidden units and one output, found by an evolution strategy
(T. Salimans et al., arXiv 1703.03864) on the beam's equation, which this file has again. Nothing but Python: a minute and
a half. It stands for the trainers of others: Sinew learns nothing of it but the file that it writes.
"""
import math
import random
import struct
import sys

HISTORY, FIELDS, HIDDEN = 4, 2, 8
INPUTS = HISTORY * FIELDS
SIZE = HIDDEN * INPUTS + HIDDEN + HIDDEN + 1  # w1, b1, w2, b2
STEP_S, SUBSTEPS, EPISODE = 0.005, 5, 500  # 200 Hz
POPULATION, SIGMA, RATE, GENERATIONS = 24, 0.1, 0.15, 60


def act(theta, x):
    """The network as the file has it: oldest first, tanh, one output."""
    out = theta[-1]
    for h in range(HIDDEN):
        total = theta[HIDDEN * INPUTS + h]
        row = h * INPUTS
        for i in range(INPUTS):
            total += theta[row + i] * x[i]
        out += theta[HIDDEN * INPUTS + HIDDEN + h] * math.tanh(total)
    return out


def cost(theta, seed):
    """One fall of the beam: start, push, noise and delay are drawn."""
    draw = random.Random(seed)
    pitch, rate = draw.choice((-0.3, 0.3)), 0.0
    push, delay = draw.uniform(-0.3, 0.3), draw.choice((0, 1))
    past, waiting, before, total = [], [0.0, 0.0], 0.0, 0.0
    for _ in range(EPISODE):
        seen = [-math.sin(pitch) + draw.uniform(-0.01, 0.01), rate + draw.uniform(-0.01, 0.01)]
        past = (past + seen if past else seen * HISTORY)[-INPUTS:]
        command = max(-1.0, min(1.0, act(theta, past)))
        waiting = [command, waiting[0]]
        for _ in range(SUBSTEPS):
            rate += (4 * pitch + push + 12 * waiting[delay]) * STEP_S / SUBSTEPS
            pitch += rate * STEP_S / SUBSTEPS
            if abs(pitch) > 0.3:
                pitch, rate = math.copysign(0.3, pitch), 0.0
        total += pitch * pitch + 1e-3 * rate * rate + 2e-3 * (command - before) ** 2
        before = command
    return total


def train(seed):
    draw = random.Random(seed)
    theta = [draw.gauss(0, 0.3) for _ in range(SIZE)]
    for generation in range(GENERATIONS):
        pairs = []
        for p in range(POPULATION // 2):
            noise = [draw.gauss(0, 1) for _ in range(SIZE)]
            seeds = [1000 * generation + 10 * p + k for k in range(2)]
            scores = [sum(cost([t + sign * SIGMA * n for t, n in zip(theta, noise)], s) for s in seeds) for sign in (1, -1)]
            pairs.append((scores, noise))
        ranks = {v: i for i, v in enumerate(sorted(s for scores, _ in pairs for s in scores))}
        for scores, noise in pairs:
            weight = (ranks[scores[0]] - ranks[scores[1]]) / POPULATION
            theta = [t - RATE * weight * n / math.sqrt(POPULATION) for t, n in zip(theta, noise)]
        if generation % 10 == 9:
            print(f"generation {generation + 1}: cost {sum(cost(theta, s) for s in range(8)) / 8:.3f}")
    return theta


def varint(value):
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes(out) + bytes([value])


def field(number, value):
    """A field of a protobuf message: an integer, or bytes."""
    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    return varint(number << 3 | 2) + varint(len(value)) + value


def tensor(name, dims, numbers):
    return b"".join(field(1, d) for d in dims) + field(2, 1) + field(8, name.encode()) + field(9, struct.pack(f"<{len(numbers)}f", *numbers))


def port(name, size):
    shape = field(1, field(2, b"batch")) + field(1, field(1, size))
    return field(1, name.encode()) + field(2, field(1, field(1, 1) + field(2, shape)))


def node(op, name, inputs, output, transposed=False):
    out = b"".join(field(1, i.encode()) for i in inputs) + field(2, output.encode()) + field(3, name.encode()) + field(4, op.encode())
    return out + (field(5, field(1, b"transB") + field(3, 1) + field(20, 2)) if transposed else b"")


def onnx(theta):
    w1, b1 = theta[:HIDDEN * INPUTS], theta[HIDDEN * INPUTS:HIDDEN * INPUTS + HIDDEN]
    w2, b2 = theta[HIDDEN * INPUTS + HIDDEN:-1], theta[-1:]
    graph = field(1, node("Gemm", "/hidden/Gemm", ("obs", "w1", "b1"), "a", True)) + field(1, node("Tanh", "/hidden/Tanh", ("a",), "h"))
    graph += field(1, node("Gemm", "/out/Gemm", ("h", "w2", "b2"), "action", True)) + field(2, b"seesaw")
    for name, dims, numbers in (("w1", (HIDDEN, INPUTS), w1), ("b1", (HIDDEN,), b1), ("w2", (1, HIDDEN), w2), ("b2", (1,), b2)):
        graph += field(5, tensor(name, dims, numbers))
    graph += field(11, port("obs", INPUTS)) + field(12, port("action", 1))
    return field(1, 8) + field(2, b"train_policy.py") + field(7, graph) + field(8, field(1, b"") + field(2, 17))


def main():
    with open(sys.argv[1], "wb") as out:
        out.write(onnx(train(int(sys.argv[2]) if len(sys.argv) > 2 else 1)))


if __name__ == "__main__":
    main()
