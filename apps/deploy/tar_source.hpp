#pragma once
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "apps/deploy/deploy_plan.hpp"

namespace sinew::app {

/// Files as a tar stream, piece by piece.
/// Thread:  owner.
class TarSource {
 public:
  explicit TarSource(const std::vector<DeployFile>& files) : files_(files), buffer_(1 << 18, '\0') {}
  /// Valid until the next call; empty: that was all, or it failed.
  std::string_view next();
  /// Why the stream is not whole; empty: it is.
  const std::string& failure() const { return failure_; }

 private:
  enum class State { header, content, end, over };
  std::string_view header();
  std::string_view content();
  std::string_view fail(std::string why);

  const std::vector<DeployFile>& files_;
  std::string buffer_, text_, failure_;
  std::ifstream in_;
  std::size_t index_ = 0;
  std::uint64_t size_ = 0, left_ = 0;
  State state_ = State::header;
};

}  // namespace sinew::app
