#pragma once
#include <mutex>
#include <optional>

#include "hal/os.hpp"
#include "record/split_writer.hpp"

namespace sinew::record {

/// The files of a split recording; all but the first one are made on a thread of their own: while a disk stalls, making
/// a file takes as long as the stall.
/// Thread:  owner, an ordinary one. `open_part` is called by the owner for file 0, and by a thread, one at a time, for
///          the later ones.
class LaterFiles {
 public:
  LaterFiles(SplitWriter::OpenPart open_part, hal::Os& os) : open_part_(std::move(open_part)), os_(os) {}
  ~LaterFiles();  // waits for the file that is being made, and removes one that nobody took

  /// As SplitWriter::OpenPart. Waits for file 0; for a later one, the first call begins to make it and answers null.
  /// Errors:  those of `open_part`; those of starting a thread.
  hal::Result<std::unique_ptr<hal::OutputFile>> open(unsigned part);

 private:
  using Made = hal::Result<std::unique_ptr<hal::OutputFile>>;
  void make(unsigned part);

  const SplitWriter::OpenPart open_part_;
  hal::Os& os_;
  std::mutex mutex_;  // of made_
  std::optional<Made> made_;
  std::unique_ptr<hal::Thread> thread_;  // null: none has been asked for since the last one was taken
};

}  // namespace sinew::record
