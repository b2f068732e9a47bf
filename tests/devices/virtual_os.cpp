#include "virtual_os.hpp"

#include <algorithm>

namespace sinew::test {
namespace {
VirtualOs* the_one = nullptr;
}

/// Joins by letting the thread run to its end.
class VirtualOs::Handle final : public hal::Thread {
 public:
  Handle(VirtualOs& os, Task& task) : os_(os), task_(task) {}
  ~Handle() override { Handle::join(); }
  void join() override { os_.join(task_); }
  const std::string& shortfall() const override { return none_; }

 private:
  VirtualOs& os_;
  Task& task_;
  std::string none_;
};

VirtualOs::VirtualOs() {
  clock.set({1'000'000'000});
  the_one = this;
}
VirtualOs::~VirtualOs() {
  for (const auto& task : tasks_) join(*task);
  the_one = nullptr;
}

VirtualOs* VirtualOs::current() noexcept { return the_one; }

VirtualOs::Task*& VirtualOs::mine() noexcept {
  thread_local Task* task = nullptr;
  return task;
}

hal::Result<std::unique_ptr<hal::Thread>> VirtualOs::start_thread(const hal::ThreadOptions&,
                                                                  std::function<void()> body) {
  tasks_.push_back(std::make_unique<Task>());
  Task& task = *tasks_.back();
  task.body = std::move(body);
  task.due = now();
  task.thread = std::thread([this, &task] {
    mine() = &task;
    {
      std::unique_lock lock(mutex_);
      moved_.wait(lock, [&task] { return task.runs; });
    }
    task.body();
    const std::lock_guard lock(mutex_);
    task.ended = true;
    task.runs = false;
    moved_.notify_all();
  });
  return std::unique_ptr<hal::Thread>(new Handle(*this, task));
}

/// Called by the task itself: lets the task that started it go on, until its own turn comes again.
void VirtualOs::block(Task& task) {
  std::unique_lock lock(mutex_);
  task.runs = false;
  moved_.notify_all();
  moved_.wait(lock, [&task] { return task.runs; });
}

void VirtualOs::hand_over(Task& task) {
  std::unique_lock lock(mutex_);
  task.word = nullptr;
  task.fds = nullptr;
  task.runs = true;
  moved_.notify_all();
  moved_.wait(lock, [&task] { return !task.runs; });
}

VirtualOs::Task* VirtualOs::next_due(hal::Time t) {
  Task* next = nullptr;
  for (const auto& task : tasks_) {
    if (task->ended) continue;
    if (task->fds && ::poll(task->fds, task->fd_count, 0) > 0) task->due = now();
    if (task->due <= t && (!next || task->due < next->due)) next = task.get();
  }
  return next;
}

void VirtualOs::run_until(hal::Time t) {
  while (Task* task = next_due(t)) {
    if (task->due > now()) clock.set(task->due);
    hand_over(*task);
  }
  if (t > now()) clock.set(t);
}

void VirtualOs::join(Task& task) {
  if (!task.thread.joinable()) return;
  while (!task.ended) {
    Task* next = next_due(hal::kNever);
    if (next->due > now()) clock.set(next->due);
    hand_over(*next);
  }
  task.thread.join();
}

void VirtualOs::sleep_until(hal::Time t) noexcept {
  Task* task = mine();
  if (!task) return run_until(t);
  task->due = t;
  block(*task);
}

void VirtualOs::wait(hal::WakeWord& word, std::uint32_t expected, hal::Time deadline) noexcept {
  if (word.load() != expected) return;
  Task* task = mine();
  if (!task) return run_until(deadline);
  task->due = deadline;
  task->word = &word;
  block(*task);
}

void VirtualOs::wake(hal::WakeWord& word) noexcept {
  for (const auto& task : tasks_)
    if (task->word == &word) task->due = now();
}

std::optional<int> VirtualOs::poll(pollfd* fds, nfds_t count, hal::Time deadline) noexcept {
  Task* task = mine();
  if (!task) return std::nullopt;
  const int ready = ::poll(fds, count, 0);
  if (ready != 0 || deadline <= now()) return ready;
  task->due = deadline;
  task->fds = fds;
  task->fd_count = count;
  block(*task);
  return ::poll(fds, count, 0);
}

}  // namespace sinew::test
