#pragma once
// The members of the replies to topics, status, params and timeline, as docs/robot-socket.md has them. Only for code
// that answers requests: it shows the JSON library.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "msg/team.hpp"
#include "rt/exec/stats.hpp"
#include "rt/exec/timeline.hpp"
#include "rt/graph.hpp"
#include "rt/graph_spec.hpp"
#include "tap/request.hpp"

namespace sinew::tap {

/// One topic as `topics` tells of it.
struct TopicAbout {
  std::string name;
  const msg::TypeInfo* type = nullptr;
  std::string writer, thread;
  std::uint32_t bulk_bytes = 0, keep = 0;
  double rate_hz = 0;  // planned, or recorded; 0: not known
  bool external = false, wakes_outsiders = false;
  std::vector<std::string> readers{};  // modules
};
/// The modules with an input on this topic, each once. A driver that reads its own raw topic is none.
std::vector<std::string> readers_of(const rt::Graph& graph, std::uint32_t topic);
/// `topics` and `types`.
Json directory_json(const std::vector<TopicAbout>& topics);

// One entry of a list of `status`.
Json thread_json(const rt::ThreadSpec& thread, const std::vector<std::string>& modules, const rt::ThreadStats& stats);
Json module_json(const rt::ModuleSpec& module, const std::string& thread, const rt::ModuleStats& stats);
Json topic_json(const std::string& name, const rt::TopicStats& stats, std::uint64_t drops);
Json chain_json(const rt::ChainSpec& chain, const rt::ChainStats& stats);

/// `team` of `status`, without the places that no mate has.
Json team_json(const msg::TeamState& team);

/// One entry of `params`. `narrowed`: what the module's device leaves of the range. `start`: what the run began with.
Json param_json(const std::string& module, const rt::Declaration::Param& param,
                const std::optional<rt::ParamRange>& narrowed, const rt::ParamValue& value,
                const rt::ParamValue& start);
Json to_json(const rt::ParamValue& value);

/// The newest of these events, as many as fit into a reply: their description, and the member "events".
struct TimelineText {
  Json description;
  std::string events;
};
TimelineText timeline_text(const std::vector<std::string>& threads, const std::vector<std::string>& modules,
                           const std::vector<rt::TimelineEvent>& events);

}  // namespace sinew::tap
