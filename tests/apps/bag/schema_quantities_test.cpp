// The quantities of messages whose type only their recording knows.
#include "apps/bag/schema_quantities.hpp"

#include <gmock/gmock.h>

#include "msg/all.hpp"
#include "msg/ros2msg.hpp"

namespace sinew::app::schema_quantities_test {
namespace {

using record::Quantity;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<Quantity> of(std::string_view text, std::uint32_t& size) {
  std::string why;
  const auto schema = record::Ros2Schema::parse("my_msgs/msg/My", text, why);
  EXPECT_TRUE(schema) << why;
  return schema ? schema_quantities(*schema, size) : std::vector<Quantity>();
}

std::vector<std::string> names_of(std::string_view text) {
  std::uint32_t size = 0;
  std::vector<std::string> names;
  for (const Quantity& q : of(text, size)) names.push_back(q.path + "@" + std::to_string(q.offset) + " " + q.unit);
  return names;
}

TEST(SchemaQuantities, AreThoseOfTheTypeItselfForEveryTypeThatThisProgramKnows) {
  for (const msg::TypeInfo* const type : msg::all_types()) {
    std::uint32_t size = 0;
    const auto now = of(msg::ros2msg_schema(*type), size), own = record::quantities(*type);
    ASSERT_EQ(now.size(), own.size()) << type->name;
    for (std::size_t i = 0; i < own.size(); ++i) {
      EXPECT_EQ(now[i].path, own[i].path) << type->name;
      EXPECT_EQ(now[i].unit, own[i].unit) << type->name << "." << own[i].path;
      EXPECT_EQ(now[i].what, own[i].what) << type->name << "." << own[i].path;
      EXPECT_EQ(now[i].kind, own[i].kind) << type->name << "." << own[i].path;
      EXPECT_EQ(now[i].offset, own[i].offset) << type->name << "." << own[i].path;
    }
    EXPECT_EQ(size, type->size) << type->name;
  }
}

TEST(SchemaQuantities, AreWhereCdrPutsThemUpToTheFirstTextOrList) {
  EXPECT_THAT(names_of("bool on\nfloat64[2] x  # [m] world\nuint16 n\nfloat32 y\nstring name\nfloat64 z"),
              ElementsAre("on@0 ", "x[0]@8 m", "x[1]@16 m", "n@24 ", "y@28 "));
  EXPECT_THAT(names_of("uint8[] pixels\nfloat64 z"), IsEmpty());
}

TEST(SchemaQuantities, OfADefinitionWithoutEndAreTheFirstTenThousand) {
  std::uint32_t size = 0;
  EXPECT_EQ(of("uint8[4000000000] x", size).size(), 10'000u);
  EXPECT_THAT(of("my_msgs/None[4000000000] x\n================\nMSG: my_msgs/None\n", size), IsEmpty());
}

TEST(SchemaQuantities, OfAQuatThatIsNoneAreItsNumbers) {
  const std::string mark = "\n" + std::string(80, '=') + "\nMSG: sinew_msgs/Quat\n";
  EXPECT_THAT(names_of("sinew_msgs/Quat q  # [1] world" + mark + "float64 w"), ElementsAre("q.w@0 1"));
}

}  // namespace
}  // namespace sinew::app::schema_quantities_test
