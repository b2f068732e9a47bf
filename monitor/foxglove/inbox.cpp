#include "monitor/foxglove/inbox.hpp"

#include <utility>

namespace sinew::foxglove {

Inbox::~Inbox() {
  for (const Item& item : items_) backlog_->bytes.fetch_sub(item.payload->size());
}

void Inbox::drop_oldest() {
  backlog_->bytes.fetch_sub(items_.front().payload->size());
  items_.pop_front();
  dropped_.fetch_add(1, std::memory_order_relaxed);
}

void Inbox::put(Item item) {
  const std::size_t size = item.payload->size();
  {
    const std::lock_guard lock(mutex_);
    while (items_.size() >= most_ || (!items_.empty() && backlog_->bytes.load() + size > Backlog::kMostBytes))
      drop_oldest();
    backlog_->bytes.fetch_add(size);
    items_.push_back(std::move(item));
  }
  backlog_->tell();
}

std::optional<Item> Inbox::take() {
  const std::lock_guard lock(mutex_);
  if (items_.empty()) return std::nullopt;
  Item item = std::move(items_.front());
  items_.pop_front();
  backlog_->bytes.fetch_sub(item.payload->size());
  return item;
}

}  // namespace sinew::foxglove
