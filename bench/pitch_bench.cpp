// The load of two teams of four: eight humanoids on the pitch with its dynamics, each with two cameras at 10 pictures a
// second and 100 commands a second. They walk towards the ball by their own sensors; two of them lose their torque and
// fall. How many seconds of that one core does in a second, and what takes the time. The robots' own programs are not
// counted.
//
//   taskset -c 0 pitch_bench [SECONDS [BODY.toml [PICTURES]]]     SECONDS of simulated time: 8; PICTURES: a folder
//   BODY.toml has BODY_motion.toml beside it.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/toml/body_reader.hpp"
#include "apps/toml/motion_reader.hpp"
#include "motion/walk.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/view.hpp"

namespace {

using namespace sinew;
using namespace sinew::plant;

constexpr std::size_t kRobots = 8;
constexpr int kCommandSteps = 5, kPictureSteps = 50;  // 100 a second, 10 a second
constexpr double kStand_s = 0.5, kLimp_s = 1, kWalk_mps = 0.2;

/// One robot's own program: it walks by its own sensors, as kid::Mover makes it walk. Its time is not the plant's.
class Walker {
 public:
  Walker(const motion::Figure& figure, const motion::MotionBook& book)
      : joints_(figure.joints()), walk_(figure, book.rest_rad) {
    walk_.params = book.walk;
  }
  /// As it stands before it walks.
  std::vector<double> standing() {
    motion::Sensed upright;
    const std::vector<double> zero(joints_);
    upright.joints_rad = zero;
    upright.accel_mps2 = {0, 0, 9.81};
    walk_.reset(upright);
    std::vector<double> rad(joints_);
    walk_.step({}, upright, kCommandSteps * kPitchStepNs * 1e-9, rad);
    return rad;
  }
  std::span<const double> step(const BodySensors& s, const motion::WalkCommand& command) {
    for (std::size_t j = 0; j < joints_; ++j) measured_rad_[j] = s.joint[j].position_rad;
    const motion::Sensed sensed{std::span(measured_rad_).first(joints_), s.gyro_radps, s.accel_mps2, s.cell_n};
    if (!begun_) walk_.reset(sensed);
    begun_ = true;
    walk_.step(command, sensed, kCommandSteps * kPitchStepNs * 1e-9, targets_rad_);
    return std::span(targets_rad_).first(joints_);
  }

 private:
  std::size_t joints_;
  motion::Walk walk_;
  motion::JointAngles measured_rad_{}, targets_rad_{};
  bool begun_ = false;
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
  const double seconds = argc > 1 ? std::max(0.1, std::atof(argv[1])) : 8;
  const std::string path = argc > 2 ? argv[2] : "robots/kid/op3.toml";
  const app::LoadedBody loaded = app::load_body(path);
  if (!loaded.problems.empty()) return std::fprintf(stderr, "pitch_bench: no body\n"), 2;
  const kinematics::Body& body = loaded.body;
  const app::LoadedMotions motions =
      app::load_motions(std::filesystem::path(path).replace_extension().string() + "_motion.toml", body);
  std::string why;
  const auto figure = motion::Figure::make(body, why);
  if (!motions.problems.empty() || !figure) return std::fprintf(stderr, "pitch_bench: no motions %s\n", why.c_str()), 2;
  const std::vector<double> standing = Walker(*figure, motions.book).standing();

  std::vector<PitchBody> bodies;
  for (std::size_t i = 0; i < kRobots; ++i) {
    PitchBody b{.body = body};
    b.team = static_cast<std::uint8_t>(i / 4);
    const double side = i < 4 ? -1 : 1, row = static_cast<double>(i % 4);
    b.start = {.x_m = side * (0.7 + 0.5 * row), .y_m = 1.1 * (row - 1.5), .joints_rad = standing};
    b.start.heading_rad = math::atan2(-b.start.y_m, -b.start.x_m);  // towards the ball
    b.gain_per_rad = motions.book.walk.servo_gain_per_rad;
    bodies.push_back(b);
  }
  const PitchOptions options;
  auto created = Pitch::create(options, bodies, 1);
  if (!created) return std::fprintf(stderr, "pitch_bench: no pitch\n"), 1;
  Pitch& pitch = **created;
  const PitchView view(options, bodies);

  for (const auto& [width, height] : {std::pair{320u, 240u}, {640u, 480u}}) {
    std::vector<Walker> walkers;
    for (std::size_t i = 0; i < kRobots; ++i) {
      pitch.place(i, bodies[i].start);
      walkers.emplace_back(*figure, motions.book);
    }
    raster::Raster picture(width, height);
    PitchScene scene;
    double steps_s = 0, pictures_s = 0;
    int pictures = 0, down = 0, most_down = 0;
    const int steps = static_cast<int>(seconds * 1e9 / kPitchStepNs);
    for (int step = 0; step < steps; ++step) {
      const double t = step * kPitchStepNs * 1e-9;
      if (step % kCommandSteps == 0)
        for (std::size_t i = 0; i < kRobots; ++i) {
          const BodySensors& sensors = pitch.sensors(i);
          const auto walked =
              walkers[i].step(sensors, {.forward_mps = t < kStand_s ? 0 : kWalk_mps, .walk = t >= kStand_s});
          std::vector<double> rad(walked.begin(), walked.end());
          // Two fall: limp for half a second, then their legs go on where they lie.
          if ((i == 1 || i == 6) && t > kLimp_s && t < kLimp_s + 0.5) std::fill(rad.begin(), rad.end(), math::kNan);
          const auto begin = core_s();
          pitch.command(i, rad);
          steps_s += core_s() - begin;
        }
      const auto begin = core_s();
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
    double way_m = 0;
    for (std::size_t i = 0; i < kRobots; ++i) {
      const math::Vec3& at = pitch.truth(i).torso.p_m;
      way_m += math::hypot(at.x - bodies[i].start.x_m, at.y - bodies[i].start.y_m) / kRobots;
    }
    std::printf(
        "pitch_%ux%u   %.2f x real time: of a simulated second %.3f s for steps and commands (%.3f ms a step), %.3f s "
        "for %d pictures (%.2f ms each); %d robots down, %.2f m walked by each, MuJoCo warned %llu times\n",
        width, height, seconds / (steps_s + pictures_s), steps_s / seconds, 1e3 * steps_s / steps, pictures_s / seconds,
        static_cast<int>(pictures / seconds), 1e3 * pictures_s / std::max(1, pictures), most_down, way_m,
        static_cast<unsigned long long>(pitch.trouble()));
  }
}
