#include "record/queued_file.hpp"

#include <algorithm>
#include <chrono>
#include <new>

namespace sinew::record {
namespace {

constexpr std::chrono::milliseconds kTryAgain{100};

}  // namespace

hal::Result<std::unique_ptr<hal::OutputFile>> QueuedFile::open(std::unique_ptr<hal::OutputFile> file,
                                                               std::shared_ptr<QueueMemory> memory, hal::Os& os) {
  const auto free = file->free_bytes();
  {
    const Lock lock(memory->mutex_);
    memory->free_ = free;
  }
  std::unique_ptr<QueuedFile> queued(new QueuedFile(std::move(file), std::move(memory)));
  hal::ThreadOptions thread;
  thread.name = "record_disk";
  thread.stack_bytes = 64 * 1024;
  thread.nice = -10;  // as the recorder: what else the machine does shall not fill the memory
  auto started = os.start_thread(thread, [writer = queued.get()] { writer->write(); });
  if (!started) return started.error();
  queued->thread_ = std::move(*started);
  return std::unique_ptr<hal::OutputFile>(std::move(queued));
}

QueuedFile::~QueuedFile() {
  {
    const Lock lock(memory_->mutex_);
    stop_ = true;
  }
  asked_.notify_all();
  thread_.reset();  // joins
  const Lock lock(memory_->mutex_);
  give_back(waiting_bytes_);
}

hal::Status QueuedFile::append(hal::Parts parts) noexcept {
  std::size_t bytes = 0;
  for (const auto& part : parts) bytes += part.size();
  try {
    std::vector<std::byte> block;
    block.reserve(bytes);
    for (const auto& part : parts) block.insert(block.end(), part.begin(), part.end());
    Lock lock(memory_->mutex_);
    memory_->done_.wait(
        lock, [&] { return refused_ || waiting_.empty() || memory_->waiting_bytes_ + bytes <= memory_->most_bytes_; });
    if (refused_) return *refused_;
    waiting_.push_back(std::move(block));
    waiting_bytes_ += bytes, memory_->waiting_bytes_ += bytes;
  } catch (const std::bad_alloc&) {
    return hal::Error{hal::Errc::out_of_memory, "record: no memory for what waits for the disk"};
  }
  asked_.notify_all();
  return {};
}

hal::Status QueuedFile::sync() noexcept {
  std::optional<hal::Error> failed;
  {
    const Lock lock(memory_->mutex_);
    sync_asked_ = true;
    failed.swap(sync_failed_);
  }
  asked_.notify_all();
  if (failed) return *failed;
  return {};
}

hal::Status QueuedFile::cut(std::uint64_t to) noexcept {
  Lock lock(memory_->mutex_);
  memory_->done_.wait(lock, [this] { return !busy_; });
  while (!waiting_.empty() && size() > to) {
    std::vector<std::byte>& last = waiting_.back();
    const std::uint64_t too_much = std::min<std::uint64_t>(size() - to, last.size());
    give_back(too_much);
    last.resize(static_cast<std::size_t>(last.size() - too_much));
    if (last.empty()) waiting_.pop_back();
  }
  if (waiting_.empty()) refused_.reset();
  if (written_ <= to) return {};
  auto done = file_->cut(to);
  if (done) written_ = to;
  return done;
}

hal::Result<std::uint64_t> QueuedFile::free_bytes() noexcept {
  const Lock lock(memory_->mutex_);
  auto& free = memory_->free_;
  if (idle()) free = file_->free_bytes();
  if (!free) return free;
  return *free - std::min(*free, memory_->waiting_bytes_);
}

hal::Status QueuedFile::settle() noexcept {
  Lock lock(memory_->mutex_);
  const std::uint64_t attempts = attempts_ + (busy_ ? 1 : 0);
  memory_->done_.wait(lock,
                      [&] { return waiting_.empty() ? !busy_ && !sync_asked_ : refused_ && attempts_ > attempts; });
  if (!waiting_.empty()) return *refused_;
  return {};
}

bool QueuedFile::settled() noexcept {
  const Lock lock(memory_->mutex_);
  return waiting_.empty() && !busy_ && !sync_asked_;
}

hal::Status QueuedFile::remove() noexcept {
  if (auto done = cut(0); !done) return done;
  return file_->remove();
}

// ---- the thread

void QueuedFile::write() {
  Lock lock(memory_->mutex_);
  while (true) {
    if (refused_)
      asked_.wait_for(lock, kTryAgain, [this] { return stop_ || waiting_.empty(); });
    else
      asked_.wait(lock, [this] { return stop_ || sync_asked_ || !waiting_.empty(); });
    if (!waiting_.empty())
      write_one(lock);
    else if (sync_asked_)
      sync_all(lock);
    if (stop_ && (refused_ || (waiting_.empty() && !sync_asked_))) return;
  }
}

void QueuedFile::write_one(Lock& lock) {
  busy_ = true;
  const std::uint64_t at = written_;
  const std::span<const std::byte> block = waiting_.front();  // a deque keeps it in its place
  lock.unlock();
  hal::Status done = torn_ ? file_->cut(at) : hal::Status{};
  if (done) done = file_->append({&block, 1});
  torn_ = !done && !file_->cut(at);
  auto free = file_->free_bytes();
  lock.lock();
  busy_ = false;
  ++attempts_;
  refused_.reset();
  if (!done) refused_ = done.error();
  memory_->free_ = free;
  if (done) {
    written_ += block.size();
    give_back(block.size());
    waiting_.pop_front();
  }
  memory_->done_.notify_all();
}

void QueuedFile::sync_all(Lock& lock) {
  busy_ = true;
  sync_asked_ = false;  // for what was appended up to here
  lock.unlock();
  hal::Status done = file_->sync();
  lock.lock();
  busy_ = false;
  if (!done) sync_failed_ = done.error();
  memory_->done_.notify_all();
}

}  // namespace sinew::record
