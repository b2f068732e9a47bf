// For any bytes: no packet or answer, or one that is written and read again as the same, and that says only words of
// RefereeState to anybody.
#include <array>
#include <cstdlib>

#include "wire/game_controller.hpp"

using namespace sinew;

namespace {

void check_packet(std::span<const std::uint8_t> bytes) {
  wire::GamePacket packet, again;
  if (wire::read_game_packet(bytes, packet) != nullptr) return;
  std::array<std::uint8_t, wire::kGameMostBytes> out{};
  const std::size_t size = wire::write_game_packet(packet, out);
  if (size != bytes.size() || wire::read_game_packet(std::span(out).first(size), again) != nullptr) std::abort();
  if (!(again == packet)) std::abort();
  msg::RefereeState said;
  for (const wire::GameTeam& team : packet.team)
    for (std::uint8_t player = 1; player <= wire::most_players(packet.layout); ++player) {
      if (!wire::said_by_packet(packet, team.number, player, said)) std::abort();
      if (said.phase > msg::GamePhase::finished || said.penalty > msg::GamePenalty::other || said.team > 1)
        std::abort();
    }
}

void check_answer(std::span<const std::uint8_t> bytes) {
  wire::GameAnswer answer, again;
  if (wire::read_game_answer(bytes, answer) != nullptr) return;
  std::array<std::uint8_t, wire::kGameMostAnswerBytes> out{};
  const std::size_t size = wire::write_game_answer(answer, out);
  if (size != bytes.size() || wire::read_game_answer(std::span(out).first(size), again) != nullptr) std::abort();
  if (!(again == answer)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  check_packet({data, size});
  check_answer({data, size});
  return 0;
}
