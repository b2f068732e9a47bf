#pragma once
#include <optional>
#include <span>
#include <vector>

#include "record/run/message_store.hpp"
#include "record/run/recorded_run.hpp"

namespace sinew::record {

/// What modules that are executed again publish now, under the sequences that the record has, for those who read it.
///
/// A step that publishes fewer messages than it did leaves sequences without any: an input for the newest message then
/// holds the one before, a queue holds the others. What it publishes beyond has no sequence, and nobody reads it.
/// Thread:  owner.
class ReplayChain {
 public:
  explicit ReplayChain(const rt::Graph& graph);

  /// The topics that this module writes come from it.
  void add_writer(std::uint32_t module);
  /// Nothing was added: every input is as recorded.
  bool empty() const { return !any_; }
  /// For the first step of a topic's writer: the newest message that the record has from before it, or null. It is what
  /// inputs hold as long as the writer publishes nothing.
  void begin(std::uint32_t topic, const MessageStore::Entry* before);
  bool begins(std::uint32_t topic) const { return topics_[topic].written && !topics_[topic].begin; }
  /// A step of the writer was executed again; in the record it published `count` messages from `first` on.
  void publish(std::uint32_t topic, std::uint32_t first, std::uint32_t count,
               std::span<const rt::SlotHeader* const> messages);

  enum class Source : std::uint8_t {
    record,   // no writer of it is executed again, or it began later
    now,      // in store(), or missing there
    nowhere,  // its writer has not come so far, and will not
  };
  Source source(std::uint32_t topic, std::uint32_t sequence) const;
  const MessageStore& store(std::uint32_t topic) const { return stores_[topic]; }
  void forget(const RecordedRun& run) { run.forget(stores_); }

 private:
  struct Topic {
    bool written = false;
    std::optional<std::uint32_t> begin{}, end{};  // of the sequences of the steps that were executed again
  };
  const rt::Graph& graph_;
  std::vector<Topic> topics_;
  std::vector<MessageStore> stores_;
  bool any_ = false;
};

}  // namespace sinew::record
