#include "apps/run/serial_devices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/command/command.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;
using drivers::SerialFound;
using drivers::SerialScan;
using wire::DxlVersion;

/// What servos come with (57,600, 1,000,000) and are usually set to, the most likely first.
constexpr std::uint32_t kUsualRates[] = {1'000'000, 57'600, 115'200, 2'000'000, 3'000'000, 4'000'000, 500'000};
constexpr hal::Duration kMachine = 5ms;       // this process may be late by so much
constexpr hal::Duration kAgain = 30ms;        // more for a joint of the robot file that has not answered
constexpr hal::Duration kSlowAdapter = 16ms;  // one whose latency timer could not be set

std::string rates_text(const std::vector<std::uint32_t>& rates) {
  std::string all;
  for (const std::uint32_t rate : rates) all += (all.empty() ? "" : ", ") + std::to_string(rate);
  return all + " bit/s";
}

const char* version_text(DxlVersion v) { return v == DxlVersion::two ? "2.0" : "1.0"; }

}  // namespace

void SerialDevices::add(const std::string& name, const drivers::SerialBusConfig& config) {
  lines_.push_back({name, config.spec, config.hub.rate.latency, true});
}

void SerialDevices::add(const std::string& path) {
  Line line;
  line.name = "serial:" + path;
  line.latency = 1ms;
  line.spec.path = path;
  line.spec.bit_rate = kUsualRates[0];
  line.spec.low_latency = true;
  lines_.push_back(std::move(line));
}

SerialScan::Options SerialDevices::options(const Line& line, bool slow_adapter) const {
  SerialScan::Options o;
  o.bit_rates = bit_rates;
  if (o.bit_rates.empty() && line.of_robot) o.bit_rates = {line.spec.bit_rate};
  if (o.bit_rates.empty()) o.bit_rates.assign(std::begin(kUsualRates), std::end(kUsualRates));
  o.versions.clear();
  if (dynamixel) o.versions.push_back(DxlVersion::two);
  o.versions.push_back(DxlVersion::one);  // both makers'
  o.latency = kMachine + line.latency + (slow_adapter ? kSlowAdapter : 0ms);
  return o;
}

bool SerialDevices::scan(Json& all) const {
  bool good = true;
  for (const Line& line : lines_) good = scan(line, all) && good;
  return good;
}

bool SerialDevices::scan(const Line& line, Json& all) const {
  hal::Os& os = hal::system_os();
  const auto connectors = hal::LinuxConnectors::unwatched(os);
  const std::string title = line.of_robot ? fmt::format("{} ({})", line.name, line.spec.path) : line.name;
  std::string why;
  auto port = connectors->serial(line.spec, why);
  if (!port) {
    fail("bus " + title + ": " + why);
    return false;
  }
  if (!why.empty()) std::fprintf(stderr, "warning: bus %s: %s\n", title.c_str(), why.c_str());
  const SerialScan::Options asked = options(line, !why.empty());
  SerialScan scan(**port, asked);
  if (!json) {
    std::printf("bus %s: asks all ids at %s; at most %.0f s\n", title.c_str(), rates_text(asked.bit_rates).c_str(),
                std::ceil(msg::seconds(scan.longest())));
    std::fflush(stdout);
  }
  const hal::Time begin = os.now();
  if (const hal::Status ran = scan.run(os); !ran) {
    fail(fmt::format("bus {}: {}: the line is gone", title, to_string(ran.error().code)), kFailed);
    return false;
  }
  std::vector<SerialFound> found = scan.found();
  for (const ExpectedServo& e : joints) {  // a single byte may have been lost
    const auto is_it = [&](const SerialFound& f) { return joint(line, f) == &e; };
    if (e.bus != line.name || std::any_of(found.begin(), found.end(), is_it)) continue;
    for (const SerialFound& f : ask_again(**port, line, e.id)) found.push_back(f);
  }
  return tell(line, title, found, scan.skipped(), msg::seconds(os.now() - begin), all);
}

/// One id at the line's own bit rate, with more patience.
std::vector<SerialFound> SerialDevices::ask_again(hal::Serial& port, const Line& line, std::uint8_t id) const {
  SerialScan::Options one = options(line, true);
  one.bit_rates = {line.spec.bit_rate}, one.least_id = one.most_id = id;
  one.latency += kAgain;
  for (int i = 0; i < 2; ++i) {
    SerialScan scan(port, one);
    if (!scan.run(hal::system_os())) return {};
    if (!scan.found().empty()) return scan.found();
  }
  return {};
}

const ExpectedServo* SerialDevices::joint(const Line& line, const SerialFound& found) const {
  const auto it = std::find_if(joints.begin(), joints.end(), [&](const ExpectedServo& e) {
    return e.bus == line.name && e.id == found.id && e.maker == found.maker && found.bit_rate == line.spec.bit_rate;
  });
  return it == joints.end() ? nullptr : &*it;
}

bool SerialDevices::tell(const Line& line, const std::string& title, const std::vector<SerialFound>& found,
                         const std::vector<std::uint32_t>& skipped, double took_s, Json& all) const {
  Json list = Json::array(), missing = Json::array();
  std::string lines;
  std::vector<const ExpectedServo*> answered;
  bool whole = true;
  for (const SerialFound& f : found) {
    if (!feetech && f.maker == wire::ServoMaker::feetech) continue;
    if (!dynamixel && f.maker == wire::ServoMaker::robotis && !f.broken) continue;
    whole = whole && !f.broken;
    const ExpectedServo* known = f.broken ? nullptr : joint(line, f);
    if (known) answered.push_back(known);
    lines += fmt::format("  {:<10}{:>3}  {} bit/s, packets {}: {}", f.broken ? "?" : drivers::to_string(f.maker), f.id,
                         f.bit_rate, version_text(f.version), describe(f));
    if (known)
      lines += "; " + known->name;
    else if (with_robot && !f.broken)
      lines += "; not in the robot file";
    lines += '\n';
    Json one{{"family", f.broken ? "?" : drivers::to_string(f.maker)},
             {"id", f.id},
             {"joint", known ? Json(known->name) : Json(nullptr)},
             {"bit_rate", f.bit_rate},
             {"protocol", version_text(f.version)},
             {"broken", f.broken}};
    if (!f.broken) {
      one["model_number"] = f.number, one["firmware"] = f.firmware, one["error"] = f.error, one["faults"] = f.faults;
      one["model"] = f.model ? Json(std::string(f.model->name)) : Json(nullptr);
    }
    if (f.voltage_v) one["voltage_v"] = *f.voltage_v;
    if (f.temperature_c) one["temperature_c"] = *f.temperature_c;
    list.push_back(std::move(one));
  }
  for (const ExpectedServo& e : joints) {
    const bool asked = e.maker == wire::ServoMaker::feetech ? feetech : dynamixel;
    if (e.bus != line.name || !asked || std::count(answered.begin(), answered.end(), &e) > 0) continue;
    missing.push_back({{"joint", e.name}, {"family", drivers::to_string(e.maker)}, {"id", e.id}});
    lines += fmt::format("  {:<10}{:>3}  no answer at {} bit/s; {}\n", drivers::to_string(e.maker), e.id,
                         line.spec.bit_rate, e.name);
  }
  if (!json) {
    const std::size_t n = list.size();
    std::printf("bus %s: %zu servo%s, after %.1f s\n%s", title.c_str(), n, n == 1 ? "" : "s", took_s, lines.c_str());
    for (const std::uint32_t rate : skipped)
      std::printf("  its adapter cannot do %u bit/s\n", static_cast<unsigned>(rate));
    if (!missing.empty())
      std::printf("  for servos at another bit rate: sinew devices --bus serial:%s\n", line.spec.path.c_str());
  }
  const bool complete = missing.empty() && whole;
  all.push_back({{"bus", line.name},
                 {"driver", std::string(drivers::kSerialBus)},
                 {"address", line.spec.path},
                 {"seconds", took_s},
                 {"found", std::move(list)},
                 {"missing", std::move(missing)},
                 {"skipped_bit_rates", skipped}});
  return complete;
}

}  // namespace sinew::app
