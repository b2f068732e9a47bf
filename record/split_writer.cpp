#include "record/split_writer.hpp"

namespace sinew::record {

hal::Result<SplitWriter> SplitWriter::open(OpenPart open_part, BeginPart begin_part, const SplitOptions& options) {
  SplitWriter split(std::move(open_part), std::move(begin_part), options);
  auto file = split.open_part_(0);
  if (!file) return file.error();
  auto writer = Writer::open(std::move(*file), options.writer);
  if (!writer) return writer.error();
  split.writer_ = std::move(*writer);
  if (auto done = split.begin(); !done) return done.error();
  return split;
}

bool SplitWriter::due(std::uint64_t log_time) const {
  if (!writer_->is_open()) return true;  // the next file could not even be begun
  if (writer_->counters().chunks < retry_chunk_) return false;
  if (options_.file_bytes != 0 && writer_->bytes_planned() >= options_.file_bytes) return true;
  const std::uint64_t first = writer_->first_time();
  const auto duration = static_cast<std::uint64_t>(options_.file_duration.count());
  return duration != 0 && first != 0 && log_time > first && log_time - first >= duration;
}

hal::Status SplitWriter::split() {
  auto file = open_part_(part_ + 1);
  if (!file) return file.error();
  if (auto done = writer_->continue_in(std::move(*file)); !done) return done;
  ++part_;
  begun_ = false;
  return {};
}

hal::Status SplitWriter::begin() {
  if (begin_part_)
    if (auto done = begin_part_(*writer_, part_); !done) return done;
  begun_ = true;
  return {};
}

hal::Status SplitWriter::write_parts(std::uint16_t channel, const Stamps& stamps, hal::Parts parts) {
  if (finished_) return hal::Error{hal::Errc::closed, "record: the recording is finished"};
  if (due(stamps.log_time) && !split()) {
    ++failed_splits_;
    retry_chunk_ = writer_->counters().chunks + 1;
  }
  if (!begun_ && writer_->is_open())
    if (auto done = begin(); !done) return done;
  return writer_->write_parts(channel, stamps, parts);
}

hal::Status SplitWriter::finish() {
  auto done = writer_->finish();
  finished_ = finished_ || bool(done);
  return done;
}

}  // namespace sinew::record
