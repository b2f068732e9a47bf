#include "robots/terrain/world/ground.hpp"

#include <algorithm>
#include <cstdio>
#include <span>
#include <string_view>

#include "math/elementary.hpp"
#include "robots/quad/world/room_xml.hpp"

namespace sinew::plant {
namespace {

struct Knot {
  double x_m, z_m;  // x in multiples of the height field's grid
};

// A riser is as wide as the grid.
constexpr Knot kSteps[] = {{16, 0},    {16.1, 0.3}, {22, 0.3}, {22.1, 0.65}, {28, 0.65}, {28.1, 0.25},
                           {34, 0.25}, {34.1, 0.6}, {40, 0.6}, {40.1, 1},    {46, 1},    {46.1, 0.6},
                           {52, 0.6},  {52.1, 0.2}, {58, 0.2}, {58.1, 0.5},  {64, 0.5},  {64.1, 0.9},
                           {70, 0.9},  {70.1, 0.5}, {76, 0.5}, {76.1, 0.1},  {84, 0.1},  {84.1, 0}};
constexpr Knot kBuildings[] = {{16, 0}, {26, 2.5}, {34, 2.5}, {44, 0}, {50, 0},
                               {62, 3}, {70, 3},   {74, 2},   {78, 2}, {86, 0}};

double along(std::span<const Knot> knots, double x_m) {
  if (x_m <= knots.front().x_m) return knots.front().z_m;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const Knot &a = knots[i - 1], &b = knots[i];
    if (x_m < b.x_m) return a.z_m + (b.z_m - a.z_m) * (x_m - a.x_m) / (b.x_m - a.x_m);
  }
  return knots.back().z_m;
}

double hills(double x_m, double across_m) {
  const double x = x_m - kCourseBegin_m, y = across_m;
  const auto wave = [](double phase) { return 0.5 - 0.5 * math::cos(phase); };
  const double fade = std::clamp(std::min(x, kCourseEnd_m - x_m) / 4, 0.0, 1.0);
  const double z = 0.75 * wave(2 * math::kPi * (x / 15 + 0.1 * math::sin(y / 5))) +
                   0.4 * wave(2 * math::kPi * (x + 0.6 * y) / 9.5) + 0.15 * wave(2 * math::kPi * (y - 0.3 * x) / 7);
  return fade * z;
}

/// One lane as a height field: the text with its heights, the field, and the geom.
struct Lane {
  Terrain terrain;
  const char *name, *material;
  int rows, columns;
  double top_m;
};
constexpr double kBegin_m = 12, kEnd_m = 92;
constexpr Lane kLanes[] = {{Terrain::hills, "hills", "meadow", 49, 161, 1.4},
                           {Terrain::steps, "steps", "floor", 2, 801, 1.1},
                           {Terrain::buildings, "buildings", "roofs", 2, 801, 3.1}};

std::string heights(const Lane& lane) {
  std::string text;
  for (int row = 0; row < lane.rows; ++row)
    for (int column = 0; column < lane.columns; ++column) {
      const double x = kBegin_m + (kEnd_m - kBegin_m) * column / (lane.columns - 1);
      const double y = kLaneHalfWidth_m * (2.0 * row / (lane.rows - 1) - 1);
      text += std::to_string(static_cast<int>(1000 * ground_m(lane.terrain, x, y) + 0.5)) + ' ';
    }
  return text;
}

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

/// What stands between two words of the quadrotor's room, the first word included.
std::string_view part(std::string_view room, std::string_view from, std::string_view to) {
  const auto begin = room.find(from), end = room.find(to, begin);
  return room.substr(begin, end - begin);
}

}  // namespace

double lane_m(Terrain terrain) { return 30.0 * (static_cast<int>(terrain) - 1); }

double ground_m(Terrain terrain, double x_m, double across_m) {
  if (x_m <= kCourseBegin_m || x_m >= kCourseEnd_m) return 0;
  switch (terrain) {
    case Terrain::hills:
      return hills(x_m, across_m);
    case Terrain::steps:
      return along(kSteps, x_m);
    case Terrain::buildings:
      return along(kBuildings, x_m);
  }
  return 0;
}

std::string terrain_room() {
  const std::string_view quad = robots::room_xml_of_quad();
  std::string assets, custom, geoms;
  for (const Lane& lane : kLanes) {
    const std::string name = lane.name;
    assets += "    <hfield name=\"" + name + "\" nrow=\"" + std::to_string(lane.rows) + "\" ncol=\"" +
              std::to_string(lane.columns) + "\" size=\"" + number((kEnd_m - kBegin_m) / 2) + " " +
              number(kLaneHalfWidth_m) + " " + number(lane.top_m) + " 0.1\"/>\n";
    custom += "    <text name=\"" + name + "\" data=\"" + heights(lane) + "\"/>\n";
    // Two millimetres under the floor, where both are level.
    geoms += "    <geom name=\"" + name + "\" class=\"solid\" type=\"hfield\" hfield=\"" + name + "\" pos=\"" +
             number((kBegin_m + kEnd_m) / 2) + " " + number(lane_m(lane.terrain)) + " -0.002\" material=\"" +
             lane.material + "\"/>\n";
  }
  std::string room(part(quad, "<mujoco", "<asset>"));
  room += "<custom>\n" + custom + "  </custom>\n  <asset>\n";
  room += R"(    <texture name="floor" type="2d" builtin="flat" rgb1="0.60 0.58 0.54" width="1024" height="1024"/>
    <texture name="meadow" type="2d" builtin="flat" rgb1="0.40 0.50 0.30" width="1024" height="1024"/>
    <texture name="roofs" type="2d" builtin="flat" rgb1="0.50 0.45 0.40" width="1024" height="1024"/>
    <material name="floor" texture="floor" texuniform="true" texrepeat="0.25 0.25" specular="0" shininess="0"/>
    <material name="meadow" texture="meadow" texuniform="true" texrepeat="0.0625 0.0625" specular="0" shininess="0"/>
    <material name="roofs" texture="roofs" texuniform="true" texrepeat="0.0625 0.0625" specular="0" shininess="0"/>
)" + assets;
  room += part(quad, "<material name=\"carbon\"", "<geom name=\"floor\"");
  room += R"(<geom name="floor" class="solid" type="plane" size="80 60 1" pos="40 30 0" material="floor"/>
)" + geoms;
  room += quad.substr(quad.find("<body name=\"quad\""));
  return room;
}

}  // namespace sinew::plant
