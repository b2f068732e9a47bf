#include "drivers/joints/serial_setup.hpp"

namespace sinew::drivers {
namespace {

using hal::Errc;
using hal::Error;
using hal::Time;
using wire::DxlVersion;
using wire::ServoMaker;
using wire::ServoModel;
using wire::ServoRegister;

constexpr int kWriteTries = 3;                                        // single bytes may be lost
constexpr hal::Duration kEepromTime = std::chrono::milliseconds(50);  // a servo may be deaf while it writes

class ServoSetup {
 public:
  ServoSetup(hal::Serial& line, hal::Os& os, const SerialChange& change, std::string& why)
      : line_(line), os_(os), c_(change), dialogue_(line, change.latency), why_(why) {}

  hal::Result<SerialFound> run() {
    auto servo = find(c_.id, c_.bit_rate);
    if (!servo) return servo;
    if (!c_.new_id && !c_.new_bit_rate) return servo;
    if (!servo->model) return refuse(Errc::not_supported, describe(*servo) + ": its registers are not known here");
    const ServoModel& m = *servo->model;
    std::optional<std::uint8_t> rate;
    if (c_.new_bit_rate) {
      rate = wire::servo_rate_code(m, *c_.new_bit_rate);
      if (!rate)
        return refuse(Errc::not_supported, std::string(m.title) + " cannot do " + std::to_string(*c_.new_bit_rate) +
                                               " bit/s; it can do " + wire::servo_rates_text(m));
    }
    const std::uint8_t id = c_.new_id.value_or(c_.id);
    const std::uint32_t at = c_.new_bit_rate.value_or(c_.bit_rate);
    if (id > wire::dxl_most_id(m.version))
      return refuse(Errc::not_supported, "an id is from 0 to " + std::to_string(wire::dxl_most_id(m.version)));
    if (id != c_.id || at != c_.bit_rate) {
      std::string taken = why_;
      if (auto other = find(id, at); other || other.error().code != Errc::not_found || !nobody_) {
        if (!other && other.error().code != Errc::not_found) return other;
        return refuse(Errc::busy, "id " + std::to_string(id) + " at " + std::to_string(at) + " bit/s is taken");
      }
      why_ = std::move(taken);
      if (const hal::Status set = line_.set_bit_rate(c_.bit_rate); !set) return set.error();
    }
    if (auto s = write(m, c_.id, m.torque_enable, 0, c_.bit_rate, true); !s) return s.error();
    const bool locks = m.maker == ServoMaker::feetech;
    if (locks)
      if (auto s = write(m, c_.id, m.lock, 0, c_.bit_rate, true); !s) return s.error();
    // Answers to these two may come in the name of the new id, or at the new bit rate: not waited for.
    if (id != c_.id)
      if (auto s = write(m, c_.id, m.id, id, c_.bit_rate, false); !s) return s.error();
    if (rate && at != c_.bit_rate)
      if (auto s = write(m, id, m.bit_rate, *rate, c_.bit_rate, false); !s) return s.error();
    if (const hal::Status set = line_.set_bit_rate(at); !set) return set.error();
    if (locks)
      if (auto s = write(m, id, m.lock, 1, at, true); !s) return s.error();
    auto now = find(id, at);
    if (now && now->model == servo->model) return now;
    return refuse(Errc::io, "the new values were written, and it does not answer under them: " + why_);
  }

 private:
  Error refuse(Errc code, const std::string& words) {
    why_ = words;
    return Error{code, "serial servo"};
  }

  /// Who has this id, in packets of either kind.
  hal::Result<SerialFound> find(std::uint8_t id, std::uint32_t rate) {
    nobody_ = false;
    SerialScan::Options o;
    o.bit_rates = {rate}, o.least_id = o.most_id = id, o.latency = c_.latency;
    if (id > wire::kDxlMostId2) o.versions = {DxlVersion::one};
    SerialScan scan(line_, o);
    if (const hal::Status ran = scan.run(os_); !ran) return ran.error();
    const std::string what = "id " + std::to_string(id) + " at " + std::to_string(rate) + " bit/s: ";
    if (!scan.skipped().empty()) return refuse(Errc::not_supported, what + "the line's adapter cannot do that");
    if (scan.found().empty()) {
      nobody_ = true;
      return refuse(Errc::not_found, what + "nobody answers");
    }
    if (scan.found().size() > 1) return refuse(Errc::not_found, what + "two servos answer");
    if (scan.found()[0].broken) return refuse(Errc::not_found, what + describe(scan.found()[0]));
    return scan.found()[0];
  }

  /// `sure`: it has to be answered without an error.
  hal::Status write(const ServoModel& m, std::uint8_t id, const ServoRegister& reg, std::int32_t value,
                    std::uint32_t rate, bool sure) {
    for (int i = 0; i < (sure ? kWriteTries : 1); ++i) {
      wire::DxlBuilder packet = wire::dxl_write(m.version, id, reg.address, wire::servo_bytes(m, reg, value));
      if (const hal::Status sent = dialogue_.ask(m.version, id, packet, 0, rate, os_.now()); !sent) return sent;
      auto heard = SerialDialogue::Heard::nothing;
      while (heard == SerialDialogue::Heard::nothing) {
        if (const auto ready = line_.wait_readable(dialogue_.deadline()); !ready) return ready.error();
        const auto now = dialogue_.listen(os_.now());
        if (!now) return now.error();
        heard = *now;
      }
      if (!sure) {
        os_.sleep_until(os_.now() + kEepromTime);
        return {};
      }
      if (heard != SerialDialogue::Heard::answer) continue;
      const std::uint8_t error = m.version == DxlVersion::two
                                     ? static_cast<std::uint8_t>(dialogue_.error() & ~wire::kDxlAlert)
                                     : std::uint8_t{0};  // of 1.0: the state of the servo, mostly
      if (error == 0) return {};
      return refuse(Errc::io, "register " + std::to_string(reg.address) +
                                  " was refused: " + std::string(to_string(static_cast<wire::DxlError>(error))));
    }
    return refuse(Errc::io,
                  "register " + std::to_string(reg.address) + ": no answer to a write (Status Return Level?)");
  }

  hal::Serial& line_;
  hal::Os& os_;
  const SerialChange& c_;
  SerialDialogue dialogue_;
  std::string& why_;
  bool nobody_ = false;  // of the last find()
};

}  // namespace

hal::Result<SerialFound> change_servo(hal::Serial& line, hal::Os& os, const SerialChange& change, std::string& why) {
  return ServoSetup(line, os, change, why).run();
}

}  // namespace sinew::drivers
