#pragma once
// A table of a TOML file whose keys are taken one by one; keys that are left over are unknown ones.
#include <functional>
#include <initializer_list>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

// The library asserts that "[[:" cannot occur before it reports that as an error; a wrong file must not end the
// process.
#ifdef NDEBUG
#error "with NDEBUG, toml++ tells the compiler to assume what it would have asserted"
#endif
#define TOML_ASSERT(expr) static_cast<void>(0)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "hal/did_you_mean.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

using Problems = std::vector<rt::Problem>;

int line_of(const toml::node& node);
std::string value_text(const toml::node& node);
/// Parses `text` of the file `path`. Nothing: problems say why (not ASCII outside of comments, or no TOML).
std::optional<toml::table> parse_toml(std::string_view text, const std::string& path, Problems& problems);
/// A boolean, integer, number or string; false: something else.
bool read_param_value(const toml::node& node, rt::ParamValue& out);

/// Reads typed values out of one table; a value that does not fit becomes a Problem, and the default stays.
class TomlReader {
 public:
  TomlReader(const toml::table& table, std::string path, Problems& problems)
      : table_(table), path_(std::move(path)), problems_(problems) {}

  int line() const { return line_of(table_); }
  const std::string& path() const { return path_; }
  bool has(std::string_view key) const { return table_.contains(key); }
  /// The node of `key`, marked as known; null when absent.
  const toml::node* take(std::string_view key);

  bool read(std::string_view key, std::string& out, std::string_view allowed = "a string");
  bool read(std::string_view key, bool& out);
  bool read(std::string_view key, std::int64_t& out, std::int64_t min, std::int64_t max);
  bool read(std::string_view key, double& out, double min, double max);
  /// A time in `unit` ("us", "ms") as the suffix of the key says; fractions are allowed, to the nanosecond.
  bool read_time(std::string_view key, rt::Duration& out, double unit_ns, rt::Duration min, rt::Duration max);
  bool read(std::string_view key, std::vector<int>& out, int min, int max);
  /// A string or an array of strings.
  bool read_names(std::string_view key, std::vector<rt::Located<std::string>>& out);
  template <class E>
  bool read_choice(std::string_view key, E& out, std::initializer_list<std::pair<std::string_view, E>> choices) {
    return read_choice(key, out, std::span(choices.begin(), choices.size()));
  }
  template <class E>
  bool read_choice(std::string_view key, E& out,
                   std::span<const std::pair<std::string_view, std::type_identity_t<E>>> choices);
  /// Calls `each` with a reader for the sub-table `key`, if there.
  void table(std::string_view key, const std::function<void(TomlReader&)>& each);
  /// Calls `each` for every entry of the table `key`, all of which must be tables.
  void tables_by_name(std::string_view key, const std::function<void(const std::string&, TomlReader&)>& each);
  /// Calls `each` for every entry of the array of tables `key`.
  void array_of_tables(std::string_view key, const std::function<void(TomlReader&)>& each);
  /// A string that must be there.
  void require(std::string_view key, std::string& out, std::string_view allowed = "a string; it is required");

  void problem(const toml::node& node, std::string_view key, std::string allowed);
  void missing(std::string_view key, std::string_view allowed);
  /// Every key that was not taken becomes a Problem that lists the known ones.
  void finish();

  const toml::table& raw() const { return table_; }
  Problems& problems() { return problems_; }
  std::string full(std::string_view key) const {
    const std::string name =
        key.empty() ? "\"\"" : std::string(key);  // TOML allows an empty key; a problem must name it
    return path_.empty() ? name : path_ + "." + name;
  }

 private:
  const toml::table& table_;
  std::string path_;
  Problems& problems_;
  std::set<std::string, std::less<>> known_;
};

template <class E>
bool TomlReader::read_choice(std::string_view key, E& out,
                             std::span<const std::pair<std::string_view, std::type_identity_t<E>>> choices) {
  const toml::node* node = take(key);
  if (!node) return false;
  std::vector<std::string> names;
  const auto text = node->value_exact<std::string>();
  for (const auto& [name, value] : choices) {
    if (text && *text == name) {
      out = value;
      return true;
    }
    names.emplace_back(name);
  }
  problem(*node, key, "one of " + hal::quoted(names) + hal::did_you_mean(text.value_or(""), names));
  return false;
}

}  // namespace sinew::app
