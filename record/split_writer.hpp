#pragma once
#include <functional>

#include "record/writer.hpp"

namespace sinew::record {

struct SplitOptions {
  WriterOptions writer{};
  std::uint64_t file_bytes = 0;              // about, and at least twice what a file begins with; 0: no bound
  std::chrono::nanoseconds file_duration{};  // of log time; 0: no bound
};

/// One recording in as many files as its bounds need, each complete: same channels, same attachments; sequences and
/// times continue.
///
/// Thread:  owner, an ordinary one.
///          While a file settles that was ended, and while the next one is not there yet, the present one goes on
///          beyond its bounds: write() waits for neither.
/// Errors:  those of Writer. When the next file cannot be made, the present one goes on, too. When the next file can
///          be made but not begun, the present one is whole already, and messages are refused with the reason. Either
///          is tried again Writer::kRetryAfter of log time later.
class SplitWriter {
 public:
  /// Makes file `part`, counted from 0; after a failure the same one again, over an empty file that may be left. Null,
  /// not for file 0: it is not there yet, and asked for again with the next message.
  /// Errors: any.
  using OpenPart = std::function<hal::Result<std::unique_ptr<hal::OutputFile>>(unsigned part)>;
  /// Writes the beginning of every file: metadata and attachments, no messages; after a failure all of it again. The
  /// channels need no call.
  using BeginPart = std::function<hal::Status(Writer& writer, unsigned part)>;

  static hal::Result<SplitWriter> open(OpenPart open_part, BeginPart begin_part, const SplitOptions& options);

  /// For channels, attachments and times without messages.
  Writer& writer() { return *writer_; }
  unsigned part() const { return part_; }  // the last file with a beginning, or lacking only that of BeginPart
  std::uint64_t failed_splits() const { return failed_splits_; }

  hal::Status write(std::uint16_t channel, const Stamps& stamps, std::span<const std::byte> data) {
    return write_parts(channel, stamps, {&data, 1});
  }
  hal::Status write_parts(std::uint16_t channel, const Stamps& stamps, hal::Parts parts);
  /// Completes the last file and the one before it. On an error it may be tried again. After a failure an empty file
  /// may be left behind it.
  hal::Status finish();

  /// Messages before this log time do not count for the duration of a file.
  void count_from(std::uint64_t log_time) { counts_from_ = log_time; }

 private:
  SplitWriter(OpenPart open_part, BeginPart begin_part, const SplitOptions& options)
      : open_part_(std::move(open_part)), begin_part_(std::move(begin_part)), options_(options) {}
  bool usable() const { return writer_->is_open() && begun_; }
  bool due(std::uint64_t log_time) const;
  hal::Status make_part(std::uint64_t log_time);
  hal::Result<std::unique_ptr<hal::OutputFile>> next_file();
  hal::Status split(std::unique_ptr<hal::OutputFile> file);
  hal::Status begin();

  OpenPart open_part_;
  BeginPart begin_part_;
  SplitOptions options_;
  std::unique_ptr<Writer> writer_;
  std::unique_ptr<hal::OutputFile> completing_;  // the file before, until it has settled
  unsigned part_ = 0;
  std::uint64_t failed_splits_ = 0;
  hal::Status last_{};  // of the last attempt to split or to begin
  std::uint64_t counts_from_ = 0;
  std::uint64_t attempted_at_ = 0;  // log time
  std::uint64_t begin_bytes_ = 0;   // what the present file begins with
  bool begun_ = false;              // the beginning is written
  bool finished_ = false;
};

}  // namespace sinew::record
