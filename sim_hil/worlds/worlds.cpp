#include "sim_hil/worlds/worlds.hpp"

#include <algorithm>

namespace sinew::plant {

const WorldDevice* WorldInfo::find(Part part) const {
  const auto it = std::ranges::find(devices, part, &WorldDevice::part);
  return it == devices.end() ? nullptr : &*it;
}

bool WorldInfo::has(FaultDevice device) const {
  return device == FaultDevice::link || std::ranges::find(devices, device, &WorldDevice::fault) != devices.end();
}

WorldInfo world_info(WorldKind kind) { return kind == WorldKind::desk_head ? HeadWorld::info() : QuadWorld::info(); }

std::optional<WorldKind> find_world(std::string_view name) {
  for (const WorldKind kind : kWorldKinds)
    if (world_info(kind).name == name) return kind;
  return std::nullopt;
}

hal::Result<std::unique_ptr<World>> create_world(const WorldOptions& options, std::uint64_t seed) {
  if (options.kind == WorldKind::desk_head) {
    HeadOptions head = options.head;
    head.seed = seed;
    return std::unique_ptr<World>(std::make_unique<HeadWorld>(head));
  }
  QuadOptions quad = options.quad;
  quad.seed = seed;
  auto made = QuadWorld::create(quad);
  if (!made) return made.error();
  return std::unique_ptr<World>(std::move(*made));
}

}  // namespace sinew::plant
