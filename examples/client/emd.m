% Reads the motion of the ground from the robot's camera (elementary motion detection), for its altitude to fly by.
%   sinew run robots/terrain/terrain_octave.toml --duration 46 &
%   octave examples/client/emd.m
addpath(fileparts(mfilename("fullpath")));  % shift_of.m
FOCAL = 15 / tan(1.0382921838 / 2);  % of 40 x 30 bins
robot = sinew_mex("attach", "terrain_octave");
older = []; rates = zeros(0, 3); sent_ms = work_ms = []; from = 0;
try, while true  % until the robot's run has ended
  frame = sinew_mex("wait", robot, "camera.raw", 2);
  if isempty(frame), puts("no picture for 2 s\n"); continue; end  % a busy machine draws none; the vehicle takes care of itself
  tic; stamp = double(frame.stamp_ns); dt = (stamp - from) / 1e9;
  newer = squeeze(mean(mean(reshape(double(frame.pixels(:,:,1)), 4, 30, 4, 40), 1), 3));  % Y of yuyv, bins of 4 x 4
  newer -= mean(newer(:));
  while ! isempty(s = sinew_mex("next", robot, "filter.state", 0))
    rates(end+1,:) = [double(s.stamp_ns) s.gyro_radps.x s.gyro_radps.y];
  end
  if ! isempty(older) && dt < 0.05  % after a frame that was missed the shift is more than a correlator sees
    held = rates(rates(:,1) > from & rates(:,1) <= stamp, 2:3); turn = dt * sum(held, 1) / max(1, rows(held));
    turned = FOCAL * [turn(1) -turn(2)] .* (1 + [40 30].^2 / (12 * FOCAL^2));
    [d, seen] = shift_of(older, newer); moved = (d - turned) / (FOCAL * dt);
    motion = struct("interval_ns", dt * 1e9, "left_radps", moved(1), "forward_radps", moved(2), "seen", seen, ...
                    "bin", 4, "turn_left_px", turned(1), "turn_forward_px", turned(2), "shift_px", norm(d), ...
                    "contrast_grey", std(newer(:)));
    sinew_mex("publish", robot, "octave.motion", motion, [], frame.stamp_ns);
    sent_ms(end+1) = double(sinew_mex("now", robot)) / 1e6; work_ms(end+1) = 1e3 * toc;
    if mod(numel(sent_ms), 150) == 0  % equations (1) to (4), for people
      My = newer(1:end-1,:) .* older(2:end,:) - older(1:end-1,:) .* newer(2:end,:); My = My(:,1:end-1);
      Mx = newer(:,1:end-1) .* older(:,2:end) - older(:,1:end-1) .* newer(:,2:end); Mx = Mx(1:end-1,:);
      printf("%.2f rad/s forward; magnitude %.0f, median; direction: down in %.0f %% of the bins\n", moved(2), ...
             median(sqrt(Mx.^2 + My.^2)(:)), 100 * mean(sin(atan2(My, Mx)(:)) < 0));
    end
  end
  older = newer; from = stamp; rates = rates(rates(:,1) > stamp, :);
end, catch e, if ! strcmp(e.identifier, "sinew:closed"), rethrow(e); end, end  % the robot's run has ended
at = @(v, share) sort(v)(max(1, ceil(share * numel(v))));
printf("%d messages; period %.1f ms, p99 %.1f; picture to message %.1f ms, p99 %.1f\n", numel(sent_ms), ...
       at(diff(sent_ms), 0.5), at(diff(sent_ms), 0.99), at(work_ms, 0.5), at(work_ms, 0.99));
