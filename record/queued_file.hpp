#pragma once
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "hal/file.hpp"
#include "hal/os.hpp"

namespace sinew::record {

/// The memory in which bytes wait for one disk, of all files that a recording has open there.
/// Thread:  any; its files lock it.
class QueueMemory {
 public:
  explicit QueueMemory(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}

 private:
  friend class QueuedFile;
  const std::uint64_t most_bytes_;
  std::mutex mutex_;              // of all below, and of the files
  std::condition_variable done_;  // wakes owners of files
  std::uint64_t waiting_bytes_ = 0;
  hal::Result<std::uint64_t> free_ = std::uint64_t{0};  // of the disk, after the last write
};

/// A file whose bytes wait in memory while the disk stalls: append() copies them and returns, a thread of its own
/// writes them. Memory is taken while bytes wait, and given back when they are written.
/// Thread:  owner. The file below is used by the writing thread, and by the owner while that one has nothing to do.
/// Errors:  append(): while the disk refuses what waits, its error, and nothing is taken; the thread tries what waits
///          every 100 ms. settle(): the error of what is not in the file yet. sync(): that of an earlier one.
class QueuedFile final : public hal::OutputFile {
 public:
  /// An append() beyond the memory's bound waits for the disk, unless nothing of this file waits yet.
  /// Errors:  those of starting a thread.
  static hal::Result<std::unique_ptr<hal::OutputFile>> open(std::unique_ptr<hal::OutputFile> file,
                                                            std::shared_ptr<QueueMemory> memory, hal::Os& os);
  ~QueuedFile() override;  // writes what waits, unless the disk refuses it

  hal::Status append(hal::Parts parts) noexcept override;
  /// Asks the thread to sync when it has written everything; never waits.
  hal::Status sync() noexcept override;
  hal::Status cut(std::uint64_t size) noexcept override;
  /// Of the disk without what waits; while the disk stalls, as it was before.
  hal::Result<std::uint64_t> free_bytes() noexcept override;
  hal::Status settle() noexcept override;
  bool settled() noexcept override;
  hal::Status remove() noexcept override;

 private:
  using Lock = std::unique_lock<std::mutex>;
  QueuedFile(std::unique_ptr<hal::OutputFile> file, std::shared_ptr<QueueMemory> memory)
      : file_(std::move(file)), memory_(std::move(memory)) {}
  bool idle() const { return !busy_ && (waiting_.empty() || refused_); }
  std::uint64_t size() const { return written_ + waiting_bytes_; }
  void give_back(std::uint64_t bytes) { waiting_bytes_ -= bytes, memory_->waiting_bytes_ -= bytes; }
  void write();
  void write_one(Lock& lock);
  void sync_all(Lock& lock);

  const std::unique_ptr<hal::OutputFile> file_;
  const std::shared_ptr<QueueMemory> memory_;   // its mutex is that of all below
  std::condition_variable asked_;               // wakes the thread
  std::deque<std::vector<std::byte>> waiting_;  // the first one is being written while busy_
  std::uint64_t waiting_bytes_ = 0, written_ = 0;
  std::uint64_t attempts_ = 0;  // to write, that ended
  bool busy_ = false, sync_asked_ = false, stop_ = false;
  bool torn_ = false;  // a part of the first one may be in the file; the thread's
  std::optional<hal::Error> refused_, sync_failed_;
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::record
