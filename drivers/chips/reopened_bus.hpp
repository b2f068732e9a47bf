#pragma once
#include <functional>
#include <memory>
#include <string>

#include "hal/buses.hpp"

namespace sinew::drivers {

/// A bus whose adapter may be unplugged. When the bus is gone, the next transfer opens it anew: the old descriptor
/// stays dead when the adapter comes back as a new one.
/// Thread:  owner.   Errors: those of the bus; closed as long as it cannot be opened again.
template <class Bus>
class ReopenedBus {
 public:
  using Opener = std::function<hal::Result<std::unique_ptr<Bus>>(std::string& why)>;
  /// Opens it. Errors: those of opening, with words in `why`.
  hal::Status open(Opener opener, std::string& why) {
    open_ = std::move(opener);
    return renew(why);
  }
  template <class Transfer>
  hal::Status use(Transfer&& transfer) noexcept {
    std::string why;  // the next set_up() fails in the same way, and says it
    if (!bus_)
      if (auto done = renew(why); !done) return hal::Error{hal::Errc::closed, "bus is gone", done.error().detail};
    hal::Status done = transfer(*bus_);
    if (!done && done.error().code == hal::Errc::closed) bus_.reset();
    return done;
  }

 private:
  hal::Status renew(std::string& why) {
    auto bus = open_(why);
    if (!bus) return bus.error();
    bus_ = std::move(*bus);
    return {};
  }
  Opener open_;
  std::unique_ptr<Bus> bus_;
};

class ReopenedI2c final : public hal::I2cBus, public ReopenedBus<hal::I2cBus> {
 public:
  hal::Status transfer(std::uint8_t address, std::span<const std::uint8_t> write,
                       std::span<std::uint8_t> read) noexcept override {
    return use([&](hal::I2cBus& bus) { return bus.transfer(address, write, read); });
  }
};

class ReopenedSpi final : public hal::SpiBus, public ReopenedBus<hal::SpiBus> {
 public:
  hal::Status transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept override {
    return use([&](hal::SpiBus& bus) { return bus.transfer(out, in); });
  }
};

}  // namespace sinew::drivers
