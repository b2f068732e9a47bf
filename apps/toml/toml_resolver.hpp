#pragma once
// TOML files that extend other ones, merged into one text that says where each of its lines stands.
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "apps/toml/line_place.hpp"
#include "apps/toml/toml_reader.hpp"

namespace sinew::app {

/// Where somebody wrote nodes that stand in no TOML file.
using NodePlaces = std::map<const toml::node*, LinePlace>;

/// TOML that stands alone.
struct MergedToml {
  std::string text;
  std::vector<rt::Problem> problems{};  // missing, no TOML, circular: there is no such text
  /// Where line i + 1 of `text` was written; with problems: of theirs.
  std::vector<LinePlace> places{};
};

/// Reads a file with the chain of files that it extends, and writes all as one text. A key of a file takes the place of
/// the same key below it; tables are merged key by key, arrays of tables by their `name`; `without = ["module.pad"]`
/// takes tables away.
class TomlResolver {
 public:
  /// Null after a problem was added.
  std::unique_ptr<toml::table> merged(const std::string& text, const std::string& path);
  /// Puts the file that the key `extends` of the table `name` names (relative to the file that says so) below that
  /// table; without such a key does nothing. False after a problem was added.
  bool merge_below(toml::table& root, const char* name);
  /// For nodes that are put into the tables from elsewhere.
  NodePlaces& elsewhere() { return elsewhere_; }

  /// Writes the text, which begins with `title`, and where its lines are from.
  void write(const toml::table& table, const std::string& title, const std::string& path);
  /// Lines of the written text, or of problems of this resolver, become those of the files where they stand.
  void place_lines(std::vector<rt::Problem>& problems) const;
  MergedToml& result() { return out_; }

 private:
  struct Entry {
    std::string key;
    const toml::node* node;
    std::pair<int, std::uint32_t> at;  // file, line
  };
  std::unique_ptr<toml::table> refuse(std::uint32_t line, const std::string& path, const std::string& key,
                                      const std::string& value, const std::string& allowed);
  std::unique_ptr<toml::table> extended(const toml::node& said, const std::string& key, const std::string& path);
  void remember(const std::string& path) { order_.emplace(path, static_cast<int>(order_.size())); }
  void take_away(toml::table& base, const toml::table& own, const std::string& path);
  std::pair<int, std::uint32_t> place(const toml::node& node) const;
  std::vector<Entry> entries(const toml::table& table) const;
  LinePlace written(const toml::node& node) const;
  std::string origin(const toml::node& node) const;
  void put(const std::string& lines, const LinePlace& at);
  void print(const toml::table& table, const std::string& prefix, bool root);

  MergedToml out_;
  NodePlaces elsewhere_;
  std::vector<std::string> seen_;
  std::map<std::string, int> order_;
  std::ostringstream text_;
};

}  // namespace sinew::app
