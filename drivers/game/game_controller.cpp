#include "drivers/game/game_controller.hpp"

#include <array>
#include <utility>

namespace sinew::drivers {
namespace {

constexpr int kMostAtOnce = 64;  // packets of others that one read() passes over: a flood takes no more

std::string version_words(std::uint32_t version, std::uint8_t player) {
  return "the game controller's version " + std::to_string(version) + " has no player " + std::to_string(player);
}

DeviceOpener read_game_controller(DeviceKeys& keys, const DeviceSpecs&) {
  GameControllerConfig config;
  keys.read_integer("team", config.team, 1, 254,
                    {.doc = "number of the robot's team, as the league gave it", .required = true});
  keys.read_integer("player", config.player, 1, wire::kGameMostPlayers,
                    {.doc = "number on the robot's shirt; version 12 has 11 at most", .required = true});
  keys.read_integer("port", config.port, 1, 65535, {.doc = "where the game controller sends to"});
  keys.read_integer("answer_port", config.answer_port, 1, 65535, {.doc = "where it listens to robots"});
  keys.claim("port", "UDP port " + std::to_string(config.port));
  return [config](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    hal::RadioSpec spec;
    spec.listens = true, spec.port = config.port;
    auto radio = context.connectors.radio(spec, why);
    if (!radio) return radio.error();
    const auto referee = std::make_shared<GameController>(std::move(*radio), context.os, config);
    OpenedDevice device;
    device.report = referee.get();
    device.sensor(hal::SensorKind::referee) = static_cast<hal::Referee*>(referee.get());
    device.owner = referee;
    return device;
  };
}

}  // namespace

GameController::GameController(std::unique_ptr<hal::Radio> radio, const hal::Clock& clock,
                               const GameControllerConfig& config)
    : radio_(std::move(radio)),
      clock_(clock),
      config_(config),
      radio_report_(dynamic_cast<const hal::SelfReport*>(radio_.get())) {
  heard_ns_.store(clock_.now().ns);  // silence is counted from here on
  refused_ns_.store((clock_.now() - 2 * kSilent).ns);
  answered_ = clock_.now() - config_.answer_every;
}

hal::Result<bool> GameController::read(msg::RefereeState& out) noexcept {
  hal::Result<bool> read = false;
  bool heard = false;
  for (int i = 0; i < kMostAtOnce && !heard; ++i) {
    read = radio_->read(datagram_);
    if (!read || !*read) break;
    heard = hear(datagram_, out);
  }
  answer();
  if (!read) return read.error();
  return heard;
}

bool GameController::hear(const msg::Datagram& datagram, msg::RefereeState& out) noexcept {
  if (const char* why = wire::read_game_packet(datagram.bytes(), packet_)) {
    unreadable_.store(why, std::memory_order_relaxed);
    refuse(Refusal::unreadable, datagram.stamp);
    return false;
  }
  const std::uint8_t teams[] = {packet_.team[0].number, packet_.team[1].number};
  if (teams[0] != config_.team && teams[1] != config_.team) {
    other_teams_.store(std::uint32_t{teams[0]} << 8 | teams[1], std::memory_order_relaxed);
    refuse(Refusal::other_teams, datagram.stamp);
    return false;
  }
  if (!wire::said_by_packet(packet_, config_.team, config_.player, out)) {
    other_version_.store(static_cast<std::uint32_t>(packet_.layout), std::memory_order_relaxed);
    refuse(Refusal::no_such_player, datagram.stamp);
    return false;
  }
  out.stamp = datagram.stamp;
  layout_ = packet_.layout;
  controller_ = {datagram.sender, config_.answer_port};
  heard_ns_.store(datagram.stamp.ns);
  return true;
}

void GameController::refuse(Refusal refusal, hal::Time when) noexcept {
  refusal_.store(refusal, std::memory_order_relaxed);
  refused_ns_.store(when.ns);
}

void GameController::answer() noexcept {
  const hal::Time now = clock_.now();
  if (controller_.port == 0 || now - hal::Time{heard_ns_.load()} > kAnswers || now - answered_ < config_.answer_every)
    return;
  wire::GameAnswer alive;
  alive.layout = layout_;
  alive.team = config_.team, alive.player = config_.player;
  std::array<std::uint8_t, wire::kGameMostAnswerBytes> bytes{};
  const std::size_t size = wire::write_game_answer(alive, bytes);
  answered_ = now;
  // One that does not go out is the radio's complaint; the next is due soon.
  static_cast<void>(radio_->send_to(controller_, std::span(bytes).first(size)));
}

std::string GameController::trouble() const {
  std::string text = radio_report_ ? radio_report_->trouble() : std::string();
  const hal::Time now = clock_.now();
  if (now - hal::Time{heard_ns_.load()} <= kSilent) return text;
  if (!text.empty()) text += '\n';
  const std::string team = std::to_string(config_.team);
  const bool refused = now - hal::Time{refused_ns_.load()} <= kSilent;
  switch (refused ? refusal_.load(std::memory_order_relaxed) : Refusal::none) {
    case Refusal::none:
      return text + "hears no game controller on UDP port " + std::to_string(config_.port);
    case Refusal::unreadable:
      return text + "hears no game controller of team " + team +
             ", but on its port comes: " + unreadable_.load(std::memory_order_relaxed);
    case Refusal::other_teams: {
      const std::uint32_t teams = other_teams_.load(std::memory_order_relaxed);
      return text + "hears only the game of the teams " + std::to_string(teams >> 8) + " and " +
             std::to_string(teams & 0xFF) + ", and is in team " + team;
    }
    case Refusal::no_such_player:
      return text + version_words(other_version_.load(std::memory_order_relaxed), config_.player);
  }
  return text;
}

std::string GameController::shortfall() const { return radio_report_ ? radio_report_->shortfall() : std::string(); }

DriverKind game_controller_driver() { return {"gamecontroller", "referee", read_game_controller}; }

}  // namespace sinew::drivers
