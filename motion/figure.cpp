#include "motion/figure.hpp"

#include <algorithm>

namespace sinew::motion {

using kinematics::kNone;

std::size_t Figure::find_joint(std::string_view name) const {
  const auto link = body_->find_link(name);
  return link && *link > 0 ? *link - 1 : kNone;
}

std::optional<Figure> Figure::make(const kinematics::Body& body, std::string& why) {
  Figure figure;
  figure.body_ = &body;
  for (const Side side : kSides) {
    const std::string letter = side == Side::left ? "l_" : "r_";
    const kinematics::Place* sole = body.find_place(letter + "sole");
    if (sole == nullptr) {
      why = body.name + ": it has no place " + letter + "sole";
      return std::nullopt;
    }
    auto leg = kinematics::Leg::make(body, sole->link, why);
    if (!leg) return std::nullopt;
    LegOfFigure& mine = figure.legs_[index(side)];
    mine.leg = *leg;
    mine.foot = sole->link;
    mine.sole = sole->pose;
    for (const kinematics::Shape& shape : body.links[sole->link].shapes)
      if (shape.kind == kinematics::Shape::Kind::box &&
          shape.size_m.x * shape.size_m.y > mine.sole_length_m * mine.sole_width_m)
        mine.sole_length_m = shape.size_m.x, mine.sole_width_m = shape.size_m.y;
    if (!(mine.sole_length_m > 0)) {
      why = body.links[sole->link].name + ": a foot needs a box as its sole";
      return std::nullopt;
    }
    figure.shoulder_pitch_[index(side)] = figure.find_joint(letter + "shoulder_pitch");
  }
  for (const char* name : {"head_pan", "head_yaw"})
    if (figure.head_pan_ == kNone) figure.head_pan_ = figure.find_joint(name);
  for (const char* name : {"head_tilt", "head_pitch"})
    if (figure.head_tilt_ == kNone) figure.head_tilt_ = figure.find_joint(name);
  figure.mass_kg_ = body.mass_kg();
  return figure;
}

bool Figure::place_sole(Side side, const kinematics::Pose& sole, std::span<double> joints_rad) const {
  const LegOfFigure& mine = leg(side);
  const kinematics::LegAngles found = mine.leg.solve(sole * mine.sole.inverse());
  for (std::size_t j = 0; j < kinematics::kLegJoints; ++j) joints_rad[mine.leg.links()[j] - 1] = found.rad[j];
  return found.reached;
}

void Figure::limit(std::span<double> joints_rad) const {
  for (std::size_t j = 0; j < joints(); ++j)
    joints_rad[j] = std::clamp(joints_rad[j], body_->links[j + 1].least_rad, body_->links[j + 1].most_rad);
}

}  // namespace sinew::motion
