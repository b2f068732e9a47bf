#include "drivers/text/alturi_ini.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "hal/did_you_mean.hpp"
#include "hal/udp_address.hpp"
#include "wire/text/usarsim.hpp"
#include "wire/text_scan.hpp"

namespace sinew::drivers {
namespace {

std::string_view ini_trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

struct IniValue {
  std::string text;
  int line = 0;
};
struct IniSection {
  std::string name;  // as it is written
  int line = 0;
  std::map<std::string, IniValue> values;  // by the key in lower case
};
using Ini = std::map<std::string, IniSection>;

/// Whether `name` is `what` with a number behind it.
bool is_numbered(std::string_view name, std::string_view what) {
  return name.starts_with(what) && wire::parse_decimal(name.substr(what.size()), 4).has_value();
}

const std::vector<std::string>& known_keys(std::string_view section) {
  static const std::vector<std::string> connection{"SimIP4", "SimCommandPort", "SimImagePort", "SimSensorPort"};
  static const std::vector<std::string> drives{"DrivePrefix", "DriveTotal", "DriveNormalize", "DriveFirstParameter"};
  static const std::vector<std::string> commands{"CommandPrefix", "CommandTotal"}, messages{"MessageTotal"};
  static const std::vector<std::string> one{"Key", "Min", "Max", "Increment"};
  static const std::vector<std::string> message{"MessageName", "KeyName", "Index"}, none;
  if (section == "connection") return connection;
  if (section == "drives") return drives;
  if (section == "commands") return commands;
  if (section == "messages") return messages;
  if (is_numbered(section, "drive") || is_numbered(section, "command")) return one;
  if (is_numbered(section, "message")) return message;
  return none;
}

class AlturiReader {
 public:
  AlturiReader(DeviceSpec& link, std::vector<rt::Problem>& problems) : link_(link), problems_(problems) {}

  void read(std::string_view text) {
    parse(text);
    if (ini_.empty()) return problem(1, "INI", "", "sections such as [connection] and [drives]");
    read_connection();
    read_drives();
    read_commands();
    read_messages();
  }

 private:
  void problem(int line, std::string key, std::string value, std::string allowed) {
    problems_.push_back({line, std::move(key), std::move(value), std::move(allowed)});
  }

  void parse(std::string_view text) {
    IniSection* section = nullptr;
    for (int number = 1; !text.empty(); ++number) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = ini_trimmed(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.empty()) continue;
      const std::size_t mark = line.find_first_of(";#[=");
      if (mark != std::string_view::npos && (line[mark] == ';' || line[mark] == '#')) continue;
      if (mark == std::string_view::npos) {
        problem(number, "INI", std::string(line), "[section], key=value, or a comment behind ; or #");
      } else if (line[mark] == '[') {
        section = open_section(line.substr(mark), number);
      } else if (!section) {
        problem(number, "INI", std::string(line), "a [section] in front of it");
      } else {
        add_value(*section, ini_trimmed(line.substr(0, mark)), ini_trimmed(line.substr(mark + 1)), number);
      }
    }
  }

  IniSection* open_section(std::string_view rest, int number) {
    const std::size_t close = rest.rfind(']');
    if (close == std::string_view::npos || close < 2) {
      problem(number, "INI", std::string(rest), "[section]");
      return nullptr;
    }
    const std::string name(rest.substr(1, close - 1)), key = lower(name);
    if (known_keys(key).empty() && !key.starts_with("commandgroup")) {
      const std::vector<std::string> known{"connection", "drives", "commands", "messages"};
      problem(number, "[" + name + "]", "",
              "[connection], [drives], [driveN], [commands], [commandN], [messages], [messageN]" +
                  hal::did_you_mean(key, known));
    }
    const auto [it, is_new] = ini_.try_emplace(key, IniSection{name, number, {}});
    if (!is_new) problem(number, "[" + name + "]", "", "once: it is in line " + std::to_string(it->second.line));
    return &it->second;
  }

  void add_value(IniSection& section, std::string_view key, std::string_view value, int number) {
    const std::string name = lower(key);
    const std::string section_key = lower(section.name);
    const std::vector<std::string>& known = known_keys(section_key);
    const bool is_known = std::any_of(known.begin(), known.end(), [&](const auto& k) { return lower(k) == name; });
    if (!known.empty() && !is_known) {
      std::string all;
      for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
      problem(number, section.name + "." + std::string(key), std::string(value),
              "a key that altURI knows here: " + all + hal::did_you_mean(key, known));
    }
    section.values[name] = {std::string(value), number};  // as altURI: the last one counts
  }

  const IniSection* section(const std::string& name) const {
    const auto it = ini_.find(name);
    return it == ini_.end() ? nullptr : &it->second;
  }
  const IniValue* value(const IniSection* s, std::string_view key) const {
    if (!s) return nullptr;
    const auto it = s->values.find(lower(key));
    return it == s->values.end() || it->second.text.empty() ? nullptr : &it->second;
  }
  /// A whole number of the section; `otherwise` where the key is not there.
  std::size_t whole(const IniSection* s, std::string_view key, std::size_t otherwise, std::size_t most) {
    const IniValue* v = value(s, key);
    if (!v) return otherwise;
    const auto number = wire::parse_decimal(v->text, 9);
    if (number && *number <= most) return static_cast<std::size_t>(*number);
    problem(v->line, s->name + "." + std::string(key), v->text, "a whole number from 0 to " + std::to_string(most));
    return otherwise;
  }
  void set(std::map<std::string, rt::Located<rt::ParamValue>>& keys, std::string_view key, rt::ParamValue text,
           int line) {
    keys.try_emplace(std::string(key), rt::Located<rt::ParamValue>{std::move(text), line});
  }

  void read_connection() {
    const IniSection* s = section("connection");
    if (!s) return problem(1, "[connection]", "", "the address of the simulator; it is required");
    const IniValue* ip = value(s, "SimIP4");
    const IniValue* port = value(s, "SimCommandPort");
    const IniValue* sensors = value(s, "SimSensorPort");
    first_ = whole(section("drives"), "DriveFirstParameter", 1, 9);
    is_udp_ = first_ > 1 || sensors != nullptr;
    if (!ip) problem(s->line, s->name + ".SimIP4", "", "an IPv4 address; it is required");
    if (!port) problem(s->line, s->name + ".SimCommandPort", "", "a port; it is required");
    if (!ip || !port) return;
    if (!hal::udp_address(ip->text + ":1")) problem(ip->line, s->name + ".SimIP4", ip->text, "an IPv4 address");
    for (const IniValue* p : {port, sensors})
      if (p && !hal::udp_address("127.0.0.1:" + p->text))
        problem(p->line, s->name + (p == port ? ".SimCommandPort" : ".SimSensorPort"), p->text, "1 to 65535");
    set(link_.keys, "to", (is_udp_ ? "udp:" : "tcp:") + ip->text + ":" + port->text, ip->line);
    if (!sensors) return;
    set(link_.keys, "state", "udp:" + ip->text + ":" + sensors->text, sensors->line);
    set(link_.keys, "state_decoder", std::string("navdata"), sensors->line);
    set(link_.keys, "state_hello", std::string("\1\0\0\0", 4), sensors->line);
  }

  /// The text of a command with its first conversions as sequence numbers, and %d of what is no whole number as bits.
  std::string converted(std::string text, bool fractions) const {
    std::size_t conversion = 1;
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
      if (text[i] != '%') continue;
      if (text[i + 1] == '%') {
        ++i;
        continue;
      }
      const std::size_t letter = text.find_first_not_of("-+ 0123456789.", i + 1);
      if (letter == std::string::npos) break;
      if (conversion < first_)
        text.replace(i, letter - i + 1, "%q");
      else if (first_ > 1 && fractions && (text[letter] == 'd' || text[letter] == 'i'))
        text.replace(i, letter - i + 1, "%b");
      ++conversion;
    }
    return text;
  }

  /// Key, Min, Max and Increment of a section as those of a table.
  bool read_one(const std::string& name, const std::string& prefix, bool normalized, DeviceSpec& out) {
    const IniSection* s = section(name);
    if (!s) return false;
    out.line = s->line;
    const IniValue* key = value(s, "Key");
    if (!key) {
      problem(s->line, s->name + ".Key", "", "the text of the command; it is required");
      return false;
    }
    std::array<double, 3> numbers{0, 0, 0};
    bool fractions = false;
    const std::array<std::string_view, 3> keys{"Min", "Max", "Increment"};
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const IniValue* v = value(s, keys[i]);
      if (!v) continue;
      const auto number = wire::parse_number(v->text);
      if (!number) {
        problem(v->line, s->name + "." + std::string(keys[i]), v->text, "a number");
        continue;
      }
      numbers[i] = *number;
      fractions = fractions || std::floor(*number) != *number;
      set(out.keys, lower(keys[i]), *number, v->line);
    }
    const IniValue* max = value(s, "Max");
    if (numbers[1] < numbers[0])
      problem(max ? max->line : s->line, s->name + ".Max", max ? max->text : "0", "not below Min");
    if (const IniValue* step = value(s, "Increment"); step && numbers[2] < 0)
      problem(step->line, s->name + ".Increment", step->text, "0 or more");
    if (normalized)
      for (const auto& [k, v] : {std::pair{"min", -100.0}, std::pair{"max", 100.0}}) out.keys[k] = {v, s->line};
    set(out.keys, "text", prefix + converted(key->text, fractions), key->line);
    return true;
  }

  /// "{AltitudeVelocity %1.2f}": AltitudeVelocity
  static std::string name_in(std::string_view text, const std::string& otherwise) {
    if (!text.starts_with('{')) return otherwise;
    const std::string_view word = text.substr(1, std::min(text.find_first_of(" }", 1), text.size()) - 1);
    const bool good = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
    return good ? std::string(word) : otherwise;
  }
  static bool is_taken(const std::vector<DeviceSpec>& tables, const std::string& name) {
    return std::any_of(tables.begin(), tables.end(), [&](const DeviceSpec& t) { return t.name == name; });
  }
  void read_drives() {
    const IniSection* s = section("drives");
    const std::size_t total = whole(s, "DriveTotal", 0, 100);
    const bool normalized = whole(s, "DriveNormalize", 0, 1) == 1;
    const IniValue* prefix = value(s, "DrivePrefix");
    const bool is_at = first_ > 1;
    if (prefix) set(link_.keys, "prefix", prefix->text + (is_at ? "" : " "), prefix->line);
    if (is_at) {
      set(link_.keys, "separate", true, s->line);
      set(link_.keys, "line_end", std::string("\r"), s->line);
    }
    std::vector<DeviceSpec> drives;
    for (std::size_t i = 1; i <= total; ++i) {
      const std::string name = "drive" + std::to_string(i);
      DeviceSpec drive;
      if (read_one(name, "", normalized, drive)) {
        drive.name = name_in(std::get<std::string>(drive.keys["text"].value), name);
        if (is_taken(drives, drive.name)) drive.name = name;
        drives.push_back(std::move(drive));
      } else if (!section(name)) {
        const IniValue* v = value(s, "DriveTotal");
        problem(v ? v->line : 0, "drives.DriveTotal", std::to_string(total), "as many as there are: no [" + name + "]");
      }
    }
    link_.drives = std::move(drives);
  }

  void read_commands() {
    const IniSection* s = section("commands");
    const std::size_t total = whole(s, "CommandTotal", 0, 100);
    const IniValue* prefix = value(s, "CommandPrefix");
    std::vector<DeviceSpec> commands;
    for (std::size_t i = 1; i <= total; ++i) {
      DeviceSpec command;
      command.name = "command" + std::to_string(i);
      if (read_one(command.name, prefix ? prefix->text + " " : "", false, command)) {
        commands.push_back(std::move(command));
      } else if (!section("command" + std::to_string(i))) {
        const IniValue* v = value(s, "CommandTotal");
        problem(v ? v->line : 0, "commands.CommandTotal", std::to_string(total),
                "as many as there are: no [command" + std::to_string(i) + "]");
      }
    }
    link_.commands = std::move(commands);
  }

  void read_messages() {
    const IniSection* s = section("messages");
    const std::size_t total = whole(s, "MessageTotal", 0, 100);
    std::vector<DeviceSpec> messages;
    for (std::size_t i = 1; i <= total; ++i) {
      const std::string name = "message" + std::to_string(i);
      const IniSection* one = section(name);
      if (!one) {
        const IniValue* v = value(s, "MessageTotal");
        problem(v ? v->line : 0, "messages.MessageTotal", std::to_string(total),
                "as many as there are: no [" + name + "]");
        continue;
      }
      const IniValue* type = value(one, "MessageName");
      const IniValue* key = value(one, "KeyName");
      if (!type || !key) {
        problem(one->line, one->name + (type ? ".KeyName" : ".MessageName"), "", "a name; it is required");
        continue;
      }
      DeviceSpec message;
      message.line = one->line;
      const std::size_t index = whole(one, "Index", 0, 1000);
      message.name = key->text + "_" + std::to_string(index);
      if (is_taken(messages, message.name)) message.name = type->text + "_" + message.name;
      if (is_taken(messages, message.name)) message.name = name;
      set(message.keys, "message", type->text, type->line);
      set(message.keys, "key", key->text, key->line);
      set(message.keys, "index", static_cast<std::int64_t>(index), one->line);
      messages.push_back(std::move(message));
    }
    link_.messages = std::move(messages);
  }

  DeviceSpec& link_;
  std::vector<rt::Problem>& problems_;
  Ini ini_;
  std::size_t first_ = 1;
  bool is_udp_ = false;
};

}  // namespace

void read_alturi_ini(std::string_view text, DeviceSpec& link, std::vector<rt::Problem>& problems) {
  AlturiReader(link, problems).read(text);
}

}  // namespace sinew::drivers
