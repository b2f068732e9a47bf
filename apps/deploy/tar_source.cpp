#include "apps/deploy/tar_source.hpp"

#include <algorithm>
#include <filesystem>

#include "apps/deploy/tar_stream.hpp"

namespace sinew::app {

std::string_view TarSource::fail(std::string why) {
  failure_ = std::move(why);
  state_ = State::over;
  return {};
}

std::string_view TarSource::next() {
  switch (state_) {
    case State::header:
      return index_ < files_.size() ? header() : (state_ = State::over, text_.assign(kTarEnd_bytes, '\0'), text_);
    case State::content:
      return content();
    case State::end:
      state_ = State::header;
      ++index_;
      text_ = tar_padding(size_);
      return text_.empty() ? next() : std::string_view(text_);
    case State::over:
      return {};
  }
  return {};
}

std::string_view TarSource::header() {
  const DeployFile& file = files_[index_];
  std::error_code error;
  size_ = left_ = file.text.empty() ? std::filesystem::file_size(file.from, error) : file.text.size();
  in_ = std::ifstream(file.from, std::ios::binary);
  if (error || !in_) return fail(file.from + ": cannot be read");
  const auto changed = std::filesystem::last_write_time(file.from, error);
  const auto system = std::chrono::file_clock::to_sys(changed);
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(system.time_since_epoch()).count();
  text_ = tar_header(file.name, size_, file.executable, error ? 0 : seconds);
  if (text_.empty()) return fail(file.from + ": its name is too long, or the file too large");
  state_ = left_ > 0 ? State::content : State::end;
  return text_;
}

std::string_view TarSource::content() {
  if (const DeployFile& file = files_[index_]; !file.text.empty()) {
    left_ = 0;
    state_ = State::end;
    return file.text;
  }
  const auto wanted = std::min<std::uint64_t>(left_, buffer_.size());
  in_.read(buffer_.data(), static_cast<std::streamsize>(wanted));
  const auto got = static_cast<std::size_t>(in_.gcount());
  if (got < wanted) return fail(files_[index_].from + ": became shorter while it was sent");
  left_ -= got;
  if (left_ == 0) state_ = State::end;
  return {buffer_.data(), got};
}

}  // namespace sinew::app
