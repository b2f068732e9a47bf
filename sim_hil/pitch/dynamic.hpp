#pragma once
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::plant {

/// Pitch::create() on MuJoCo's dynamics; options and bodies have been checked.
hal::Result<std::unique_ptr<Pitch>> create_dynamic_pitch(const PitchOptions& options, std::span<const PitchBody> bodies,
                                                         std::uint64_t seed);

}  // namespace sinew::plant
