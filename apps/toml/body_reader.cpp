#include "apps/toml/body_reader.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/toml/toml_guard.hpp"
#include "apps/toml/toml_resolver.hpp"
#include "math/elementary.hpp"

namespace sinew::app {
namespace {

using kinematics::Body;
using kinematics::Link;
using kinematics::Place;
using kinematics::Pose;
using kinematics::ServoType;
using kinematics::Shape;
using math::Quat;
using math::Vec3;

constexpr double kDegree = math::kPi / 180;

template <std::size_t N>
bool read_numbers(TomlReader& r, std::string_view key, std::array<double, N>& out, double least, double most) {
  const toml::node* node = r.take(key);
  if (!node) return false;
  const toml::array* array = node->as_array();
  bool good = array && array->size() == N;
  for (std::size_t i = 0; good && i < N; ++i) {
    const auto number = array->get(i)->value<double>();
    good = array->get(i)->is_number() && number && *number >= least && *number <= most;
    if (good) out[i] = *number;
  }
  if (!good)
    r.problem(*node, key,
              "an array of " + std::to_string(N) + " numbers from " + std::to_string(static_cast<int>(least)) + " to " +
                  std::to_string(static_cast<int>(most)));
  return good;
}

bool read_vector(TomlReader& r, std::string_view key, Vec3& out, double most) {
  std::array<double, 3> numbers{};
  if (!read_numbers(r, key, numbers, -most, most)) return false;
  out = {numbers[0], numbers[1], numbers[2]};
  return true;
}

Quat read_turn(TomlReader& r) {
  std::array<double, 3> deg{};
  read_numbers(r, "roll_pitch_yaw_deg", deg, -360, 360);
  return Quat::from_yaw_pitch_roll({deg[2] * kDegree, deg[1] * kDegree, deg[0] * kDegree});
}

Shape read_shape(TomlReader& r) {
  Shape shape;
  if (!r.has("kind")) r.missing("kind", "\"box\", \"capsule\" or \"sphere\"; it is required");
  r.read_choice("kind", shape.kind,
                {{"box", Shape::Kind::box}, {"capsule", Shape::Kind::capsule}, {"sphere", Shape::Kind::sphere}});
  read_vector(r, "at_m", shape.at_m, 2);
  shape.q = read_turn(r);
  r.read("contact", shape.contact);
  const auto length = [&](const char* key, double& out) {
    if (!r.has(key)) r.missing(key, "a length in m; it is required");
    r.read(key, out, 1e-4, 2);
  };
  if (shape.kind == Shape::Kind::box) {
    if (!r.has("size_m")) r.missing("size_m", "three lengths in m; they are required");
    read_vector(r, "size_m", shape.size_m, 2);
  } else {
    length("radius_m", shape.size_m.x);
    if (shape.kind == Shape::Kind::capsule) length("length_m", shape.size_m.z);
  }
  r.finish();
  return shape;
}

class BodyTables {
 public:
  explicit BodyTables(Body& body) : body_(body) {}

  void servo(TomlReader& r) {
    ServoType servo;
    r.require("name", servo.name);
    if (!r.has("stall_nm")) r.missing("stall_nm", "a torque in N m; it is required");
    r.read("stall_nm", servo.stall_nm, 1e-3, 1000);
    if (!r.has("no_load_radps")) r.missing("no_load_radps", "a speed in rad/s; it is required");
    r.read("no_load_radps", servo.no_load_radps, 1e-2, 1000);
    r.read("armature_kgm2", servo.armature_kgm2, 0, 10);
    r.finish();
    body_.servos.push_back(std::move(servo));
  }

  void link(TomlReader& r) {
    Link link;
    r.require("name", link.name);
    bool mirror = false;
    r.read("mirror", mirror);
    if (!mirror) flush();
    const bool first = body_.links.empty();
    std::string parent, servo;
    r.read("parent", parent, "the name of a link that stands before it");
    if (const auto found = body_.find_link(parent); found)
      link.parent = *found;
    else if (!first)
      refuse(r, "parent", parent, "the name of a link that stands before it");
    else if (!parent.empty())
      refuse(r, "parent", parent, "nothing: the first link hangs on none");
    read_vector(r, "at_m", link.at_m, 2);
    if (read_vector(r, "axis", link.axis, 1e3)) {
      if (math::squared_norm(link.axis) > 0)
        link.axis = math::normalized(link.axis);
      else
        refuse(r, "axis", "[0, 0, 0]", "a direction");
    } else if (!first && !r.has("axis")) {
      r.missing("axis", "the direction of its joint, three numbers; it is required");
    }
    std::array<double, 2> range_deg{};
    if (read_numbers(r, "range_deg", range_deg, -360, 360)) {
      link.least_rad = range_deg[0] * kDegree;
      link.most_rad = range_deg[1] * kDegree;
      if (range_deg[0] > range_deg[1]) refuse(r, "range_deg", "", "the lesser angle first");
    } else if (!first && !r.has("range_deg")) {
      r.missing("range_deg", "the least and the largest angle of its joint; they are required");
    }
    if (r.read("servo", servo)) {
      for (std::size_t i = 0; i < body_.servos.size(); ++i)
        if (body_.servos[i].name == servo) link.servo = i;
      if (link.servo == kinematics::kNone) refuse(r, "servo", servo, "the name of a [[servo]]");
    } else if (!first) {
      r.missing("servo", "the name of a [[servo]]; it is required");
    }
    r.read("mass_kg", link.mass_kg, 0, 1000);
    read_vector(r, "com_m", link.com_m, 2);
    read_numbers(r, "inertia_kgm2", link.inertia_kgm2, -100, 100);
    r.array_of_tables("shape", [&](TomlReader& shape) { link.shapes.push_back(read_shape(shape)); });
    r.finish();
    if (body_.find_link(link.name)) refuse(r, "name", link.name, "a name that no other link has");
    if (mirror && !link.name.starts_with("l_"))
      refuse(r, "name", link.name, "a name that begins with \"l_\", for mirror");
    if (mirror) mirrored_.push_back(body_.links.size());
    body_.links.push_back(std::move(link));
    if (body_.links.size() + mirrored_.size() > kinematics::kMaxLinks)
      refuse(r, "name", "", "at most " + std::to_string(kinematics::kMaxLinks) + " links");
  }

  void place(TomlReader& r) {
    flush();
    Place place;
    std::string link;
    bool mirror = false;
    r.require("name", place.name);
    r.require("link", link);
    r.read("mirror", mirror);
    read_vector(r, "at_m", place.pose.p_m, 2);
    place.pose.q = read_turn(r);
    r.finish();
    const auto found = body_.find_link(link);
    if (!found) {
      refuse(r, "link", link, "the name of a link");
      return;
    }
    place.link = *found;
    body_.places.push_back(place);
    if (!mirror) return;
    const auto other = body_.find_link(right(link));
    if (!place.name.starts_with("l_") || !link.starts_with("l_") || !other) {
      refuse(r, "mirror", "true", "names of place and link that begin with \"l_\"");
      return;
    }
    body_.places.push_back({right(place.name), *other, mirror_of(place.pose)});
  }

  /// The right side of the mirrored links since the last one that is not.
  void flush() {
    for (const std::size_t i : mirrored_) {
      Link link = body_.links[i];
      link.name = right(link.name);
      if (const auto parent = body_.find_link(right(body_.links[link.parent].name)); parent) link.parent = *parent;
      link.at_m.y = -link.at_m.y;
      link.axis = {-link.axis.x, link.axis.y, -link.axis.z};
      link.com_m.y = -link.com_m.y;
      link.inertia_kgm2[3] = -link.inertia_kgm2[3];
      link.inertia_kgm2[5] = -link.inertia_kgm2[5];
      for (Shape& shape : link.shapes) {
        const Pose pose = mirror_of({shape.at_m, shape.q});
        shape.at_m = pose.p_m;
        shape.q = pose.q;
      }
      body_.links.push_back(std::move(link));
    }
    mirrored_.clear();
  }

 private:
  static std::string right(const std::string& left) { return left.starts_with("l_") ? "r_" + left.substr(2) : left; }
  static Pose mirror_of(const Pose& p) { return {{p.p_m.x, -p.p_m.y, p.p_m.z}, {p.q.w, -p.q.x, p.q.y, -p.q.z}}; }
  static void refuse(TomlReader& r, std::string_view key, const std::string& value, std::string allowed) {
    r.problems().push_back({r.line(), r.full(key), '"' + value + '"', std::move(allowed)});
  }

  Body& body_;
  std::vector<std::size_t> mirrored_;
};

}  // namespace

void read_body(TomlReader& r, Body& body) {
  BodyTables tables(body);
  r.require("name", body.name);
  r.array_of_tables("servo", [&](TomlReader& servo) { tables.servo(servo); });
  r.array_of_tables("link", [&](TomlReader& link) { tables.link(link); });
  tables.flush();
  r.array_of_tables("place", [&](TomlReader& place) { tables.place(place); });
  if (body.links.empty()) r.missing("link", "at least one [[link]]");
}

LoadedBody parse_body(std::string_view text, const std::string& path) {
  LoadedBody loaded;
  const auto parsed = parse_toml(text, path, loaded.problems);
  if (!parsed) return loaded;
  TomlReader root(*parsed, "", loaded.problems);
  if ((*parsed)["body"].is_table()) {  // of a robot, whose other tables are not of interest
    root.table("body", [&](TomlReader& body) { read_body(body, loaded.body); });
    return loaded;
  }
  read_body(root, loaded.body);
  root.finish();
  return loaded;
}

LoadedBody load_body(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (std::error_code none; !in || std::filesystem::is_directory(path, none)) {
    LoadedBody loaded;
    loaded.problems.push_back({0, "file", path, "a file of a body that can be read"});
    return loaded;
  }
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto is_merged = [](const toml::table& t) { return !t.contains("extends") && !t["body"]["extends"]; };
  const toml::parse_result parsed = line_beyond_ascii(text) == 0 ? toml::parse(text, path) : toml::parse("");
  if (!parsed || is_merged(parsed.table())) return parse_body(text, path);
  TomlResolver resolver;
  const auto all = resolver.merged(text, path);
  LoadedBody loaded;
  if (all && resolver.merge_below(*all, "body")) {
    resolver.write(*all, "# " + path + " with all that it extends", path);
    loaded = parse_body(resolver.result().text, path);
  } else {
    loaded.problems = std::move(resolver.result().problems);
  }
  resolver.place_lines(loaded.problems);
  return loaded;
}

std::optional<std::string> body_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in && !in.eof()) return std::nullopt;
  if (line_beyond_ascii(text) != 0) return std::nullopt;
  const toml::parse_result parsed = toml::parse(text, path);
  if (!parsed) return std::nullopt;
  if (!parsed.table().contains("extends") && !parsed.table()["body"]["extends"]) return text;
  TomlResolver resolver;
  const auto all = resolver.merged(text, path);
  if (!all || !resolver.merge_below(*all, "body")) return std::nullopt;
  resolver.write(*all, "# " + path + " with all that it extends", path);
  return std::move(resolver.result().text);
}

}  // namespace sinew::app
