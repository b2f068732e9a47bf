#pragma once
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::plant {

/// Pitch::create() without dynamics; bodies have been checked.
std::unique_ptr<Pitch> create_kinematic_pitch(const PitchOptions& options, std::span<const PitchBody> bodies,
                                              std::uint64_t seed);

}  // namespace sinew::plant
