#include "record/run/replay_chain.hpp"

namespace sinew::record {

ReplayChain::ReplayChain(const rt::Graph& graph) : graph_(graph), topics_(graph.topics().size()) {
  for (const rt::GraphTopic& t : graph.topics()) stores_.emplace_back(*t.type);
}

void ReplayChain::add_writer(std::uint32_t module) {
  const rt::GraphModule& m = graph_.modules()[module];
  for (std::size_t p = 0; p < m.topic.size(); ++p)
    if (m.declaration.ports[p].kind == rt::Declaration::PortKind::output && m.topic[p] != rt::kNone)
      topics_[m.topic[p]].written = any_ = true;
}

void ReplayChain::begin(std::uint32_t topic, const MessageStore::Entry* before) {
  if (before && before->whole) stores_[topic].put(before->sequence, *before->header());
}

void ReplayChain::publish(std::uint32_t topic, std::uint32_t first, std::uint32_t count,
                          std::span<const rt::SlotHeader* const> messages) {
  Topic& t = topics_[topic];
  if (!t.written || count == 0) return;
  if (!t.begin) t.begin = first;
  t.end = first + count;
  for (std::uint32_t i = 0; i < count && i < messages.size(); ++i) stores_[topic].put(first + i, *messages[i]);
}

ReplayChain::Source ReplayChain::source(std::uint32_t topic, std::uint32_t sequence) const {
  const Topic& t = topics_[topic];
  if (!t.written || !t.begin || static_cast<std::int32_t>(sequence - *t.begin) < 0) return Source::record;
  return static_cast<std::int32_t>(sequence - *t.end) < 0 ? Source::now : Source::nowhere;
}

}  // namespace sinew::record
