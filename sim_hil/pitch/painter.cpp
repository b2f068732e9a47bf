#include "sim_hil/pitch/painter.hpp"

#include "sim_hil/pitch/lens_film.hpp"
#include "sim_hil/pitch/view.hpp"

namespace sinew::plant {
namespace {

/// x ahead, y left, z up to x right, y down, z ahead.
constexpr math::Quat kQOptical{0.5, -0.5, 0.5, -0.5};

plant::Pose to_world(const kinematics::Pose& p) { return {p.p_m.to<msg::Vec3>(), p.q.to<msg::Quat>()}; }

class PitchPainter final : public Painter {
 public:
  PitchPainter(std::uint32_t width, std::uint32_t height, const PitchOptions& options,
               std::span<const PitchBody> bodies)
      : picture_(width, height), view_(options, bodies) {
    if (!options.lens.none() || options.board.square_m > 0)
      film_ = std::make_unique<LensFilm>(width, height, options.focal_per_height * height, options.lens);
    pitch_.robots.resize(bodies.size());
    for (const PitchBody& body : bodies) links_.push_back(body.body.links.size());
  }

  std::span<const std::uint32_t> draw(const Scene& scene) override {
    const auto from = [](const plant::Pose& p) {
      return kinematics::Pose{math::Vec3(p.p_world_m), math::Quat(p.q_world)};
    };
    pitch_.ball = from(scene.body[0]);
    std::size_t next = 1;
    for (std::size_t r = 0; r < links_.size(); ++r)
      for (std::size_t link = 0; link < links_[r] && next < scene.bodies; ++link)
        pitch_.robots[r].link[link] = from(scene.body[next++]);
    raster::Camera camera;
    camera.pose = {math::Vec3(scene.camera.p_world_m), math::Quat(scene.camera.q_world_optical)};
    camera.fx_px = camera.fy_px = scene.camera.focal_per_height * picture_.height();
    camera.cx_px = 0.5 * picture_.width();
    camera.cy_px = 0.5 * picture_.height();
    if (film_) {
      camera.fx_px = camera.fy_px = film_->focal_px();
      camera.cx_px = 0.5 * film_->raster().width();
      camera.cy_px = 0.5 * film_->raster().height();
      view_.draw(film_->raster(), pitch_, camera);
      return film_->develop();
    }
    view_.draw(picture_, pitch_, camera);
    return picture_.pixels();
  }

 private:
  raster::Raster picture_;
  std::unique_ptr<LensFilm> film_;
  PitchView view_;
  PitchScene pitch_;
  std::vector<std::size_t> links_;
};

}  // namespace

Scene pitch_scene(const Pitch& pitch, std::size_t robot, std::size_t camera) {
  Scene scene;
  scene.body[scene.bodies++] = {pitch.ball().p_m.to<msg::Vec3>(), {}};
  for (std::size_t r = 0; r < pitch.robots(); ++r)
    for (std::size_t link = 0; link < pitch.body(r).links.size() && scene.bodies < Scene::kMost; ++link)
      scene.body[scene.bodies++] = to_world(pitch.truth(r).link[link]);
  for (const kinematics::Place& place : pitch.body(robot).places) {
    if (!place.name.starts_with("camera") || camera-- != 0) continue;
    const kinematics::Pose pose = pitch.truth(robot).link[place.link] * place.pose;
    scene.camera.p_world_m = pose.p_m.to<msg::Vec3>();
    scene.camera.q_world_optical = (pose.q * kQOptical).to<msg::Quat>();
    break;
  }
  return scene;
}

std::unique_ptr<Painter> pitch_painter(std::uint32_t width, std::uint32_t height, const PitchOptions& options,
                                       std::span<const PitchBody> bodies) {
  return std::make_unique<PitchPainter>(width, height, options, bodies);
}

}  // namespace sinew::plant
