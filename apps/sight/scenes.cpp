#include "apps/sight/scenes.hpp"

#include <algorithm>
#include <string_view>

#include "sim_hil/pitch/stance.hpp"
#include "vision/colour_table.hpp"

namespace sinew::sight {
namespace {

using math::Quat;
using math::Random;
using math::Vec3;

constexpr std::size_t kOthers = 6;
constexpr double kCarpetX_m = 5.3, kCarpetY_m = 3.8;
constexpr double kBallRadius_m = plant::kKidBall.radius_m;
constexpr Quat kOptical{0.5, -0.5, 0.5, -0.5};  // camera axes to x ahead, y left, z up

/// Plain balls have no colour of a jersey.
enum BallKind : std::uint32_t { kSpotted, kWhiteBall, kOrange, kYellow, kPink, kCyan, kBallKinds };
constexpr float kBallRgb[kBallKinds][3] = {{240, 240, 240}, {235, 235, 235}, {236, 112, 24},
                                           {220, 200, 30},  {230, 70, 150},  {60, 190, 200}};

/// -1 to 1, one value for each square of a side of 1.
double patch(double x, double y, std::uint32_t seed) {
  std::uint32_t n = seed ^ (static_cast<std::uint32_t>(static_cast<int>(math::floor(x))) * 0x9e3779b9U) ^
                    (static_cast<std::uint32_t>(static_cast<int>(math::floor(y))) * 0x85ebca6bU);
  n ^= n >> 16, n *= 0x7feb352dU, n ^= n >> 15;
  return static_cast<double>(n & 0xffff) / 32768 - 1;
}

std::vector<plant::PitchBody> bodies_of(const kinematics::Body& body) {
  std::vector<plant::PitchBody> all;
  for (std::size_t i = 0; i <= kOthers; ++i) {
    plant::PitchBody b;
    b.body = body;
    b.team = static_cast<std::uint8_t>(i % 2);
    all.push_back(std::move(b));
  }
  return all;
}

std::vector<double> posture(const kinematics::Body& body, Random& random, double wild) {
  std::vector<double> rad(body.joints());
  const double knee = random.uniform(0.2, 0.8);
  for (std::size_t i = 0; i < rad.size(); ++i) {
    const kinematics::Link& link = body.links[i + 1];
    const std::string_view name = link.name;
    const auto is = [&](std::string_view part) { return name.find(part) != name.npos; };
    if (is("knee"))
      rad[i] = knee;
    else if (is("hip_pitch") || is("ankle_pitch"))
      rad[i] = -0.5 * knee;
    else if (is("shoulder_roll"))
      rad[i] = random.uniform(0.8, 1.4);
    else if (is("shoulder_pitch"))
      rad[i] = random.uniform(-0.9, 0.9);
    else if (is("elbow"))
      rad[i] = random.uniform(0, 1.5);
    rad[i] = std::clamp(rad[i] + random.normal(0, wild), link.least_rad, link.most_rad);
  }
  return rad;
}

}  // namespace

struct SceneMaker::Light {
  std::array<double, 3> gain{1, 1, 1};
  double exposure = 1, drift = 0, gamma = 1, vignette = 0, slope_x = 0, slope_y = 0, noise = 0, texture = 0;
  std::array<double, 3> shadow_tint{1, 1, 1};
  int shadows = 0;
  double shadow = 1;
  double tilt_rad = 0, roll_rad = 0, turn_rad = 0;  // that the robot's belief is wrong by, for all pictures of a row
};

soccer::GroundXy Scene::in_robot(double x_m, double y_m) const {
  const math::SinCos t = math::sincos(robot.heading_rad);
  const double dx = x_m - robot.x_m, dy = y_m - robot.y_m;
  return {t.cos * dx + t.sin * dy, t.cos * dy - t.sin * dx};
}

SceneMaker::SceneMaker(const kinematics::Body& body, const SceneOptions& options)
    : body_(body),
      o_(options),
      bodies_(bodies_of(body)),
      view_(pitch_, bodies_),
      one_(options.width, options.height),
      two_(options.width * 2, options.height * 2),
      rgb_(std::size_t{options.width} * options.height * 3),
      other_(rgb_.size()) {
  scene_.robots.resize(bodies_.size());
}

SceneMaker::Light SceneMaker::light_of(Random& random) const {
  Light l;
  if (o_.lighting == Lighting::clean) return l;
  const bool unseen = o_.lighting == Lighting::unseen;
  const double wide = unseen ? 1.6 : 1;
  l.exposure = math::exp(random.normal(0, 0.22 * wide));
  l.drift = random.normal(0, 0.06 * wide);
  for (double& g : l.gain) g = 1 + random.uniform(-0.08, 0.08) * wide;
  l.slope_x = random.uniform(-0.2, 0.2) * wide, l.slope_y = random.uniform(-0.15, 0.15) * wide;
  l.noise = random.uniform(1, 5) * (unseen ? 1.4 : 1);
  l.texture = random.uniform(0, 0.06);
  l.shadows = static_cast<int>(random.below(unseen ? 4 : 2));
  l.shadow = unseen ? random.uniform(0.4, 0.75) : random.uniform(0.6, 0.9);
  if (unseen) {
    l.gamma = random.uniform(0.8, 1.25);
    l.vignette = random.uniform(0, 0.4);
    l.shadow_tint = {random.uniform(0.85, 1), random.uniform(0.9, 1), random.uniform(1, 1.15)};
  }
  l.tilt_rad = random.uniform(-0.02, 0.02), l.roll_rad = random.normal(0, 0.006), l.turn_rad = random.normal(0, 0.006);
  return l;
}

void SceneMaker::place_robots(Random& random, Scene& out) {
  const plant::FieldSize& f = pitch_.field;
  const double half_x = f.length_m / 2 + 0.4, half_y = f.width_m / 2 + 0.4;
  std::vector<std::pair<double, double>> used;
  out.others.clear();
  const std::size_t present = random.below(kOthers + 1);
  for (std::size_t i = 0; i <= kOthers; ++i) {
    auto& link = scene_.robots[i].link;
    if (i > present) {
      link.fill({{1e4, 1e4, -1e4}, {}});
      continue;
    }
    plant::PitchPlace at;
    for (int tries = 0; tries < 20; ++tries) {
      at.x_m = random.uniform(-half_x, half_x), at.y_m = random.uniform(-half_y, half_y);
      if (i > 0 && random.below(2) == 0) {  // near enough to matter
        const double d = random.uniform(0.5, 3), turn = random.uniform(-1.0, 1.0) + out.robot.heading_rad;
        at.x_m = out.robot.x_m + d * math::cos(turn), at.y_m = out.robot.y_m + d * math::sin(turn);
      }
      // All stand on the carpet.
      at.x_m = std::clamp(at.x_m, -kCarpetX_m, kCarpetX_m), at.y_m = std::clamp(at.y_m, -kCarpetY_m, kCarpetY_m);
      bool free = true;
      for (const auto& [x, y] : used) free = free && math::hypot(x - at.x_m, y - at.y_m) > 0.45;
      if (free) break;
    }
    used.emplace_back(at.x_m, at.y_m);
    at.heading_rad = random.uniform(-math::kPi, math::kPi);
    if (i > 0 && random.below(8) == 0) at.lie = static_cast<plant::PitchPlace::Lie>(1 + random.below(4));
    at.joints_rad = posture(body_, random, i == 0 ? 0.05 : 0.15);
    if (i == 0) {
      const auto pan = body_.find_link("head_pan"), tilt = body_.find_link("head_tilt");
      if (pan) at.joints_rad[*pan - 1] = random.uniform(-1.2, 1.2);
      if (tilt) at.joints_rad[*tilt - 1] = random.uniform(-0.15, 0.6);
      out.robot = {at.x_m, at.y_m, at.heading_rad};
    }
    kinematics::Pose base = plant::pose_on_ground(body_, at, 0);
    if (i == 0)
      base.q = base.q * Quat::exp({random.normal(0, 0.03), random.normal(0.02, 0.05), 0});  // it sways as it walks
    kinematics::BodyPose pose(body_);
    pose.set(at.joints_rad, base);
    for (std::size_t l = 0; l < body_.links.size(); ++l) link[l] = pose.link(l);
    if (i > 0)
      out.others.push_back({at.x_m, at.y_m, at.lie == plant::PitchPlace::Lie::upright, bodies_[i].team == 1, 0});
  }
  for (Scene::Other& o : out.others) {
    const soccer::GroundXy p = out.in_robot(o.x_m, o.y_m);
    o.x_m = p.x_m, o.y_m = p.y_m;
  }
}

void SceneMaker::paint_background(Random& random) {
  // rgb_ has the picture; other_ says nothing yet. Boxes of any colour where nothing of the pitch is.
  const std::uint32_t w = o_.width, h = o_.height;
  const std::uint32_t boxes = o_.lighting == Lighting::clean ? 0 : random.below(25);
  for (std::uint32_t k = 0; k < boxes; ++k) {
    const std::uint32_t x0 = random.below(w), y0 = random.below(h);
    const std::uint32_t x1 = std::min(w, x0 + 2 + random.below(w / 4)), y1 = std::min(h, y0 + 2 + random.below(h / 3));
    std::array<float, 3> c{};
    const bool grey = random.below(2) == 0;
    for (float& v : c) v = static_cast<float>(random.uniform(15, 245));
    if (grey) c[1] = c[2] = c[0];
    for (std::uint32_t y = y0; y < y1; ++y)
      for (std::uint32_t x = x0; x < x1; ++x)
        if (one_.shown(x, y) == plant::kShowsNothing) std::copy(c.begin(), c.end(), &rgb_[3 * (y * w + x)]);
  }
}

void SceneMaker::degrade(const Light& light, Random& random, const raster::Raster& picture,
                         const raster::Camera& camera, Scene& out) {
  const std::uint32_t w = o_.width, h = o_.height;
  if (o_.lighting != Lighting::clean) {
    struct Shadow {
      double x, y, nx, ny, r;
      bool disc;
    };
    std::vector<Shadow> shadows;
    for (int i = 0; i < light.shadows; ++i) {
      const double turn = random.uniform(-math::kPi, math::kPi);
      shadows.push_back({out.robot.x_m + random.normal(0, 1.5), out.robot.y_m + random.normal(0, 1.5), math::cos(turn),
                         math::sin(turn), random.uniform(0.3, 1.5), random.below(2) == 0});
    }
    const double lift = 1 + light.drift * random.normal();
    const std::uint32_t grain = random.next_u32();
    for (std::uint32_t y = 0; y < h; ++y)
      for (std::uint32_t x = 0; x < w; ++x) {
        const double nx = 2.0 * x / w - 1, ny = 2.0 * y / h - 1;
        double all = light.exposure * lift * (1 + light.slope_x * nx + light.slope_y * ny) *
                     (1 - light.vignette * 0.5 * (nx * nx + ny * ny));
        std::array<double, 3> tint{1, 1, 1};
        const double depth = picture.depth_m(x, y);
        if (depth > 0) {
          const Vec3 p = camera.pose.of({(x + 0.5 - camera.cx_px) / camera.fx_px * depth,
                                         (y + 0.5 - camera.cy_px) / camera.fy_px * depth, depth});
          for (const Shadow& s : shadows) {
            const double dx = p.x - s.x, dy = p.y - s.y;
            const bool in = s.disc ? dx * dx + dy * dy < s.r * s.r : dx * s.nx + dy * s.ny > s.r;
            if (!in) continue;
            all *= light.shadow;
            for (std::size_t c = 0; c < 3; ++c) tint[c] *= light.shadow_tint[c];
          }
          if (picture.shown(x, y) == plant::kShowsCarpet)
            all *= 1 + light.texture * (patch(p.x * 3, p.y * 3, grain) + 0.7 * patch(p.x * 40, p.y * 40, grain));
        }
        float* const at = &rgb_[3 * (std::size_t{y} * w + x)];
        for (std::size_t c = 0; c < 3; ++c)
          at[c] = static_cast<float>(std::min(400.0, at[c] * all * light.gain[c] * tint[c]));
      }
    // Dirt on the lens.
    for (std::uint32_t k = random.below(4); k > 0; --k) {
      const double cx = random.uniform(0, w), cy = random.uniform(0, h), r = random.uniform(1.5, 0.02 * w);
      const double keeps = random.uniform(0.3, 0.8);
      for (std::uint32_t y = 0; y < h; ++y)
        for (std::uint32_t x = 0; x < w; ++x)
          if ((x - cx) * (x - cx) + (y - cy) * (y - cy) < r * r)
            for (std::size_t c = 0; c < 3; ++c) rgb_[3 * (std::size_t{y} * w + x) + c] *= static_cast<float>(keeps);
    }
    // The head turns while the shutter is open; and the lens is not quite sharp.
    const double blur = std::max(0.0, random.normal(0, 0.008 * w)), way = random.normal(0, 0.5);
    const int taps = 1 + 2 * static_cast<int>(blur / 2 + 0.5);
    out.blur_px = taps - 1;
    if (taps > 1) {
      other_ = rgb_;
      const math::SinCos along{math::sin(way), math::cos(way)};
      for (std::uint32_t y = 0; y < h; ++y)
        for (std::uint32_t x = 0; x < w; ++x)
          for (std::size_t c = 0; c < 3; ++c) {
            float sum = 0;
            for (int t = 0; t < taps; ++t) {
              const double s = t - (taps - 1) / 2;
              const int px = std::clamp(static_cast<int>(x + s * along.cos + 0.5), 0, static_cast<int>(w) - 1);
              const int py = std::clamp(static_cast<int>(y + s * along.sin + 0.5), 0, static_cast<int>(h) - 1);
              sum += other_[3 * (static_cast<std::size_t>(py) * w + static_cast<std::size_t>(px)) + c];
            }
            rgb_[3 * (std::size_t{y} * w + x) + c] = sum / static_cast<float>(taps);
          }
    }
    if (random.below(2) == 0) {
      other_ = rgb_;
      for (std::uint32_t y = 1; y + 1 < h; ++y)
        for (std::uint32_t x = 1; x + 1 < w; ++x)
          for (std::size_t c = 0; c < 3; ++c) {
            const auto at = [&](std::uint32_t px, std::uint32_t py) {
              return other_[3 * (std::size_t{py} * w + px) + c];
            };
            rgb_[3 * (std::size_t{y} * w + x) + c] =
                0.25F * at(x, y) + 0.125F * (at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1)) +
                0.0625F * (at(x - 1, y - 1) + at(x + 1, y - 1) + at(x - 1, y + 1) + at(x + 1, y + 1));
          }
    }
    for (float& v : rgb_) {
      double x = v;
      if (light.gamma != 1) x = 255 * math::pow(std::clamp(x, 0.0, 400.0) / 255, light.gamma);
      // Four bytes together are nearly normal; their standard deviation is 147.8.
      const std::uint32_t draw = random.next_u32();
      const auto sum = static_cast<double>((draw & 255) + (draw >> 8 & 255) + (draw >> 16 & 255) + (draw >> 24));
      x += light.noise * (sum - 510) / 147.8;
      v = static_cast<float>(x);
    }
  }
  for (std::size_t i = 0; i < std::size_t{w} * h; i += 2) {
    vision::Yuv yuv[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const float* const c = &rgb_[3 * (i + k)];
      const auto byte = [](float v) { return static_cast<int>(std::clamp(v + 0.5F, 0.0F, 255.0F)); };
      yuv[k] = vision::to_yuv({byte(c[0]), byte(c[1]), byte(c[2])});
    }
    std::uint8_t* const to = &out.yuyv[2 * i];
    to[0] = static_cast<std::uint8_t>(yuv[0].y), to[1] = static_cast<std::uint8_t>((yuv[0].u + yuv[1].u + 1) / 2);
    to[2] = static_cast<std::uint8_t>(yuv[1].y), to[3] = static_cast<std::uint8_t>((yuv[0].v + yuv[1].v + 1) / 2);
  }
}

void SceneMaker::make(std::uint64_t number, Scene& out) {
  const std::uint32_t w = o_.width, h = o_.height;
  Random of_light(o_.seed, 1, number / std::max<std::uint64_t>(1, o_.same_light));
  Random random(o_.seed, 2, number);
  const Light light = light_of(of_light);
  const auto kind = o_.lighting == Lighting::clean ? std::uint32_t{kSpotted}
                    : random.below(2) == 0         ? std::uint32_t{kSpotted}
                                                   : random.below(kBallKinds);
  out.width = w, out.height = h;
  out.yuyv.resize(std::size_t{w} * h * 2);
  out.shows.resize(std::size_t{w} * h);

  const plant::FieldSize& f = pitch_.field;
  out.robot = {random.uniform(-f.length_m / 2, f.length_m / 2), random.uniform(-f.width_m / 2, f.width_m / 2), 0};
  place_robots(random, out);
  const std::size_t camera = random.below(10) < 6 ? 0 : 1;
  const raster::Camera see = view_.camera(scene_, 0, camera, w, h);

  // The ball: mostly somewhere in the picture, some anywhere, some at a robot's feet; and in a fifth there is none.
  scene_.has_ball = random.below(5) != 0;
  out.camera = {see.fx_px, see.fy_px, 0.5 * (w - 1), 0.5 * (h - 1)};
  out.true_pose.p_world_m = see.pose.p_m.to<msg::Vec3>();
  out.true_pose.q_world_optical = see.pose.q.to<msg::Quat>();
  const soccer::GroundView truly(out.camera, out.true_pose, {}, {});
  Vec3 ball;
  for (int tries = 0; tries < (o_.seek_ball ? 6 : 1); ++tries) {
    ball = {random.uniform(-4.5, 4.5), random.uniform(-3, 3), kBallRadius_m};
    const std::uint32_t where = random.below(10);
    if (where < 6) {
      const auto p = truly.at_height(random.uniform(0, w), random.uniform(0.1 * h, h), kBallRadius_m);
      if (p && math::fabs(p->x_m) < 5.4 && math::fabs(p->y_m) < 3.9) ball.x = p->x_m, ball.y = p->y_m;
    } else if (where < 8 && !out.others.empty()) {
      const std::size_t who = 1 + random.below(static_cast<std::uint32_t>(out.others.size()));
      const Vec3 at = scene_.robots[who].link[0].p_m;
      const double turn = random.uniform(-math::kPi, math::kPi), d = random.uniform(0.13, 0.3);
      ball.x = at.x + d * math::cos(turn), ball.y = at.y + d * math::sin(turn);
    } else if (where == 8) {  // on or at a line
      ball.y = (random.below(2) ? 1 : -1) * (f.width_m / 2 + random.normal(0, 0.08));
    }
    ball.x = std::clamp(ball.x, -kCarpetX_m, kCarpetX_m), ball.y = std::clamp(ball.y, -kCarpetY_m, kCarpetY_m);
    const soccer::PixelAt at = truly.pixel(ball);
    if (at.depth_m > 0 && at.u_px > 0 && at.v_px > 0 && at.u_px < w && at.v_px < h) break;
  }
  scene_.ball = {ball, Quat::exp({random.normal(0, 1.5), random.normal(0, 1.5), random.normal(0, 1.5)})};

  view_.draw(one_, scene_, see);
  const bool smooth = o_.lighting != Lighting::clean && random.below(4) != 0;
  if (smooth) {
    raster::Camera twice = see;
    twice.fx_px *= 2, twice.fy_px *= 2, twice.cx_px *= 2, twice.cy_px *= 2;
    view_.draw(two_, scene_, twice);
  }
  std::size_t ball_pixels = 0;
  for (std::uint32_t y = 0; y < h; ++y)
    for (std::uint32_t x = 0; x < w; ++x) {
      const std::uint8_t shows = one_.shown(x, y);
      out.shows[std::size_t{y} * w + x] = shows;
      ball_pixels += shows == plant::kShowsBall;
      if (shows > plant::kShowsRobot && shows - plant::kShowsRobot - 1U < out.others.size())
        ++out.others[shows - plant::kShowsRobot - 1U].pixels;
      std::array<float, 3> sum{};
      const auto take = [&](const raster::Raster& r, std::uint32_t px, std::uint32_t py, float share) {
        const raster::Colour c = r.rgb(px, py);
        std::array<float, 3> rgb{static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)};
        if (kind != kSpotted && r.shown(px, py) == plant::kShowsBall) {
          const bool white = c.r == c.b;  // the black of its spots is bluish
          const float shade = white ? rgb[0] / 240 : rgb[0] / 30;
          for (std::size_t i = 0; i < 3; ++i) rgb[i] = shade * kBallRgb[kind][i];
        }
        for (std::size_t i = 0; i < 3; ++i) sum[i] += share * rgb[i];
      };
      if (smooth)
        for (std::uint32_t k = 0; k < 4; ++k) take(two_, 2 * x + k % 2, 2 * y + k / 2, 0.25F);
      else
        take(one_, x, y, 1);
      std::copy(sum.begin(), sum.end(), &rgb_[3 * (std::size_t{y} * w + x)]);
    }
  out.ball.reset();
  out.blur_px = 0;
  if (scene_.has_ball) {
    Scene::Ball b;
    b.spotted = kind == kSpotted;
    const soccer::GroundXy p = out.in_robot(ball.x, ball.y);
    b.p_m = {p.x_m, p.y_m, ball.z};
    const soccer::PixelAt at = truly.pixel(ball);
    if (at.depth_m > 0) {
      b.u_px = at.u_px, b.v_px = at.v_px;
      const double d2 = math::squared_norm(ball - truly.camera_m()) - kBallRadius_m * kBallRadius_m;
      b.radius_px = d2 > 0 ? see.fx_px * kBallRadius_m / math::sqrt(d2) : 0;
      // A sphere's outline off the middle is an ellipse, longer by the ratio of the way to it to its depth.
      const double longer = norm(ball - truly.camera_m()) / at.depth_m;
      b.visible = static_cast<double>(ball_pixels) / (math::kPi * b.radius_px * b.radius_px * longer);
    }
    out.ball = b;
  }
  paint_background(random);
  degrade(light, random, one_, see, out);

  // What the robot believes: the camera looks a little higher or lower than its pose says.
  const double more = o_.lighting == Lighting::clean ? 0 : 1;
  const Vec3 wrong{light.tilt_rad + more * random.normal(0, 0.003), light.turn_rad + more * random.normal(0, 0.003),
                   light.roll_rad + more * random.normal(0, 0.003)};
  out.believed_pose = out.true_pose;
  out.believed_pose.q_world_optical = (see.pose.q * Quat::exp(wrong)).to<msg::Quat>();
}

}  // namespace sinew::sight
