#pragma once
#include <array>
#include <optional>

#include "sim_hil/pitch/pitch.hpp"

namespace sinew::plant {

/// The pose of link 0 for a place on flat ground: the lowest point of the body's shapes is `above_m` over it.
kinematics::Pose pose_on_ground(const kinematics::Body& body, const PitchPlace& at, double above_m);
/// Height of the lowest point of the shapes with contact, in the frame that `pose` was set in.
double lowest_point_m(const kinematics::BodyPose& pose);

/// A rectangle under a foot that carries four pressure cells at its corners.
struct Sole {
  std::size_t link = 0;
  std::size_t shape = 0;  // of the link: a box
  kinematics::Pose box;   // its middle in the link's frame
  math::Vec3 half_m;
};
/// Left and right: the boxes nearest to the places "l_sole" and "r_sole". A body without them has no soles.
std::array<std::optional<Sole>, 2> soles_of(const kinematics::Body& body);

/// Shares of the four cells (front left, front right, back left, back right) in a force at this place of the box; a
/// plate on four springs.
std::array<double, 4> cell_shares(const Sole& sole, const math::Vec3& at_box_m);

}  // namespace sinew::plant
