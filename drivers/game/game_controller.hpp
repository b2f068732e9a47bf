#pragma once
#include <atomic>
#include <memory>
#include <string>

#include "drivers/driver.hpp"
#include "hal/clock.hpp"
#include "hal/self_report.hpp"
#include "hal/wide.hpp"
#include "wire/game_controller.hpp"

namespace sinew::drivers {

struct GameControllerConfig {
  std::uint8_t team = 0, player = 0;  // this robot's, as the game controller has them
  std::uint16_t port = wire::kGamePort, answer_port = wire::kGameAnswerPort;
  hal::Duration answer_every = std::chrono::milliseconds(500);  // the leagues ask for one each 0.5 to 2 s
};

/// RoboCup's game controller as the referee of a game: each packet about this robot's team is a sample, with the
/// kernel's stamp. Its sender is told twice a second that this robot is there, for as long as packets come and a few
/// seconds more; so a robot whose program no longer reads its referee is shown as lost.
///
/// Other packets are passed over: those of other games in the hall, of versions that are unknown, and anything else
/// that comes in at the port.
/// Thread:  one reads; trouble() any.
/// RT:      read() yes: never blocks, allocates nothing.
/// Errors:  read(): the radio's.
class GameController final : public hal::Referee, public hal::SelfReport {
 public:
  GameController(std::unique_ptr<hal::Radio> radio, const hal::Clock& clock, const GameControllerConfig& config);

  hal::Result<bool> read(msg::RefereeState& out) noexcept override;
  hal::Time ready_at() const noexcept override { return radio_->ready_at(); }
  void set_wake(hal::Wake* wake) noexcept override { radio_->set_wake(wake); }
  std::string trouble() const override;
  std::string shortfall() const override;

  /// Without a packet about this team for so long it complains.
  static constexpr hal::Duration kSilent = std::chrono::seconds(3);
  /// So long answers go on without one.
  static constexpr hal::Duration kAnswers = std::chrono::seconds(5);

 private:
  /// Why a packet was none for this robot.
  enum class Refusal : std::uint32_t { none, unreadable, other_teams, no_such_player };

  bool hear(const msg::Datagram& datagram, msg::RefereeState& out) noexcept;
  void refuse(Refusal refusal, hal::Time when) noexcept;
  void answer() noexcept;

  std::unique_ptr<hal::Radio> radio_;
  const hal::Clock& clock_;
  const GameControllerConfig config_;
  const hal::SelfReport* radio_report_;  // null: the radio has no words for itself

  // The reader's own.
  msg::Datagram datagram_;
  wire::GamePacket packet_;
  wire::GameLayout layout_{};
  hal::UdpAddress controller_;  // the sender of the newest packet; port 0: none came
  hal::Time answered_{};

  // What trouble() reads. Relaxed: each says only what it says.
  hal::Wide<std::int64_t> heard_ns_, refused_ns_;
  std::atomic<Refusal> refusal_{Refusal::none};
  std::atomic<const char*> unreadable_{""};    // in words
  std::atomic<std::uint32_t> other_teams_{0};  // both numbers
  std::atomic<std::uint32_t> other_version_{0};
};

/// driver = "gamecontroller".
DriverKind game_controller_driver();

}  // namespace sinew::drivers
