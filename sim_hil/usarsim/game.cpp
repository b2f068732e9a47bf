#include "sim_hil/usarsim/game.hpp"

#include <algorithm>

#include "sim_hil/usarsim/values.hpp"

namespace sinew::usarsim {

using plant::kMostRobots;

namespace {

constexpr std::size_t kInARow = 4;
constexpr std::size_t kMostAddresses = 64;

}  // namespace

void Game::remove(std::size_t slot) {
  std::erase_if(bots_, [&](const Bot& b) { return b.slot == slot; });
  for (auto& [address, slots] : shown_) std::ranges::replace(slots, slot, kMostRobots);
  // Whoever chose only what is gone sees all again.
  std::erase_if(shown_, [](const auto& shown) {
    return std::ranges::all_of(shown.second, [](std::size_t s) { return s == kMostRobots; });
  });
}

const Game::Bot* Game::find(std::string_view name) const {
  const auto found = std::ranges::find_if(bots_, [&](const Bot& b) { return same_word(b.name, name); });
  return found == bots_.end() ? nullptr : &*found;
}

void Game::show(const std::string& address, const std::vector<std::size_t>& slots) {
  if (slots.empty() || (shown_.size() >= kMostAddresses && !shown_.contains(address))) return;
  shown_[address] = slots;
}

Wall Game::wall(const std::string& address) const {
  std::vector<std::size_t> slots;
  std::size_t in_a_row = kInARow;
  auto shown = shown_.find(address);
  if (shown == shown_.end()) shown = shown_.find("");
  if (shown != shown_.end()) {
    slots = shown->second;
    in_a_row = slots.size() > 1 ? 2 : 1;
  } else {
    for (const Bot& b : bots_) slots.push_back(b.slot);
  }
  if (slots.empty()) slots.push_back(kMostRobots);
  Wall wall;
  const std::size_t columns = std::min(in_a_row, slots.size()), rows = (slots.size() + columns - 1) / columns;
  wall.width = static_cast<std::uint32_t>(columns) * options_.tile_width;
  wall.height = static_cast<std::uint32_t>(rows) * options_.tile_height;
  for (std::size_t i = 0; i < slots.size(); ++i)
    wall.tiles.push_back({slots[i], static_cast<std::uint32_t>(i % columns) * options_.tile_width,
                          static_cast<std::uint32_t>(i / columns) * options_.tile_height});
  return wall;
}

int Game::view_of(std::size_t slot) const {
  const auto found = std::ranges::find(bots_, slot, &Bot::slot);
  // As the captured session has it, where the only robot has no part of a picture: -1.
  return bots_.size() < 2 || found == bots_.end() ? -1 : static_cast<int>(found - bots_.begin());
}

}  // namespace sinew::usarsim
