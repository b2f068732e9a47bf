// Bends the knees of a humanoid: its body from a file, legs solved for feet that stay flat on the ground, and where its
// centre of mass is then.
//
//   example_crouch robots/kid/op3.toml [0.03]                  the torso goes down by so much, m
#include <cstdio>
#include <cstdlib>

#include "apps/toml/body_reader.hpp"
#include "kinematics/leg.hpp"

using namespace sinew;

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: example_crouch BODY.toml [METRES]\n"), 2;
  const app::LoadedBody loaded = app::load_body(argv[1]);
  for (const rt::Problem& p : loaded.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, argv[1]).c_str());
  if (!loaded.problems.empty()) return 2;
  const kinematics::Body& body = loaded.body;
  const double down_m = argc > 2 ? std::atof(argv[2]) : 0.03;

  std::vector<double> angles_rad(body.joints());
  kinematics::BodyPose pose(body);
  pose.set(angles_rad);
  for (const char* sole : {"l_sole", "r_sole"}) {
    const kinematics::Place* place = body.find_place(sole);
    std::string why = "it is missing";
    const auto leg = place ? kinematics::Leg::make(body, place->link, why) : std::nullopt;
    if (!leg) return std::fprintf(stderr, "%s: %s\n", sole, why.c_str()), 1;
    kinematics::Pose foot = pose.link(place->link);
    foot.p_m.z += down_m;
    const kinematics::LegAngles found = leg->solve(foot);
    if (!found.reached) return std::fprintf(stderr, "%s: %g m is too far\n", sole, down_m), 1;
    for (std::size_t j = 0; j < kinematics::kLegJoints; ++j) {
      const std::size_t link = leg->links()[j];
      angles_rad[link - 1] = found.rad[j];
      std::printf("%-16s %7.2f deg\n", body.links[link].name.c_str(), found.rad[j] * 180 / math::kPi);
    }
  }
  pose.set(angles_rad);
  const math::Vec3 com = pose.centre_of_mass(), sole = pose.place(*body.find_place("l_sole")).p_m;
  std::printf("%.2f kg, its middle %.1f mm before the soles' and %.1f mm above them\n", body.mass_kg(),
              1e3 * (com.x - sole.x), 1e3 * (com.z - sole.z));
}
