#pragma once
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "hal/board.hpp"

namespace sinew::hal {

/// A board that combines several boards: each named device comes from its own board, all others from the first.
/// Thread:  owner, configure only.
/// Owner:   the boards, which have to outlive this one.
/// Errors:  those of the board that was asked.
class MixedBoard final : public Board {
 public:
  explicit MixedBoard(Board& others) : others_(others) {}
  void assign(std::string device, Board& board) { boards_.insert_or_assign(std::move(device), &board); }

  Result<Device*> open_sensor(SensorKind kind, std::string_view name) override {
    return of(name).open_sensor(kind, name);
  }
  Result<Camera*> camera(std::string_view name) override { return of(name).camera(name); }
  Result<Radio*> radio(std::string_view name) override { return of(name).radio(name); }
  Result<Actuators*> actuators(std::string_view name) override { return of(name).actuators(name); }

  /// Devices with a board of their own that were never asked for: names that are not the robot's.
  std::vector<std::string> unused() const {
    std::vector<std::string> out;
    for (const auto& [device, board] : boards_)
      if (!asked_.contains(device)) out.push_back(device);
    return out;
  }

 private:
  Board& of(std::string_view device) {
    asked_.emplace(device);
    const auto it = boards_.find(device);
    return it == boards_.end() ? others_ : *it->second;
  }

  Board& others_;
  std::map<std::string, Board*, std::less<>> boards_;
  std::set<std::string, std::less<>> asked_;
};

}  // namespace sinew::hal
