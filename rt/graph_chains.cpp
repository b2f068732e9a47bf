// Where the origin of a chain travels: along every way from its first topic to its last, each way once. An input that
// closes a loop does not carry it, or an origin would go round for ever and the age grow without end.
#include <vector>

#include "rt/graph.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

class ChainWalk {
 public:
  ChainWalk(std::vector<GraphModule>& modules, std::size_t topics, std::uint32_t chain, std::uint32_t to)
      : modules_(modules),
        bit_(1u << chain),
        to_(to),
        topic_leads_(topics),
        module_leads_(modules.size()),
        seen_(modules.size()),
        on_way_(modules.size()) {
    topic_leads_[to] = true;
    while (spread()) {
    }
  }

  void from_topic(std::uint32_t topic) {
    if (topic == to_) return;
    for (std::uint32_t m = 0; m < modules_.size(); ++m)
      for (std::uint32_t p = 0; p < modules_[m].topic.size(); ++p) {
        if (modules_[m].topic[p] != topic || !reads(m, p) || !module_leads_[m] || on_way_[m]) continue;
        modules_[m].carried_chains[p] |= bit_;
        if (!seen_[m]) from_module(m);
      }
  }

 private:
  bool reads(std::uint32_t m, std::uint32_t p) const {
    const Declaration::Port& port = modules_[m].declaration.ports[p];
    return port.kind != PortKind::output && !port.supervises;  // a driver reads its own raw topic
  }
  void from_module(std::uint32_t m) {
    seen_[m] = on_way_[m] = true;
    for (std::uint32_t p = 0; p < modules_[m].topic.size(); ++p)
      if (modules_[m].declaration.ports[p].kind == PortKind::output && topic_leads_[modules_[m].topic[p]])
        from_topic(modules_[m].topic[p]);
    on_way_[m] = false;
  }
  /// One round of finding modules that lead to the last topic; false when it found nothing new.
  bool spread() {
    bool news = false;
    for (std::uint32_t m = 0; m < modules_.size(); ++m)
      for (std::uint32_t p = 0; p < modules_[m].topic.size(); ++p) {
        const std::uint32_t topic = modules_[m].topic[p];
        if (topic == kNone) continue;
        const bool output = modules_[m].declaration.ports[p].kind == PortKind::output;
        if (output && topic_leads_[topic] && !module_leads_[m]) news = module_leads_[m] = true;
        if (reads(m, p) && module_leads_[m] && !topic_leads_[topic]) news = topic_leads_[topic] = true;
      }
    return news;
  }

  std::vector<GraphModule>& modules_;
  const std::uint32_t bit_, to_;
  std::vector<bool> topic_leads_, module_leads_, seen_, on_way_;
};

}  // namespace

void Graph::resolve_chains() {
  for (std::uint32_t c = 0; c < spec_.chains.size(); ++c) {
    const ChainSpec& spec = spec_.chains[c];
    chains_.push_back({spec, find_topic(spec.from.value), find_topic(spec.to.value)});
    const GraphChain& chain = chains_.back();
    if (c >= kMaxChains || chain.from == kNone || chain.to == kNone) continue;
    topics_[chain.from].source_chains |= 1u << c;
    topics_[chain.to].sink_chains |= 1u << c;
    ChainWalk(modules_, topics_.size(), c, chain.to).from_topic(chain.from);
  }
}

}  // namespace sinew::rt
