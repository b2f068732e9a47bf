// A humanoid stands on the pitch and is pushed from behind, harder each time, until it falls.
//
//   example_push_a_kid robots/kid/op3.toml [SEED]
#include <cstdio>
#include <cstdlib>

#include "apps/toml/body_reader.hpp"
#include "sim_hil/pitch/pitch.hpp"

using namespace sinew;
using namespace sinew::plant;

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: example_push_a_kid BODY.toml [SEED]\n"), 2;
  const app::LoadedBody loaded = app::load_body(argv[1]);
  for (const rt::Problem& p : loaded.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, argv[1]).c_str());
  if (!loaded.problems.empty()) return 2;

  PitchBody kid{.body = loaded.body};
  kid.start.joints_rad.assign(loaded.body.joints(), 0);  // upright
  kid.gain_per_rad = 12;
  std::string why;
  auto created =
      Pitch::create({.has_ball = false}, {&kid, 1}, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1, &why);
  if (!created) return std::fprintf(stderr, "%s\n", why.c_str()), 1;
  Pitch& pitch = **created;
  std::printf("%.2f kg, commands arrive after %lld ms\n", pitch.body(0).mass_kg(),
              static_cast<long long>(pitch.command_delay_ns(0) / 1'000'000));

  for (double speed_mps = 0.05; speed_mps < 1; speed_mps += 0.05) {
    pitch.place(0, kid.start);
    for (int step = 0; step < 1500; ++step) {
      if (step % 5 == 0) pitch.command(0, kid.start.joints_rad);
      if (step == 500) pitch.push(0, {speed_mps * pitch.body(0).mass_kg(), 0, 0}, 100'000'000);
      pitch.step();
    }
    std::printf("pushed by %.2f m/s: %s\n", speed_mps, pitch.truth(0).fallen ? "falls" : "stands");
    if (pitch.truth(0).fallen) return 0;
  }
}
