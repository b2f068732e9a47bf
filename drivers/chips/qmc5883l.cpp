#include "drivers/chips/qmc5883l.hpp"

#include <array>
#include <cstdio>

namespace sinew::drivers {

using namespace std::chrono_literals;
namespace qmc = wire::qmc5883l;

hal::Status Qmc5883l::set_up(std::string& why) {
  const auto failed = [&](const hal::Error& e) {
    why = bus_problem(*registers_, e);
    return e;
  };
  const auto id = registers_->read(qmc::kChipId);
  if (!id) return failed(id.error());
  if (*id != qmc::kChipIdValue) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "0x%02x", unsigned{*id});
    why = registers_->where() + ": its id is " + hex + "; a QMC5883L says 0xff (an HMC5883L is another chip, at 0x1e)";
    return hal::Error{hal::Errc::not_found, "qmc5883l: another chip", *id};
  }
  const auto writes = qmc::setup_writes(setup_);
  if (!writes) {
    why = "range_gauss is 2 or 8, rate_hz 10, 50, 100 or 200";
    return hal::Error{hal::Errc::bad_argument, "qmc5883l"};
  }
  if (auto done = registers_->write(qmc::kControl2, qmc::kSoftReset); !done) return failed(done.error());
  os_.sleep_until(os_.now() + 10ms);
  if (auto done = registers_->write_and_check(*writes); !done) return failed(done.error());
  return {};
}

hal::Status Qmc5883l::poll(hal::Time now, std::vector<msg::MagSample>& out, std::string& why) {
  std::array<std::uint8_t, qmc::kBurst> bytes{};
  if (auto done = registers_->read(qmc::kData, bytes); !done) {
    why = bus_problem(*registers_, done.error());
    return done;
  }
  const qmc::Sample raw = qmc::decode_burst(bytes);
  if (raw.overflow) {
    why = registers_->where() + ": the field is beyond its range (a magnet or motor cable beside it?)";
    return hal::Error{hal::Errc::bad_data, "qmc5883l: overflow"};
  }
  if (!raw.ready) return {};
  out.push_back({.stamp = now, .field_t = mount_.to_base(qmc::field_t(raw, setup_))});
  return {};
}

}  // namespace sinew::drivers
