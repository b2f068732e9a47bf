#include "robots/quad/world/quad_world.hpp"

#include <mujoco/mujoco.h>

#include "robots/quad/world/room_xml.hpp"
#include "sim_hil/worlds/wind.hpp"

namespace sinew::plant {

struct QuadWorld::Impl {
  Impl(const QuadOptions& first, ModelPtr m)
      : model(std::move(m)),
        data(mj_makeData(model.get())),
        wind({first.gust_mps, first.wind_mps, first.wind_toward_rad}, first.seed) {}

  msg::Time now() const { return {steps * kStepNs}; }

  ModelPtr model;
  DataPtr data;
  Wind wind;
  std::array<const Quad*, kMostRobots> seen{};  // the same, for each other
  std::vector<std::unique_ptr<Quad>> quads;
  std::int64_t steps = 0;
};

QuadWorld::QuadWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
QuadWorld::~QuadWorld() = default;

WorldInfo QuadWorld::info() { return {"quad", kQuadDevices, kQuadWorldOptions, kMostQuads}; }

hal::Result<std::unique_ptr<QuadWorld>> QuadWorld::create(std::span<const QuadOptions> robots) {
  if (robots.empty() || robots.size() > kMostQuads)
    return hal::Error{hal::Errc::bad_argument, "vehicles in the room", static_cast<std::int64_t>(robots.size())};
  auto model = load_room(robots::room_xml_of_quad(), RoomUse::physics, robots.size());
  if (!model) return model.error();
  auto impl = std::make_unique<Impl>(robots[0], std::move(*model));
  const std::span<const Quad* const> all(impl->seen.data(), robots.size());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    impl->quads.push_back(std::make_unique<Quad>(robots[i], *impl->model, *impl->data, i, all));
    impl->seen[i] = impl->quads.back().get();
  }
  for (const auto& quad : impl->quads)
    if (!quad->start()) return hal::Error{hal::Errc::bad_argument, "no room to start: vehicles need 0.7 m"};
  mj_forward(impl->model.get(), impl->data.get());  // static geoms get their world poses here
  return std::unique_ptr<QuadWorld>(new QuadWorld(std::move(impl)));
}

void QuadWorld::advance(std::span<const RobotCommand> commands) {
  Impl& w = *impl_;
  const msg::Vec3& wind = w.wind.step(1e-9 * kStepNs);
  for (std::size_t i = 0; i < w.quads.size(); ++i) w.quads[i]->apply_forces(commands[i], wind);
  if (w.quads.size() != 1 || !w.quads[0]->accelerate_freely())
    mj_forwardSkip(w.model.get(), w.data.get(), mjSTAGE_NONE, 1);
  for (const auto& quad : w.quads) quad->integrate();
  ++w.steps;
  for (const auto& quad : w.quads) {
    quad->watch_contacts(w.now());
    quad->sample(w.steps);
  }
}

msg::Time QuadWorld::now() const { return impl_->now(); }
std::size_t QuadWorld::robots() const { return impl_->quads.size(); }
Quad& QuadWorld::quad(std::size_t number) { return *impl_->quads[number]; }

}  // namespace sinew::plant
