#pragma once
// What a robot hears from its mates and says to them, over one radio.
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/device_reader.hpp"
#include "hal/clock_filter.hpp"
#include "hal/radio.hpp"
#include "msg/team.hpp"
#include "rt/module.hpp"
#include "wire/team_frame.hpp"

namespace sinew::team {

/// Another robot of the team.
struct Mate {
  std::string name{};       // as topics name it: "robot2" of "robot2/ball.model"
  std::uint16_t robot = 0;  // its number, 1 to 65535
};

/// A topic of this robot that mates may hear.
struct Said {
  std::string topic{};  // "ball.model"
  double rate_hz = 10;  // at most so many messages a second
  int priority = 0;     // the highest goes first where the budget is short
};

/// In front of the '/' of a topic that all mates share: "mates/ball.model".
inline constexpr std::string_view kAllMates = "mates";
inline constexpr std::size_t kMostSaid = 24, kMostHeard = 28;

/// What `[team]` of a robot file says (docs/robot-file.md).
struct LinkOptions {
  std::uint16_t robot = 0;  // own number
  std::uint32_t team = 0;
  double bytes_per_s = 10'000;  // budget of all frames, without the heads of UDP and IP
  std::vector<Mate> mates{};    // at most msg::kMaxMates
  std::vector<Said> said{};     // at most kMostSaid
  /// Remote topics that this robot's inputs name: "robot2/ball.model", "mates/ball.model"; at most kMostHeard.
  std::vector<std::string> heard{};
};

/// The input of a link for a topic that it says: "say_ball_model".
std::string say_port(std::string_view topic);

/// It is a FromMate<...>.
bool is_from_mate(const msg::TypeInfo& type);

/// What saying one topic costs at most, in bytes.
struct SaidCost {
  std::size_t message_bytes = 0;  // in a frame
  double bytes_per_s = 0;         // without the frame's own head
};
/// Of messages of this type.
SaidCost cost_of(const Said& said, const msg::TypeInfo& type);
/// Of frames' heads and of echoes, at most, for a link that steps at `step_hz` (0: not known).
double overhead_bytes_per_s(const LinkOptions& options, double step_hz);
/// A message of one frame has at most so many bytes, beside its topic's name.
std::size_t most_cdr_bytes(std::string_view topic);

/// Brings frames of mates to remote topics, and messages of own topics to frames (docs/team.md, docs/team-protocol.md).
///
/// Inputs:  say_TOPIC for each topic that is said: the newest message, when it is due. `raw`: what the radio heard.
/// Outputs: one for each remote topic. "NAME/TOPIC": the newest message of a step of that mate, as the mate's own topic
///          has it. "mates/TOPIC": a FromMate for each message of any mate. `state`: the mates, ten times a second
///          while somebody is heard, else twice. `frame`: what is sent; at most one a step.
/// A message is published once its mate's clock is known, and when it is newer than the one before: never out of order,
/// never twice. Its instants are on the own clock then.
/// Thread:  executor; in a thread with a period. RT: yes.
/// Errors:  configure: what opening the radio says.
class Link final : public rt::DriverModule, public drivers::DeviceReader {
 public:
  explicit Link(LinkOptions options);
  ~Link() override;

  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  void collect(rt::Time now) noexcept override;
  rt::StepStatus step(const rt::Step& step) noexcept override;
  void emit(rt::Time now) noexcept override;
  hal::Device* device() override { return device_; }
  std::string_view reads() const override { return "radio"; }

 private:
  static constexpr std::uint32_t kReceiveBurst = 16;  // datagrams a step, and messages of a topic of all mates
  struct Incoming;
  struct Outgoing;

  /// State of one mate.
  struct MateRecord {
    hal::ClockFilter clock{};
    msg::MateState state{};
    std::uint64_t came = 0;  // bit i: the frame i before the newest
    rt::Time echoed{};       // own clock, when the mate was last told of its frames; 0: never
    std::uint32_t former_start = 0, echoed_sequence = 0;
  };
  /// State of one remote topic at one mate.
  struct Newest {
    std::uint32_t any = 0, sequence = 0;
  };
  /// State of a topic that is said.
  struct Due {
    rt::Time at{};
    std::uint32_t any = 0, sequence = 0;  // of the message that was said last
    std::uint32_t starved = 0, spare = 0;
  };
  /// The rest of the state.
  struct OwnRecord {
    rt::Time state_at{}, frame_at{};  // when the state was published, and the last frame made
    double tokens = 0;                // bytes that may be sent
    std::uint32_t sequence = 0, start = 0, began = 0, changed = 0;
  };

  void begin(rt::Time now) noexcept;
  void receive(const msg::Datagram& datagram) noexcept;
  bool accept(MateRecord& mate, const wire::TeamHead& head) noexcept;
  void take_echoes(MateRecord& mate, const wire::TeamReader& frame, rt::Time arrived) noexcept;
  void receive_message(std::size_t mate, const wire::TeamMessage& message, rt::Time received) noexcept;
  bool publish(const MateRecord& from, Incoming& remote, const wire::TeamMessage& message, rt::Time received) noexcept;
  void send(const rt::Step& step) noexcept;
  std::size_t by_urgency(rt::Time now) noexcept;
  static std::size_t bytes_of(const Outgoing& topic) noexcept;
  void add_echoes(wire::TeamWriter& frame, std::size_t most, rt::Time now) noexcept;
  bool add_message(wire::TeamWriter& frame, std::size_t said, rt::Time now) noexcept;
  void publish_state(rt::Time now) noexcept;

  const LinkOptions options_;
  std::string device_name_ = "radio";
  hal::Radio* device_ = nullptr;

  rt::Raw<msg::Datagram> raw_;
  rt::Out<msg::Datagram> frame_;
  rt::Out<msg::TeamState> state_;
  std::vector<std::unique_ptr<Incoming>> incoming_;  // bound by address
  std::vector<std::unique_ptr<Outgoing>> outgoing_;
  std::vector<std::uint8_t> cdr_;          // one message
  std::vector<std::max_align_t> scratch_;  // one decoded message
  std::vector<std::uint32_t> urgent_;      // said topics in the order of a step

  // State:
  std::vector<MateRecord> mates_;  // by mate
  std::vector<Newest> newest_;     // by remote and mate
  std::vector<Due> due_;           // by said topic
  OwnRecord own_{};
  msg::TeamState counts_{};
};

}  // namespace sinew::team
