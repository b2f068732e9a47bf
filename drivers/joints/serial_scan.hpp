#pragma once
// Finds the servos on a half-duplex serial line: asks each id and listens. It writes into no servo and enables nothing.
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/buses.hpp"
#include "hal/clock.hpp"
#include "hal/os.hpp"
#include "wire/servos/servo_models.hpp"

namespace sinew::drivers {

/// One question to one servo at a time, for what is done outside of a hub: asks, drops an echo of our own bytes, and
/// waits for the answer of one servo. It is the line's only user. Thread:  owner.   RT: yes, as far as the line is.
class SerialDialogue {
 public:
  /// `latency`: how late bytes come in at the most that the line has carried: adapter and this machine.
  SerialDialogue(hal::Serial& line, hal::Duration latency) : line_(line), latency_(latency) {}

  /// Drops what has come until now, and sends. `data`: bytes in the answer besides its frame.
  /// Errors:  those of the line.
  hal::Status ask(wire::DxlVersion version, std::uint8_t id, wire::DxlBuilder& packet, std::size_t data,
                  std::uint32_t bit_rate, hal::Time now);
  enum class Heard : std::uint8_t {
    nothing,  // yet
    answer,   // of that servo, with as much data as was expected
    silence,  // nothing came in time
    broken    // something came, but no such answer
  };
  /// Errors:  those of the line.
  hal::Result<Heard> listen(hal::Time now);
  hal::Time deadline() const { return deadline_; }

  /// Of the answer: its error byte and its data.
  std::uint8_t error() const { return error_; }
  std::span<const std::uint8_t> data() const { return {data_.data(), size_}; }

  /// How long a question without an answer takes. `sent`: bytes of the whole packet.
  static hal::Duration patience(wire::DxlVersion version, std::size_t sent, std::size_t data, std::uint32_t bit_rate,
                                hal::Duration latency);

 private:
  void hear(std::uint8_t byte);
  void take(std::uint8_t byte);

  hal::Serial& line_;
  const hal::Duration latency_;
  wire::DxlVersion version_ = wire::DxlVersion::two;
  std::uint8_t id_ = 0, error_ = 0;
  std::size_t expected_ = 0, size_ = 0;
  std::array<std::uint8_t, 64> data_{}, sent_{};
  std::size_t sent_size_ = 0, echo_at_ = 0;
  bool answered_ = false, bytes_came_ = false;  // besides our echo
  wire::DxlReader one_{wire::DxlVersion::one}, two_{wire::DxlVersion::two};
  hal::Time deadline_{};
};

/// One servo that answered, or an id at which answers were broken.
struct SerialFound {
  wire::DxlVersion version{};
  wire::ServoMaker maker{};
  std::uint32_t bit_rate = 0;
  std::uint8_t id = 0;
  bool broken = false;                      // bytes came, but never a whole answer: two servos with this id?
  std::uint16_t number = 0;                 // of its model
  const wire::ServoModel* model = nullptr;  // null: one that wire/servos does not know; nothing below is read then
  std::string firmware{};                   // "45", Feetech "3.6"
  std::optional<double> voltage_v{}, temperature_c{};
  std::uint8_t error = 0;    // hardware error, or the error bits of 1.0
  std::uint32_t faults = 0;  // msg::JointFault bits of it
};
/// "dynamixel" or "feetech", as a joint's `driver`.
const char* to_string(wire::ServoMaker maker);
/// "XM430-W350 (xm430_w350), firmware 45, 12.1 V, 31 C", "model number 1234, which is not known here; ...".
std::string describe(const SerialFound& found);

/// Asks all ids at each bit rate, first in packets of 2.0 (ping), then of 1.0 and Feetech (a read of the first
/// registers). A servo that answers is asked for voltage, temperature and errors. Broken answers are asked for again,
/// once. An echo of our own bytes is dropped.
/// A servo whose Status Return Level is 0 answers no read and is not found in packets of 1.0. Two servos of one kind
/// with one id, firmware and delay may answer in unison, as one.
/// It is the line's only user meanwhile, and leaves the line at the last bit rate.
/// Source:  e-manual, "Ping" of DYNAMIXEL Protocol 2.0; memory tables as wire/servos/servo_models.cpp.
/// Thread:  owner.   RT: no (its list grows).
class SerialScan {
 public:
  struct Options {
    std::vector<std::uint32_t> bit_rates{1'000'000};
    std::vector<wire::DxlVersion> versions{wire::DxlVersion::two, wire::DxlVersion::one};
    std::uint8_t least_id = 0, most_id = wire::kDxlMostId1;  // 2.0: 252 at most
    /// How late bytes come in at the most that the line has carried: adapter and this machine.
    hal::Duration latency{std::chrono::milliseconds(5)};
  };
  SerialScan(hal::Serial& line, const Options& options);

  /// Takes what has come and asks what is due. Answers when to call it again at the latest; bytes may come before.
  /// Errors:  those of the line.
  hal::Result<hal::Time> step(hal::Time now);
  bool done() const { return done_; }
  /// All steps, waiting for the line between them. Errors: those of the line. RT: no.
  hal::Status run(hal::Os& os);
  /// In the order in which they were found: by bit rate, packets, id.
  const std::vector<SerialFound>& found() const { return found_; }
  /// Bit rates that the line's driver cannot do.
  const std::vector<std::uint32_t>& skipped() const { return skipped_; }
  std::uint64_t questions() const { return asked_; }
  /// What a whole scan takes if nobody answers, and nothing is skipped.
  hal::Duration longest() const;

 private:
  enum class Ask : std::uint8_t { who, error, power };
  bool set_rate();
  bool next_place();
  void ask(Ask what, hal::Time now);
  void go_on(hal::Time now);
  void answered(hal::Time now);
  void unanswered(bool broken, hal::Time now);
  void identify();
  wire::DxlVersion version() const { return options_.versions[version_]; }
  std::uint32_t bit_rate() const { return options_.bit_rates[rate_]; }
  std::uint8_t most_id(wire::DxlVersion v) const { return std::min(options_.most_id, wire::dxl_most_id(v)); }

  hal::Serial& line_;
  const Options options_;
  SerialDialogue dialogue_;
  std::vector<SerialFound> found_;
  std::vector<std::uint32_t> skipped_;
  std::size_t rate_ = 0, version_ = 0;
  std::uint8_t id_ = 0;
  bool begun_ = false, done_ = false, again_ = false;
  Ask what_ = Ask::who;
  std::optional<hal::Error> failed_{};
  std::uint64_t asked_ = 0;
};

}  // namespace sinew::drivers
