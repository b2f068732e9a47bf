#pragma once
#include <string>

#include "kinematics/body.hpp"

namespace sinew::plant {

struct BodyXml {
  std::string name_end;    // behind each name, so that several robots are in one world
  math::Vec3 at_m;         // of link 0
  double friction = 0.8;   // of all shapes
  std::string material{};  // of the shapes; empty: none
  bool free = true;        // link 0 hangs on nothing
};

/// A body as MuJoCo's XML, for a <worldbody>: <body> elements with inertias, hinges, shapes, and a site for each place.
/// Hinges have the rotors' inertia and no motor; torques come from a servo's model.
std::string body_xml(const kinematics::Body& body, const BodyXml& options);

}  // namespace sinew::plant
