// Homing of a CiA 402 drive: mode 6, then back to the cyclic mode.
#include "drivers/cia402_servo.hpp"

namespace sinew::drivers {

using namespace std::chrono_literals;

void Cia402Servo::end_homing() noexcept {
  if (homing_ != Homing::no) set_mode(mode_of(config().mode), Homing::set_back);  // before it can be enabled again
}

void Cia402Servo::home(Time now, const ServoCommand& command) noexcept {
  if (homing_ == Homing::no) {
    if (command.request_number != request_seen_) begin_homing(now, command);
    return;
  }
  if (homing_ == Homing::moving) {
    joint_.forget_position();                                         // its zero is about to be another
    const bool told = joint_.feedback().number - homing_number_ > 3;  // the statusword is of this mode by now
    if (told && (status_ & wire::kStatusHomingError) == 0 && (status_ & wire::kStatusHomed) != 0) {
      set_mode(mode_of(config().mode), Homing::set_back);
    } else if ((told && (status_ & wire::kStatusHomingError) != 0) || now > homing_deadline_) {
      joint_.trip(now, msg::kJointOther);
    }
    return;
  }
  if (sdo_.state() == SdoClient::State::busy) return;
  if (sdo_.state() != SdoClient::State::done) {  // refused, or not answered: again; it stays off until then
    if (wants_) joint_.trip(now, msg::kJointOther);
    set_mode(mode_of(config().mode), Homing::set_back);
  } else if (homing_ == Homing::set_method) {
    set_mode(wire::DriveMode::homing, Homing::set_mode);
  } else if (homing_ == Homing::set_mode) {
    homing_ = Homing::moving;
    homing_number_ = joint_.feedback().number;
    homing_deadline_ = now + 60s;
  } else {
    homing_ = Homing::no;
    if (wants_) joint_.resume(now);
  }
}

void Cia402Servo::begin_homing(Time now, const ServoCommand& command) noexcept {
  const bool home = command.request == ServoCommand::Request::home;
  if (home && !was_enabled_) return;  // it waits until the joint is enabled
  request_seen_ = command.request_number;
  if (command.request == ServoCommand::Request::zero_here && joint_.zero_here()) joint_.resume(now);
  if (!home || config().homing_method == 0) return;
  reading_temperature_ = false;
  sdo_.start(wire::sdo_write(wire::kHomingMethod, static_cast<std::uint8_t>(config().homing_method), 1));
  homing_ = Homing::set_method;
}

void Cia402Servo::set_mode(wire::DriveMode mode, Homing step) noexcept {
  sdo_.start(wire::sdo_write(wire::kModeOfOperation, static_cast<std::uint8_t>(mode), 1));
  homing_ = step;
}

}  // namespace sinew::drivers
