#include "tap/topic_notifier.hpp"

#include <algorithm>
#include <new>

#include "hal/linux/shared_memory.hpp"

namespace sinew::tap {

static_assert(sizeof(hal::WakeWord) == 4 && hal::WakeWord::is_always_lock_free, "other processes map the page");

TopicNotifier::TopicNotifier(const rt::Segment& segment, hal::Os& os, std::unique_ptr<hal::SharedMemory> page)
    : segment_(segment), os_(os), page_(std::move(page)) {
  new (page_->data()) hal::WakeWord[segment.header().writer_count]{};
}

hal::Result<std::unique_ptr<TopicNotifier>> TopicNotifier::open(const rt::Segment& segment, hal::Os& os) {
  auto page = os.shared_memory("sinew doorbells", segment.header().writer_count * sizeof(hal::WakeWord));
  if (!page) return page.error();
  std::unique_ptr<TopicNotifier> notifier(new TopicNotifier(segment, os, std::move(*page)));
  auto thread = os.start_thread({.name = "doorbells", .cpus = {}, .stack_bytes = 64 * 1024, .nice = 5},
                                [n = notifier.get()] { n->run(); });
  if (!thread) return thread.error();
  notifier->thread_ = std::move(*thread);
  return notifier;
}

TopicNotifier::~TopicNotifier() {
  end_.store(true, std::memory_order_relaxed);
  changed_.fetch_add(1, std::memory_order_release);
  os_.wake(changed_);
  thread_.reset();
  for (rt::WriterId w = 0; w < segment_.header().writer_count; ++w) ring(w, number_of(w) + 1);
}

void TopicNotifier::subscribe(std::uint64_t client, std::vector<rt::WriterId> writers, hal::Duration period) {
  {
    const std::lock_guard lock(mutex_);
    if (writers.empty())
      wishes_.erase(client);
    else
      wishes_[client] = {std::move(writers), period};
  }
  changed_.fetch_add(1, std::memory_order_release);
  os_.wake(changed_);
}

bool TopicNotifier::subscribes(std::uint64_t client) const {
  const std::lock_guard lock(mutex_);
  return wishes_.contains(client);
}

std::uint32_t TopicNotifier::number_of(rt::WriterId writer) const {
  const auto* base = reinterpret_cast<const std::byte*>(&segment_.header());
  const auto* word = reinterpret_cast<const rt::StdAtomics::Word*>(base + segment_.writer_entry(writer).number);
  return word->load(std::memory_order_relaxed);  // says only that there is something new; the reader looks for itself
}

void TopicNotifier::ring(rt::WriterId writer, std::uint32_t number) {
  hal::WakeWord& word = reinterpret_cast<hal::WakeWord*>(page_->data())[writer];
  word.store(number, std::memory_order_relaxed);
  hal::wake_shared(word);
}

/// Answers how long to wait before the next look; Duration::max() when no client subscribes.
hal::Duration TopicNotifier::look_at_all(std::vector<std::uint32_t>& seen) {
  const std::lock_guard lock(mutex_);
  hal::Duration period = hal::Duration::max();
  for (const auto& [client, wish] : wishes_) {
    period = std::min(period, wish.period);
    for (const rt::WriterId w : wish.writers) {
      const std::uint32_t number = number_of(w);
      if (number == seen[w]) continue;
      seen[w] = number;
      ring(w, number);
    }
  }
  return period;
}

void TopicNotifier::run() {
  std::vector<std::uint32_t> seen(segment_.header().writer_count, 0);
  while (!end_.load(std::memory_order_relaxed)) {
    const std::uint32_t before = changed_.load(std::memory_order_acquire);
    const hal::Duration period = look_at_all(seen);
    if (end_.load(std::memory_order_relaxed)) return;
    os_.wait(changed_, before, period == hal::Duration::max() ? hal::kNever : os_.now() + period);
  }
}

}  // namespace sinew::tap
