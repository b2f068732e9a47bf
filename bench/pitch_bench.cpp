// The load of two teams of four: eight humanoids on the pitch with its dynamics, each with two cameras at 10 pictures a
// second and 100 commands a second; two of them fall over. How many seconds of that one core does in a second, and
// what takes the time.
//
//   taskset -c 0 pitch_bench [SECONDS [BODY.toml [PICTURES]]]     SECONDS of simulated time: 5; PICTURES: a folder
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "apps/toml/body_reader.hpp"
#include "kinematics/leg.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/view.hpp"

namespace {

using namespace sinew;
using namespace sinew::plant;

constexpr std::size_t kRobots = 8;
constexpr int kCommandSteps = 5, kPictureSteps = 50;  // 100 a second, 10 a second

/// Marks time on the spot: feet lifted in turn, the weight shifted over the other one.
class March {
 public:
  explicit March(const kinematics::Body& body) : zero_(body), rad_(body.joints()) {
    std::string why;
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t foot = *body.find_link(side == 0 ? "l_ankle_roll" : "r_ankle_roll");
      auto leg = kinematics::Leg::make(body, foot, why);
      if (!leg) std::fprintf(stderr, "pitch_bench: %s\n", why.c_str()), std::exit(2);
      leg_.push_back(*leg);
      foot_.push_back(zero_.link(foot));
    }
  }
  const std::vector<double>& at(double t_s) {
    const double phase = t_s / 0.25, swing = phase - math::floor(phase);
    const std::size_t lifted = static_cast<std::size_t>(phase) % 2;
    for (std::size_t side = 0; side < 2; ++side) {
      kinematics::Pose to = foot_[side];
      to.p_m.z += 0.025 + (side == lifted ? 0.02 * math::sin(math::kPi * swing) : 0);
      const auto angles = leg_[side].solve(to);
      for (std::size_t i = 0; i < kinematics::kLegJoints; ++i) rad_[leg_[side].links()[i] - 1] = angles.rad[i];
    }
    return rad_;
  }

 private:
  kinematics::BodyPose zero_;
  std::vector<kinematics::Leg> leg_{};
  std::vector<kinematics::Pose> foot_{};
  std::vector<double> rad_;
};

void write_ppm(const std::string& path, const raster::Raster& picture) {
  FILE* const out = std::fopen(path.c_str(), "wb");
  if (!out) return std::perror(path.c_str());
  std::fprintf(out, "P6 %u %u 255\n", picture.width(), picture.height());
  for (const std::uint32_t p : picture.pixels())
    for (int shift = 0; shift < 24; shift += 8) std::fputc(static_cast<int>(p >> shift & 255), out);
  std::fclose(out);
}

/// Of this process's processor time: others may be on the core, too.
double core_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::max(0.1, std::atof(argv[1])) : 5;
  const app::LoadedBody loaded = app::load_body(argc > 2 ? argv[2] : "robots/kid/op3.toml");
  if (!loaded.problems.empty()) return std::fprintf(stderr, "pitch_bench: no body\n"), 2;
  const kinematics::Body& body = loaded.body;
  March march(body);

  std::vector<PitchBody> bodies;
  for (std::size_t i = 0; i < kRobots; ++i) {
    PitchBody b{.body = body};
    b.team = static_cast<std::uint8_t>(i / 4);
    const double side = i < 4 ? -1 : 1, row = static_cast<double>(i % 4);
    b.start = {.x_m = side * (0.7 + 0.5 * row), .y_m = 1.1 * (row - 1.5), .joints_rad = march.at(0)};
    b.start.heading_rad = math::atan2(-b.start.y_m, -b.start.x_m);  // towards the ball
    b.gain_per_rad = 12;
    bodies.push_back(b);
  }
  const PitchOptions options;
  auto created = Pitch::create(options, bodies, 1);
  if (!created) return std::fprintf(stderr, "pitch_bench: no pitch\n"), 1;
  Pitch& pitch = **created;
  const PitchView view(options, bodies);
  const auto head = body.find_link("head_tilt");

  for (const auto& [width, height] : {std::pair{320u, 240u}, {640u, 480u}}) {
    for (std::size_t i = 0; i < kRobots; ++i) pitch.place(i, bodies[i].start);
    raster::Raster picture(width, height);
    PitchScene scene;
    double steps_s = 0, pictures_s = 0;
    int pictures = 0, down = 0, most_down = 0;
    const int steps = static_cast<int>(seconds * 1e9 / kPitchStepNs);
    for (int step = 0; step < steps; ++step) {
      const double t = step * kPitchStepNs * 1e-9;
      const auto begin = core_s();
      if (step % kCommandSteps == 0)
        for (std::size_t i = 0; i < kRobots; ++i) {
          auto rad = march.at(t + 0.03 * static_cast<double>(i));
          if (head) rad[*head - 1] = 0.3;
          // Two fall: limp for half a second, then they march on where they lie.
          if ((i == 1 || i == 6) && t > 0.3 && t < 0.8) std::fill(rad.begin(), rad.end(), math::kNan);
          pitch.command(i, rad);
        }
      if (step == 150 || step == 151) pitch.push(step == 150 ? 1 : 6, {2, 1, 0}, 100'000'000);
      pitch.step();
      steps_s += core_s() - begin;
      if (step % kPictureSteps != 0) continue;
      const auto drawn = core_s();
      scene.take(pitch);
      for (std::size_t i = 0; i < kRobots; ++i)
        for (std::size_t camera = 0; camera < view.cameras(i); ++camera, ++pictures) {
          view.draw(picture, scene, i, camera);
          if (argc > 3 && step == kPictureSteps * 10)
            write_ppm(std::string(argv[3]) + "/robot" + std::to_string(i) + "_" + view.camera_name(i, camera) + "_" +
                          std::to_string(width) + ".ppm",
                      picture);
        }
      pictures_s += core_s() - drawn;
      if (argc > 3 && step == kPictureSteps * 10) {
        raster::Raster outside(960, 600);
        view.draw(outside, scene, camera_at({-4.2, -3.6, 2.4}, {0, 0, 0.1}, 960, 600));
        write_ppm(std::string(argv[3]) + "/outside.ppm", outside);
      }
      down = 0;
      for (std::size_t i = 0; i < kRobots; ++i) down += pitch.truth(i).fallen ? 1 : 0;
      most_down = std::max(most_down, down);
    }
    std::printf(
        "pitch_%ux%u   %.2f x real time: of a simulated second %.3f s for steps and commands (%.3f ms a step), %.3f s "
        "for %d pictures (%.2f ms each); %d robots down, MuJoCo warned %llu times\n",
        width, height, seconds / (steps_s + pictures_s), steps_s / seconds, 1e3 * steps_s / steps, pictures_s / seconds,
        static_cast<int>(pictures / seconds), 1e3 * pictures_s / std::max(1, pictures), most_down,
        static_cast<unsigned long long>(pitch.trouble()));
  }
}
