#include "policy/plan.hpp"

#include <algorithm>

#include "math/hash.hpp"
#include "rt/graph_check.hpp"
#include "rt/parameters.hpp"

namespace sinew::policy {
namespace {

using onnx::Network;

std::string counted(std::size_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}
std::string named(const Network::Port& port) {
  return "'" + onnx::printable(port.name) + "' " + onnx::text_of(port.dims);
}

class Planner {
 public:
  Planner(const PolicyOptions& o, const PlanTypes& types, const Network& network, std::vector<rt::Problem>& problems)
      : o_(o), types_(types), network_(network), problems_(problems) {}

  Plan make() {
    recurrences();
    plain(network_.inputs(), plan_.plain_inputs, [](const Recurrence& r) { return r.input; });
    plain(network_.outputs(), plan_.plain_outputs, [](const Recurrence& r) { return r.output; });
    sources();
    feeds();
    commands();
    return std::move(plan_);
  }

 private:
  /// The sources of one entry.
  struct Group {
    const Observed* entry;
    std::uint32_t input, first, count;
  };

  void add(int line, const std::string& key, const std::string& value, std::string allowed) {
    problems_.push_back({line, key, value, std::move(allowed)});
  }
  std::string one_of(const std::string& what, const std::vector<Network::Port>& ports, std::string_view asked) const {
    std::vector<std::string> names;
    for (const Network::Port& p : ports) names.push_back(onnx::printable(p.name));
    return what + ": " + rt::listed_for(asked, names);
  }

  void recurrences() {
    const std::string key = "module." + o_.name + ".recurrent";
    std::vector<std::uint32_t> outputs;
    for (const auto& [input, output] : o_.recurrent) {
      const int in = network_.find_input(input), out = network_.find_output(output);
      if (in < 0) {
        add(o_.recurrent_line, key + "." + input, rt::quoted(output),
            one_of("an input of the network in front of =", network_.inputs(), input));
      } else if (out < 0) {
        add(o_.recurrent_line, key + "." + input, rt::quoted(output),
            one_of("an output of the network", network_.outputs(), output));
      } else {
        const auto from = static_cast<std::size_t>(in), to = static_cast<std::size_t>(out);
        const std::size_t size = network_.inputs()[from].size();
        if (network_.outputs()[to].size() != size)
          add(o_.recurrent_line, key + "." + input, named(network_.outputs()[to]),
              "an output as large as " + named(network_.inputs()[from]));
        plan_.recurrences.push_back({static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to),
                                     static_cast<std::uint32_t>(plan_.carried), static_cast<std::uint32_t>(size)});
        plan_.carried += size;
      }
    }
  }

  template <class Of>
  void plain(const std::vector<Network::Port>& all, std::vector<std::uint32_t>& out, Of&& of) {
    for (std::uint32_t i = 0; i < all.size(); ++i)
      if (std::none_of(plan_.recurrences.begin(), plan_.recurrences.end(), [&](const auto& r) { return of(r) == i; }))
        out.push_back(i);
  }

  /// The port that an entry names, or the only one; nothing, with a problem.
  std::optional<std::uint32_t> port(int line, const std::string& key, const std::string& name,
                                    const std::vector<Network::Port>& all, const std::vector<std::uint32_t>& plain) {
    for (const std::uint32_t i : plain)
      if (name.empty() ? plain.size() == 1 : all[i].name == name) return i;
    std::vector<std::string> names;
    for (const std::uint32_t i : plain) names.push_back(onnx::printable(all[i].name));
    add(line, key, name.empty() ? "missing" : rt::quoted(name),
        names.empty() ? "none is left: all are recurrent" : "one of the network: " + rt::listed_for(name, names));
    return std::nullopt;
  }

  bool shaping_fits(int line, const std::string& key, const std::vector<Shaping>& all, std::size_t numbers) {
    if (all.size() <= 1 || all.size() == numbers) return true;
    add(line, key, counted(all.size(), "value"), "one value of scale and offset, or " + std::to_string(numbers));
    return false;
  }
  static Shaping shaping_of(const std::vector<Shaping>& all, std::size_t i) {
    if (all.empty()) return {};
    return all.size() == 1 ? all[0] : all[i];
  }

  void sources() {
    const auto topics = observed_topics(o_);
    for (const Observed& e : o_.observed) {
      const auto input = port(e.line, e.key + ".input", e.input, network_.inputs(), plan_.plain_inputs);
      const auto first = static_cast<std::uint32_t>(plan_.sources.size());
      if (!e.topic.empty()) {
        const auto at = std::find(topics.begin(), topics.end(), e.topic) - topics.begin();
        fields(e, static_cast<std::uint32_t>(at));
      } else if (!e.output.empty()) {
        const auto out = port(e.line, e.key + ".output", e.output, network_.outputs(), plan_.plain_outputs);
        const std::size_t size = out ? network_.outputs()[*out].size() : 0;
        if (out && !shaping_fits(e.line, e.key, e.shaping, size)) continue;
        for (std::size_t i = 0; i < size; ++i) {
          plan_.watched.push_back({*out, static_cast<std::uint32_t>(i)});
          Source s;
          s.kind = Source::Kind::output;
          s.output = static_cast<std::uint32_t>(plan_.watched.size() - 1);
          s.shaping = shaping_of(e.shaping, i);
          plan_.sources.push_back(s);
        }
      } else {
        Source s;
        s.shaping.scale = 0;
        s.shaping.offset = e.value.value_or(0);
        plan_.sources.push_back(s);
      }
      for (std::size_t i = first; i < plan_.sources.size(); ++i) {
        Source& s = plan_.sources[i];
        s.depth = (o_.history - 1) + (e.history - 1) + e.delay;
        s.past = static_cast<std::uint32_t>(plan_.past);
        plan_.past += s.depth;
      }
      plan_.most_delay = std::max(plan_.most_delay, e.delay);
      if (input) groups_.push_back({&e, *input, first, static_cast<std::uint32_t>(plan_.sources.size()) - first});
    }
  }

  void fields(const Observed& e, std::uint32_t topic) {
    const msg::TypeInfo& type = *types_.topics[topic];
    if (!shaping_fits(e.line, e.key, e.shaping, e.fields.size())) return;
    for (std::size_t i = 0; i < e.fields.size(); ++i) {
      const auto field = rt::find_number(type, e.fields[i]);
      if (!field) {
        add(e.line, e.key + ".fields", rt::quoted(e.fields[i]),
            "a number of " + std::string(type.name) + ": " + rt::listed_for(e.fields[i], rt::number_paths(type)));
        incomplete_ = true;
        continue;
      }
      Source s;
      s.kind = Source::Kind::field;
      s.topic = topic;
      s.field = *field;
      s.shaping = shaping_of(e.shaping, i);
      plan_.sources.push_back(s);
    }
  }

  void feeds() {
    for (const std::uint32_t input : plan_.plain_inputs) {
      std::uint32_t index = 0;
      std::string parts;
      const auto feed = [&](const Group& g, std::uint32_t age) {
        for (std::uint32_t i = 0; i < g.count; ++i)
          plan_.feeds.push_back({input, index++, g.first + i, age + g.entry->delay});
      };
      const auto over = [this](std::uint32_t history, auto&& each) {
        for (std::uint32_t i = 0; i < history; ++i) each(o_.newest_first ? i : history - 1 - i);
      };
      over(o_.history, [&](std::uint32_t frame) {
        for (const Group& g : groups_)
          if (g.input == input) over(g.entry->history, [&](std::uint32_t age) { feed(g, frame + age); });
      });
      for (const Group& g : groups_)
        if (g.input == input)
          parts += (parts.empty() ? "" : ", ") + counted(std::size_t{g.count} * g.entry->history, "number") + " of " +
                   (g.entry->topic.empty() ? g.entry->output.empty() ? "value" : "output " + g.entry->output
                                           : g.entry->topic);
      const Network::Port& port = network_.inputs()[input];
      if (index == port.size() || incomplete_) continue;
      std::string allowed = "as many as input " + named(port) + " takes: " + std::to_string(port.size());
      if (!parts.empty())
        allowed += " (observed: " + parts + (o_.history > 1 ? ", " + std::to_string(o_.history) + " times" : "") + ")";
      add(o_.line, "module." + o_.name + ".observe", counted(index, "number"), allowed);
    }
  }

  void commands() {
    const auto ports = commanded_ports(o_);
    for (const Commanded& c : o_.commanded) {
      const auto at = static_cast<std::uint32_t>(std::find(ports.begin(), ports.end(), c.to) - ports.begin());
      const msg::TypeInfo& type = *types_.ports[at];
      std::optional<std::uint32_t> output = 0;
      if (!c.value) output = port(c.line, c.key + ".output", c.output, network_.outputs(), plan_.plain_outputs);
      if (!output || !shaping_fits(c.line, c.key, c.shaping, c.fields.size())) continue;
      const std::size_t size = network_.outputs()[*output].size();
      if (!c.value && c.index + c.fields.size() > size) {
        add(c.line, c.key + ".index", std::to_string(c.index) + " and " + counted(c.fields.size(), "field"),
            "numbers within output " + named(network_.outputs()[*output]));
        continue;
      }
      for (std::size_t i = 0; i < c.fields.size(); ++i) command(c, i, at, type, *output);
    }
  }

  void command(const Commanded& c, std::size_t i, std::uint32_t port, const msg::TypeInfo& type, std::uint32_t output) {
    const auto field = rt::find_number(type, c.fields[i]);
    if (!field || c.fields[i] == "stamp") {
      add(c.line, c.key + ".fields", rt::quoted(c.fields[i]),
          "a number of " + std::string(type.name) +
              " other than stamp: " + rt::listed_for(c.fields[i], rt::number_paths(type)));
      return;
    }
    const bool twice = std::any_of(plan_.commands.begin(), plan_.commands.end(), [&](const Command& other) {
      return other.port == port && other.field.offset == field->offset;
    });
    if (twice) {
      add(c.line, c.key + ".fields", rt::quoted(c.fields[i]), "a field that is commanded once");
      return;
    }
    Command command;
    command.port = port;
    command.field = *field;
    command.output = output;
    command.index = c.index + static_cast<std::uint32_t>(i);
    command.value = c.value;
    command.shaping = shaping_of(c.shaping, i);
    command.delay = c.delay;
    command.past = static_cast<std::uint32_t>(plan_.sent);
    plan_.sent += c.delay + 1;
    plan_.commands.push_back(command);
  }

  const PolicyOptions& o_;
  const PlanTypes& types_;
  const Network& network_;
  std::vector<rt::Problem>& problems_;
  std::vector<Group> groups_;
  bool incomplete_ = false;  // the length of the observation says nothing
  Plan plan_;
};

template <class Entries, class Of>
std::vector<std::string> each_once(const Entries& entries, Of&& of) {
  std::vector<std::string> names;
  for (const auto& e : entries)
    if (const std::string& name = of(e); !name.empty() && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  return names;
}

}  // namespace

std::string hash_of(const PolicyFile& file) {
  std::string text(16, '0');
  std::uint64_t hash = math::fnv1a64(file.bytes);
  for (std::size_t i = 16; i-- > 0; hash >>= 4) text[i] = "0123456789abcdef"[hash & 15];
  return text;
}

std::string attachment_name(std::string_view module) { return std::string(module) + ".onnx"; }

std::string topic_port(std::string_view topic) {
  std::string port = "in_" + std::string(topic);
  for (char& c : port)
    if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'))) c = '_';
  return port;
}

std::vector<std::string> observed_topics(const PolicyOptions& options) {
  return each_once(options.observed, [](const Observed& e) -> const std::string& { return e.topic; });
}
std::vector<std::string> commanded_ports(const PolicyOptions& options) {
  return each_once(options.commanded, [](const Commanded& c) -> const std::string& { return c.to; });
}

Plan make_plan(const PolicyOptions& options, const PlanTypes& types, const onnx::Network& network,
               std::vector<rt::Problem>& problems) {
  return Planner(options, types, network, problems).make();
}

std::unique_ptr<onnx::Network> load_network(const PolicyOptions& options, const PolicyFile& file,
                                            std::vector<rt::Problem>& problems) {
  const std::string key = "module." + options.name + ".file";
  if (!file.problem.empty() || file.bytes.empty()) {
    problems.push_back({options.file_line, key, rt::quoted(file.path),
                        "an ONNX file: " + (file.problem.empty() ? "it is empty" : file.problem)});
    return nullptr;
  }
  auto loaded = onnx::Network::load({reinterpret_cast<const std::uint8_t*>(file.bytes.data()), file.bytes.size()});
  for (const std::string& problem : loaded.problems)
    problems.push_back({options.file_line, key, rt::quoted(file.path), problem});
  return std::move(loaded.network);
}

std::string describe(const PolicyOptions& options, const PolicyFile& file, const onnx::Network& network) {
  std::size_t numbers = 0, fields = 0;
  for (const auto& port : network.inputs()) numbers += options.recurrent.contains(port.name) ? 0 : port.size();
  for (const Commanded& c : options.commanded) fields += c.fields.size();
  return options.name + ": observes " + counted(numbers, "number") + " from " +
         counted(observed_topics(options).size(), "topic") + ", commands " + counted(fields, "field") + "; " +
         file.path + " (" + hash_of(file) + "): " + counted(network.operations(), "operation") + ", " +
         std::to_string(network.multiplications()) + " multiplications a step";
}

}  // namespace sinew::policy
