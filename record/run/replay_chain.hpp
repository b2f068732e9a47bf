#pragma once
#include <optional>
#include <span>
#include <vector>

#include "record/run/message_store.hpp"
#include "record/run/recorded_run.hpp"

namespace sinew::record {

/// The new messages of replayed modules, under the recorded sequences, for their readers.
///
/// A step that publishes fewer messages than recorded leaves sequences empty: an input for the newest message then
/// holds the one before, a queue holds the others. Messages beyond the recorded number have no sequence, and no module
/// reads them.
/// Thread:  owner.
class ReplayChain {
 public:
  explicit ReplayChain(const rt::Graph& graph);

  /// The topics of this module come from the chain.
  void add_writer(std::uint32_t module);
  /// True when nothing was added: every input is as recorded.
  bool empty() const { return !any_; }
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
    std::optional<std::uint32_t> begin{}, end{};  // sequences of the steps that were executed again
  };
  const rt::Graph& graph_;
  std::vector<Topic> topics_;
  std::vector<MessageStore> stores_;
  bool any_ = false;
};

}  // namespace sinew::record
