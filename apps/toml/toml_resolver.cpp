#include "apps/toml/toml_resolver.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/toml/toml_guard.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

std::string name_of(const toml::node& node) {
  const toml::table* table = node.as_table();
  return table ? (*table)["name"].value_or(std::string()) : std::string();
}

void merge_by_name(toml::array& base, toml::array& over);

// Moves nodes: a copied node loses its file and line.
void merge(toml::table& base, toml::table& over) {
  for (auto&& [key, node] : over) {
    toml::node* const there = base.get(key);
    if (there && there->is_table() && node.is_table())
      merge(*there->as_table(), *node.as_table());
    else if (there && there->is_array_of_tables() && node.is_array_of_tables())
      merge_by_name(*there->as_array(), *node.as_array());
    else
      node.visit([&, k = std::string(key.str())](auto& value) { base.insert_or_assign(k, std::move(value)); });
  }
}

void merge_by_name(toml::array& base, toml::array& over) {
  for (toml::node& one : over) {
    const std::string name = name_of(one);
    const auto same = std::find_if(base.begin(), base.end(),
                                   [&](const toml::node& n) { return !name.empty() && name_of(n) == name; });
    if (same != base.end())
      merge(*same->as_table(), *one.as_table());
    else
      base.push_back(std::move(*one.as_table()));
  }
}

std::string quoted_key(const std::string& key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-';
  });
  return bare ? key : '"' + key + '"';
}

/// Arrays of numbers, and of arrays, on one line: toml++ 3.3 computes the width of an array with the logarithm of its
/// numbers as an unsigned one, which is undefined for those below 1.
void print_value(const toml::node& node, std::ostringstream& out) {
  const toml::array* const array = node.as_array();
  const auto is_ours = [](const toml::node& n) { return n.is_number() || n.is_array(); };
  if (!array || array->empty() || !std::all_of(array->begin(), array->end(), is_ours)) {
    node.visit([&](const auto& value) { out << value; });
    return;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    out << (i == 0 ? "[ " : ", ");
    print_value((*array)[i], out);
  }
  out << " ]";
}

}  // namespace

std::unique_ptr<toml::table> TomlResolver::refuse(std::uint32_t line, const std::string& path, const std::string& key,
                                                  const std::string& value, const std::string& allowed) {
  out_.places.push_back({path, static_cast<int>(line)});
  out_.problems.push_back({static_cast<int>(out_.places.size()), key, value, allowed});
  return nullptr;
}

/// The file that `said`, the value of `key` in the file `path`, names, with all that it extends.
std::unique_ptr<toml::table> TomlResolver::extended(const toml::node& said, const std::string& key,
                                                    const std::string& path) {
  const auto line = said.source().begin.line;
  if (!said.is_string()) return refuse(line, path, key, "", "the path of another file, a text");
  const std::string named = *said.value<std::string>();
  const std::string base = (fs::path(path).parent_path() / named).lexically_normal().string();
  seen_.push_back(fs::path(path).lexically_normal().string());
  if (std::find(seen_.begin(), seen_.end(), base) != seen_.end())
    return refuse(line, path, key, '"' + named + '"', "a file that does not extend this one: they go in a circle");
  std::ifstream in(base, std::ios::binary);
  if (std::error_code none; !in || fs::is_directory(base, none))
    return refuse(line, path, key, '"' + named + '"', "a file that can be read: " + base);
  const std::string below((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (const int odd = line_beyond_ascii(below))
    return refuse(static_cast<std::uint32_t>(odd), base, "TOML", "syntax", "only ASCII outside of comments");
  auto all = merged(below, base);
  seen_.pop_back();
  return all;
}

std::unique_ptr<toml::table> TomlResolver::merged(const std::string& text, const std::string& path) {
  toml::parse_result parsed = toml::parse(text, path);
  if (!parsed) {
    refuse(parsed.error().source().begin.line, path, "TOML", "syntax", std::string(parsed.error().description()));
    return nullptr;
  }
  auto own = std::make_unique<toml::table>(std::move(parsed).table());
  const toml::node* const said = own->get("extends");
  if (!said) {
    remember(path);
    return own;
  }
  auto all = extended(*said, "extends", path);
  if (!all) return nullptr;
  remember(path);
  take_away(*all, *own, path);
  own->erase("extends");
  own->erase("without");
  merge(*all, *own);
  return out_.problems.empty() ? std::move(all) : nullptr;
}

bool TomlResolver::merge_below(toml::table& root, const char* name) {
  toml::table* const own = root[name].as_table();
  const toml::node* const said = own ? own->get("extends") : nullptr;
  if (!said) return true;
  const std::string path = said->source().path ? *said->source().path : std::string();
  auto below = extended(*said, std::string(name) + ".extends", path);
  if (!below) return false;
  own->erase("extends");
  merge(*below, *own);
  root.insert_or_assign(name, std::move(*below));
  return true;
}

void TomlResolver::place_lines(std::vector<rt::Problem>& problems) const {
  for (rt::Problem& problem : problems) {
    const auto line = static_cast<std::size_t>(problem.line);
    if (line > 0 && line <= out_.places.size()) problem.line = out_.places[line - 1].line;
  }
}

/// `without`: "module.pad", "topic.camera.raw", "thread.vision".
void TomlResolver::take_away(toml::table& base, const toml::table& own, const std::string& path) {
  const toml::node* without = own.get("without");
  if (!without) return;
  const auto line = without->source().begin.line;
  if (!without->is_array()) {
    refuse(line, path, "without", "", "an array of tables' names, such as \"module.pad\"");
    return;
  }
  for (const toml::node& one : *without->as_array()) {
    const std::string name = one.value_or(std::string());
    const auto dot = name.find('.');
    const std::string section = name.substr(0, dot), rest = dot == name.npos ? "" : name.substr(dot + 1);
    toml::node* const tables = base.get(section);
    bool gone = false;
    if (tables && tables->is_table()) gone = tables->as_table()->erase(rest) > 0;
    if (toml::array* const list = tables ? tables->as_array() : nullptr)
      for (std::size_t i = 0; i < list->size() && !gone; ++i)
        if (name_of(*list->get(i)) == rest) {
          list->erase(list->cbegin() + static_cast<std::ptrdiff_t>(i));
          gone = true;
        }
    if (tables && tables->is_array() && tables->as_array()->empty()) base.erase(section);
    if (!gone)
      refuse(line, path, "without", '"' + name + '"', "a table of the file that is extended, such as \"module.pad\"");
  }
}

// ---- as text, in the order of the files

std::pair<int, std::uint32_t> TomlResolver::place(const toml::node& node) const {
  const auto& source = node.source();
  const auto it = source.path ? order_.find(*source.path) : order_.end();
  return {it == order_.end() ? 0 : it->second, source.begin.line};
}

std::vector<TomlResolver::Entry> TomlResolver::entries(const toml::table& table) const {
  std::vector<Entry> all;
  for (const auto& [key, node] : table) all.push_back({quoted_key(std::string(key.str())), &node, place(node)});
  std::stable_sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) { return a.at < b.at; });
  return all;
}

LinePlace TomlResolver::written(const toml::node& node) const {
  if (const auto there = elsewhere_.find(&node); there != elsewhere_.end()) return there->second;
  const auto& source = node.source();
  return {source.path ? *source.path : std::string(), static_cast<int>(source.begin.line)};
}

std::string TomlResolver::origin(const toml::node& node) const {
  const LinePlace at = written(node);
  return "  # " + at.file + ":" + std::to_string(at.line);
}

/// One or more lines (a long array), all written where their key stands.
void TomlResolver::put(const std::string& lines, const LinePlace& at) {
  text_ << lines << '\n';
  out_.places.insert(out_.places.end(), 1 + static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n')), at);
}

void TomlResolver::print(const toml::table& table, const std::string& prefix, bool root) {
  const std::vector<Entry> all = entries(table);
  const auto is_section = [](const toml::node& n) { return n.is_table() || n.is_array_of_tables(); };
  for (const Entry& e : all)
    if (!is_section(*e.node)) {
      std::ostringstream line;
      line << e.key << " = ";
      print_value(*e.node, line);
      put(line.str(), written(*e.node));
    }
  for (const Entry& e : all) {
    if (!is_section(*e.node)) continue;
    const std::string name = root ? e.key : prefix + "." + e.key;
    if (const toml::table* sub = e.node->as_table()) {
      const bool only_tables =
          std::all_of(sub->begin(), sub->end(), [&](const auto& pair) { return is_section(pair.second); });
      if (!only_tables || sub->empty()) put("\n[" + name + "]" + origin(*sub), written(*sub));
      print(*sub, name, false);
      continue;
    }
    for (const toml::node& one : *e.node->as_array()) {
      put("\n[[" + name + "]]" + origin(one), written(one));
      print(*one.as_table(), name, false);
    }
  }
}

void TomlResolver::write(const toml::table& table, const std::string& title, const std::string& path) {
  put(title, {path, 1});
  print(table, "", true);
  out_.text = text_.str();
}

}  // namespace sinew::app
