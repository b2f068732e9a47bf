#pragma once
#include <memory>
#include <string>

namespace sinew::monitor {

/// The token of this monitor in the run folder, `monitor-PID.token`, for its user alone (mode 0600), as long as it
/// runs. Thread:  owner.
class TokenFile {
 public:
  /// Errors: null, with `why`: the run folder, no random numbers, the disk.
  static std::unique_ptr<TokenFile> make(std::string& why);
  ~TokenFile();
  TokenFile(const TokenFile&) = delete;
  TokenFile& operator=(const TokenFile&) = delete;

  const std::string& token() const { return token_; }
  const std::string& path() const { return path_; }

 private:
  TokenFile(std::string token, std::string path) : token_(std::move(token)), path_(std::move(path)) {}
  const std::string token_, path_;
};

}  // namespace sinew::monitor
