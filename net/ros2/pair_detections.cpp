// What is seen in pictures.
#include <algorithm>

#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "net/ros2/pair_code.hpp"

namespace sinew::ros2::detail {

template <class Sighting>
bool write_detection(const Context& c, const void* own) {
  const auto& seen = *static_cast<const Sighting*>(own);
  Value& detections = at(c, "detections");
  if (seen.found == 0) return detections.items.clear(), true;
  const Type& type = *c.ros.type().find("detections")->nested;
  if (detections.items.empty()) {
    detections.items.resize(1);
    Message::make_default(type, detections.items[0]);
    Value& results = *find_value(type, detections.items[0], "results");
    results.items.resize(1);
    Message::make_default(*type.find("results")->nested, results.items[0]);
  }
  Value& one = detections.items[0];
  one.items[0] = at(c, "header");
  const auto field = [&](const char* path) -> Value& { return *find_value(type, one, path); };
  field("results[0].hypothesis.class_id").text = c.options.object;
  field("results[0].hypothesis.score").set(seen.confidence);
  const bool ranged = math::is_finite(seen.range_m);
  put_geometry(field("results[0].pose.pose.position"),
               math::Vec3(seen.direction_optical) * (ranged ? seen.range_m : 1.0));
  put_geometry(field("results[0].pose.pose.orientation"), math::Quat());
  put_diagonal(field("results[0].pose.covariance"), {kNoIdea, kNoIdea, kNoIdea, kNoIdea, kNoIdea, kNoIdea});
  field("bbox.center.position.x").set(seen.u_px);
  field("bbox.center.position.y").set(seen.v_px);
  field("bbox.size_x").set(2 * seen.radius_px);
  field("bbox.size_y").set(2 * seen.radius_px);
  return true;
}

template <class Sighting>
const char* read_detection(const Context& c, void* own) {
  auto& seen = *static_cast<Sighting*>(own);
  const Type& type = *c.ros.type().find("detections")->nested;
  Value& detections = at(c, "detections");
  Value* best = nullptr;
  double best_score = -1;
  math::Vec3 position;
  for (Value& one : detections.items)
    for (const Value& result : find_value(type, one, "results")->items) {  // hypothesis {class_id, score}, pose
      const double score = result.items[0].items[1].number();
      if (result.items[0].items[0].text != c.options.object || !(score > best_score)) continue;
      best = &one, best_score = score;
      position = vec_of(result.items[1].items[0].items[0]);
    }
  if (!best) return nullptr;  // found = 0
  const auto number = [&](const char* path) { return find_value(type, *best, path)->number(); };
  seen.u_px = number("bbox.center.position.x");
  seen.v_px = number("bbox.center.position.y");
  seen.radius_px = (number("bbox.size_x") + number("bbox.size_y")) / 4;
  const std::vector<double>& camera = c.options.camera;
  if (math::squared_norm(position) > 0)
    seen.range_m = math::norm(position);
  else
    position = {(seen.u_px - camera[2]) / camera[0], (seen.v_px - camera[3]) / camera[1], 1};
  seen.direction_optical = math::normalized(position).template to<msg::Vec3>();
  if (!math::is_finite(position) || !math::is_finite(seen.u_px + seen.v_px + seen.radius_px + best_score))
    return "a number that is not finite";
  seen.confidence = std::clamp(best_score, 0.0, 1.0);
  seen.found = 1;
  seen.blobs = static_cast<std::uint32_t>(std::min<std::size_t>(detections.items.size(), 1000));
  return nullptr;
}

template bool write_detection<msg::PadSighting>(const Context&, const void*);
template bool write_detection<msg::BallSighting>(const Context&, const void*);
template const char* read_detection<msg::PadSighting>(const Context&, void*);
template const char* read_detection<msg::BallSighting>(const Context&, void*);

}  // namespace sinew::ros2::detail
