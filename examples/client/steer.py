"""Flies the quadrotor of quad_client.toml: looks through its camera, keeps the landing pad below it, comes down again.

    sinew run examples/client/quad_client.toml &
    PYTHONPATH=python python3 examples/client/steer.py
"""
import sys

import numpy
import sinew

HEIGHT_M, CLIMB_MPS, SINK_MPS, GAIN_MPS = 1.2, 0.5, 0.3, 0.8

with sinew.attach("quad_client") as robot:
    camera, state, setpoint = map(robot.topic, ("camera.raw", "filter.state", "client.setpoint"))
    begin_ns, up, highest_m = None, True, 0.0
    while (frame := camera.wait(2)) is not None:
        now_ns, height_m = robot.now_ns(), state.latest()["height_m"]
        if begin_ns is None and state.latest()["position_valid"]:
            begin_ns = now_ns
        bright = numpy.argwhere(frame.pixels[::4, ::4, 0] > 200)  # the pad is the whitest thing there is
        offset = (bright.mean(axis=0) * 4 / (frame["height"], frame["width"]) - 0.5) if len(bright) else (0, 0)
        flies = begin_ns is not None and now_ns - begin_ns > 1_000_000_000  # the rotors turn up first
        up, highest_m = up and height_m < HEIGHT_M, max(highest_m, height_m)
        setpoint.publish({"mode": "velocity" if flies else "idle", "armed": begin_ns is not None,
                          "v_world_mps.x": -GAIN_MPS * offset[0], "v_world_mps.y": -GAIN_MPS * offset[1],
                          "v_world_mps.z": CLIMB_MPS if up else -SINK_MPS})
        if not up and height_m < 0.15:
            break
    setpoint.publish(armed=0)
    print(f"was {highest_m:.2f} m high")
    sys.exit(highest_m < HEIGHT_M)
