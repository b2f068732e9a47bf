#pragma once
#include <string>
#include <vector>

#include "rt/runner.hpp"

namespace sinew::app {

/// Threads and topics of a run as text, with rates since the previous call.
/// Thread:  owner; reads statistics that the executor's threads write.
class StatusTable {
 public:
  StatusTable(const rt::Graph& graph, rt::Runner& runner);
  /// Shape:   one line a thread and one a topic, at most `columns` wide.
  std::string render(rt::Time now, int columns);

 private:
  const rt::Graph& graph_;
  rt::Runner& runner_;
  rt::Time last_{};
  std::vector<std::uint64_t> cycles_, messages_;
};

}  // namespace sinew::app
