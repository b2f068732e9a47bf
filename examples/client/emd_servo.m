% Detector and servo in Octave: an AirRobot flies forward, and its height is held by the motion of the ground in its camera.
%   sinew run robots/air_robot/emd_octave.toml --duration 25 &
%   octave examples/client/emd_servo.m
addpath(fileparts(mfilename("fullpath")));  % shift_of.m
FORWARD_MPS = 0.7; WANTED_RADPS = 0.5;  % so the right height is 1.4 m
FOCAL = 0.7945024 * 30;  % of 40 x 30 bins
robot = sinew_mex("attach", "emd_octave");
older = []; rates = zeros(0, 3); sent_ms = heights_m = []; from = begin = climb_mps = 0;
try, while true  % until the robot's run has ended
  frame = sinew_mex("wait", robot, "camera.raw", 2);
  if isempty(frame), puts("no picture for 2 s\n"); continue; end  % a busy machine draws none; the vehicle takes care of itself
  stamp = double(frame.stamp_ns); dt = (stamp - from) / 1e9;
  if ! begin, begin = stamp; end
  newer = squeeze(mean(mean(reshape(double(frame.pixels(:,:,1)), 4, 30, 4, 40), 1), 3));  % Y of yuyv, bins of 4 x 4
  newer -= mean(newer(:));
  while ! isempty(s = sinew_mex("next", robot, "filter.state", 0))
    rates(end+1,:) = [double(s.stamp_ns) s.gyro_radps.x s.gyro_radps.y];
  end
  after_s = (stamp - begin) / 1e9; forward_mps = FORWARD_MPS * (after_s > 3.5);
  if after_s < 3.5
    climb_mps = 0.5 * (after_s > 1);  % to about 1.2 m, by the clock
  elseif ! isempty(older) && dt < 0.05
    held = rates(rates(:,1) > from & rates(:,1) <= stamp, 2:3); turn = dt * sum(held, 1) / max(1, rows(held));
    turned = FOCAL * [turn(1) -turn(2)] .* (1 + [40 30].^2 / (12 * FOCAL^2));
    [d, seen] = shift_of(older, newer); moved = (d - turned) / (FOCAL * dt);
    if seen && after_s > 5  % at its speed: too much motion is too low
      climb_mps += 0.2 * (max(-0.5, min(0.5, 0.8 * (moved(2) / WANTED_RADPS - 1))) - climb_mps);
    else
      climb_mps = 0;
    end
  end
  zero = struct("x", 0, "y", 0, "z", 0);
  wanted = struct("stamp", frame.stamp_ns, "linear_mps", setfield(setfield(zero, "x", forward_mps), "z", climb_mps), ...
                  "angular_radps", zero);
  down = struct("stamp", frame.stamp_ns, "value", [0 pi/2 0 0 0 0 0 0], "count", 2, "armed", 1);
  sinew_mex("publish", robot, "octave.velocity", wanted, [], frame.stamp_ns);
  sinew_mex("publish", robot, "octave.look", down, [], frame.stamp_ns);
  sent_ms(end+1) = double(sinew_mex("now", robot)) / 1e6;
  if ! isempty(s = sinew_mex("latest", robot, "range.raw")) && after_s > 8, heights_m(end+1) = s.range_m; end  % only told
  older = newer; from = stamp; rates = rates(rates(:,1) > stamp, :);
end, catch e, if ! strcmp(e.identifier, "sinew:closed"), rethrow(e); end, end  % the robot's run has ended
at = @(v, share) sort(v)(max(1, ceil(share * numel(v))));
printf("%d commands; period %.1f ms, p99 %.1f; height %.2f to %.2f m, right %.2f\n", numel(sent_ms), at(diff(sent_ms), 0.5), ...
       at(diff(sent_ms), 0.99), min(heights_m), max(heights_m), FORWARD_MPS / WANTED_RADPS);
