% Every command of sinew_mex against the robot of client_robot.toml.
function refused(words, varargin)
  try
    sinew_mex(varargin{:});
  catch e
    assert(! isempty(strfind(e.message, words)), "%s: %s", varargin{1}, e.message);
    return
  end
  error("not refused: %s", words);
end
assert(isequal(sinew_mex("robots"), {"ball"}));
r = sinew_mex("attach", "");
m = sinew_mex("wait", r, "ball.height", 5);
assert(m.range_m >= 0 && m.range_m <= 1 && m.stamp == m.stamp_ns && m.published_ns >= m.stamp_ns);
n = sinew_mex("next", r, "ball.height", 5);
assert(n.sequence == m.sequence + 1 + n.missed);
setenv("OVERWRITE_COPIES", "2");  % copy_fault.c: these two messages are overwritten while they are read
o = sinew_mex("next", r, "ball.height", 5);
assert(o.sequence == n.sequence + 1 + o.missed && o.missed >= 2);
sinew_mex("set", r, "ball", "restitution", 0.5);
assert(sinew_mex("get", r, "ball", "restitution"), 0.5);
refused("a number from 0 to 1", "set", r, "ball", "restitution", 7);
assert(isempty(sinew_mex("wait", r, "operator.range", 0.01)));
now_ns = sinew_mex("now", r);
sinew_mex("publish", r, "operator.range", struct("range_m", 2.5), [], now_ns);
l = sinew_mex("latest", r, "operator.range");
assert(l.range_m == 2.5 && l.stamp_ns == now_ns);
refused("RangeSample has no field range", "publish", r, "operator.range", struct("range", 2.5));
refused("the robot's present time", "publish", r, "operator.range", struct("range_m", 1), [], now_ns + 1e12);
refused("written by a module", "publish", r, "ball.height", struct("range_m", 1));
for channels = [1 2 3]  % mono8, yuyv, rgb8
  pixels = uint8(mod(reshape(0:4*16*channels-1, 4, 16, channels), 256));
  sinew_mex("publish", r, "camera.raw", struct("frame_number", channels), pixels);
  c = sinew_mex("wait", r, "camera.raw", 5);
  assert(isequal(c.pixels, pixels) && c.frame_number == channels && c.width == 16 && c.height == 4);
end
refused("more pixels", "publish", r, "camera.raw", struct(), zeros(481, 1280, "uint8"));
assert(! isempty(strfind(sinew_mex("request", r, "hello"), '"robot":"ball"')));
refused("did you mean hello", "request", r, "helo");
refused("no topic ball.heigth", "wait", r, "ball.heigth");
sinew_mex("detach", r);
refused("this robot is not attached", "now", r);
disp("OK sinew_mex");
