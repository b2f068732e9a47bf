#include "apps/robot/without_camera.hpp"

#include <algorithm>

namespace sinew::app {

std::vector<std::string> leave_out_camera(rt::GraphSpec& graph) {
  std::vector<std::string> gone;
  const auto is_gone = [&](const std::string& module) {
    return std::find(gone.begin(), gone.end(), module) != gone.end();
  };
  const auto needs_gone = [&](const rt::ModuleSpec& m) {
    return std::any_of(m.in.begin(), m.in.end(),
                       [&](const auto& in) { return is_gone(in.second.value.substr(0, in.second.value.find('.'))); });
  };
  for (bool more = true; more;) {
    more = false;
    for (const auto& m : graph.modules)
      if (!is_gone(m.name) && (m.type == "drivers::CameraSource" || needs_gone(m))) gone.push_back(m.name), more = true;
  }
  std::erase_if(graph.modules, [&](const auto& m) { return is_gone(m.name); });
  for (auto& t : graph.threads) std::erase_if(t.order, [&](const auto& m) { return is_gone(m.value); });
  std::erase_if(graph.threads, [](const auto& t) { return t.order.empty(); });
  std::erase_if(graph.topics, [&](const auto& t) { return is_gone(t.name.substr(0, t.name.find('.'))); });
  return gone;
}

}  // namespace sinew::app
