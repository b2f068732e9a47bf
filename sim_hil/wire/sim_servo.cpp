#include "sim_hil/wire/sim_servo.hpp"

namespace sinew::sim_hil {

void JointModel::advance(Duration dt) {
  const double s = msg::seconds(dt);
  // Friction by its exact decay, so that no step is too long for it.
  const double rate = p_.damping_nmspr / p_.inertia_kgm2;
  const double decay = std::exp(-rate * s);
  const double settled = p_.damping_nmspr > 0 ? effort_nm_ / p_.damping_nmspr : 0;
  velocity_radps_ = p_.damping_nmspr > 0 ? settled + (velocity_radps_ - settled) * decay
                                         : velocity_radps_ + effort_nm_ / p_.inertia_kgm2 * s;
  position_rad_ += velocity_radps_ * s;
  if (position_rad_ > p_.max_rad || position_rad_ < p_.min_rad) {
    position_rad_ = position_rad_ > p_.max_rad ? p_.max_rad : p_.min_rad;
    velocity_radps_ = 0;
  }
}

double SimDrive::chance() {
  random_ = random_ * 6364136223846793005u + 1442695040888963407u;  // Knuth's MMIX generator
  return static_cast<double>(random_ >> 11) / 9007199254740992.0;
}

void SimServo::receive(const msg::CanFrame& frame, Time now) {
  if (!powered() || frame.error() || chance() < faults.lost) return;
  on_frame(frame, now);
}

void SimServo::send(msg::CanFrame frame) {
  if (!powered() || faults.silent || chance() < faults.lost) return;
  if (faults.garbage) {
    frame.size = static_cast<std::uint32_t>(chance() * 9);
    for (std::size_t i = 0; i < 8; ++i) frame.data[i] = static_cast<std::uint8_t>(chance() * 256);
  }
  (void)bus_.send(frame, hal::kNever);  // a bus that is gone loses the frame, like any other
}

double SimDrive::drive_position() const {
  if (faults.stuck) return stuck_position_;
  return mount_.sign * mount_.gear_ratio * (joint_.position_rad() + mount_.zero_rad);
}
double SimDrive::drive_velocity() const {
  return faults.stuck ? stuck_velocity_ : mount_.sign * mount_.gear_ratio * joint_.velocity_radps();
}

void SimDrive::power(bool on) {
  if (on == powered_) return;
  powered_ = on;
  on_power();
  if (on) started_ = false;
}

void SimDrive::advance(Time now) {
  if (now_.ns == 0) now_ = now;
  if (powered_ && !started_) {
    started_ = true;
    on_power();
  }
  if (!faults.stuck) {
    stuck_position_ = drive_position();
    stuck_velocity_ = drive_velocity();
    stuck_effort_ = effort_nm_;
  }
  constexpr Duration kStep = std::chrono::milliseconds(1);
  while (now_ < now) {
    const Duration dt = now - now_ < kStep ? now - now_ : kStep;
    effort_nm_ = powered_ && !faults.stuck ? control(now_, dt) : 0;
    joint_.set_effort(mount_.sign * effort_nm_ * mount_.gear_ratio);
    joint_.advance(dt);
    now_ = now_ + dt;
  }
  if (powered_) say(now);
}

void SimServos::poll(Time now) {
  for (const auto& servo : servos_) servo->advance(now);
  msg::CanFrame frame;
  for (int most = 0; most < 100000; ++most) {
    const auto got = bus_.read(frame);
    if (!got || !*got) return;
    for (const auto& servo : servos_) servo->receive(frame, now);
  }
}

}  // namespace sinew::sim_hil
