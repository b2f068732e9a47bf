#include "tap/topic_notifier.hpp"

#include <algorithm>

namespace sinew::tap {

hal::Result<std::unique_ptr<TopicNotifier>> TopicNotifier::open(const rt::Segment& segment, rt::OutsideBells& bells,
                                                                hal::Os& os) {
  std::unique_ptr<TopicNotifier> notifier(new TopicNotifier(segment, bells, os));
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
  for (const auto& [client, wish] : wishes_)
    for (const rt::WriterId w : wish.at_once) bells_.end_asking(w);
  for (rt::WriterId w = 0; w < segment_.header().writer_count; ++w) bells_.ring(w, number_of(w) + 1);
}

void TopicNotifier::subscribe(std::uint64_t client, Wish wish) {
  {
    const std::lock_guard lock(mutex_);
    for (const rt::WriterId w : wish.at_once) bells_.ask(w);  // first: a writer of both lists goes on ringing
    if (const auto old = wishes_.find(client); old != wishes_.end()) {
      for (const rt::WriterId w : old->second.at_once) bells_.end_asking(w);
      wishes_.erase(old);
    }
    if (!wish.writers.empty() || !wish.at_once.empty()) wishes_[client] = std::move(wish);
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

/// Answers the number that the word has now. A writer may ring its own word meanwhile (Wish::at_once): an older number
/// never stays on top of a newer one.
std::uint32_t TopicNotifier::ring(rt::WriterId writer) {
  for (;;) {
    const std::uint32_t number = number_of(writer);
    bells_.ring(writer, number);
    if (number_of(writer) == number) return number;
  }
}

/// Answers how long to wait before the next look; Duration::max() when no client subscribes.
hal::Duration TopicNotifier::look_at_all(std::vector<std::uint32_t>& seen) {
  const std::lock_guard lock(mutex_);
  hal::Duration period = hal::Duration::max();
  for (const auto& [client, wish] : wishes_) {
    if (!wish.writers.empty()) period = std::min(period, wish.period);
    for (const rt::WriterId w : wish.writers) {
      if (number_of(w) != seen[w]) seen[w] = ring(w);
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
