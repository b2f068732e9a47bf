// The fault matrix: every driver that a robot file can name, every fault. docs/reference/device-faults.md has the
// results.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "cell_run.hpp"
#include "drivers/board/driver_list.hpp"
#include "page.hpp"
#include "source_dir.hpp"

namespace sinew::test::device_faults_test {
namespace {

std::vector<RigKind> all_rigs() {
  std::vector<RigKind> all;
  for (auto* some : {iio_rigs, chip_rigs, serial_rigs, camera_rigs, joint_rigs, serial_joint_rigs}) {
    const auto list = some();
    all.insert(all.end(), list.begin(), list.end());
  }
  return all;
}

/// All cells of one device.
std::vector<Cell> play(const RigKind& kind) {
  std::vector<Cell> cells;
  for (const Fault fault : kind.make()->faults()) {
    const auto ways = kind.make()->ways(fault);
    EXPECT_FALSE(ways.empty()) << kind.title << ": no cell for " << to_string(fault);
    for (std::size_t way = 0; way < ways.size(); ++way) {
      SCOPED_TRACE(kind.title + ", " + to_string(fault) + " " + ways[way].label);
      if (ways[way].cannot.empty())
        cells.push_back(CellRun(kind, fault, way).play());
      else
        cells.push_back({kind.title, to_string(fault), {to_string(ways[way].cannot[0])}, "-", "-"});
    }
  }
  return cells;
}

const std::string kPage = test::source_dir() + "/docs/reference/device-faults.md";

std::string committed_page() {
  std::ifstream in(kPage);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// From its title to the next one.
std::string committed_section(const std::string& title) {
  const std::string page = committed_page();
  const std::size_t begin = page.find("\n## " + title + "\n");
  if (begin == std::string::npos) return "";
  const std::size_t end = page.find("\n\n## ", begin + 1);
  return page.substr(begin, end == std::string::npos ? end : end + 1 - begin);
}

void expect_same(const std::string& is, const std::string& was) {
  std::istringstream now(is), before(was);
  for (std::string a, b; std::getline(now, b);) {
    a.clear();
    std::getline(before, a);
    EXPECT_EQ(a, b) << "docs/reference/device-faults.md differs from what was measured; SINEW_WRITE_DOCS=1 writes it";
  }
}

TEST(DeviceFaultsPage, EveryDriverOfTheRegistryHasATable) {
  std::set<std::string> played;
  for (const RigKind& rig : all_rigs()) played.insert(rig.kind);
  for (const drivers::DriverKind& driver : drivers::all_drivers()) {
    if (driver.measures == "radio") continue;       // its faults are a network's: tests/hal/linux/udp_radio_test.cpp
    if (driver.name.starts_with("text")) continue;  // as well: tests/drivers/text/text_link_test.cpp
    if (driver.name == "grab") continue;            // another program's: tests/grab
    if (driver.name == "usarsim_images") continue;  // a network's: tests/hal/linux/image_server_camera_test.cpp
    if (driver.name == "gamecontroller") continue;  // likewise: tests/drivers/game/game_controller_test.cpp
    if (driver.name == "published") continue;       // no device: whoever reads the topic moves the joints
    EXPECT_TRUE(played.contains(std::string(driver.name))) << driver.name << ": nobody plays its faults";
  }
}

class DeviceFaults : public ::testing::TestWithParam<RigKind> {};

TEST_P(DeviceFaults, EveryFaultIsToldActedOnAndOverAsThePageSays) {
  const std::vector<Cell> cells = play(GetParam());
  const std::string is = section_of(cells), was = committed_section(GetParam().title);
  if (std::getenv("SINEW_WRITE_DOCS")) return;
  expect_same(is, was);
  EXPECT_EQ(std::count(is.begin(), is.end(), '\n'), std::count(was.begin(), was.end(), '\n'));
}

INSTANTIATE_TEST_SUITE_P(Of, DeviceFaults, ::testing::ValuesIn(all_rigs()),
                         [](const ::testing::TestParamInfo<RigKind>& rig) {
                           std::string name;
                           for (const char c : rig.param.title)
                             if (std::isalnum(static_cast<unsigned char>(c))) name += c;
                           return name;
                         });

/// The text between the tables, and their order. With SINEW_WRITE_DOCS it plays everything and writes the page.
TEST(DeviceFaultsPage, HasTheTablesOfAllDevicesAndNoOthers) {
  std::vector<std::vector<Cell>> devices;
  const bool writes = std::getenv("SINEW_WRITE_DOCS") != nullptr;
  std::vector<std::string> titles;
  for (const RigKind& rig : all_rigs()) {
    titles.push_back("## " + rig.title);
    devices.push_back(writes ? play(rig) : std::vector<Cell>{{rig.title, "", {}, "", ""}});
  }
  if (writes) std::ofstream(kPage) << page_of(devices);
  std::istringstream page(committed_page()), head(page_of(devices).substr(0, page_of({}).size()));
  for (std::string a, b; std::getline(head, b);) {
    std::getline(page, a);
    EXPECT_EQ(a, b);
  }
  std::vector<std::string> found;
  for (std::string line; std::getline(page, line);)
    if (line.starts_with("## ")) found.push_back(line);
  EXPECT_EQ(found, titles);
}

}  // namespace
}  // namespace sinew::test::device_faults_test
