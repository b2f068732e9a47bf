#pragma once
// Changes the id and the bit rate of a servo on a serial line: what every new servo needs before it joins others.
#include <optional>
#include <string>

#include "drivers/joints/serial_scan.hpp"
#include "hal/os.hpp"

namespace sinew::drivers {

struct SerialChange {
  std::uint8_t id = 1;                 // as it is
  std::uint32_t bit_rate = 1'000'000;  // as it is
  std::optional<std::uint8_t> new_id{};
  std::optional<std::uint32_t> new_bit_rate{};
  hal::Duration latency{std::chrono::milliseconds(5)};  // as SerialScan::Options::latency
};

/// Looks who has the id, and that nobody has the new one; takes the servo's torque; writes the new values into its
/// EEPROM (a Feetech's lock is opened and closed), the bit rate last; and asks whether it is there under them.
/// Ok: the servo as it is now. With neither new value: who is there.
/// The line is at the servo's bit rate afterwards.
/// Errors:  not_found: nobody, or something that is not whole, has that id; busy: the new id is taken; not_supported: a
///          model that is not known here, a bit rate that it or the line cannot do; io: it was written, and the servo
///          does not answer under the new values; those of the line. `why` has it in words.
/// Thread:  owner.   RT: no; it waits for each answer, for `latency` and the time of the bytes.
hal::Result<SerialFound> change_servo(hal::Serial& line, hal::Os& os, const SerialChange& change, std::string& why);

}  // namespace sinew::drivers
