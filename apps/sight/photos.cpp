#include "apps/sight/photos.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "hal/linux/camera/jpeg_decoder.hpp"
#include "msg/image_buffer.hpp"
#include "vision/colour_table.hpp"

namespace sinew::sight {
namespace {

soccer::SightOptions photo_options() {
  soccer::SightOptions o;
  o.ball_radius_m = kMslBallRadius_m;
  o.ball_farthest_m = 13;
  o.ball_confidence = 0.02;
  o.most_width = msg::kMaxImageWidth, o.most_height = msg::kMaxImageHeight;
  return o;
}

std::optional<Scene::Ball> nearest_ball(const Photo& photo, double u, double v) {
  std::optional<Scene::Ball> best;
  for (const Photo::Box& b : photo.balls) {
    if (best && math::hypot(best->u_px - u, best->v_px - v) < math::hypot(b.u_px - u, b.v_px - v)) continue;
    best = Scene::Ball{{}, b.u_px, b.v_px, 0.25 * (b.wide_px + b.high_px), 1};
  }
  return best;
}

}  // namespace

std::vector<Photo> load_photos(const std::string& folder, std::string& why) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".jpg") names.push_back(entry.path().string());
  std::ranges::sort(names);
  std::vector<Photo> out;
  if (error || names.empty()) {
    why = folder + ": no photos";
    return out;
  }
  for (const std::string& name : names) {
    std::ifstream file(name, std::ios::binary);
    const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
    const std::span<const std::uint8_t> jpeg(reinterpret_cast<const std::uint8_t*>(chars.data()), chars.size());
    const auto shape = hal::JpegDecoder::shape_of(jpeg);
    Photo photo;
    photo.name = std::filesystem::path(name).stem().string();
    if (!shape || shape->width > msg::kMaxImageWidth || shape->height > msg::kMaxImageHeight || shape->width % 2 != 0) {
      why = name + ": no JPEG of at most 1280 x 960 and even width";
      return {};
    }
    photo.width = shape->width, photo.height = shape->height;
    msg::ImageBuffer rgb(msg::PixelFormat::rgb8, shape->width, shape->height);
    hal::JpegDecoder decoder(msg::PixelFormat::rgb8, shape->width, shape->height);
    if (!decoder.decode(jpeg, *rgb)) {
      why = name + ": cannot be decoded";
      return {};
    }
    for (std::uint32_t y = 0; y < photo.height; ++y)
      for (std::uint32_t x = 0; x < photo.width; x += 2) {
        const std::uint8_t* p = rgb->row(y) + 3 * x;
        const vision::Yuv a = vision::to_yuv({p[0], p[1], p[2]}), b = vision::to_yuv({p[3], p[4], p[5]});
        for (const int v : {a.y, (a.u + b.u) / 2, b.y, (a.v + b.v) / 2})
          photo.yuyv.push_back(static_cast<std::uint8_t>(v));
      }
    std::ifstream labels(std::filesystem::path(name).replace_extension(".txt"));
    int kind = 0;
    Photo::Box b{};
    while (labels >> kind >> b.u_px >> b.v_px >> b.wide_px >> b.high_px) {
      b.u_px *= photo.width, b.wide_px *= photo.width, b.v_px *= photo.height, b.high_px *= photo.height;
      if (kind == 0) photo.balls.push_back(b);
    }
    out.push_back(std::move(photo));
  }
  return out;
}

msg::CameraPose PhotoCamera::pose() const {
  msg::CameraPose p;
  const double down = math::atan2(camera.cy_px - horizon_px, camera.fy_px);
  p.p_world_m = {0, 0, height_m};
  p.q_world_optical = (math::Quat::from_axis_angle({0, 1, 0}, down) * math::Quat{0.5, -0.5, 0.5, -0.5}).to<msg::Quat>();
  return p;
}

PhotoCamera fit_camera(std::span<const Photo> photos, double ball_radius_m) {
  // Middle of a ball: horizon + (height - radius) / radius * (radius in the picture). Of all pairs of horizon and
  // slope, that with the least upper third of the radii's relative errors: a ball in the air or a wrong label does no
  // harm.
  PhotoCamera out;
  if (photos.empty()) return out;
  double best = math::kInf;
  for (double horizon = 0.3; horizon < 0.6; horizon += 0.0025)
    for (double slope = 2; slope < 14; slope += 0.1) {
      std::vector<double> off;
      for (const Photo& p : photos)
        for (const Photo::Box& b : p.balls) {
          const double radius = (b.v_px - horizon * p.height) / slope;
          off.push_back(radius > 1 ? math::fabs(math::log(radius / (0.25 * (b.wide_px + b.high_px)))) : 9);
        }
      if (off.empty()) return out;
      std::ranges::sort(off);
      const double median = off[off.size() * 2 / 3];
      if (median < best)
        best = median, out.horizon_px = horizon * photos[0].height, out.height_m = ball_radius_m * (1 + slope);
    }
  const double w = photos[0].width, h = photos[0].height;
  out.camera = {0.9 * w, 0.9 * w, 0.5 * (w - 1), 0.5 * (h - 1)};
  return out;
}

void collect(std::span<const Photo> photos, const PhotoCamera& camera, std::vector<Example>& out) {
  soccer::FieldSight sight(photo_options());
  msg::SoccerSight seen;
  const soccer::GroundView view(camera.camera, camera.pose(), {}, {});
  for (const Photo& p : photos) {
    sight.set_carpet({});
    if (!sight.look(p.view(), view, seen) || !sight.border().found()) continue;
    for (const soccer::BallCandidate& c : sight.candidates().all()) {
      const Verdict v = verdict(c, nearest_ball(p, c.u_px, c.v_px));
      if (v == Verdict::unclear) continue;
      Example e;
      soccer::take_patch(sight.picture(), sight.carpet(), c, e.patch);
      e.is_ball = v == Verdict::ball;
      out.push_back(e);
    }
  }
}

Judgement judge(std::span<const Photo> photos, const PhotoCamera& camera, std::string& lines) {
  Judgement out;
  soccer::FieldSight sight(photo_options());
  msg::SoccerSight seen;
  const soccer::GroundView view(camera.camera, camera.pose(), {}, {});
  for (const Photo& p : photos) {
    sight.set_carpet({});
    ++out.pictures;
    out.balls += p.balls.size();
    char line[200];
    const bool looked = sight.look(p.view(), view, seen) && sight.border().found();
    std::size_t among = 0;
    double best = 0, wrong = 0;
    for (const Photo::Box& b : p.balls)
      among += looked && std::ranges::any_of(sight.candidates().all(), [&](const auto& c) {
                 return verdict(c, Scene::Ball{{}, b.u_px, b.v_px, 0.25 * (b.wide_px + b.high_px), 1}) == Verdict::ball;
               });
    out.balls_candidates += among;
    for (std::uint32_t i = 0; looked && i < seen.balls; ++i) {
      const auto t = nearest_ball(p, seen.ball[i].u_px, seen.ball[i].v_px);
      const bool on =
          t && math::hypot(seen.ball[i].u_px - t->u_px, seen.ball[i].v_px - t->v_px) < 0.6 * t->radius_px + 1.5;
      out.sightings.push_back({seen.ball[i].confidence, on, !on, 0, 1, 0});
      double& most = on ? best : wrong;
      most = std::max(most, static_cast<double>(seen.ball[i].confidence));
    }
    std::snprintf(line, sizeof line, "%s: %zu labelled, %zu among the candidates; surest right %.3f, wrong %.3f\n",
                  p.name.c_str(), p.balls.size(), among, best, wrong);
    lines += line;
  }
  return out;
}

}  // namespace sinew::sight
