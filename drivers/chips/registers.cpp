#include "drivers/chips/registers.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::drivers {

hal::Status Registers::write_and_check(std::span<const wire::RegisterWrite> writes) noexcept {
  for (const wire::RegisterWrite& w : writes)
    if (auto done = write(w.address, w.value); !done) return done;
  for (std::size_t i = 0; i < writes.size(); ++i) {
    const auto later = [&](const wire::RegisterWrite& w) { return w.address == writes[i].address; };
    if (std::any_of(writes.begin() + static_cast<std::ptrdiff_t>(i) + 1, writes.end(), later)) continue;
    const auto value = read(writes[i].address);
    if (!value) return value.error();
    if (*value != writes[i].value) return hal::Error{hal::Errc::bad_data, "register", writes[i].address};
  }
  return {};
}

hal::Status I2cRegisters::read(std::uint8_t first, std::span<std::uint8_t> into) noexcept {
  return bus_->transfer(address_, {&first, 1}, into);
}

hal::Status I2cRegisters::write(std::uint8_t address, std::uint8_t value) noexcept {
  const std::uint8_t bytes[] = {address, value};
  return bus_->transfer(address_, bytes, {});
}

std::string I2cRegisters::where() const {
  char text[16];
  std::snprintf(text, sizeof text, "i2c 0x%02x", unsigned{address_});
  return text;
}

hal::Status SpiRegisters::read(std::uint8_t first, std::span<std::uint8_t> into) noexcept {
  if (into.size() > kMostBytes) return hal::Error{hal::Errc::bad_argument, "spi: too long"};
  out_[0] = first | 0x80;
  const std::size_t n = into.size() + 1;
  if (auto done = bus_->transfer({out_.data(), n}, {in_.data(), n}); !done) return done;
  std::copy_n(in_.begin() + 1, into.size(), into.begin());
  return {};
}

hal::Status SpiRegisters::write(std::uint8_t address, std::uint8_t value) noexcept {
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(address & 0x7F), value};
  return bus_->transfer(bytes, {});
}

std::string bus_hint(std::uint8_t value) {
  return value == 0x00 || value == 0xFF ? " (nobody there: wiring, power, chip select?)" : "";
}

std::string bus_problem(const std::string& where, const hal::Error& error) {
  std::string text = where + ": ";
  if (error.code == hal::Errc::not_found) return text + "nothing answers (wiring, address, power?)";
  if (error.code == hal::Errc::busy) return text + "a kernel driver holds this chip; use its IIO device, or unbind it";
  if (error.code == hal::Errc::closed) return text + "its bus is gone (adapter unplugged, driver unloaded?)";
  if (error.code == hal::Errc::timeout)
    return text + "the bus is held (a wire, or a chip that holds it; power it off and on)";
  if (error.code == hal::Errc::bad_data) {
    char hex[32];
    std::snprintf(hex, sizeof hex, "register 0x%02x", static_cast<unsigned>(error.detail) & 0xFF);
    return text + hex + " does not keep what is written (another chip, or a bad line)";
  }
  text += hal::to_string(error.code);
  if (error.detail != 0) text += " (errno " + std::to_string(error.detail) + ")";
  return text;
}

}  // namespace sinew::drivers
