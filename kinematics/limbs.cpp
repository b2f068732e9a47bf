#include "kinematics/limbs.hpp"

namespace sinew::kinematics {
namespace {

/// The link that hangs on link 0 and carries this one.
std::size_t branch_of(const Body& body, std::size_t link) {
  while (link != 0 && body.links[link].parent != 0) link = body.links[link].parent;
  return link;
}

std::size_t branch_with(const Body& body, std::string_view place) {
  const Place* const found = body.find_place(place);
  return found && found->link != 0 ? branch_of(body, found->link) : kNone;
}

}  // namespace

std::string_view to_string(Limb limb) {
  constexpr std::string_view kNames[kLimbs] = {"head", "left_arm", "right_arm", "left_leg", "right_leg"};
  return kNames[static_cast<std::size_t>(limb)];
}

Limbs Limbs::of(const Body& body) {
  const std::size_t left = branch_with(body, "l_sole"), right = branch_with(body, "r_sole");
  Limbs limbs;
  for (std::size_t joint = 0; joint < body.joints(); ++joint) {
    const std::size_t branch = branch_of(body, joint + 1);
    const std::string& name = body.links[branch].name;
    Limb limb = Limb::head;
    if (branch == left)
      limb = Limb::left_leg;
    else if (branch == right)
      limb = Limb::right_leg;
    else if (name.starts_with("l_"))
      limb = Limb::left_arm;
    else if (name.starts_with("r_"))
      limb = Limb::right_arm;
    limbs.joints[static_cast<std::size_t>(limb)].push_back(joint);
  }
  return limbs;
}

}  // namespace sinew::kinematics
