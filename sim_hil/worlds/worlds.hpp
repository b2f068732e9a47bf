#pragma once
#include <optional>
#include <string_view>

#include "sim_hil/worlds/head_world.hpp"
#include "sim_hil/worlds/quad_world.hpp"

namespace sinew::plant {

/// Which world, and what each kind can be told.
struct WorldOptions {
  WorldKind kind = WorldKind::quad;
  QuadOptions quad;
  HeadOptions head;
};

inline constexpr WorldKind kWorldKinds[] = {WorldKind::quad, WorldKind::desk_head};

/// What this kind of world has on board.
WorldInfo world_info(WorldKind kind);
/// By the name that world_info() gives it.
std::optional<WorldKind> find_world(std::string_view name);
/// `seed` is the run's, in place of the options'.
hal::Result<std::unique_ptr<World>> create_world(const WorldOptions& options, std::uint64_t seed);

}  // namespace sinew::plant
