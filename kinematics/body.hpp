#pragma once
// A robot's body: links that hang on each other by hinges, with masses, servos and shapes. One table (body_file.hpp)
// gives the simulator its model and the robot its kinematics.
//
//   const BodyFile file = load_body("robots/kid/op3.toml");
//   BodyPose pose(file.body);
//   pose.set(joints_rad);
//   pose.link(body.find_link("l_ankle_roll")).p_m;       // where the left foot is, in the torso's frame
//   pose.centre_of_mass();
//
// Frames:  each link has x forward, y left, z up when all joints are at 0; its origin lies on its joint's axis. Link 0
//          is the one that hangs on nothing: the torso.
// Source:  R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 2 to 4.
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "math/linear.hpp"

namespace sinew::kinematics {

inline constexpr std::size_t kMaxLinks = 48;
inline constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// A frame in another one: p is its origin there, q takes its coordinates to those.
struct Pose {
  math::Vec3 p_m;
  math::Quat q;

  math::Vec3 of(const math::Vec3& point_m) const { return p_m + q.rotate(point_m); }
  Pose inverse() const { return {q.conjugate().rotate(-p_m), q.conjugate()}; }
  friend Pose operator*(const Pose& a, const Pose& b) { return {a.of(b.p_m), a.q * b.q}; }
};

/// A servo at its rated voltage, with its gear.
struct ServoType {
  std::string name;
  double stall_nm = 0, no_load_radps = 0;
  double armature_kgm2 = 0;  // the rotor's inertia, seen at the joint
};

/// What a link is like from outside, for contacts and pictures.
struct Shape {
  enum class Kind : std::uint8_t { box, capsule, sphere } kind = Kind::box;
  math::Vec3 at_m;  // its middle, in the link's frame
  math::Vec3
      size_m;    // box: full lengths; capsule: x radius, z length between the middles of its ends; sphere: x radius
  math::Quat q;  // a capsule lies along its z
  bool contact = true;
};

struct Link {
  std::string name;  // also of its joint
  std::size_t parent = kNone;
  math::Vec3 at_m;           // the link's origin in its parent's frame
  math::Vec3 axis{0, 0, 1};  // of the joint; unit length
  double least_rad = 0, most_rad = 0;
  std::size_t servo = kNone;  // in Body::servos
  double mass_kg = 0;
  math::Vec3 com_m;
  std::array<double, 6> inertia_kgm2{};  // about com, in the link's axes: xx, yy, zz, xy, xz, yz
  std::vector<Shape> shapes{};
};

/// A place on a link that has a name: a camera (x forward, y left, z up), the IMU, the middle of a sole.
struct Place {
  std::string name;
  std::size_t link = 0;
  Pose pose;
};

struct Body {
  std::string name;
  std::vector<ServoType> servos{};
  std::vector<Link> links{};  // a parent stands before its children; joint i belongs to link i + 1
  std::vector<Place> places{};

  std::size_t joints() const { return links.empty() ? 0 : links.size() - 1; }
  std::optional<std::size_t> find_link(std::string_view link) const;
  const Place* find_place(std::string_view place) const;
  double mass_kg() const;
};

/// The pose of every link for given joint angles.
/// Thread:  owner.   RT: yes, after the constructor.
/// Owner:   the body lives as long.
class BodyPose {
 public:
  /// The body has 1 to kMaxLinks links.
  explicit BodyPose(const Body& body);

  /// One angle for each joint, rad; `base`: where link 0 is.
  void set(std::span<const double> joints_rad, const Pose& base = {});

  const Body& body() const { return *body_; }
  const Pose& link(std::size_t link) const { return pose_[link]; }
  Pose place(const Place& place) const { return pose_[place.link] * place.pose; }
  math::Vec3 centre_of_mass() const;

  /// How a point fixed to a link moves with each joint, in the axes of the frame that `base` was given in: columns for
  /// the joints in order, `linear` in m/rad and `angular` in rad/rad.
  void jacobian(std::size_t link, const math::Vec3& point_m, std::span<math::Vec3> linear,
                std::span<math::Vec3> angular) const;
  /// How the centre of mass moves with each joint, link 0 held: m/rad.
  void jacobian_of_centre_of_mass(std::span<math::Vec3> linear) const;

 private:
  const Body* body_;
  std::array<Pose, kMaxLinks> pose_{};
  double mass_kg_ = 0;
};

}  // namespace sinew::kinematics
