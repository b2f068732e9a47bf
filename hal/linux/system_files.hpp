#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::hal {

/// The small text files in which a Linux machine describes itself, beneath a root folder ("/", or a made-up tree).
/// Names are without the leading slash ("proc/version").
/// Thread:  any.
class SystemFiles {
 public:
  explicit SystemFiles(std::string root);
  /// True for the machine on which this runs: then things may be tried, not only read.
  bool is_live() const { return root_ == "/"; }
  const std::string& root() const { return root_; }

  /// The content without the white space at its end; nothing when it cannot be read.
  std::optional<std::string> text(const std::string& name) const;
  std::optional<std::int64_t> number(const std::string& name) const;
  /// The rest of the first line that begins with `key`, without white space around it.
  std::optional<std::string> field(const std::string& name, std::string_view key) const;
  /// Names in a folder, sorted with numbers by value (cpu2 before cpu10).
  std::vector<std::string> list(const std::string& folder) const;
  bool is_folder(const std::string& name) const;
  bool writable(const std::string& name) const;
  /// The permissions of a file; nothing when there is no such file.
  struct Access {
    bool ours = false;   // this process may read and write it
    std::uint32_t mode;  // permission bits, 0660
    std::string group;   // its name, or its number where that has none
  };
  std::optional<Access> access(const std::string& name) const;
  /// A switch of the running kernel's build (CONFIG_...): "y", "m", a value; "" when it is off, nothing when no
  /// configuration can be read. Looks into proc/config.gz and boot/config-RELEASE.
  std::optional<std::string> kernel_option(std::string_view option) const;

 private:
  std::string root_;
  std::optional<std::string> config_;
};

/// "0-2,5" as numbers; other text is left out.
std::vector<int> cpu_list(std::string_view text);
/// The inverse of cpu_list().
std::string to_text(const std::vector<int>& cpus);

}  // namespace sinew::hal
