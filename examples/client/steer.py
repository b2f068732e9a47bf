"""Flies the quadrotor of quad_client.toml: climbs, looks for the red of the landing pad with its camera, lands there.

    sinew run examples/client/quad_client.toml --rate 0.25 &
    python3 examples/client/steer.py
"""
import numpy
import sinew

HEIGHT_M, CLIMB_MPS, SINK_MPS, GAIN_MPS = 1.5, 0.5, 0.25, 0.7

with sinew.attach("quad_client") as robot:
    camera, state, setpoint = map(robot.topic, ("camera.raw", "filter.state", "client.setpoint"))
    state.wait(60)  # the filter has begun
    begin_ns, high = None, False
    while (frame := camera.wait(2)) is not None:
        red = numpy.argwhere(frame.pixels[::4, 1::4, 1] > 180)  # V of yuyv
        down, right = red.mean(axis=0) * 4 / (frame["height"], frame["width"]) - 0.5 if len(red) > 5 else (0, 0)
        now_ns, height_m, ready = robot.now_ns(), state.latest()["height_m"], state.latest()["position_valid"]
        begin_ns = now_ns if ready and begin_ns is None else begin_ns
        flies = begin_ns is not None and now_ns - begin_ns > 1_000_000_000  # the rotors turn up first
        high = high or height_m > HEIGHT_M
        sinks = len(red) > 5 and max(abs(down), abs(right)) < 0.12 or height_m < 0.5
        setpoint.publish({"mode": "velocity" if flies else "idle", "armed": begin_ns is not None,
                          "v_world_mps.x": -GAIN_MPS * down, "v_world_mps.y": -GAIN_MPS * right,
                          "v_world_mps.z": CLIMB_MPS if not high else -SINK_MPS if sinks else 0})
        if high and height_m < 0.14:
            break
    setpoint.publish(armed=0)
    print("landed" if high else "did not fly")
