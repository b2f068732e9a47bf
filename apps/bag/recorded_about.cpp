#include "apps/bag/recorded_about.hpp"

#include <algorithm>
#include <charconv>

#include "apps/robot_file/param_value.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "record/run/ros2_convert.hpp"
#include "record/run/run_messages.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

constexpr std::size_t kMostChanges = 100'000;

std::vector<std::string> values_of(const record::Texts& texts) {
  std::vector<std::string> values;
  for (const auto& text : texts) values.push_back(text.second);  // in the order of their numbers
  return values;
}

/// "module in 003", "source in 003". Without a number: no thread.
std::uint32_t thread_number(const std::string& text) {
  std::uint32_t number = rt::kNone;
  const auto at = text.rfind(' ');
  if (at != std::string::npos) std::from_chars(text.data() + at + 1, text.data() + text.size(), number);
  return number;
}

/// As rt::to_string() wrote it.
rt::ParamValue recorded_value(const std::string& text) {
  const bool is_text = text.size() >= 2 && text.front() == '"';
  return is_text ? rt::ParamValue(text.substr(1, text.size() - 2)) : param_value(text);
}

std::vector<RecordedAbout::ParamChange> param_changes(record::Reader& reader) {
  std::vector<RecordedAbout::ParamChange> changes;
  record::MessageReader messages = reader.messages({.topics = {std::string(record::kRequestsTopic)}});
  record::Message m;
  record::LoggedRequest logged;
  for (record::Next next; changes.size() < kMostChanges && (next = messages.next(m)) != record::Next::end;) {
    if (next == record::Next::problem || !record::decode(m.data, logged)) continue;  // the playback names the problem
    const rt::Request& request = logged.request;
    if (request.kind != rt::Request::Kind::set_param || logged.effect.refused) continue;
    changes.push_back({logged.now, request.module, request.index,
                       std::visit([](const auto& v) { return rt::ParamValue(v); }, request.value)});
  }
  return changes;
}

}  // namespace

RecordedAbout recorded_about(record::Reader& reader, const std::string& file, const rt::ModuleTypes& types) {
  RecordedAbout about;
  const record::Texts run = record::read_metadata(reader, "sinew.run");
  const auto text = [&run](const char* key) {
    const auto found = run.find(key);
    return found == run.end() ? std::string() : found->second;
  };
  about.robot = text("robot"), about.board = text("board"), about.virtual_time = text("virtual_time") == "true";
  about.threads = values_of(record::read_metadata(reader, "sinew.threads"));
  about.modules = values_of(record::read_metadata(reader, "sinew.modules"));
  about.thread_of.resize(about.modules.size(), rt::kNone);
  const record::Texts graph = record::read_metadata(reader, "sinew.graph");
  std::size_t m = 0;
  for (const auto& [key, what] : graph)
    if (key.find('.') == std::string::npos && m < about.modules.size()) about.thread_of[m++] = thread_number(what);
  about.params = record::read_metadata(reader, "sinew.params");
  if (const auto robot = record::read_attachment(reader, "robot.toml"))
    about.graph = std::make_unique<rt::Graph>(parse_robot(*robot, file).robot.graph, types);
  about.changes = param_changes(reader);
  return about;
}

std::vector<RecordedAbout::Param> RecordedAbout::params_at(rt::Time at) const {
  std::vector<Param> all;
  if (!graph) return all;
  for (const rt::GraphModule& module : graph->modules()) {
    const auto number =
        static_cast<std::size_t>(std::find(modules.begin(), modules.end(), module.spec.name) - modules.begin());
    for (std::size_t p = 0; p < module.declaration.params.size(); ++p) {
      const rt::Declaration::Param& declared = module.declaration.params[p];
      const auto said = params.find(module.spec.name + "." + std::string(declared.name));
      if (said == params.end()) continue;  // the recorded version of the module did not have it
      Param param{module.spec.name, &declared, recorded_value(said->second)};
      for (const ParamChange& c : changes)
        if (c.at <= at && c.module == number && c.index == p) param.value = c.value;
      const auto* whole = std::get_if<std::int64_t>(&param.value);  // "7" of a number
      if (whole && std::holds_alternative<double*>(declared.target)) param.value = static_cast<double>(*whole);
      all.push_back(std::move(param));
    }
  }
  return all;
}

}  // namespace sinew::app
