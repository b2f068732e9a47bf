#include "monitor/token_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "hal/linux/run_dir.hpp"
#include "monitor/gate.hpp"

namespace sinew::monitor {

std::unique_ptr<TokenFile> TokenFile::make(std::string& why) {
  std::string folder;
  if (const auto got = hal::run_dir(folder); !got) {
    why = fmt::format("run folder {}: {}", folder, hal::to_string(got.error().code));
    return nullptr;
  }
  const std::string token = new_token();
  if (token.empty()) {
    why = "the system gives no random numbers";
    return nullptr;
  }
  const std::string path = fmt::format("{}/monitor-{}.token", folder, getpid());
  unlink(path.c_str());  // of a killed one with our number
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const std::string line = token + "\n";
  const bool written = fd >= 0 && write(fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  if (!written) why = fmt::format("{}: {}", path, std::strerror(errno));
  if (fd >= 0) close(fd);
  if (!written) return nullptr;
  return std::unique_ptr<TokenFile>(new TokenFile(token, path));
}

TokenFile::~TokenFile() { unlink(path_.c_str()); }

}  // namespace sinew::monitor
