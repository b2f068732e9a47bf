#pragma once
#include <deque>
#include <memory>
#include <vector>

#include "record/run/run_messages.hpp"
#include "rt/port.hpp"

namespace sinew::record {

/// Messages of one topic from a file, each behind a header as in its slot, for as long as steps may need them.
/// Thread:  owner.
class MessageStore {
 public:
  explicit MessageStore(const msg::TypeInfo& type) : type_(&type) {}
  MessageStore(MessageStore&&) = default;
  MessageStore(const MessageStore&) = delete;

  struct Entry {
    std::uint32_t sequence = 0;
    rt::Time published;
    bool whole = false;               // with its bulk
    std::optional<ImageHead> head{};  // images
    std::unique_ptr<std::byte[], void (*)(std::byte*)> memory{nullptr, nullptr};
    std::size_t capacity = 0;  // room for the bulk
    std::size_t pixels = 0;    // pixels that came

    const rt::SlotHeader* header() const { return reinterpret_cast<const rt::SlotHeader*>(memory.get()); }
    const void* message() const { return header()->message(); }
  };

  /// Adds a message of a type without bulk. False: the bytes are no such message.
  bool add(std::uint32_t sequence, rt::Time published, std::span<const std::byte> cdr);
  /// The two parts of an image, in any order.
  bool add_head(std::uint32_t sequence, rt::Time published, std::span<const std::byte> cdr);
  bool add_pixels(std::uint32_t sequence, rt::Time published, std::span<const std::byte> cdr);

  void set_pixels(std::uint32_t sequence, rt::Time published, std::span<const std::byte> pixels);

  /// Copies a message from another source than the file; it is whole.
  void put(std::uint32_t sequence, const rt::SlotHeader& message);

  /// Null when it is not there.
  const Entry* find(std::uint32_t sequence) const;
  /// The newest message up to `sequence`; null when there is none.
  const Entry* newest_until(std::uint32_t sequence) const;
  /// Forgets messages older than the newest `keep` of those published by `horizon`, but none from sequence `from` on.
  void forget(rt::Time horizon, std::size_t keep, std::optional<std::uint32_t> from);
  const msg::TypeInfo& type() const { return *type_; }

 private:
  static void settle(Entry& entry);
  Entry& place(std::uint32_t sequence, rt::Time published, std::size_t bulk);

  const msg::TypeInfo* type_;
  std::deque<Entry> entries_;  // by sequence
  std::vector<Entry> spare_;
};

}  // namespace sinew::record
