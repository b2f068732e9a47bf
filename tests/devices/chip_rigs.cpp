// MPU-6050, ICM-42600, BMP280, QMC5883L, INA219 and INA226 behind /dev/i2c-1 and /dev/spidev0.0.
#include <cerrno>
#include <cmath>

#include "rig.hpp"
#include "sim_hil/wire/sim_imu_chips.hpp"
#include "sim_hil/wire/sim_power_monitor.hpp"
#include "wire/bmp280.hpp"
#include "wire/qmc5883l.hpp"

namespace sinew::test {
namespace {

using sim_hil::BusFault, sim_hil::SimChip, sim_hil::SimI2cBus, sim_hil::SimSpiDevice;

constexpr const char *kI2c = "/dev/i2c-1", *kSpi = "/dev/spidev0.0";

/// An SPI chip with a cable that can fail: there is no acknowledge, so an absent chip reads as an open line.
class SpiCable final : public hal::SpiBus {
 public:
  explicit SpiCable(std::shared_ptr<SimChip> chip) : chip_(std::move(chip)) {}
  hal::Status transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) noexcept override {
    if (fault == BusFault::gone) return hal::Error{hal::Errc::closed, "simulated", ENODEV};
    if (fault == BusFault::none) return chip_.transfer(out, in);
    std::fill(in.begin(), in.end(), fault == BusFault::held_low ? std::uint8_t{0} : std::uint8_t{0xFF});
    return {};
  }
  BusFault fault = BusFault::none;

 private:
  SimSpiDevice chip_;
};

class ChipRig : public Rig {
 public:
  ChipRig(std::uint8_t address, std::shared_ptr<SimChip> chip, Duration period, bool on_spi)
      : period_(period), on_spi_(on_spi), address_(address), spi_(std::make_shared<SpiCable>(chip)) {
    bus_->attach(address, chip);
    i2c_ = std::make_shared<I2cNode>(bus_);
    names = {on_spi ? kSpi : kI2c};
    kernel.group = on_spi ? "spi" : "i2c";
    plug(true);
  }
  std::vector<Way> ways(Fault fault) const override {
    const bool stays_at_bus = fault == Fault::absent || fault == Fault::unplugged;
    if (stays_at_bus) return {{.label = "the bus"}, {.label = "the chip"}};
    if (fault == Fault::garbage) return {{.label = "lines held high"}, {.label = "lines held low"}};
    if (fault == Fault::duplicate) return {{.cannot = {Reason::no_number}}};
    if (fault == Fault::busy && on_spi_) return {{.label = "a kernel driver is bound, so there is no spidev"}};
    if (fault == Fault::busy) return {{.label = "a kernel driver has the chip"}};
    return {{}};
  }
  void inject(Fault fault, std::size_t way) override {
    fault_ = fault;
    if (fault == Fault::absent && way == 0) plug(false);
    if (fault == Fault::busy && on_spi_) plug(false);
    if (fault == Fault::unplugged && way == 0) plug(false);
    if ((fault == Fault::absent || fault == Fault::unplugged) && way == 1) set(BusFault::no_answer);
    if (fault == Fault::garbage) set(way == 0 ? BusFault::held_high : BusFault::held_low);
    if (fault == Fault::busy) i2c_->held.insert(address_);
    if (fault == Fault::denied) kernel.refuse(names[0], EACCES);
  }
  void heal() override {
    fault_.reset();
    plug(true);
    set(BusFault::none);
    i2c_->held.clear();
    kernel.refuse(names[0], 0);
  }
  void advance(Time now) override {
    if (next_.ns == 0) next_ = now;
    for (; next_ <= now; next_ = next_ + period_) {
      ++number_;
      if (fault_ == Fault::silent || (fault_ == Fault::slow && number_ % 64 != 0)) continue;
      measure(fault_ == Fault::stuck ? Time{1} : next_, fault_ == Fault::stuck);
    }
  }

 protected:
  virtual void measure(Time now, bool stuck) = 0;
  static double wave(Time now) { return std::sin(7 * msg::seconds(now - Time{})); }
  drivers::DeviceSpec place(const std::string& driver, std::map<std::string, rt::ParamValue> keys = {}) const {
    keys["path"] = std::string(on_spi_ ? kSpi : kI2c);
    return table(device, driver, std::move(keys));
  }

 private:
  void plug(bool in) {
    if (in && on_spi_) kernel.add(kSpi, std::make_shared<SpiNode>(spi_));
    if (in && !on_spi_) kernel.add(kI2c, i2c_);
    if (!in) kernel.remove(names[0]);
  }
  void set(BusFault fault) { bus_->fault = fault, spi_->fault = fault; }

  const Duration period_;
  const bool on_spi_;
  const std::uint8_t address_;
  std::shared_ptr<SimI2cBus> bus_ = std::make_shared<SimI2cBus>();
  std::shared_ptr<SpiCable> spi_;
  std::shared_ptr<I2cNode> i2c_;
  std::optional<Fault> fault_;
  Time next_{};
  int number_ = 0;
};

template <class Chip>
class ImuRig final : public ChipRig {
 public:
  ImuRig(const char* driver, bool on_spi, std::shared_ptr<Chip> chip = std::make_shared<Chip>())
      : ChipRig(0x68, chip, 5ms, on_spi), chip_(std::move(chip)) {
    device = measures = "imu";
    specs.devices.push_back(place(driver, {{"rate_hz", std::int64_t{200}}}));
  }

 private:
  void measure(Time now, bool) override {
    chip_->measure({now, {0.1 + 0.05 * wave(now), -0.2, 0.3}, {1, -2 + 0.1 * wave(now), 9.81}});
  }
  std::shared_ptr<Chip> chip_;
};

struct PlainChip : SimChip {
  std::uint8_t reset = 0, reset_word = 0;
  void on_write(std::uint8_t address, std::uint8_t value) override {
    if (address != reset || value != reset_word) poke(address, value);
  }
  std::uint8_t on_read(std::uint8_t address) override {
    const std::uint8_t value = peek(address);
    if (address == clears_on_read) poke(address, 0);
    return value;
  }
  std::uint8_t clears_on_read = 0xFE;
};

class Bmp280Rig final : public ChipRig {
 public:
  explicit Bmp280Rig(std::shared_ptr<PlainChip> chip = std::make_shared<PlainChip>())
      : ChipRig(0x76, chip, 20ms, false), chip_(std::move(chip)) {
    device = measures = "baro";
    specs.devices.push_back(place("bmp280"));
    chip_->reset = wire::bmp280::kReset, chip_->reset_word = wire::bmp280::kResetWord;
    chip_->poke(wire::bmp280::kId, 0x58);
    // The example of the datasheet, BST-BMP280-DS001 section 3.12.
    constexpr int kWords[] = {27504, 26435, -1000, 36477, -10685, 3024, 2855, 140, -7, 15500, -14600, 6000};
    std::uint8_t at = wire::bmp280::kCalibration;
    for (const int word : kWords) {
      chip_->poke(at++, static_cast<std::uint8_t>(word));
      chip_->poke(at++, static_cast<std::uint8_t>(static_cast<unsigned>(word) >> 8));
    }
  }

 private:
  void measure(Time now, bool stuck) override {
    const auto lock = chip_->lock();
    const int pressure = 0x655AC + (stuck ? 0 : static_cast<int>(300 * wave(now)));
    std::uint8_t at = wire::bmp280::kPressure;
    for (const int byte : {pressure >> 12, pressure >> 4 & 0xFF, pressure << 4 & 0xFF, 0x7E, 0xED, 0x00})
      chip_->poke(at++, static_cast<std::uint8_t>(byte));
  }
  std::shared_ptr<PlainChip> chip_;
};

class Qmc5883lRig final : public ChipRig {
 public:
  explicit Qmc5883lRig(std::shared_ptr<PlainChip> chip = std::make_shared<PlainChip>())
      : ChipRig(wire::qmc5883l::kAddress, chip, 10ms, false), chip_(std::move(chip)) {
    device = measures = "mag";
    specs.devices.push_back(place("qmc5883l", {{"rate_hz", std::int64_t{100}}}));
    chip_->reset = wire::qmc5883l::kControl2, chip_->reset_word = wire::qmc5883l::kSoftReset;
    chip_->poke(wire::qmc5883l::kChipId, wire::qmc5883l::kChipIdValue);
    chip_->clears_on_read = wire::qmc5883l::kStatus;
  }

 private:
  void measure(Time now, bool stuck) override {
    const auto lock = chip_->lock();
    const int field = 3000 + (stuck ? 0 : static_cast<int>(200 * wave(now)));
    chip_->poke(wire::qmc5883l::kData, static_cast<std::uint8_t>(field));
    chip_->poke(wire::qmc5883l::kData + 1, static_cast<std::uint8_t>(field >> 8));
    chip_->poke(wire::qmc5883l::kStatus, wire::qmc5883l::kReady);
  }
  std::shared_ptr<PlainChip> chip_;
};

class PowerMonitorRig final : public ChipRig {
 public:
  PowerMonitorRig(const char* driver, wire::ina2xx::Chip which)
      : PowerMonitorRig(driver, std::make_shared<sim_hil::SimPowerMonitor>(which)) {}

 private:
  PowerMonitorRig(const char* driver, std::shared_ptr<sim_hil::SimPowerMonitor> chip)
      : ChipRig(0x40, chip, 35ms, false), chip_(std::move(chip)) {
    device = measures = "battery";
    specs.devices.push_back(place(driver, {{"shunt_mohm", 1.0}, {"cells", std::int64_t{4}}}));
  }
  void measure(Time now, bool stuck) override {
    chip_->measure(15.2, 0.012 + (stuck ? 0 : 0.001 * wave(now)));  // four cells, 12 A
  }
  std::shared_ptr<sim_hil::SimPowerMonitor> chip_;
};

}  // namespace

std::vector<RigKind> chip_rigs() {
  return {
      {"mpu6050", "`mpu6050` on I2C", [] { return std::make_unique<ImuRig<sim_hil::SimMpu6050>>("mpu6050", false); }},
      {"icm42600", "`icm42600` on SPI",
       [] { return std::make_unique<ImuRig<sim_hil::SimIcm42600>>("icm42600", true); }},
      {"bmp280", "`bmp280` on I2C", [] { return std::make_unique<Bmp280Rig>(); }},
      {"qmc5883l", "`qmc5883l` on I2C", [] { return std::make_unique<Qmc5883lRig>(); }},
      {"ina219", "`ina219` on I2C",
       [] { return std::make_unique<PowerMonitorRig>("ina219", wire::ina2xx::Chip::ina219); }},
      {"ina226", "`ina226` on I2C",
       [] { return std::make_unique<PowerMonitorRig>("ina226", wire::ina2xx::Chip::ina226); }},
  };
}

}  // namespace sinew::test
