// docs/reference/device-keys.md has exactly the drivers' tables of keys.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "keys_page.hpp"
#include "source_dir.hpp"

namespace sinew::test::device_keys_test {
namespace {

const std::string kPage = test::source_dir() + "/docs/reference/device-keys.md";

TEST(DeviceKeysPage, SaysWhatTheTablesOfTheDriversSay) {
  const std::string is = keys_page(drivers::key_tables());
  if (std::getenv("SINEW_WRITE_DOCS")) std::ofstream(kPage) << is;
  std::ifstream in(kPage);
  std::istringstream now(is);
  for (std::string a, b; std::getline(now, a);) {
    b.clear();
    std::getline(in, b);
    EXPECT_EQ(a, b) << "docs/reference/device-keys.md differs from the drivers' tables; SINEW_WRITE_DOCS=1 writes it";
  }
  std::string more;
  EXPECT_FALSE(std::getline(in, more)) << "and has nothing more: " << more;
}

TEST(DeviceKeysPage, EveryDriverHasATableAndSomebodyWhoReadsIt) {
  std::set<std::string_view> devices;
  for (const drivers::KeyTable& t : drivers::key_tables()) {
    if (t.header != "[device.NAME]") continue;
    devices.insert(t.driver);
    EXPECT_FALSE(t.readers.empty()) << t.driver;
    for (const std::string_view reader : t.readers) EXPECT_FALSE(reader.empty()) << t.driver << ": " << t.measures;
  }
  for (const drivers::DriverKind& d : drivers::all_drivers()) EXPECT_TRUE(devices.contains(d.name)) << d.name;
}

TEST(DeviceKeysPage, EveryKeySaysWhatItMeansAndNoKeyTwice) {
  for (const drivers::KeyTable& t : drivers::key_tables()) {
    std::set<std::string> names;
    for (const drivers::KeyRow& row : t.rows) {
      SCOPED_TRACE(std::string(t.driver) + "." + row.key);
      EXPECT_TRUE(names.insert(row.key).second);
      EXPECT_FALSE(row.doc.empty());
      EXPECT_FALSE(row.type.empty());
      EXPECT_FALSE(row.allowed.empty());
      const bool has_unit_in_name = row.key.ends_with("_hz") || row.key.ends_with("_ms") || row.key.ends_with("_rad") ||
                                    row.key.ends_with("_radps") || row.key.ends_with("_nm") ||
                                    row.key.ends_with("_deg") || row.key.ends_with("_c");
      EXPECT_TRUE(!has_unit_in_name || !row.unit.empty()) << "a unit";
    }
  }
}

}  // namespace
}  // namespace sinew::test::device_keys_test
