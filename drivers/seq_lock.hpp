#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sinew::drivers {

/// A value that one thread writes and others copy, none of them waiting: a reader that met the writer looks again.
/// Thread:  store(): one; load(): any.   RT: yes; load() gives up after kTries and leaves `out` as it was.
template <class T>
class SeqLock {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  SeqLock() { store(T{}); }
  void store(const T& value) noexcept {
    std::array<Word, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint32_t before = sequence_.load(std::memory_order_relaxed);
    sequence_.store(before + 1, std::memory_order_relaxed);
    // release, each with the acquire of load(): whoever sees a new word also sees the odd number before it.
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    sequence_.store(before + 2, std::memory_order_release);  // pairs with load's first: all words are there
  }
  bool load(T& out) const noexcept {
    std::array<Word, kWords> words;
    for (int tries = 0; tries < kTries; ++tries) {
      const std::uint32_t before = sequence_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if ((before & 1) != 0 || sequence_.load(std::memory_order_relaxed) != before) continue;
      std::memcpy(static_cast<void*>(&out), words.data(), sizeof(T));
      return true;
    }
    return false;
  }

 private:
  using Word = std::size_t;  // what the machine reads at once
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(Word) - 1) / sizeof(Word);
  static constexpr int kTries = 64;  // the writer may be a thread of lower priority, in the middle of a store
  std::atomic<std::uint32_t> sequence_{0};
  std::array<std::atomic<Word>, kWords> words_{};
};

}  // namespace sinew::drivers
