#include "robots/air_robot/world/places.hpp"

#include <mujoco/mujoco.h>

#include <array>
#include <cstdio>
#include <string>

#include "robots/air_robot/devices.hpp"
#include "robots/air_robot/world/room_xml.hpp"
#include "robots/quad/world/room_xml.hpp"
#include "sim_hil/mujoco/room.hpp"

namespace sinew::plant {

using math::Vec3;

namespace {

constexpr double kHalfTurn = math::kPi;

/// From the first mark up to the second.
std::string_view between(std::string_view text, std::string_view first, std::string_view end) {
  const std::string_view rest = text.substr(text.find(first));
  return rest.substr(0, rest.find(end));
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

// ---- what moves

constexpr const char* kAccents[kMostRobots] = {"0.80 0.14 0.10 1", "0.10 0.30 0.78 1", "0.12 0.55 0.22 1",
                                               "0.86 0.74 0.12 1", "0.45 0.20 0.60 1", "0.05 0.55 0.62 1",
                                               "0.86 0.48 0.62 1", "0.30 0.30 0.32 1"};

/// A body of vehicles.xml as number `number` of its kind.
std::string copy_of(const std::string& body, std::size_t number) {
  const std::string digits = std::to_string(number), name = "name=\"" + body;
  std::string all(between(robots::vehicles_xml_of_air_robot(), "<body " + name + "\"", "</body>"));
  replace_all(all, name + "\"", name + digits + "\"");
  replace_all(all, "material=\"v_accent\"", "material=\"v_accent" + digits + "\"");
  return all + "</body>\n";
}

std::string moving_xml(bool crate_is_there) {
  const std::string_view vehicles = robots::vehicles_xml_of_air_robot();
  std::string assets(between(vehicles, "<asset>", "</asset>"));
  if (crate_is_there) {  // the room paints one of its own
    const auto at = assets.find("<texture name=\"crate\"");
    assets.erase(at, assets.find("/>", at) + 2 - at);
  }
  for (std::size_t i = 0; i < kMostRobots; ++i)
    assets += "<material name=\"v_accent" + std::to_string(i) + "\" rgba=\"" + kAccents[i] +
              "\" specular=\"0.4\" shininess=\"0.6\"/>\n";
  std::string bodies;
  for (const char* kind : {"flying", "wheeled"})
    for (std::size_t i = 0; i < kMostRobots; ++i) bodies += copy_of(kind, i);
  bodies += copy_of("target", 0);
  for (const char* kind : {"crate_plain", "crate_red", "crate_green", "crate_blue"})
    for (std::size_t i = 0; i < kMostOfAKind; ++i) bodies += copy_of(kind, i);
  for (std::size_t i = 0; i < kMostRobots; ++i) bodies += copy_of("steered", i);
  return assets + "</asset>\n<worldbody>\n" + bodies + "</worldbody>\n";
}

// ---- the places

/// Windows before the walls of the buildings: a plane for each side of a tower.
std::string fronts(std::string_view town) {
  constexpr const char* kMaterials[] = {"facade", "facade_red", "facade_blue"};
  std::string all;
  std::size_t number = 0;
  for (auto at = town.find("<geom name=\"tower"); at != std::string_view::npos;
       at = town.find("<geom name=\"tower", at + 1)) {
    const std::string geom(town.substr(at, town.find("/>", at) - at));
    double sx = 0, sy = 0, sz = 0, px = 0, py = 0, pz = 0;
    const auto size = geom.find("size=\""), pos = geom.find("pos=\"");
    if (size == std::string::npos || pos == std::string::npos ||
        std::sscanf(geom.c_str() + size, "size=\"%lf %lf %lf", &sx, &sy, &sz) != 3 ||
        std::sscanf(geom.c_str() + pos, "pos=\"%lf %lf %lf", &px, &py, &pz) != 3)
      continue;
    constexpr double kBefore_m = 0.06;
    const char* material = kMaterials[number++ % std::size(kMaterials)];
    const auto front = [&](double half, double x, double y, const char* axes) {
      char text[240];
      std::snprintf(text, sizeof text,
                    "<geom type=\"plane\" size=\"%.3f %.3f 1\" pos=\"%.3f %.3f %.3f\" xyaxes=\"%s 0 0 1\" "
                    "material=\"%s\"/>\n",
                    half, sz, x, y, pz, axes, material);
      all += text;
    };
    front(sy, px + sx + kBefore_m, py, "0 1 0");
    front(sy, px - sx - kBefore_m, py, "0 -1 0");
    front(sx, px, py + sy + kBefore_m, "-1 0 0");
    front(sx, px, py - sy - kBefore_m, "1 0 0");
  }
  return all;
}

std::string fixed_xml(PlaceNumber number) {
  switch (number) {
    case PlaceNumber::town: {
      std::string town(robots::town_xml_of_air_robot());
      return town.insert(town.find("</worldbody>"), fronts(town));
    }
    case PlaceNumber::room: {
      std::string room(robots::room_xml_of_quad());
      const auto quad = room.find("<body name=\"quad\"");
      constexpr std::string_view kEnd = "</body>";
      return room.erase(quad, room.find(kEnd, quad) + kEnd.size() - quad);
    }
    case PlaceNumber::empty_arena: {
      std::string arena(robots::arena_xml_of_air_robot());
      const auto begin = arena.find("<!-- obstacles -->");
      return arena.erase(begin, arena.find("<!-- end of obstacles -->") - begin);
    }
    case PlaceNumber::arena:
      break;
  }
  return std::string(robots::arena_xml_of_air_robot());
}

std::string whole_xml(PlaceNumber number) {
  std::string xml = fixed_xml(number);
  const bool crate_is_there = xml.find("texture name=\"crate\"") != std::string::npos;
  return xml.insert(xml.find("</mujoco>"), moving_xml(crate_is_there));
}

/// Those of the geoms that belong to no body and can be touched.
hal::Result<std::vector<Solid>> solids_of(std::string_view xml) {
  auto model = load_room(xml, RoomUse::physics);
  if (!model) return model.error();
  const mjModel& m = **model;
  std::vector<Solid> solids;
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.geom_bodyid[g] != 0 || m.geom_contype[g] == 0) continue;
    Solid s;
    switch (m.geom_type[g]) {
      case mjGEOM_PLANE:
        s.shape = Shape::plane;
        break;
      case mjGEOM_BOX:
        s.shape = Shape::box;
        break;
      case mjGEOM_CYLINDER:
        s.shape = Shape::cylinder;
        break;
      case mjGEOM_SPHERE:
        s.shape = Shape::sphere;
        break;
      default:
        return hal::Error{hal::Errc::bad_data, "place: solids are planes, boxes, cylinders and spheres", g};
    }
    const double *p = m.geom_pos + 3 * g, *q = m.geom_quat + 4 * g, *size = m.geom_size + 3 * g;
    s.p_world_m = {p[0], p[1], p[2]};
    s.q_world = {q[0], q[1], q[2], q[3]};
    s.half_m = {size[0], size[1], size[2]};
    if (s.shape == Shape::cylinder) s.half_m = {size[0], 0, size[1]};
    solids.push_back(s);
  }
  return solids;
}

std::vector<StartPose> poses(std::initializer_list<std::array<double, 3>> places) {
  std::vector<StartPose> all;
  for (const auto& [x, y, yaw] : places) all.push_back({"Pose" + std::to_string(all.size() + 1), {x, y, 0}, yaw});
  return all;
}

}  // namespace

std::string_view place_xml(PlaceNumber number) {
  static const std::array<std::string, kPlaces> all = [] {
    std::array<std::string, kPlaces> xml;
    for (std::size_t i = 0; i < kPlaces; ++i) xml[i] = whole_xml(static_cast<PlaceNumber>(i + 1));
    return xml;
  }();
  return all[static_cast<std::size_t>(number) - 1];
}

hal::Result<PlaceMap> load_place(PlaceNumber number) {
  auto solids = solids_of(place_xml(number));
  if (!solids) return solids.error();
  PlaceMap map;
  map.solids = std::move(*solids);
  map.target_radius_m = 0.25;
  const double up = map.target_radius_m;
  switch (number) {
    case PlaceNumber::arena:
    case PlaceNumber::empty_arena:
      map.name = number == PlaceNumber::arena ? "Arena" : "EmptyArena";
      map.starts = poses({{-5, 0, 0},
                          {-5, 1.5, 0},
                          {-5, -1.5, 0},
                          {-5, 3, 0},
                          {-6.5, 0, 0},
                          {-6.5, 1.5, 0},
                          {-6.5, -1.5, 0},
                          {-6.5, 3, 0}});
      map.target_way = {{-2, 0.4, up}, {-0.4, -1, up}, {-0.4, 2.4, up}, {-3.2, 1.6, up}};
      map.latitude_deg = 39.133788, map.longitude_deg = -77.216633;  // DefaultUSAR.ini, ZeroZeroLocation
      break;
    case PlaceNumber::town:
      map.name = "Town";
      map.starts =
          poses({{0, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 4, 0}, {-3, 0, 0}, {-3, 2, 0}, {-3, -2, 0}, {-3, 4, 0}});
      map.target_way = {{5, 0, up}, {10, -5, up}, {2, -8, up}, {-8, -8, up}, {-8, 5, up}, {4, 6, up}};
      map.latitude_deg = 39.133788, map.longitude_deg = -77.216633;
      break;
    case PlaceNumber::room:
      map.name = "Room";
      map.starts = poses({{0, 0, 0},
                          {0, 1, 0},
                          {0, -1, 0},
                          {-1.2, 0, 0},
                          {-1.2, 1, 0},
                          {1.2, 0, kHalfTurn},
                          {1.2, 1, kHalfTurn},
                          {1.2, -0.9, kHalfTurn}});
      map.target_way = {{2.4, 0.8, up}, {2.4, -0.6, up}};
      map.latitude_deg = 39.133788, map.longitude_deg = -77.216633;
      break;
  }
  return map;
}

}  // namespace sinew::plant
