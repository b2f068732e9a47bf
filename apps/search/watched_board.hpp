#pragma once
#include <memory>
#include <string>
#include <vector>

#include "apps/search/command_check.hpp"
#include "hal/board.hpp"

namespace sinew::search {

/// A board that shows each command for its actuators to a check; everything else passes through.
/// Thread:  as the board behind it.
class WatchedBoard final : public hal::Board {
 public:
  /// `check` may be null: nobody watches. All must outlive this.
  WatchedBoard(hal::Board& board, const hal::Clock& clock, std::string group, CommandCheck* check)
      : board_(board), clock_(clock), group_(std::move(group)), check_(check) {}

  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override {
    return board_.open_sensor(kind, name);
  }
  hal::Result<hal::Camera*> camera(std::string_view name) override { return board_.camera(name); }
  hal::Result<hal::Radio*> radio(std::string_view name) override { return board_.radio(name); }
  hal::Result<hal::Actuators*> actuators(std::string_view name) override {
    auto opened = board_.actuators(name);
    if (!opened || !check_ || name != group_) return opened;
    watched_ = std::make_unique<Watched>(**opened, clock_, *check_);
    return watched_.get();
  }

 private:
  class Watched final : public hal::Actuators {
   public:
    Watched(hal::Actuators& device, const hal::Clock& clock, CommandCheck& check)
        : device_(device), clock_(clock), check_(check) {}
    hal::Status write(const msg::ActuatorCommand& command, hal::Duration lease) noexcept override {
      check_.written(clock_.now(), command, lease);
      return device_.write(command, lease);
    }
    hal::Status stop() noexcept override {
      check_.stopped(clock_.now());
      return device_.stop();
    }
    hal::Status fall_back(hal::FallBack how) noexcept override {
      check_.stopped(clock_.now());
      return device_.fall_back(how);
    }

   private:
    hal::Actuators& device_;
    const hal::Clock& clock_;
    CommandCheck& check_;
  };

  hal::Board& board_;
  const hal::Clock& clock_;
  const std::string group_;
  CommandCheck* check_;
  std::unique_ptr<Watched> watched_;
};

}  // namespace sinew::search
