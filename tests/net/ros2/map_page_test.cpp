// docs/reference/ros2-types.md has exactly the table of translations, and net/ros2/sinew_msgs is a package of our
// messages.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "net/ros2/convert.hpp"
#include "source_dir.hpp"

namespace sinew::ros2 {
namespace {

constexpr const char* kHead = R"(# ROS 2 types

The test `net_ros2_map_page_test` writes this page from the table of translations (`net/ros2/pairs.cpp`) when `SINEW_WRITE_DOCS=1`
is set; without it the test fails when page and table differ. [ros2.md](../ros2.md) says how topics are mapped.

Units are SI on both sides. Axes are those of REP-103 on both sides: a body's x is forward, y left, z up; the world's x is east, y
north, z up; an optical frame's z is forward, x right, y down. What differs is said below. Fields in backquotes are keys of
`[[ros2.out]]` and `[[ros2.in]]`; fields of the ROS type that are not named are 0 or empty, and not looked at.

Every own message also goes in both directions as `sinew_msgs/msg/NAME`, by its own definition: each field as it is.
)";

std::string page() {
  std::string text = kHead;
  for (const MapLine& line : map_table()) {
    text += "\n## " + std::string(line.ros) + (line.own.empty() ? "" : ", " + std::string(line.own)) + "\n\n";
    text += line.out && line.in ? "Out and in." : line.out ? "Out." : "In.";
    for (std::size_t i = 0; i < line.needs.size(); ++i)
      text += (i == 0 ? " Needs `" : "`, `") + std::string(line.needs[i]) + (i + 1 == line.needs.size() ? "`." : "");
    if (!line.remark.empty()) text += " " + std::string(line.remark);
    text += "\n";
    if (line.fields.empty()) continue;
    text += "\n| ROS 2 | Sinew |\n|---|---|\n";
    for (const auto& [ros, from] : line.fields) text += "| " + ros + " | " + from + " |\n";
  }
  return text;
}

TEST(Ros2TypesPage, SaysWhatTheTableOfTranslationsSays) {
  const std::string path = test::source_dir() + "/docs/reference/ros2-types.md";
  if (std::getenv("SINEW_WRITE_DOCS")) std::ofstream(path) << page();
  std::ifstream in(path);
  std::ostringstream is;
  is << in.rdbuf();
  EXPECT_EQ(is.str(), page()) << "docs/reference/ros2-types.md differs from the table; SINEW_WRITE_DOCS=1 writes it";
}

/// A package for colcon, by file.
std::map<std::string, std::string> package() {
  constexpr std::string_view kOurs = "sinew_msgs/msg/";
  std::map<std::string, std::string> files;
  std::string list;
  for (const Type& type : known_types(Distro::humble).all()) {
    if (!type.name.starts_with(kOurs)) continue;
    const std::string name = "msg/" + type.name.substr(kOurs.size()) + ".msg";
    files[name] = type.lines;
    list += "  \"" + name + "\"\n";
  }
  files["CMakeLists.txt"] =
      "cmake_minimum_required(VERSION 3.8)\nproject(sinew_msgs)\nfind_package(ament_cmake REQUIRED)\n"
      "find_package(rosidl_default_generators REQUIRED)\nrosidl_generate_interfaces(${PROJECT_NAME}\n" +
      list + ")\nament_export_dependencies(rosidl_default_runtime)\nament_package()\n";
  files["package.xml"] =
      "<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name>sinew_msgs</name>\n  <version>0.1.0</version>\n"
      "  <description>Messages of Sinew; net/ros2 writes this package.</description>\n"
      "  <maintainer email=\"nobody@example.org\">Sinew</maintainer>\n  <license>BSD-3-Clause</license>\n"
      "  <buildtool_depend>ament_cmake</buildtool_depend>\n  <build_depend>rosidl_default_generators</build_depend>\n"
      "  <exec_depend>rosidl_default_runtime</exec_depend>\n"
      "  <member_of_group>rosidl_interface_packages</member_of_group>\n"
      "  <export>\n    <build_type>ament_cmake</build_type>\n  </export>\n</package>\n";
  return files;
}

TEST(Ros2TypesPage, ThePackageOfOwnMessagesIsWhatTheirDescriptionsSay) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(test::source_dir()) / "net/ros2/sinew_msgs";
  const auto files = package();
  if (std::getenv("SINEW_WRITE_DOCS")) {
    fs::remove_all(folder);
    fs::create_directories(folder / "msg");
    for (const auto& [name, text] : files) std::ofstream(folder / name) << text;
  }
  std::map<std::string, std::string> there;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path());
    std::ostringstream is;
    is << in.rdbuf();
    there[entry.path().lexically_relative(folder).string()] = is.str();
  }
  EXPECT_EQ(there, files) << "net/ros2/sinew_msgs differs from the messages; SINEW_WRITE_DOCS=1 writes it";
}

}  // namespace
}  // namespace sinew::ros2
