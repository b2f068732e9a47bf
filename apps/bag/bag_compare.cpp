// bag compare: two flights side by side.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "apps/bag/bag_options.hpp"
#include "apps/bag/recorded_flight.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/view/plot.hpp"
#include "hal/did_you_mean.hpp"
#include "record/run/comparison.hpp"

namespace sinew::app {
namespace {

using Sample = RecordedField::Sample;

constexpr const char* kStart = "start";  // of the recording, as an event
constexpr std::size_t kMostFields = 100;

/// An event of both flights, or of one of them.
struct EventPair {
  std::string text;
  std::optional<double> a_s{}, b_s{};  // from the common event
};

/// The n-th event of a kind is compared with the other flight's n-th: of a failsafe the name counts, not what was
/// measured.
std::string kind_of(const std::string& text) { return text.substr(0, text.find(": ")); }

std::optional<rt::Time> time_of(const RecordedFlight& flight, const std::string& event) {
  if (event == kStart) return flight.start();
  for (const RecordedFlight::Event& e : flight.events())
    if (kind_of(e.text) == event || e.text == event) return e.at;
  return std::nullopt;
}

std::vector<std::string> kinds_in_both(const RecordedFlight& a, const RecordedFlight& b) {
  std::vector<std::string> kinds;
  for (const RecordedFlight::Event& e : a.events())
    if (const std::string kind = kind_of(e.text); time_of(b, kind) && std::ranges::find(kinds, kind) == kinds.end())
      kinds.push_back(kind);
  return kinds;
}

/// Where both times begin: what the user said, or else the start of the climb, or the moment of arming, or the start.
std::optional<std::string> common_event(const RecordedFlight& a, const RecordedFlight& b, const std::string& asked) {
  if (asked.empty()) {
    for (const char* const usual : {"climbing", "armed"})
      if (time_of(a, usual) && time_of(b, usual)) return usual;
    return kStart;
  }
  if (time_of(a, asked) && time_of(b, asked)) return asked;
  std::vector<std::string> known = kinds_in_both(a, b);
  known.insert(known.begin(), kStart);
  fail(fmt::format("--from-event {}: an event of both flights: {}{}", asked, fmt::join(known, ", "),
                   hal::did_you_mean(asked, known)));
  return std::nullopt;
}

std::vector<EventPair> pairs_of(const RecordedFlight& a, rt::Time from_a, const RecordedFlight& b, rt::Time from_b) {
  std::vector<EventPair> pairs;
  for (const RecordedFlight::Event& e : a.events()) pairs.push_back({e.text, msg::seconds(e.at - from_a)});
  for (const RecordedFlight::Event& e : b.events()) {
    const double at_s = msg::seconds(e.at - from_b);
    const auto same = std::ranges::find_if(
        pairs, [&](const EventPair& p) { return p.a_s && !p.b_s && kind_of(p.text) == kind_of(e.text); });
    if (same != pairs.end())
      same->b_s = at_s;
    else
      pairs.push_back({e.text, std::nullopt, at_s});
  }
  std::ranges::stable_sort(pairs, {}, [](const EventPair& p) { return p.a_s ? *p.a_s : *p.b_s; });
  return pairs;
}

// ---- fields

std::optional<std::vector<std::string>> chosen_fields(const RecordedFlight& a, const RecordedFlight& b,
                                                      const std::vector<std::string>& asked) {
  const std::vector<std::string> of_b = b.field_names();
  std::vector<std::string> both, chosen;
  for (const std::string& name : a.field_names())
    if (std::ranges::find(of_b, name) != of_b.end()) both.push_back(name);
  for (const std::string& pattern : asked) {
    const bool any = std::ranges::any_of(both, [&](const auto& name) { return record::means(pattern, name); });
    if (any) continue;
    fail(fmt::format("--field {}: no field of a topic of both flights, like filter.state.p_world_m.z{}", pattern,
                     hal::did_you_mean(pattern, both)));
    return std::nullopt;
  }
  for (const std::string& name : both) {
    const bool wanted = std::ranges::any_of(asked, [&](const auto& p) { return record::means(p, name); });
    if (asked.empty() ? a.is_usual(name) : wanted) chosen.push_back(name);
  }
  if (chosen.size() <= kMostFields) return chosen;
  fail(fmt::format("--field: {} fields, at most {}: name fewer", chosen.size(), kMostFields));
  return std::nullopt;
}

struct ComparedField {
  std::string name, unit;
  record::Deviation deviation;  // b - a; times from the common event
  Plot plot;
};

ComparedField compare(const RecordedField& a, rt::Time from_a, const RecordedField& b, rt::Time from_b,
                      const std::string& event) {
  ComparedField out{a.name, a.what.unit, {}, {}};
  Series of_a{"A", {}}, of_b{"B", {}}, apart{"between A and B", {}};
  for (const Sample& s : a.samples) {
    const rt::Time at{(s.at - from_a).count()};
    const double at_s = msg::seconds(at - rt::Time{});
    if (a.is_number()) of_a.points.emplace_back(at_s, s.value[0]);
    const auto other = b.at(from_b + (at - rt::Time{}));
    if (!other) continue;
    const double d = difference(a, s, *other);
    if (std::isfinite(d)) out.deviation.add(d, at);
    if (!a.is_number()) apart.points.emplace_back(at_s, d);
  }
  if (a.is_number())
    for (const Sample& s : b.samples) of_b.points.emplace_back(msg::seconds(s.at - from_b), s.value[0]);
  out.plot.title = fmt::format("{}: B is {:.3g} {} RMS from A", a.name, out.deviation.rms(), a.what.unit);
  out.plot.x_label = fmt::format("time from {} (s)", event);
  out.plot.y_label = a.what.unit;
  if (a.is_number())
    out.plot.series = {std::move(of_a), std::move(of_b)};
  else
    out.plot.series = {std::move(apart)};
  return out;
}

// ---- what is printed

std::string seconds_cell(const std::optional<double>& s) { return s ? fmt::format("{:.3f}", *s) : "-"; }

std::string events_table(const std::vector<EventPair>& pairs, const std::string& event) {
  const std::string head = fmt::format("event, in s from {}", event);
  std::size_t width = head.size();
  for (const EventPair& p : pairs) width = std::max(width, p.text.size());
  std::string out = fmt::format("{:<{}}  {:>9} {:>9} {:>9}\n", head, width, "A", "B", "B - A");
  for (const EventPair& p : pairs) {
    out += fmt::format("{:<{}}  {:>9} {:>9}", p.text, width, seconds_cell(p.a_s), seconds_cell(p.b_s));
    out += p.a_s && p.b_s ? fmt::format(" {:>+9.3f}\n", *p.b_s - *p.a_s) : "\n";
  }
  return out;
}

std::string fields_table(const std::vector<ComparedField>& fields) {
  if (fields.empty()) return "no usual field is in both: --field names some\n";
  std::size_t width = std::string_view("B against A").size();
  for (const ComparedField& f : fields) width = std::max(width, f.name.size());
  std::string out = fmt::format("{:<{}}  {:<7} {:>11} {:>11} {:>10} {:>9}\n", "B against A", width, "unit", "RMS",
                                "maximum", "at s", "messages");
  for (const ComparedField& f : fields)
    out += fmt::format("{:<{}}  {:<7} {:>11.4g} {:>11.4g} {:>10.3f} {:>9}\n", f.name, width, f.unit, f.deviation.rms(),
                       f.deviation.max, msg::seconds(f.deviation.max_at - rt::Time{}), f.deviation.count);
  return out;
}

Json comparison_as_json(const RecordedFlight& a, const RecordedFlight& b, const std::string& event,
                        const std::vector<EventPair>& pairs, const std::vector<ComparedField>& fields) {
  Json all_events = Json::array(), all_fields = Json::array();
  for (const EventPair& p : pairs) {
    Json json{{"text", p.text}, {"a_s", p.a_s ? Json(*p.a_s) : Json()}, {"b_s", p.b_s ? Json(*p.b_s) : Json()}};
    all_events.push_back(std::move(json));
  }
  for (const ComparedField& f : fields) {
    Json json{{"name", f.name},
              {"unit", f.unit},
              {"messages", f.deviation.count},
              {"rms", f.deviation.rms()},
              {"max", f.deviation.max}};
    if (f.deviation.max > 0) json["max_at_s"] = msg::seconds(f.deviation.max_at - rt::Time{});
    all_fields.push_back(std::move(json));
  }
  return {{"a", {{"file", a.path()}, {"result", a.result()}}},
          {"b", {{"file", b.path()}, {"result", b.result()}}},
          {"from_event", event},
          {"events", all_events},
          {"fields", all_fields}};
}

/// What happened in each of them, in the order of time.
std::vector<PlotMark> marks_of(const RecordedFlight& a, rt::Time from_a, const RecordedFlight& b, rt::Time from_b) {
  std::vector<PlotMark> marks;
  const auto add = [&marks](const char* flight, const RecordedFlight& of, rt::Time from) {
    for (const RecordedFlight::Event& e : of.events())
      marks.push_back({msg::seconds(e.at - from), fmt::format("{} {}", flight, kind_of(e.text)), e.alarm});
  };
  add("A", a, from_a);
  add("B", b, from_b);
  std::ranges::stable_sort(marks, {}, &PlotMark::x);
  return marks;
}

/// False after printing why.
bool draw(const std::vector<ComparedField>& fields, std::vector<PlotMark> marks, const std::string& path) {
  if (std::filesystem::exists(path)) {
    fail(path + ": exists; nothing is overwritten");
    return false;
  }
  std::vector<Plot> plots;
  for (const ComparedField& f : fields) {
    plots.push_back(f.plot);
    plots.back().marks = marks;
    for (PlotMark& mark : marks) mark.text.clear();  // the first plot has them
  }
  const std::string why = write_plots(path, plots);
  if (!why.empty()) fail("--plot " + why);
  return why.empty();
}

}  // namespace

int bag_compare(const BagCompareOptions& options) {
  std::unique_ptr<RecordedFlight> a, b;
  std::optional<std::vector<std::string>> names;
  bool good = false;
  {
    Progress progress("reading");
    a = RecordedFlight::open(options.file, progress);
    b = a ? RecordedFlight::open(options.other, progress) : nullptr;
    names = b ? chosen_fields(*a, *b, options.fields) : std::nullopt;
    if (!names) return kNotBegun;
    good = a->read(*names);
    good = b->read(*names) && good;
  }
  const auto event = common_event(*a, *b, options.from_event);
  if (!event) return kNotBegun;
  const rt::Time from_a = *time_of(*a, *event), from_b = *time_of(*b, *event);
  const std::vector<EventPair> pairs = pairs_of(*a, from_a, *b, from_b);
  std::vector<ComparedField> fields;
  for (std::size_t i = 0; i < names->size(); ++i)
    fields.push_back(compare(a->fields()[i], from_a, b->fields()[i], from_b, *event));
  if (!options.plot.empty() && !draw(fields, marks_of(*a, from_a, *b, from_b), options.plot)) return kNotBegun;
  const std::string text = options.json
                               ? to_line(comparison_as_json(*a, *b, *event, pairs, fields))
                               : fmt::format("A  {}: {}\nB  {}: {}\n\n{}\n{}", a->path(), a->result(), b->path(),
                                             b->result(), events_table(pairs, *event), fields_table(fields));
  std::printf("%s", text.c_str());
  return good ? kDone : kFailed;
}

}  // namespace sinew::app
