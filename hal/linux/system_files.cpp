#include "hal/linux/system_files.hpp"

#ifdef SINEW_ZLIB
#include <zlib.h>
#endif
#include <dirent.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace sinew::hal {
namespace {

std::string trimmed(std::string_view text) {
  const char* const white = " \t\r\n";
  const auto first = text.find_first_not_of(white);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(white) - first + 1));
}

bool is_folder_at(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0 && S_ISDIR(info.st_mode);
}

std::optional<std::string> whole_file(const std::string& path) {
  if (is_folder_at(path)) return std::nullopt;  // a folder opens, but throws when it is read
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(in), {});
}

#ifdef SINEW_ZLIB
std::optional<std::string> unpacked_file(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rb");
  if (!file) return std::nullopt;
  std::string text;
  char part[4096];
  for (int n = 0; (n = gzread(file, part, sizeof(part))) > 0;) text.append(part, static_cast<std::size_t>(n));
  gzclose(file);
  if (text.empty()) return std::nullopt;
  return text;
}
#else
std::optional<std::string> unpacked_file(const std::string&) { return std::nullopt; }
#endif

// So that cpu10 comes after cpu2.
bool before(const std::string& a, const std::string& b) {
  const auto digits = [](const std::string& s) { return s.find_first_of("0123456789"); };
  const auto at = digits(a);
  if (at != digits(b) || at == std::string::npos || a.compare(0, at, b, 0, at) != 0) return a < b;
  const long x = std::strtol(a.c_str() + at, nullptr, 10), y = std::strtol(b.c_str() + at, nullptr, 10);
  return x != y ? x < y : a < b;
}

}  // namespace

SystemFiles::SystemFiles(std::string root) : root_(std::move(root)) {
  if (root_.empty() || root_.back() != '/') root_ += '/';
  config_ = unpacked_file(root_ + "proc/config.gz");
  const std::string release = text("proc/sys/kernel/osrelease").value_or("");
  if (!config_ && !release.empty()) config_ = whole_file(root_ + "boot/config-" + release);
  if (config_) config_->insert(0, "\n");  // so that every line has one before it
}

std::optional<std::string> SystemFiles::text(const std::string& name) const {
  const auto all = whole_file(root_ + name);
  if (!all) return std::nullopt;
  return trimmed(*all);
}

std::optional<std::int64_t> SystemFiles::number(const std::string& name) const {
  const auto t = text(name);
  std::int64_t value = 0;
  if (!t || std::from_chars(t->data(), t->data() + t->size(), value).ec != std::errc()) return std::nullopt;
  return value;
}

std::optional<std::string> SystemFiles::field(const std::string& name, std::string_view key) const {
  const auto all = whole_file(root_ + name);
  if (!all) return std::nullopt;
  for (std::size_t at = 0; at < all->size();) {
    const std::size_t end = std::min(all->find('\n', at), all->size());
    const auto line = std::string_view(*all).substr(at, end - at);
    if (line.starts_with(key)) return trimmed(line.substr(key.size()));
    at = end + 1;
  }
  return std::nullopt;
}

std::vector<std::string> SystemFiles::list(const std::string& folder) const {
  std::vector<std::string> names;
  if (DIR* dir = opendir((root_ + folder).c_str())) {
    while (const dirent* entry = readdir(dir))
      if (entry->d_name[0] != '.') names.emplace_back(entry->d_name);
    closedir(dir);
  }
  std::sort(names.begin(), names.end(), before);
  return names;
}

bool SystemFiles::is_folder(const std::string& name) const { return is_folder_at(root_ + name); }

bool SystemFiles::writable(const std::string& name) const { return ::access((root_ + name).c_str(), W_OK) == 0; }

std::optional<SystemFiles::Access> SystemFiles::access(const std::string& name) const {
  struct stat info {};
  if (::stat((root_ + name).c_str(), &info) != 0) return std::nullopt;
  const group* g = getgrgid(info.st_gid);
  return Access{::access((root_ + name).c_str(), R_OK | W_OK) == 0, info.st_mode & 07777u,
                g ? g->gr_name : std::to_string(info.st_gid)};
}

std::optional<std::string> SystemFiles::kernel_option(std::string_view option) const {
  if (!config_) return std::nullopt;
  const std::string line = "\n" + std::string(option) + "=";
  const auto at = config_->find(line);
  if (at == std::string::npos) return "";
  const auto value = at + line.size();
  return config_->substr(value, config_->find('\n', value) - value);
}

std::vector<int> cpu_list(std::string_view text) {
  std::vector<int> cpus;
  while (!text.empty()) {
    const auto part = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    int first = 0, last = 0;
    const char* const end = part.data() + part.size();
    const auto a = std::from_chars(part.data(), end, first);
    if (a.ec != std::errc()) continue;
    last = first;
    if (a.ptr != end && *a.ptr == '-' && std::from_chars(a.ptr + 1, end, last).ec != std::errc()) continue;
    for (int cpu = first; cpu <= last && cpu < 4096; ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

std::string to_text(const std::vector<int>& cpus) {
  std::string text;
  for (std::size_t i = 0; i < cpus.size();) {
    std::size_t last = i;
    while (last + 1 < cpus.size() && cpus[last + 1] == cpus[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += std::to_string(cpus[i]);
    if (last > i) text += (last == i + 1 ? ',' : '-') + std::to_string(cpus[last]);
    i = last + 1;
  }
  return text;
}

}  // namespace sinew::hal
