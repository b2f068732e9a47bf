#include "record/split_writer.hpp"

#include <algorithm>

namespace sinew::record {

hal::Result<SplitWriter> SplitWriter::open(OpenPart open_part, BeginPart begin_part, const SplitOptions& options) {
  SplitWriter split(std::move(open_part), std::move(begin_part), options);
  auto file = split.open_part_(0);
  if (!file) return file.error();
  if (!*file) return hal::Error{hal::Errc::bad_argument, "record: no first file"};
  auto writer = Writer::open(std::move(*file), options.writer);
  if (!writer) return writer.error();
  split.writer_ = std::move(*writer);
  if (auto done = split.begin(); !done) return done.error();
  return split;
}

bool SplitWriter::due(std::uint64_t log_time) const {
  if (!writer_->is_open()) return true;  // the next file could not even be begun
  // Otherwise each message would get a file when the files' beginnings are larger than the bound.
  const std::uint64_t most = std::max(options_.file_bytes, 2 * begin_bytes_);
  if (options_.file_bytes != 0 && writer_->bytes_planned() >= most) return true;
  auto first = writer_->first_time();
  if (first) *first = std::max(*first, counts_from_);
  const auto duration = static_cast<std::uint64_t>(options_.file_duration.count());
  return duration != 0 && first && log_time > *first && log_time - *first >= duration;
}

/// Makes another file when one is due, and completes the beginning of the present file if it is missing.
hal::Status SplitWriter::make_part(std::uint64_t log_time) {
  constexpr auto kWait = static_cast<std::uint64_t>(std::chrono::nanoseconds(Writer::kRetryAfter).count());
  if (completing_ && completing_->settled()) completing_.reset();
  const bool is_due = due(log_time);
  if (begun_ && !is_due) return last_;
  if (!last_ && log_time >= attempted_at_ && log_time - attempted_at_ < kWait) return last_;
  attempted_at_ = log_time;
  if (is_due) {
    auto next = next_file();
    if (next && !*next) {
      if (usable()) last_ = {};
      return last_;
    }
    last_ = next ? split(std::move(*next)) : hal::Status(next.error());
    if (!last_) ++failed_splits_;
  } else {
    last_ = {};
  }
  if (last_ && !begun_) last_ = begin();
  return last_;
}

/// Null: the present file goes on.
hal::Result<std::unique_ptr<hal::OutputFile>> SplitWriter::next_file() {
  // With two files that have not settled, a third one would only take more threads and memory.
  if (writer_->is_open() && completing_) return std::unique_ptr<hal::OutputFile>();
  if (auto room = writer_->room(); !room) return room.error();  // ending this file would use the free floor
  return open_part_(part_ + 1);
}

hal::Status SplitWriter::split(std::unique_ptr<hal::OutputFile> file) {
  if (auto done = writer_->continue_in(std::move(file), completing_); !done) return done;
  ++part_;
  begun_ = false;
  return {};
}

hal::Status SplitWriter::begin() {
  if (begin_part_)
    if (auto done = writer_->begin_with([this](Writer& writer) { return begin_part_(writer, part_); }); !done)
      return done;
  begun_ = true, begin_bytes_ = writer_->bytes_planned();
  return {};
}

hal::Status SplitWriter::write_parts(std::uint16_t channel, const Stamps& stamps, hal::Parts parts) {
  if (finished_) return hal::Error{hal::Errc::closed, "record: the recording is finished"};
  if (auto done = make_part(stamps.log_time); !done && !usable()) return done;
  return writer_->write_parts(channel, stamps, parts);
}

hal::Status SplitWriter::finish() {
  if (finished_) return hal::Error{hal::Errc::closed, "record: the recording is finished"};
  if (writer_->is_open()) {  // otherwise the last file is whole, and the next was never begun
    if (!begun_)
      if (auto done = begin(); !done) return done;
    if (auto done = writer_->finish(); !done) return done;
  }
  if (completing_)
    if (auto done = completing_->settle(); !done) return done;
  completing_.reset();
  open_part_ = {};
  finished_ = true;
  return {};
}

}  // namespace sinew::record
