#pragma once
#include <string>

#include "rt/graph.hpp"

namespace sinew::app {

/// The graph as a tree of threads, modules and ports with the topics that they read and write.
std::string graph_tree(const rt::Graph& graph);

/// The graph in Graphviz's language: threads as boxes around their modules, topics as edges.
std::string graph_dot(const rt::Graph& graph);

/// The slots and bytes of every topic, term by term. The graph must have no problems.
std::string slot_table(rt::Graph& graph);

/// "1 ms", "33.3 ms", "5 us": a duration for people.
std::string human(rt::Duration d);

}  // namespace sinew::app
