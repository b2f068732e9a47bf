// The half of Session that reads, writes and follows parameters.
#include <algorithm>
#include <utility>

#include "monitor/foxglove/reply.hpp"
#include "monitor/foxglove/session.hpp"

namespace sinew::foxglove {
namespace {

constexpr unsigned kTicksOfParameters = 10;

}  // namespace

struct Session::Reading {
  std::vector<std::string> names{};  // empty: all
  std::optional<std::string> id{};
  After after = After::asked;
  std::size_t missing = 0;                                     // replies
  std::vector<std::pair<std::string, ParameterText>> found{};  // by name
};

struct Session::Writing {
  SetParameters message;
  std::size_t next = 0;
};

void Session::handle(const GetParameters& message) { read_parameters(message.names, message.id, After::asked); }

void Session::handle(const FollowParameters& message) {
  if (!message.on) {
    for (const std::string& name : message.names) followed_parameters_.erase(name), known_parameters_.erase(name);
    if (message.names.empty()) followed_parameters_.clear(), known_parameters_.clear();
    return;
  }
  for (const std::string& name : message.names)
    if (followed_parameters_.size() < 4096) followed_parameters_.insert(name);
  if (message.names.empty()) followed_parameters_.insert("");  // all
  ticks_ = 0;
}

void Session::read_parameters(std::vector<std::string> names, std::optional<std::string> id, After after) {
  const auto reading = std::make_shared<Reading>();
  reading->names = std::move(names), reading->id = std::move(id), reading->after = after;
  for (const Seen& seen : robots_) {
    const std::string prefix = seen.prefix.empty() ? "" : seen.prefix + "/";
    const auto received = [this, reading] {
      if (--reading->missing == 0) parameters_read(*reading);
    };
    reading->missing += 2;
    const bool params = ask(seen.robot, "params", "{}", [=](const std::string& reply) {
      const Json json = object_of(reply);
      for (const Json& p : list_of(json, "params")) {
        const std::string name = prefix + text_of(p, "module") + "." + text_of(p, "param");
        const auto value = p.find("value");
        if (value != p.end())
          reading->found.emplace_back(name, ParameterText{name, one_line(*value), text_of(p, "type") == "number"});
      }
      received();
    });
    const bool status =
        params && ask_status(seen.robot, after != After::written, [=](const std::string& reply) {
          const Json json = object_of(reply);
          for (const Json& m : list_of(json, "modules")) {
            const std::string name = prefix + text_of(m, "name") + ".enabled";
            const auto running = m.find("running");
            if (running != m.end()) reading->found.emplace_back(name, ParameterText{name, one_line(*running)});
          }
          for (const Json& t : list_of(json, "threads")) {
            const std::string name = prefix + text_of(t, "name") + ".period_us";
            const auto period = t.find("period_ns");
            if (period != t.end() && period->is_number() && period->get<double>() > 0)
              reading->found.emplace_back(name, ParameterText{name, one_line(period->get<double>() / 1e3), true});
          }
          received();
        });
    if (!status) {
      if (reading->after == After::followed) looks_at_parameters_ = false;
      return complain(StatusLevel::error, "parameters: too many requests at once");
    }
  }
  if (reading->missing == 0) parameters_read(*reading);
}

void Session::parameters_read(const Reading& reading) {
  looks_at_parameters_ = looks_at_parameters_ && reading.after != After::followed;
  const auto wanted = [&](const std::string& name) {
    return reading.names.empty() || std::find(reading.names.begin(), reading.names.end(), name) != reading.names.end();
  };
  std::vector<ParameterText> values;
  for (const auto& [name, parameter] : reading.found) {
    if (reading.after == After::followed) {
      if (!followed_parameters_.contains("") && !followed_parameters_.contains(name)) continue;
      std::string& known = known_parameters_[name];
      if (known == parameter.value) continue;
      known = parameter.value;
    } else if (!wanted(name)) {
      continue;
    }
    values.push_back(parameter);
  }
  if (reading.after == After::followed && values.empty()) return;
  send(parameter_values(values, reading.id));
}

void Session::handle(const SetParameters& message) {
  const auto writing = std::make_shared<Writing>();
  writing->message = message;
  write_next(writing);
}

/// One after the other: the robot's mailboxes hold only a few changes.
void Session::write_next(const std::shared_ptr<Writing>& writing) {
  while (writing->next < writing->message.parameters.size()) {
    const auto& [name, value] = writing->message.parameters[writing->next++];
    const auto fail = [&, &n = name](const std::string& why) { complain(StatusLevel::error, n + ": " + why); };
    std::string_view rest;
    const Seen* const seen = find(name, rest);
    const std::size_t point = rest.rfind('.');
    if (!seen || point == std::string_view::npos) {
      fail("no such parameter: they are called MODULE.PARAM");
      continue;
    }
    const std::string owner(rest.substr(0, point)), param(rest.substr(point + 1));
    const Json json = Json::parse(value, nullptr, false);
    const auto& threads = seen->robot->facts().threads;
    std::string request = "param.set";
    Json arguments{{"module", owner}, {"param", param}, {"value", json}};
    if (param == "enabled") {
      if (!json.is_boolean()) {
        fail("true or false");
        continue;
      }
      request = json.get<bool>() ? "module.enable" : "module.disable";
      arguments = {{"module", owner}};
    } else if (param == "period_us" && std::find(threads.begin(), threads.end(), owner) != threads.end()) {
      request = "thread.period";
      arguments = {{"thread", owner}, {"period_us", json}};
    }
    if (const std::string why = why_not(seen->robot, request); !why.empty()) {
      fail(why);
      continue;
    }
    const bool asked =
        ask(seen->robot, request, one_line(arguments), [this, writing, n = name](const std::string& reply) {
          if (const std::string why = error_of(object_of(reply)); !why.empty())
            complain(StatusLevel::error, n + ": " + why);
          write_next(writing);
        });
    if (asked) return;
    fail("too many requests at once");
  }
  std::vector<std::string> names;
  for (const auto& p : writing->message.parameters) names.push_back(p.name);
  if (writing->message.id && !names.empty()) read_parameters(std::move(names), writing->message.id, After::written);
  ticks_ = 0;  // who follows them sees the change soon
}

void Session::look_at_followed_parameters() {
  if (ticks_++ % kTicksOfParameters != 0 || followed_parameters_.empty() || looks_at_parameters_ || robots_.empty())
    return;
  looks_at_parameters_ = true;
  read_parameters({}, std::nullopt, After::followed);
}

}  // namespace sinew::foxglove
