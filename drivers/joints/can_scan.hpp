#pragma once
// Finds the devices on a CAN bus: asks and listens. It configures and enables nothing, but the question to MIT motors
// is the frame that ends their mode: a live one loses its torque.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"
#include "wire/canopen.hpp"
#include "wire/dronecan.hpp"

namespace sinew::drivers {

enum class CanFamily : std::uint8_t { canopen, mit, cybergear, dronecan };
inline constexpr CanFamily kCanFamilies[] = {CanFamily::canopen, CanFamily::mit, CanFamily::cybergear,
                                             CanFamily::dronecan};
const char* to_string(CanFamily family);

/// One device that answered or was heard.
struct CanFound {
  CanFamily family{};
  std::uint32_t id = 0;
  std::optional<std::uint32_t> device_type{}, vendor{}, product{};  // canopen: 1000h, 1018h:1 and :2, as far as it said
  std::uint32_t replies_as = 0;                                     // mit: identifier of its answer
  std::uint64_t serial = 0;                                         // cybergear: its processor's number
  std::uint8_t health = 0, mode = 0;                                // dronecan: of its newest NodeStatus
};
/// "type 0x00020192 (CiA 402), vendor 0x00000051, product 0x00000402".
std::string describe(const CanFound& found);

/// Asks each id from 1 to 127, twice where nobody answers, so slowly that it takes a quarter of the bus at most:
/// - canopen: reads the objects 1000h and, where that answers, 1018h:1 and :2 (SDO);
/// - mit: sends the frame that takes a motor out of its mode, as the protocol has no question; a motor without torque
///   stays without. **A motor that is live loses its torque.** Answers under identifiers up to 07Fh, 100h to 17Fh and
///   `masters` count.
/// - cybergear: asks who it is (kind 0);
/// - dronecan: listens for NodeStatus, which each node sends at least once a second.
/// It enables nothing and writes nothing. It is the bus's only reader meanwhile.
/// Source:  as wire/canopen.hpp, mit_motor.hpp, cybergear.hpp, dronecan_types.hpp; id 001h is CiA 304's "global
///          failsafe command": leave mit out on a bus with such a device.
/// Thread:  owner.   RT: no (its list grows).
class CanScan {
 public:
  struct Options {
    std::vector<CanFamily> families{std::begin(kCanFamilies), std::end(kCanFamilies)};
    std::vector<std::uint32_t> masters{};  // mit: further identifiers of answers (`master_id`)
    std::uint32_t most_id = 127;
  };
  CanScan(hal::CanBus& bus, const Options& options);

  /// Reads the waiting frames and sends what is due. Answers when to call it again.
  /// Errors:  those of the bus, when it is gone for more than a second, or takes no frame for so long.
  hal::Result<hal::Time> step(hal::Time now);
  bool done() const { return done_; }
  /// By family and id.
  std::vector<CanFound> found() const;
  std::uint64_t questions() const { return asked_; }

  static constexpr hal::Duration kListen = std::chrono::milliseconds(2500);  // dronecan: two statuses, and room
  static constexpr hal::Duration kMost = std::chrono::seconds(30);           // it ends, whatever comes

 private:
  struct Question {
    CanFamily family{};
    std::uint32_t id = 0;
    wire::ObjectAddress object{};  // canopen
    msg::CanFrame frame() const;
  };
  static constexpr std::size_t kIds = 128;
  bool wants(CanFamily family) const;
  void queue_round();
  CanFound* find(CanFamily family, std::uint32_t id);
  CanFound& note(CanFamily family, std::uint32_t id);
  void hear(const msg::CanFrame& frame, hal::Time now);
  void hear_sdo(const msg::CanFrame& frame, std::uint32_t node);
  bool hear_mit(const msg::CanFrame& frame, hal::Time now);
  void hear_extended(const msg::CanFrame& frame, hal::Time now);

  hal::CanBus& bus_;
  Options options_;
  wire::DronecanAssembler assembler_;
  std::vector<Question> queue_;  // the next one at the back
  std::vector<CanFound> found_;
  std::array<hal::Time, kIds> mit_asked_{};
  int round_ = 0;
  bool begun_ = false, done_ = false;
  hal::Time begin_{}, next_{}, last_question_{}, good_{};
  std::uint64_t asked_ = 0;
};

}  // namespace sinew::drivers
