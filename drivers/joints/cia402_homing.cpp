// Homing of a CiA 402 drive: mode 6, then back to the cyclic mode.
#include "drivers/joints/cia402_servo.hpp"

namespace sinew::drivers {

using namespace std::chrono_literals;

namespace {

constexpr std::uint32_t kFramesOfBefore = 4;  // so many statuswords in a new step may be from before it

}  // namespace

void Cia402Servo::end_homing() noexcept {
  if (homing_ != Homing::no) set_mode(mode_of(config().mode), Homing::set_back);  // before it can be enabled again
}

void Cia402Servo::home(Time now, const ServoCommand& command) noexcept {
  if (homing_ >= Homing::arriving) joint_.expect_new_zero();
  if (homing_ == Homing::no) {
    begin_homing(now, command);
  } else if (homing_ == Homing::arriving || homing_ == Homing::moving) {
    watch_homing(now);
  } else {
    next_homing_step(now);
  }
}

void Cia402Servo::begin_homing(Time now, const ServoCommand& command) noexcept {
  bool asked = command.request_number != request_seen_ && command.request == ServoCommand::Request::home;
  if (asked && !was_enabled_) {
    asked = false;  // it waits until the joint is enabled
  } else if (command.request_number != request_seen_) {
    request_seen_ = command.request_number;
    if (command.request == ServoCommand::Request::zero_here && joint_.zero_here()) joint_.resume(now);
  }
  if (!was_enabled_ || config().homing_method == 0 || (homed_ && !asked)) return;
  homed_ = homed_before_ = false;
  home_anew_ = asked;
  reading_temperature_ = false;
  sdo_.start(wire::sdo_write(wire::kHomingMethod, static_cast<std::uint8_t>(config().homing_method), 1));
  homing_ = Homing::set_method;
}

/// One object at a time. The mode of 6060h holds when 6061h shows it (CiA 402-2, modes of operation), not before.
void Cia402Servo::next_homing_step(Time now) noexcept {
  if (sdo_.state() == SdoClient::State::busy) return;
  const bool no_display = homing_ == Homing::check_back && sdo_.state() == SdoClient::State::aborted;
  if (sdo_.state() != SdoClient::State::done && !no_display) {  // refused, or not answered: again; off until then
    if (wants_) joint_.trip(now, msg::kJointOther);
    set_mode(mode_of(config().mode), Homing::set_back);
    return;
  }
  const auto mode = static_cast<wire::DriveMode>(static_cast<std::int8_t>(sdo_.value()));
  switch (homing_) {
    case Homing::set_method:
      set_mode(wire::DriveMode::homing, Homing::set_mode);
      break;
    case Homing::set_mode:
      homing_deadline_ = now + 1s;
      check_mode(Homing::check_mode);
      break;
    case Homing::check_mode:
      if (mode == wire::DriveMode::homing) {
        homing_ = Homing::arriving;
        homing_number_ = joint_.feedback().number;
      } else if (now > homing_deadline_) {
        joint_.trip(now, msg::kJointOther);
        set_mode(mode_of(config().mode), Homing::set_back);
      } else {
        check_mode(Homing::check_mode);
      }
      break;
    case Homing::set_back:
      homing_deadline_ = now + 1s;
      check_mode(Homing::check_back);
      break;
    default:
      if (no_display || mode == mode_of(config().mode)) {
        homing_ = Homing::no;
        if (wants_) joint_.resume(now);
      } else if (now <= homing_deadline_) {
        check_mode(Homing::check_back);
      } else {
        if (wants_) joint_.trip(now, msg::kJointOther);
        set_mode(mode_of(config().mode), Homing::set_back);
      }
  }
}

/// In mode 6, with statuswords of this mode. Bits 12 and 10 together: homed; 12 alone or 10 alone: not (yet).
void Cia402Servo::watch_homing(Time now) noexcept {
  const std::uint32_t heard = joint_.feedback().number - homing_number_;
  if (heard < kFramesOfBefore && now < homing_deadline_) return;
  constexpr std::uint16_t kDone = wire::kStatusHomed | wire::kStatusTargetReached;
  const bool wrong = (status_ & wire::kStatusHomingError) != 0, done = !wrong && (status_ & kDone) == kDone;
  const bool attained = (status_ & wire::kStatusHomed) != 0;
  if (homing_ == Homing::arriving) {
    homing_ = Homing::moving;  // the start bit goes out from now on
    homing_began_ = !attained;
    homing_number_ = joint_.feedback().number;
    homing_deadline_ = now + 60s;
    if (!done || home_anew_) return;
  } else {
    // "Homed" may be from an earlier homing; methods at the current position may be done between two statuswords.
    const int method = config().homing_method;
    homing_began_ = homing_began_ || !attained || ((method == 35 || method == 37) && heard > 5 * kFramesOfBefore);
    if (wrong || now > homing_deadline_) joint_.trip(now, msg::kJointOther);
    if (joint_.tripped() || !done || !homing_began_) return;
  }
  homed_ = true;
  set_mode(mode_of(config().mode), Homing::set_back);
}

void Cia402Servo::check_mode(Homing step) noexcept {
  sdo_.start(wire::sdo_read(wire::kModeDisplay));
  homing_ = step;
}

void Cia402Servo::set_mode(wire::DriveMode mode, Homing step) noexcept {
  sdo_.start(wire::sdo_write(wire::kModeOfOperation, static_cast<std::uint8_t>(mode), 1));
  homing_ = step;
}

}  // namespace sinew::drivers
