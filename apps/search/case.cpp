#include "apps/search/case.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace sinew::search {
namespace {

constexpr double kLongestS = 1000;

bool amount_is_time(std::string_view kind) { return kind == "delayed" || kind == "intermittent"; }

template <class N>
bool read(std::string_view text, N& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

bool read_finite(std::string_view text, double least, double most, double& out) {
  return read(text, out) && out >= least && out <= most;
}

Duration whole_ms(double s) { return Duration{std::llround(s * 1e3) * kMsNs}; }

bool read_fault(std::string_view text, Fault& f) {
  const auto colon = text.find(':'), at = text.rfind('@'), plus = text.rfind('+');
  if (colon == text.npos || at == text.npos || plus == text.npos || !(colon < at && at < plus)) return false;
  f.device = text.substr(0, colon);
  std::string_view kind = text.substr(colon + 1, at - colon - 1);
  if (const auto open = kind.find('('); open != kind.npos) {
    if (kind.back() != ')') return false;
    std::string_view amount = kind.substr(open + 1, kind.size() - open - 2);
    kind = kind.substr(0, open);
    const bool in_ms = amount_is_time(kind);
    if (in_ms && !amount.ends_with("ms")) return false;
    if (in_ms) amount.remove_suffix(2);
    if (!read_finite(amount, -1e9, 1e9, f.amount)) return false;
  }
  f.kind = kind;
  double from_s = 0, length_s = 0;
  if (!read_finite(text.substr(at + 1, plus - at - 1), 0, kLongestS, from_s)) return false;
  if (!read_finite(text.substr(plus + 1), 0.001, kLongestS, length_s)) return false;
  f.from = Time{} + whole_ms(from_s);
  f.length = whole_ms(length_s);
  return !f.device.empty() && !f.kind.empty();
}

bool read_stress(std::string_view text, Stress& s) {
  const auto star = text.find('*');
  if (star == text.npos || star == 0) return false;
  s.module = text.substr(0, star);
  return read_finite(text.substr(star + 1), 0.01, 1000, s.factor);
}

/// Takes one word; returns what is allowed, empty when the word was right.
std::string take(std::string_view key, std::string_view value, Case& c) {
  if (key == "world") return read(value, c.world) ? "" : "a whole number";
  if (key == "jitter") {
    if (value == "none") {
      c.nominal = true;
      return "";
    }
    return read(value, c.jitter) ? "" : "a whole number, or none";
  }
  if (key == "gust") return read_finite(value, 0, 15, c.gust_mps) ? "" : "a number from 0 to 15";
  if (key == "stress") {
    Stress s;
    if (!read_stress(value, s)) return "MODULE*FACTOR, a factor from 0.01 to 1000";
    c.stress.push_back(std::move(s));
    return "";
  }
  if (key == "fault") {
    Fault f;
    if (!read_fault(value, f)) return "DEVICE:KIND[(AMOUNT)]@FROM+LENGTH, times in s, a time as amount in ms";
    c.faults.push_back(std::move(f));
    return "";
  }
  return "one of world, jitter, gust, stress, fault";
}

}  // namespace

double Case::stress_of(std::string_view module) const {
  for (const Stress& s : stress)
    if (s.module == module) return s.factor;
  return 1.0;
}

bool Case::disturbed(Time t, Duration after) const {
  for (const Fault& f : faults)
    if (t >= f.from && t - f.until() < after) return true;
  return false;
}

bool Case::lied_to(Time t) const {
  for (const Fault& f : faults)
    if (f.lies() && t >= f.from) return true;
  return false;
}

std::string to_string(const Fault& f) {
  std::string amount;
  if (f.amount != 0) amount = amount_is_time(f.kind) ? fmt::format("({}ms)", f.amount) : fmt::format("({})", f.amount);
  return fmt::format("{}:{}{}@{}+{}", f.device, f.kind, amount, static_cast<double>(f.from.ns / kMsNs) / 1e3,
                     static_cast<double>(f.length.count() / kMsNs) / 1e3);
}

std::string to_string(const Case& c) {
  std::string text = fmt::format("world={}", c.world);
  text += c.nominal ? " jitter=none" : fmt::format(" jitter={}", c.jitter);
  if (c.gust_mps != 0) text += fmt::format(" gust={}", c.gust_mps);
  for (const Stress& s : c.stress) text += fmt::format(" stress={}*{}", s.module, s.factor);
  for (const Fault& f : c.faults) text += " fault=" + to_string(f);
  return text;
}

std::optional<Case> parse_case(std::string_view text, std::string& why) {
  Case c;
  while (!text.empty()) {
    const auto space = text.find(' ');
    const std::string_view word = text.substr(0, space);
    text = space == text.npos ? std::string_view() : text.substr(space + 1);
    if (word.empty()) continue;
    const auto equals = word.find('=');
    const auto value = equals == word.npos ? std::string_view() : word.substr(equals + 1);
    if (const std::string allowed = take(word.substr(0, equals), value, c); !allowed.empty()) {
      why = fmt::format("case: {}: {}", word, allowed);
      return std::nullopt;
    }
  }
  return c;
}

}  // namespace sinew::search
