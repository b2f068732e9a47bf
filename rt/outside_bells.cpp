#include "rt/outside_bells.hpp"

#include <algorithm>
#include <new>

namespace sinew::rt {

static_assert(sizeof(hal::WakeWord) == 4 && hal::WakeWord::is_always_lock_free, "other processes map the page");

OutsideBells::OutsideBells(std::unique_ptr<hal::SharedMemory> page, std::uint32_t writers)
    : page_(std::move(page)), askers_(writers) {
  new (page_->data()) hal::WakeWord[writers]{};
}

hal::Result<std::unique_ptr<OutsideBells>> OutsideBells::make(hal::Os& os, std::uint32_t writers) {
  auto page = os.shared_memory("sinew doorbells", std::max(writers, 1u) * sizeof(hal::WakeWord));
  if (!page) return page.error();
  return std::unique_ptr<OutsideBells>(new OutsideBells(std::move(*page), writers));
}

void OutsideBells::ring(WriterId writer, std::uint32_t number) noexcept {
  hal::WakeWord& word = reinterpret_cast<hal::WakeWord*>(page_->data())[writer];
  word.store(number, std::memory_order_relaxed);  // says only that there is something new; readers look for themselves
  page_->wake_all(word);
}

}  // namespace sinew::rt
