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
  /// The next piece, valid until the next call; empty: the end, or a failure.
  std::string_view next();
  /// Why the stream is incomplete; empty: it is complete.
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
