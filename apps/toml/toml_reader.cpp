#include "apps/toml/toml_reader.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "apps/toml/toml_guard.hpp"
#include "hal/did_you_mean.hpp"

namespace sinew::app {

std::optional<toml::table> parse_toml(std::string_view text, const std::string& path, Problems& problems) {
  if (const int line = line_beyond_ascii(text)) {
    problems.push_back({line, "TOML", "syntax", "only ASCII outside of comments"});
    return std::nullopt;
  }
  toml::parse_result parsed = toml::parse(text, path);
  if (parsed) return std::move(parsed).table();
  const auto& e = parsed.error();
  problems.push_back({static_cast<int>(e.source().begin.line), "TOML", "syntax", std::string(e.description())});
  return std::nullopt;
}

int line_of(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

std::string value_text(const toml::node& node) {
  if (node.is_table()) return "{...}";
  std::ostringstream out;
  if (const toml::array* array = node.as_array()) {  // by hand: toml++ 3.3 takes the logarithm of a nan to lay it out
    for (const toml::node& entry : *array) out << (out.tellp() > 0 ? ", " : "[ ") << value_text(entry);
    out << (array->empty() ? "[]" : " ]");
  } else {
    node.visit([&](const auto& n) { out << toml::default_formatter(n, toml::format_flags::none); });
  }
  std::string text = out.str();
  for (char& c : text)
    if (c == '\n') c = ' ';
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

bool read_param_value(const toml::node& node, rt::ParamValue& out) {
  if (auto b = node.value_exact<bool>())
    out = *b;
  else if (auto i = node.value_exact<std::int64_t>())
    out = *i;
  else if (auto d = node.value_exact<double>())
    out = *d;
  else if (auto s = node.value_exact<std::string>())
    out = *s;
  else
    return false;
  return true;
}

const toml::node* TomlReader::take(std::string_view key) {
  known_.emplace(key);
  return table_.get(key);
}

void TomlReader::problem(const toml::node& node, std::string_view key, std::string allowed) {
  problems_.push_back({line_of(node), full(key), value_text(node), std::move(allowed)});
}

void TomlReader::missing(std::string_view key, std::string_view allowed) {
  problems_.push_back({line(), full(key), "missing", std::string(allowed)});
}

bool TomlReader::read(std::string_view key, std::string& out, std::string_view allowed) {
  const toml::node* node = take(key);
  if (!node) return false;
  if (auto v = node->value_exact<std::string>()) {
    out = *v;
    return true;
  }
  problem(*node, key, std::string(allowed));
  return false;
}

void TomlReader::require(std::string_view key, std::string& out, std::string_view allowed) {
  if (!has(key)) missing(key, allowed);
  read(key, out, allowed);
}

bool TomlReader::read(std::string_view key, bool& out) {
  const toml::node* node = take(key);
  if (!node) return false;
  if (auto v = node->value_exact<bool>()) {
    out = *v;
    return true;
  }
  problem(*node, key, "true or false");
  return false;
}

bool TomlReader::read(std::string_view key, std::int64_t& out, std::int64_t min, std::int64_t max) {
  const toml::node* node = take(key);
  if (!node) return false;
  if (auto v = node->value_exact<std::int64_t>(); v && *v >= min && *v <= max) {
    out = *v;
    return true;
  }
  problem(*node, key, fmt::format("an integer from {} to {}", min, max));
  return false;
}

bool TomlReader::read(std::string_view key, double& out, double min, double max) {
  const toml::node* node = take(key);
  if (!node) return false;
  if (node->is_number())
    if (auto v = node->value<double>(); v && *v >= min && *v <= max) {
      out = *v;
      return true;
    }
  problem(*node, key, fmt::format("a number from {} to {}", min, max));
  return false;
}

bool TomlReader::read_time(std::string_view key, rt::Duration& out, double unit_ns, rt::Duration min,
                           rt::Duration max) {
  const toml::node* node = take(key);
  if (!node) return false;
  const auto as_unit = [&](rt::Duration d) { return static_cast<double>(d.count()) / unit_ns; };
  if (node->is_number()) {
    const double v = *node->value<double>();
    if (v >= as_unit(min) && v <= as_unit(max)) {
      out = rt::Duration{static_cast<std::int64_t>(std::llround(v * unit_ns))};
      return true;
    }
  }
  problem(*node, key, fmt::format("a number from {} to {}", as_unit(min), as_unit(max)));
  return false;
}

bool TomlReader::read(std::string_view key, std::vector<int>& out, int min, int max) {
  const toml::node* node = take(key);
  if (!node) return false;
  const toml::array* array = node->as_array();
  std::vector<int> values;
  bool good = array != nullptr;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const auto v = (*array)[i].value_exact<std::int64_t>();
    good = v && *v >= min && *v <= max;
    if (good) values.push_back(static_cast<int>(*v));
  }
  if (good) {
    out = std::move(values);
    return true;
  }
  problem(*node, key, fmt::format("an array of integers from {} to {}", min, max));
  return false;
}

bool TomlReader::read_names(std::string_view key, std::vector<rt::Located<std::string>>& out) {
  const toml::node* node = take(key);
  if (!node) return false;
  if (auto one = node->value_exact<std::string>()) {
    out = {{*one, line_of(*node)}};
    return true;
  }
  const toml::array* array = node->as_array();
  bool good = array && !array->empty();
  std::vector<rt::Located<std::string>> names;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const auto v = (*array)[i].value_exact<std::string>();
    good = v.has_value();
    if (good) names.push_back({*v, line_of((*array)[i])});
  }
  if (good) {
    out = std::move(names);
    return true;
  }
  problem(*node, key, "a name or an array of names");
  return false;
}

void TomlReader::table(std::string_view key, const std::function<void(TomlReader&)>& each) {
  const toml::node* node = take(key);
  if (!node) return;
  if (const toml::table* t = node->as_table()) {
    TomlReader reader(*t, full(key), problems_);
    each(reader);
    reader.finish();
  } else {
    problem(*node, key, "a table");
  }
}

void TomlReader::tables_by_name(std::string_view key,
                                const std::function<void(const std::string&, TomlReader&)>& each) {
  const toml::node* node = take(key);
  if (!node) return;
  const toml::table* all = node->as_table();
  if (!all) return problem(*node, key, "a table of tables");
  for (const auto& [name, entry] : *all) {
    const std::string path = full(key) + "." + std::string(name.str());
    if (const toml::table* t = entry.as_table()) {
      TomlReader reader(*t, path, problems_);
      each(std::string(name.str()), reader);
      reader.finish();
    } else {
      problems_.push_back({line_of(entry), path, value_text(entry), "a table"});
    }
  }
}

void TomlReader::array_of_tables(std::string_view key, const std::function<void(TomlReader&)>& each) {
  const toml::node* node = take(key);
  if (!node) return;
  const toml::array* array = node->as_array();
  if (!array || !array->is_array_of_tables())
    return problem(*node, key, fmt::format("an array of tables, written [[{}]]", full(key)));
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::table& t = *(*array)[i].as_table();
    const auto name = t["name"].value<std::string>();
    TomlReader reader(t, full(key) + "." + name.value_or(std::to_string(i)), problems_);
    each(reader);
    reader.finish();
  }
}

void TomlReader::finish() {
  for (const auto& [key, node] : table_) {
    if (known_.contains(key.str())) continue;
    std::string allowed = "unknown key; known here:";
    for (const auto& k : known_) allowed += " " + k;
    allowed += hal::did_you_mean(key.str(), std::vector<std::string>(known_.begin(), known_.end()));
    problems_.push_back({static_cast<int>(key.source().begin.line), full(key.str()), value_text(node), allowed});
  }
}

}  // namespace sinew::app
