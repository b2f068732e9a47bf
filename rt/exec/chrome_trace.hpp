#pragma once
#include <span>
#include <string>

#include "rt/exec/timeline.hpp"

namespace sinew::rt {

/// The events as a trace for ui.perfetto.dev or chrome://tracing: one track per thread, with cycles that hold steps
/// that hold zones. Instants are those of the executor's clock.
/// Thread:  any.   RT: no.
/// Source:  Trace Event Format (Google, "Trace Event Format" document), JSON object form: phases M, X and i.
std::string chrome_trace(const Graph& graph, std::span<const TimelineEvent> events);

}  // namespace sinew::rt
