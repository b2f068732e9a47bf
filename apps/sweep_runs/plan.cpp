#include "apps/sweep_runs/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>

#include "apps/command/command.hpp"
#include "apps/command/place.hpp"
#include "apps/robot/board_rules.hpp"
#include "apps/robot_file/calibration.hpp"
#include "apps/robot_file/value_list.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/sweep/case_text.hpp"
#include "apps/sweep/results_file.hpp"
#include "hal/did_you_mean.hpp"
#include "hal/linux/process.hpp"
#include "math/hash.hpp"
#include "rt/parameters.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::app {
namespace {

constexpr const char* kNone = "none";
constexpr std::size_t kMostChecked = 10'000;  // different values of a list

std::vector<std::string> parts(const std::string& text, char at) {
  std::vector<std::string> all(1);
  for (const char c : text)
    if (c == at)
      all.emplace_back();
    else
      all.back() += c;
  return all;
}

bool read_seed(std::string_view text, std::uint64_t& value) {
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  return r.ec == std::errc() && r.ptr == text.data() + text.size();
}

std::string hash_text(const math::Hash64& hash) { return fmt::format("{:016x}", hash.value()); }

/// Errors:  empty, with `why`.
std::string file_hash(const std::string& path, std::string& why) {
  std::ifstream in(path, std::ios::binary);
  math::Hash64 hash;
  std::vector<char> block(std::size_t{1} << 16);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0)
    hash.add(block.data(), static_cast<std::size_t>(in.gcount()));
  if (in.eof()) return hash_text(hash);
  why = fmt::format("{}: {}", path, std::strerror(errno));
  return {};
}

std::string raw_text(const rt::ParamValue& value) {
  const std::string* const text = std::get_if<std::string>(&value);
  return text ? *text : rt::to_string(value);
}

/// Of the parameter that a setting names; a number where it is of something else.
ValueKind kind_of_setting(const rt::Graph& graph, const std::string& key) {
  const auto dot = key.find('.');
  const std::uint32_t index = dot == std::string::npos ? rt::kNone : graph.find_module(key.substr(0, dot));
  if (index == rt::kNone) return ValueKind::number;
  const auto* const param = rt::find_param(graph.modules()[index].declaration, key.substr(dot + 1));
  return param ? value_kind(*param) : ValueKind::number;
}

std::vector<std::string> faults_of(const std::string& alternative) {
  return alternative == kNone ? std::vector<std::string>{} : parts(alternative, '&');
}

RunOptions run_options(const std::string& robot, const SweepAxes& asked) {
  RunOptions options;
  options.robot = robot;
  options.virtual_time = true;
  options.camera = asked.camera;
  return options;
}

/// A robot file as the sweep will fly it; nothing, after printing why: it cannot be flown so.
std::optional<Prepared> prepared_for_sweep(const RunOptions& options, const rt::ModuleTypes& types) {
  auto prepared = prepare(options, types);
  if (!prepared) return std::nullopt;
  const rt::GraphSpec& spec = prepared->graph->spec();
  const auto problems = check_boards(spec, {.virtual_time = true});
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", prepared->options.told(p, prepared->robot).c_str());
  if (!problems.empty()) return std::nullopt;
  std::string why;
  if (spec.board == "dataset")
    why = "board \"dataset\": a sweep runs simulated robots; `sinew tune` executes recordings again";
  else if (needs_plant(spec) && prepared->robot.sim.plant != "auto")
    why = fmt::format("plant \"{}\": a sweep starts a simulator for each run (plant \"auto\")",
                      prepared->robot.sim.plant);
  if (why.empty()) return prepared;
  fail(fmt::format("{}: {}", options.robot, why));
  return std::nullopt;
}

bool check_fault(const Prepared& robot, const std::string& fault) {
  std::string why;
  if (!plant::parse_fault(fault, why)) return fail(fmt::format("--fault {}: {}", fault, why)) == kDone;
  why = unfelt_fault(robot.graph->spec(), fault);
  return why.empty() || fail(why) == kDone;
}

}  // namespace

std::optional<SeedRange> SeedRange::parse(const std::string& text, std::string& why) {
  SeedRange seeds;
  for (const std::string& part : parts(text, ',')) {
    const auto dots = part.find("..");
    std::uint64_t first = 0, last = 0;
    const bool formed = dots == std::string::npos ? read_seed(part, first) && read_seed(part, last)
                                                  : read_seed(std::string_view(part).substr(0, dots), first) &&
                                                        read_seed(std::string_view(part).substr(dots + 2), last);
    if (!formed || last < first || last - first >= sweep::kMostCases) {
      why = fmt::format("--seeds {}: whole numbers, as 1..1000, 3,5,7 or 1..10,20; at most {} of them", text,
                        sweep::kMostCases);
      return std::nullopt;
    }
    seeds.ranges_.emplace_back(first, last - first + 1);
    seeds.count_ += last - first + 1;
  }
  std::vector<std::pair<std::uint64_t, std::uint64_t>> sorted = seeds.ranges_;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].first - sorted[i - 1].first < sorted[i - 1].second) {
      why = fmt::format("--seeds {}: seed {} is named twice", text, sorted[i].first);
      return std::nullopt;
    }
  return seeds;
}

std::uint64_t SeedRange::at(std::uint64_t index) const {
  for (const auto& [first, count] : ranges_) {
    if (index < count) return first + index;
    index -= count;
  }
  return 0;
}

bool RunList::next(std::string& line) {
  while (std::getline(in_, line)) {
    ++line_;
    const auto begin = line.find_first_not_of(" \t\r");
    if (begin != std::string::npos && line[begin] != '#') return true;
  }
  return false;
}

bool RunList::open(const std::string& path, const Each& each, std::string& why) {
  path_ = path;
  in_.open(path, std::ios::binary);
  std::string line;
  for (;;) {
    const auto place = static_cast<std::uint64_t>(std::max<std::streamoff>(0, in_.tellg()));
    if (!next(line)) break;
    auto words = sweep::split_words(line);
    if (!words) why = "a quote has no end";
    if (!words || !each(std::move(*words), why)) {
      why = fmt::format("{}:{}: {}", path, line_, why);
      return false;
    }
    if (count_++ % kEach == 0) places_.push_back(place);
  }
  if (in_.bad() || !in_.is_open() || count_ == 0) {
    why = fmt::format("{}: {}", path, in_.is_open() && !in_.bad() ? "it names no run" : std::strerror(errno));
    return false;
  }
  at_ = count_;
  return true;
}

std::vector<std::string> RunList::words(std::uint64_t index) {
  if (index < at_ || index - at_ >= kEach) {
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(places_[static_cast<std::size_t>(index / kEach)]));
    at_ = index - index % kEach;
  }
  std::string line;
  for (; at_ <= index; ++at_)
    if (!next(line)) return {};  // somebody shortened the file meanwhile: the run is then refused
  return sweep::split_words(line).value_or(std::vector<std::string>{});
}

std::unique_ptr<SweepPlan> SweepPlan::make(const SweepAxes& axes, const rt::ModuleTypes& types) {
  std::unique_ptr<SweepPlan> plan(new SweepPlan);
  plan->asked_ = axes;
  std::string why;
  plan->seeded_ = !axes.seeds.empty();
  const auto seeds = SeedRange::parse(plan->seeded_ ? axes.seeds : "0", why);
  if (!seeds) {
    fail(why);
    return nullptr;
  }
  plan->seeds_ = *seeds;
  if (!plan->prepare_robots(types) || !plan->add_params_axis(types) || !plan->add_set_axes(types) ||
      !plan->add_fault_axis(types) || !plan->open_list(types) || !plan->hash_programs())
    return nullptr;
  for (const Axis& axis : plan->axes_) {
    plan->variants_ *= axis.values.size();
    if (plan->variants_ > sweep::kMostCases) break;
  }
  if (plan->variants_ <= sweep::kMostCases && plan->list_.count() > 0) plan->variants_ *= plan->list_.count();
  if (plan->variants_ > sweep::kMostCases / plan->seeds_.count()) {
    fail(fmt::format("more than {} runs: take fewer seeds or values", sweep::kMostCases));
    return nullptr;
  }
  return plan;
}

bool SweepPlan::prepare_robots(const rt::ModuleTypes& types) {
  Axis axis;
  for (const std::string& robot : asked_.robots) {
    if (contents_.contains(robot)) return fail(robot + ": named twice") == kDone;
    const auto prepared = prepared_for_sweep(run_options(robot, asked_), types);
    if (!prepared) return false;
    if (robot_.empty()) robot_ = prepared->graph->spec().robot, folder_ = prepared->robot.record.folder;
    math::Hash64 hash;
    hash.add(prepared->robot.text.data(), prepared->robot.text.size());
    for (const PolicyTable& p : prepared->robot.policies) {  // other weights are another robot
      hash.add(p.file->bytes.data(), p.file->bytes.size());
      files_.insert(p.file->place);
    }
    contents_[robot] = hash_text(hash);
    files_.insert(robot);
    for (const LinePlace& place : prepared->robot.places)
      if (!place.file.empty()) files_.insert(place.file);
    std::error_code none;
    if (const std::string calibration = calibration_path(prepared->robot);
        !calibration.empty() && std::filesystem::exists(calibration, none)) {
      std::string why;
      const std::string calibrated = file_hash(calibration, why);
      if (calibrated.empty()) return fail(why) == kDone;
      contents_[calibration] = calibrated;
      files_.insert(calibration);
    }
    axis.values.push_back({robot});
  }
  axes_.push_back(std::move(axis));
  return true;
}

bool SweepPlan::add_params_axis(const rt::ModuleTypes& types) {
  Axis axis;
  for (const std::string& file : asked_.params) {
    if (file == kNone) {
      axis.values.emplace_back();
      continue;
    }
    for (const std::string& robot : asked_.robots) {
      RunOptions options = run_options(robot, asked_);
      options.params = file;
      if (!prepare(options, types)) return false;
    }
    std::string why;
    const std::string hash = file_hash(file, why);
    if (hash.empty()) return fail(why) == kDone;
    contents_[file] = hash;
    files_.insert(file);
    axis.values.push_back({"--params", file});
  }
  if (!axis.values.empty()) axes_.push_back(std::move(axis));
  return true;
}

bool SweepPlan::add_set_axes(const rt::ModuleTypes& types) {
  std::set<std::string> keys;
  const auto first = asked_.set.empty() ? std::nullopt : prepare(run_options(asked_.robots.front(), asked_), types);
  for (const std::string& set : asked_.set) {
    const auto equals = set.find('=');
    if (equals == std::string::npos) return fail(fmt::format("--set {}: {}", set, kValueListForms)) == kDone;
    const std::string key = set.substr(0, equals);
    if (!keys.insert(key).second) return fail(fmt::format("--set {}: {} is set twice", set, key)) == kDone;
    std::vector<rt::ParamValue> values;
    std::string why;
    if (!value_list(set.substr(equals + 1), kind_of_setting(*first->graph, key), values, why))
      return fail(fmt::format("--set {}: {}", set, why)) == kDone;
    Axis axis;
    for (const rt::ParamValue& value : values) {
      std::vector<std::string> words{"--set", key + "=" + raw_text(value)};
      if (std::find(axis.values.begin(), axis.values.end(), words) != axis.values.end()) continue;
      for (const std::string& robot : asked_.robots) {
        RunOptions options = run_options(robot, asked_);
        options.set = {words[1]};
        if (!prepare(options, types)) return false;
      }
      axis.values.push_back(std::move(words));
    }
    axes_.push_back(std::move(axis));
  }
  return true;
}

bool SweepPlan::add_fault_axis(const rt::ModuleTypes& types) {
  if (asked_.faults.empty()) return true;
  Axis axis;
  for (const std::string& robot : asked_.robots) {
    const auto prepared = prepare(run_options(robot, asked_), types);
    if (!prepared) return false;
    for (const std::string& alternative : asked_.faults)
      for (const std::string& fault : faults_of(alternative))
        if (!check_fault(*prepared, fault)) return false;
  }
  for (const std::string& alternative : asked_.faults) {
    std::vector<std::string> words;
    for (const std::string& fault : faults_of(alternative)) words.insert(words.end(), {"--fault", fault});
    if (std::find(axis.values.begin(), axis.values.end(), words) != axis.values.end())
      return fail(fmt::format("--fault {}: named twice", alternative)) == kDone;
    axis.values.push_back(std::move(words));
  }
  axes_.push_back(std::move(axis));
  return true;
}

bool SweepPlan::open_list(const rt::ModuleTypes& types) {
  if (asked_.list.empty()) return true;
  static const std::vector<std::string> kAllowed{"--seed", "--set", "--fault", "--params", "--camera", "--duration"};
  std::vector<Prepared> robots;
  for (const std::string& robot : asked_.robots) {
    auto prepared = prepare(run_options(robot, asked_), types);
    if (!prepared) return false;
    robots.push_back(std::move(*prepared));
  }
  std::set<std::pair<std::string, std::string>> checked;
  const auto check = [&](const std::string& option, const std::string& value, std::string& why) {
    if (option == "--seed") {
      std::uint64_t seed = 0;
      why = seeded_ ? "--seed: the seeds come from --seeds" : fmt::format("--seed {}: a whole number", value);
      return !seeded_ && read_seed(value, seed);
    }
    if (checked.size() >= kMostChecked || !checked.emplace(option, value).second) return true;
    why = fmt::format("{} {}: refused, see above", option, value);
    if (option == "--fault")
      return std::all_of(robots.begin(), robots.end(), [&](const Prepared& r) { return check_fault(r, value); });
    if (option == "--duration") {
      double seconds = 0;
      const auto r = std::from_chars(value.data(), value.data() + value.size(), seconds);
      why = fmt::format("--duration {}: seconds", value);
      return r.ec == std::errc() && r.ptr == value.data() + value.size() && seconds >= 0;
    }
    if (option == "--params") {  // a file that cannot be read is refused below
      contents_[value] = file_hash(value, why);
      files_.insert(value);
    }
    return std::all_of(asked_.robots.begin(), asked_.robots.end(), [&](const std::string& robot) {
      RunOptions options = run_options(robot, asked_);
      if (option == "--set") options.set = {value};
      if (option == "--params") options.params = value;
      if (option == "--camera") options.camera = value;
      return prepare(options, types).has_value();
    });
  };
  const auto each = [&](const std::vector<std::string>& words, std::string& why) {
    for (std::size_t i = 0; i < words.size(); i += 2) {
      if (std::find(kAllowed.begin(), kAllowed.end(), words[i]) == kAllowed.end()) {
        why = fmt::format("{}: options of one run: {}{}", words[i], fmt::join(kAllowed, ", "),
                          hal::did_you_mean(words[i], kAllowed));
        return false;
      }
      if (i + 1 == words.size()) {
        why = words[i] + ": without a value";
        return false;
      }
      if ((words[i] == "--camera" && !asked_.camera.empty()) || (words[i] == "--duration" && asked_.duration_s > 0)) {
        why = words[i] + ": is given for all runs already";
        return false;
      }
      if (!check(words[i], words[i + 1], why)) return false;
    }
    return true;
  };
  std::string why;
  if (!list_.open(asked_.list, each, why)) return fail(why) == kDone;
  const std::string hash = file_hash(asked_.list, why);
  if (hash.empty()) return fail(why) == kDone;
  contents_[asked_.list] = hash;
  files_.insert(asked_.list);
  return true;
}

bool SweepPlan::hash_programs() {
  for (const auto& [name, path] : {std::pair<std::string, std::string>("program", hal::program_path()),
                                   std::pair<std::string, std::string>("sinew-sim", find_program("sinew-sim"))}) {
    if (path.empty()) continue;  // a robot that needs it is refused by its run
    std::string why;
    const std::string hash = file_hash(path, why);
    if (hash.empty()) return fail(why) == kDone;
    contents_[name] = hash;
  }
  return true;
}

std::vector<std::string> SweepPlan::words(std::uint64_t number) {
  const std::uint64_t seed = number / variants_;
  std::uint64_t rest = number % variants_;
  std::vector<std::string> listed;
  if (list_.count() > 0) {
    listed = list_.words(rest % list_.count());
    rest /= list_.count();
  }
  std::vector<std::size_t> chosen(axes_.size());
  for (std::size_t a = axes_.size(); a-- > 0; rest /= axes_[a].values.size())
    chosen[a] = static_cast<std::size_t>(rest % axes_[a].values.size());
  std::vector<std::string> all;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const auto& words = axes_[a].values[chosen[a]];
    all.insert(all.end(), words.begin(), words.end());
  }
  if (!asked_.camera.empty()) all.insert(all.end(), {"--camera", asked_.camera});
  if (asked_.duration_s > 0) all.insert(all.end(), {"--duration", fmt::format("{}", asked_.duration_s)});
  for (const std::string& argument : asked_.plant_args) all.push_back("--plant-arg=" + argument);
  all.insert(all.end(), listed.begin(), listed.end());
  if (seeded_) all.insert(all.end(), {"--seed", std::to_string(seeds_.at(seed))});
  return all;
}

std::vector<std::string> SweepPlan::options() const {
  std::vector<std::string> words = asked_.robots;
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) words.push_back(fmt::format("{}={}", option, value));
  };
  add("--seeds", asked_.seeds);
  for (const std::string& set : asked_.set) add("--set", set);
  for (const std::string& fault : asked_.faults) add("--fault", fault);
  for (const std::string& file : asked_.params) add("--params", file);
  add("--list", asked_.list);
  add("--camera", asked_.camera);
  if (asked_.duration_s > 0) add("--duration", fmt::format("{}", asked_.duration_s));
  for (const std::string& argument : asked_.plant_args) add("--plant-arg", argument);
  return words;
}

Json SweepPlan::identity() const {
  Json what{{"robots", asked_.robots}};
  if (seeded_) what["seeds"] = asked_.seeds;
  for (const auto& [key, values] :
       {std::pair<const char*, const std::vector<std::string>*>("set", &asked_.set),
        std::pair<const char*, const std::vector<std::string>*>("fault", &asked_.faults),
        std::pair<const char*, const std::vector<std::string>*>("params", &asked_.params),
        std::pair<const char*, const std::vector<std::string>*>("plant_args", &asked_.plant_args)})
    if (!values->empty()) what[key] = *values;
  if (!asked_.list.empty()) what["list"] = asked_.list;
  if (!asked_.camera.empty()) what["camera"] = asked_.camera;
  if (asked_.duration_s > 0) what["duration_s"] = asked_.duration_s;
  what["contents"] = contents_;
  return what;
}

}  // namespace sinew::app
