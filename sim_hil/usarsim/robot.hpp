#pragma once
#include <vector>

#include "math/random.hpp"
#include "sim_hil/usarsim/game.hpp"
#include "wire/text/usarsim.hpp"

namespace sinew::usarsim {

/// A client's robot: its vehicle in the place, and what it says of it.
/// Thread:  owner.
class Robot {
 public:
  /// The vehicle of `bot.slot`, which is there.
  Robot(Game& game, const Game::Bot& bot, std::uint64_t seed);

  const Game::Bot& bot() const { return bot_; }
  plant::Vehicle& vehicle() { return *game_.place().vehicle(bot_.slot); }
  const plant::Vehicle& vehicle() const { return *game_.place().vehicle(bot_.slot); }

  void count_drive() { ++visit_.drives; }
  /// Its time here until now.
  Game::Visit visit() const;

  void set_light(bool on) { light_ = on; }
  void set_normalized(bool on) { normalized_ = on; }
  bool normalized() const { return normalized_; }
  /// From now on ASTA lines come beside MISSTA.
  void answer_acts() { answers_acts_ = true; }

  /// Calls with each line that is due by now: sensors in the order of the class's table, MISSTA, STA. `say(line)`.
  template <class Say>
  void tell(Say&& say) {
    const double now_s = game_.now_s();
    for (Due& due : due_) {
      if (now_s + 1e-9 < due.at_s) continue;
      due.at_s += due.interval_s;
      if (due.at_s <= now_s) due.at_s = now_s + due.interval_s;  // steps that are longer than the interval
      write(due, say);
    }
  }

  /// "CONF {Type Sonar} {Name F1} ...", of all of that type, or of one name. Types as clients write them; of one that
  /// it does not have, only the type. Errors: false: no such type.
  bool configuration(std::string_view type, std::string_view name, wire::UsarWriter& out) const;
  /// "GEO ..." likewise.
  bool geometry(std::string_view type, std::string_view name, wire::UsarWriter& out) const;

 private:
  enum class What : std::uint8_t { sensors, package, status };
  /// One line, or several: sensors of one type and interval.
  struct Due {
    What what{};
    std::vector<std::size_t> sensors{};  // of the class's table
    double interval_s = 0, at_s = 0;
  };
  struct Drift {
    math::Vec3 position_m, angles_rad;  // of the INS's estimate
    math::Vec3 last_m, last_rad;
    math::Vec3 share;  // of the way
  };

  template <class Say>
  void write(const Due& due, Say&& say) {
    std::array<char, wire::kUsarLine> buffer;
    if (due.what == What::sensors && !in_one_line(due)) {
      for (const std::size_t i : due.sensors) {
        wire::UsarWriter out(buffer);
        sense({&i, 1}, out);
        say(out.line());
      }
      return;
    }
    wire::UsarWriter out(buffer);
    if (due.what == What::sensors)
      sense(due.sensors, out);
    else if (due.what == What::package)
      write_package(out, "MISSTA");
    else
      write_status(out);
    say(out.line());
    if (due.what != What::package || !answers_acts_) return;
    wire::UsarWriter asta(buffer);
    write_package(asta, "ASTA");
    say(asta.line());
  }
  const SensorMount& mount(std::size_t i) const { return bot_.kind->sensors[i]; }
  bool in_one_line(const Due& due) const;
  void sense(std::span<const std::size_t> sensors, wire::UsarWriter& out);
  void write_status(wire::UsarWriter& out) const;
  void write_package(wire::UsarWriter& out, const char* type) const;

  void sense_truth(const SensorMount& m, wire::UsarWriter& out) const;
  void sense_ins(const SensorMount& m, wire::UsarWriter& out);
  void sense_imu(const SensorMount& m, wire::UsarWriter& out);
  void sense_acceleration(const SensorMount& m, wire::UsarWriter& out) const;
  void sense_scanner(const SensorMount& m, wire::UsarWriter& out) const;
  void sense_odometry(const SensorMount& m, wire::UsarWriter& out);
  void sense_gps(const SensorMount& m, wire::UsarWriter& out);
  void sense_altitude(const SensorMount& m, wire::UsarWriter& out) const;
  double sonar_m(const SensorMount& m) const;
  bool touches(const SensorMount& m) const;
  std::int64_t ticks(const SensorMount& m);

  /// Acceleration without gravity in the axes of a body, as USARSim counts.
  math::Vec3 acceleration() const;
  std::optional<double> beam_m(const SensorMount& m, const math::Vec3& direction_base, double* incidence_rad) const;
  bool has(std::string_view type, std::string_view name, std::vector<std::size_t>& found) const;

  Game& game_;
  Game::Bot bot_;
  Game::Visit visit_;
  math::Random random_;
  std::vector<Due> due_;
  bool light_ = false, normalized_ = false, answers_acts_ = false;
  double start_z_m_ = 0;
  Drift ins_;
  math::Vec3 last_rates_;
  double last_imu_s_ = -1;
  struct {
    double left_rad = 0, right_rad = 0, x_m = 0, y_m = 0, theta_rad = 0;
  } odometer_;
};

}  // namespace sinew::usarsim
