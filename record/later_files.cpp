#include "record/later_files.hpp"

namespace sinew::record {

LaterFiles::~LaterFiles() {
  thread_.reset();  // joins
  // An empty file that cannot be removed stays, as after a failure to begin it.
  if (made_ && *made_) static_cast<void>((**made_)->remove());
}

hal::Result<std::unique_ptr<hal::OutputFile>> LaterFiles::open(unsigned part) {
  if (part == 0) return open_part_(0);
  if (!thread_) {
    hal::ThreadOptions thread;
    thread.name = "record_file";
    thread.stack_bytes = 64 * 1024;
    thread.nice = -10;  // as the recorder, which joins it
    auto started = os_.start_thread(thread, [this, part] { make(part); });
    if (!started) return started.error();
    thread_ = std::move(*started);
    return std::unique_ptr<hal::OutputFile>();
  }
  {
    const std::lock_guard lock(mutex_);
    if (!made_) return std::unique_ptr<hal::OutputFile>();
  }
  thread_.reset();  // it has nothing left to do
  Made made = std::move(*made_);
  made_.reset();
  return made;
}

void LaterFiles::make(unsigned part) {
  auto made = open_part_(part);
  const std::lock_guard lock(mutex_);
  made_.emplace(std::move(made));
}

}  // namespace sinew::record
