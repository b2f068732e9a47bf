// Faults as people write them.
#include <charconv>
#include <cmath>

#include "hal/did_you_mean.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::plant {
namespace {

constexpr double kLatestS = 1e6;

/// "off, stuck, garbage; did you mean stuck?"
template <class Names>
std::string list_for(std::string_view asked, const Names& names) {
  std::string all;
  std::vector<std::string> known;
  for (const auto n : names) {
    known.emplace_back(to_string(n));
    all += (all.empty() ? "" : ", ") + known.back();
  }
  return all + hal::did_you_mean(asked, known);
}

template <class Names, class Value>
bool find(const Names& names, std::string_view text, Value& out) {
  for (const auto n : names)
    if (to_string(n) == text) {
      out = n;
      return true;
    }
  return false;
}

bool read_number(std::string_view text, double& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(out);
}

/// Seconds: "80ms", "0.5s", "120us", "3".
bool read_time(std::string_view text, double& out) {
  double unit = 1;
  if (text.ends_with("ms")) {
    unit = 1e-3;
    text.remove_suffix(2);
  } else if (text.ends_with("us")) {
    unit = 1e-6;
    text.remove_suffix(2);
  } else if (text.ends_with("s")) {
    text.remove_suffix(1);
  }
  if (!read_number(text, out)) return false;
  out *= unit;
  return out >= 0 && out <= kLatestS;
}

std::int64_t to_ns(double s) { return std::llround(s * 1e9); }

/// The amounts that a fault may have, and the default.
struct AmountRule {
  bool allowed = false, time = false, whole = false;
  double least = 0, most = 0, usual = 0;
  const char* words = "";
};

AmountRule wrong_rule(FaultDevice device) {
  switch (device) {
    case FaultDevice::imu:
      return {true, false, false, -35, 35, 0.2, "rad/s added to each axis of the gyro, -35 to 35"};
    case FaultDevice::range:
      return {true, false, false, -10, 10, 0.5, "m added, -10 to 10"};
    case FaultDevice::baro:
      return {true, false, false, -1e5, 1e5, -60, "Pa added, -100000 to 100000"};
    case FaultDevice::battery:
      return {true, false, false, -100, 100, -2, "V added, -100 to 100"};
    case FaultDevice::camera:
      return {true, false, false, -0.9, 0.9, 0.2, "share of the width by which pictures move right, -0.9 to 0.9"};
    case FaultDevice::motors:
      return {true, false, false, 0, 1, 0.1, "share of its thrust that motor 0 lacks, 0 to 1"};
    case FaultDevice::joints:
      return {true, false, false, -3, 3, 0.1, "rad added to each position, -3 to 3"};
    case FaultDevice::soles:
      return {true, false, false, -100, 100, 10, "N added to each cell, -100 to 100"};
    case FaultDevice::head:
    case FaultDevice::left_arm:
    case FaultDevice::right_arm:
    case FaultDevice::left_leg:
    case FaultDevice::right_leg:
    case FaultDevice::gripper:
      return {true, false, false, 0, 1, 0.1, "share of its way that joint 0 lacks, 0 to 1"};
    case FaultDevice::radio:
      return {true, false, false, 0, 1, 0.1, "share of the heard datagrams with one wrong bit, 0 to 1"};
    case FaultDevice::referee:
    case FaultDevice::link:
      break;
  }
  return {};
}

AmountRule amount_rule(FaultDevice device, FaultKind kind) {
  switch (kind) {
    case FaultKind::wrong:
      return wrong_rule(device);
    case FaultKind::slow:
      return {true, false, true, 2, 1000, 4, "a whole number from 2 to 1000: one of so many comes"};
    case FaultKind::delayed:
      return {true, true, false, 1e-4, 10, is_actuator(device) ? 0.005 : 0.02, "a time from 100us to 10s"};
    case FaultKind::intermittent:
      return {true, true, false, 1e-4, 10, 0.1, "a time from 100us to 10s: mean length of a burst"};
    default:
      return {};
  }
}

bool read_amount(std::string_view text, bool given, Fault& f, std::string& why) {
  const AmountRule rule = amount_rule(f.device, f.kind);
  f.amount = rule.usual;
  if (!given) return true;
  if (!rule.allowed) {
    why = std::string(to_string(f.kind)) + " takes no amount";
    return false;
  }
  double value = 0;
  const bool number = rule.time ? read_time(text, value) : read_number(text, value);
  if (!number || value < rule.least || value > rule.most || (rule.whole && value != std::floor(value))) {
    why = "amount '" + std::string(text) + "': " + rule.words;
    return false;
  }
  f.amount = value;
  return true;
}

bool read_span(std::string_view text, Fault& f, std::string& why) {
  constexpr const char* kAllowed = "FROM, FROM+LENGTH or FROM..UNTIL, in seconds or with us, ms, s";
  const std::size_t plus = text.find('+'), dots = text.find("..");
  const std::size_t cut = std::min(plus, dots);
  double from = 0, end = 0;
  bool good = read_time(text.substr(0, cut), from);
  f.from_ns = to_ns(from);
  f.until_ns = kNoEnd;
  if (good && cut != text.npos) {
    good = read_time(text.substr(cut + (cut == plus ? 1 : 2)), end);
    f.until_ns = to_ns(end) + (cut == plus ? f.from_ns : 0);
    good = good && f.until_ns > f.from_ns;
  }
  if (!good) why = "time '" + std::string(text) + "': " + kAllowed + ", and not empty";
  return good;
}

bool parse(std::string_view text, Fault& f, std::string& why) {
  const std::size_t colon = text.find(':'), at = text.rfind('@');
  if (colon == text.npos || at == text.npos || at < colon) {
    why = "DEVICE:KIND[(AMOUNT)]@FROM[+LENGTH|..UNTIL], for example imu:stuck@5+0.5";
    return false;
  }
  const std::string_view device = text.substr(0, colon);
  std::string_view kind = text.substr(colon + 1, at - colon - 1), amount;
  const std::size_t open = kind.find('(');
  const bool given = open != kind.npos && kind.back() == ')';
  if (given) {
    amount = kind.substr(open + 1, kind.size() - open - 2);
    kind = kind.substr(0, open);
  }
  if (!find(kFaultDevices, device, f.device)) {
    why = "device '" + std::string(device) + "': one of " + list_for(device, kFaultDevices);
    return false;
  }
  if (!find(kFaultKinds, kind, f.kind)) {
    why = "kind '" + std::string(kind) + "': one of " + list_for(kind, kFaultKinds);
    return false;
  }
  if (const char* reason = why_not(f.device, f.kind)) {
    why = std::string(device) + " cannot be " + std::string(kind) + ": " + reason;
    return false;
  }
  return read_amount(amount, given, f, why) && read_span(text.substr(at + 1), f, why);
}

std::string number(double value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  return error == std::errc() ? std::string(text, end) : "?";
}

}  // namespace

std::optional<Fault> parse_fault(std::string_view text, std::string& why) {
  Fault f;
  std::string problem;
  if (parse(text, f, problem)) return f;
  why = "fault '" + std::string(text) + "': " + problem;
  return std::nullopt;
}

std::string to_string(const Fault& f) {
  std::string text = std::string(to_string(f.device)) + ":" + std::string(to_string(f.kind));
  if (amount_rule(f.device, f.kind).allowed) text += "(" + number(f.amount) + ")";
  text += "@" + number(static_cast<double>(f.from_ns) / 1e9);
  if (f.until_ns != kNoEnd) text += ".." + number(static_cast<double>(f.until_ns) / 1e9);
  return text;
}

}  // namespace sinew::plant
