% Flies the quadrotor of quad_client.toml, as steer.py does: lands where its camera sees the red of the landing pad.
%   sinew run examples/client/quad_client.toml --rate 0.25 &
%   octave examples/client/steer.m
HEIGHT_M = 1.5; CLIMB_MPS = 0.5; SINK_MPS = 0.25; GAIN_MPS = 0.7;
robot = sinew_mex("attach", "quad_client");
sinew_mex("wait", robot, "filter.state", 60);  % the filter has begun
begin_ns = 0; high = false;
while ! isempty(frame = sinew_mex("wait", robot, "camera.raw", 2))
  [y, x] = find(frame.pixels(1:4:end, 2:4:end, 2) > 180);  % V of yuyv
  seen = numel(x) > 5; down = 0; right = 0;
  if seen, down = 4 * mean(y) / double(frame.height) - 0.5; right = 4 * mean(x) / double(frame.width) - 0.5; end
  state = sinew_mex("latest", robot, "filter.state"); now_ns = sinew_mex("now", robot);
  if state.position_valid && begin_ns == 0, begin_ns = now_ns; end
  flies = begin_ns > 0 && now_ns - begin_ns > 1e9;  % the rotors turn up first
  high = high || state.height_m > HEIGHT_M;
  sinks = seen && max(abs([down right])) < 0.12 || state.height_m < 0.5;
  setpoint.mode = flies; setpoint.armed = begin_ns > 0;  % mode 0: idle, 1: velocity
  setpoint.v_world_mps = struct("x", -GAIN_MPS * double(down), "y", -GAIN_MPS * double(right), ...
                                "z", ! high * CLIMB_MPS - (high && sinks) * SINK_MPS);
  sinew_mex("publish", robot, "client.setpoint", setpoint);
  if high && state.height_m < 0.14, break; end
end
sinew_mex("publish", robot, "client.setpoint", struct("armed", 0));
disp({"did not fly", "landed"}{high + 1});
