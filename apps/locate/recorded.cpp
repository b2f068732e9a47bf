#include "apps/locate/recorded.hpp"

#include <algorithm>
#include <cstdio>

#include "math/linear.hpp"
#include "msg/cdr.hpp"
#include "msg/flight.hpp"
#include "msg/ros2msg.hpp"
#include "record/run/truth.hpp"

namespace sinew::locate {
namespace {

struct Stamped {
  msg::Time stamp;
  soccer::FieldAt at;
  bool valid = false;
};

bool read_states(record::Reader& reader, const std::string& topic, std::vector<Stamped>& out, std::string& why) {
  const auto& channels = reader.channels();
  const auto channel = std::ranges::find_if(channels, [&](const auto& c) { return c.second.topic == topic; });
  if (channel == channels.end()) return why = "no topic " + topic + " in the file", false;
  const auto schema = reader.schemas().find(channel->second.schema);
  const msg::TypeInfo& type = msg::type_info<msg::NavState>();
  if (schema == reader.schemas().end() || schema->second.data != msg::ros2msg_schema(type))
    return why = "topic " + topic + ": no NavState, or recorded with another version of it", false;
  record::MessageReader messages = reader.messages({.topics = {topic}});
  record::Message m;
  for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
    msg::NavState s{};
    if (next == record::Next::problem ||
        !msg::cdr_decode(type, {reinterpret_cast<const std::uint8_t*>(m.data.data()), m.data.size()}, &s))
      return why = "topic " + topic + ": a message cannot be read", false;
    out.push_back({s.stamp, {s.p_world_m.x, s.p_world_m.y, math::Quat(s.q_world_base).yaw()}, s.attitude_valid != 0});
  }
  if (out.empty()) return why = "topic " + topic + ": no messages", false;
  return true;
}

void add_path(std::string& svg, const std::vector<RecordedPlace>& places, bool truth, bool found, const char* style) {
  constexpr double kJump_m = 0.5;  // it took another place for its own: no path
  bool open = false;
  char text[64];
  soccer::FieldAt last;
  for (const RecordedPlace& p : places) {
    if (open && distance_m(truth ? p.truth : p.believed, last) > kJump_m) {
      svg += "\"/>\n";
      open = false;
    }
    last = truth ? p.truth : p.believed;
    if (!truth && p.found != found) {
      if (open) svg += "\"/>\n";
      open = false;
      continue;
    }
    if (!open) svg += std::string("<polyline ") + style + " points=\"";
    open = true;
    const soccer::FieldAt& at = truth ? p.truth : p.believed;
    std::snprintf(text, sizeof text, "%.3f,%.3f ", at.x_m, -at.y_m);
    svg += text;
  }
  if (open) svg += "\"/>\n";
}

}  // namespace

std::optional<std::vector<RecordedPlace>> read_places(record::Reader& reader, const std::string& topic,
                                                      std::string& why) {
  std::vector<Stamped> believed, truth;
  if (!read_states(reader, topic, believed, why) || !read_states(reader, std::string(record::kTruthTopic), truth, why))
    return std::nullopt;
  std::vector<RecordedPlace> out;
  for (const Stamped& b : believed) {
    const auto after = std::ranges::lower_bound(truth, b.stamp, {}, &Stamped::stamp);
    if (after == truth.end()) break;
    out.push_back({1e-9 * static_cast<double>(b.stamp.ns - truth[0].stamp.ns), b.at, after->at, b.valid});
  }
  if (out.empty()) {
    why = "topic " + topic + ": no message at a time whose truth is known";
    return std::nullopt;
  }
  return out;
}

PoseErrors errors_of(const std::vector<RecordedPlace>& places, double settle_s) {
  PoseErrors e;
  const soccer::Field field;
  for (const RecordedPlace& p : places) {
    if (p.t_s < places[0].t_s + settle_s) continue;
    if (!field.holds({p.truth.x_m, p.truth.y_m}, field.size().border_m)) {
      ++e.beyond;
      continue;
    }
    msg::FieldPose pose;
    pose.x_m = p.believed.x_m, pose.y_m = p.believed.y_m, pose.heading_rad = p.believed.heading_rad;
    pose.found = p.found;
    e.add(pose, p.truth);
  }
  return e;
}

std::string draw_paths(const soccer::Field& field, const std::vector<std::vector<RecordedPlace>>& runs) {
  const soccer::FieldSize& f = field.size();
  const double x = f.length_m / 2 + f.border_m, y = f.width_m / 2 + f.border_m;
  char text[320];
  std::snprintf(
      text, sizeof text,
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"%.2f %.2f %.2f %.2f\" width=\"%.0f\" height=\"%.0f\">\n"
      "<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"#3c7a3c\"/>\n<g fill=\"none\">\n",
      -x, -y, 2 * x, 2 * y, 160 * x, 160 * y, -x, -y, 2 * x, 2 * y);
  std::string svg = text;
  for (const soccer::FieldLine& l : field.lines()) {
    std::snprintf(text, sizeof text,
                  "<line x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" y2=\"%.3f\" stroke=\"#fff\" stroke-width=\"0.05\"/>\n",
                  l.from.x_m, -l.from.y_m, l.to.x_m, -l.to.y_m);
    svg += text;
  }
  std::snprintf(text, sizeof text, "<circle r=\"%.3f\" stroke=\"#fff\" stroke-width=\"0.05\"/>\n", f.circle_radius_m);
  svg += text;
  for (const soccer::FieldPoint& p : field.penalty_marks()) {
    std::snprintf(text, sizeof text, "<circle cx=\"%.3f\" cy=\"%.3f\" r=\"0.05\" fill=\"#fff\"/>\n", p.x_m, -p.y_m);
    svg += text;
  }
  for (const soccer::FieldPoint& p : field.posts()) {
    std::snprintf(text, sizeof text, "<circle cx=\"%.3f\" cy=\"%.3f\" r=\"0.07\" fill=\"#ffd24a\"/>\n", p.x_m, -p.y_m);
    svg += text;
  }
  const char* const joined = "stroke-linejoin=\"round\" stroke-linecap=\"round\"";
  for (const auto& run : runs) {
    add_path(svg, run, true, true,
             (std::string("stroke=\"#1a1a1a\" stroke-opacity=\"0.55\" stroke-width=\"0.09\" ") + joined).c_str());
    add_path(svg, run, false, true, (std::string("stroke=\"#ffb000\" stroke-width=\"0.03\" ") + joined).c_str());
    add_path(svg, run, false, false,
             (std::string("stroke=\"#ff5050\" stroke-width=\"0.03\" stroke-dasharray=\"0.05\" ") + joined).c_str());
  }
  return svg + "</g>\n</svg>\n";
}

}  // namespace sinew::locate
