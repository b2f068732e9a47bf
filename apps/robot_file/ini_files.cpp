#include "apps/robot_file/ini_files.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "drivers/text/alturi_ini.hpp"

namespace sinew::app {
namespace {

constexpr std::size_t kLongestIni = std::size_t{1} << 20;

/// What an INI file says, as nodes of a robot file.
class IniTables {
 public:
  IniTables(const std::string& path, NodePlaces& places) : path_(path), places_(places) {}

  void put_below(toml::table& device, const drivers::DeviceSpec& said) {
    for (const auto& [key, value] : said.keys)
      if (!device.contains(key)) put(device, key, value.value, value.line);
    put_list(device, "drive", said.drives);
    put_list(device, "command", said.commands);
    put_list(device, "message", said.messages);
  }

 private:
  void put(toml::table& table, const std::string& key, const rt::ParamValue& value, int line) {
    std::visit([&](const auto& v) { table.insert_or_assign(key, v); }, value);
    places_[table.get(key)] = {path_, line};
  }

  /// The tables of the INI file first, each with what the robot file says of the same name; then its others.
  void put_list(toml::table& device, const char* list, const std::vector<drivers::DeviceSpec>& said) {
    toml::node* const there = device.get(list);
    if (said.empty() || (there && !there->is_array_of_tables())) return;
    toml::array all;
    for (const drivers::DeviceSpec& one : said) {
      all.push_back(toml::table());
      toml::table& table = *all.back().as_table();
      places_[&table] = {path_, one.line};
      put(table, "name", one.name, one.line);
      for (const auto& [key, value] : one.keys) put(table, key, value.value, value.line);
    }
    if (there)
      for (toml::node& own : *there->as_array()) put_own(all, *own.as_table());
    device.insert_or_assign(list, std::move(all));
  }

  void put_own(toml::array& all, toml::table& own) {
    const auto name = own["name"].value<std::string>();
    for (toml::node& one : all) {
      toml::table& table = *one.as_table();
      if (!name || table["name"].value<std::string>() != name) continue;
      for (auto&& [key, node] : own) {
        if (const toml::node* replaced = table.get(key)) places_.erase(replaced);
        node.visit([&, k = std::string(key.str())](auto& value) { table.insert_or_assign(k, std::move(value)); });
      }
      return;
    }
    all.push_back(std::move(own));
  }

  const std::string& path_;
  NodePlaces& places_;
};

/// The key `ini` of a device that may have one; null: none.
const toml::value<std::string>* ini_key(const toml::node& device) {
  const toml::table* const keys = device.as_table();
  if (!keys || (*keys)["driver"].value_or(std::string()) != "text") return nullptr;
  const toml::node* const key = keys->get("ini");
  return key ? key->as_string() : nullptr;
}

}  // namespace

bool names_ini_file(const toml::table& robot) {
  const toml::table* const devices = robot["device"].as_table();
  return devices && std::any_of(devices->begin(), devices->end(),
                                [](const auto& device) { return ini_key(device.second) != nullptr; });
}

void read_ini_files(toml::table& robot, NodePlaces& places, std::vector<IniProblem>& problems) {
  toml::table* const devices = robot["device"].as_table();
  if (!devices) return;
  for (auto&& [name, device] : *devices) {
    const auto* const key = ini_key(device);
    if (!key) continue;
    const auto& source = key->source();
    const std::string robot_path = source.path ? *source.path : std::string();
    const std::string path = (std::filesystem::path(robot_path).parent_path() / key->get()).string();
    std::ifstream in(path, std::ios::binary);
    std::error_code none;
    if (!in || std::filesystem::is_directory(path, none) || std::filesystem::file_size(path, none) > kLongestIni) {
      problems.push_back({{0, "device." + std::string(name.str()) + ".ini", '"' + key->get() + '"',
                           "a file that can be read: " + path},
                          {robot_path, static_cast<int>(source.begin.line)}});
      continue;
    }
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    drivers::DeviceSpec said;
    std::vector<rt::Problem> of_the_file;
    drivers::read_alturi_ini(text, said, of_the_file);
    for (rt::Problem& problem : of_the_file) {
      const int line = std::max(problem.line, 1);
      problems.push_back({std::move(problem), {path, line}});
    }
    device.as_table()->erase("ini");
    IniTables(path, places).put_below(*device.as_table(), said);
  }
}

}  // namespace sinew::app
